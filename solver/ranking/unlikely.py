"""Which numbers of answers are of unlikely size, without any work where none can be."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from rulesheets.model import Model, Value

SPAN = 1e9
"""Numbers of an only answer, and 1, that lie within this factor of one another are all of likely size."""


def unlikely(
    model: Model,
    answers: Sequence[Mapping[str, Value]],
    inputs: Mapping[str, Value],
    guesses: Mapping[str, float],
) -> list[tuple[str, ...]]:
    """Of each answer the names whose numbers are of unlikely size; ``answers`` hold the inputs as well."""
    if not answers or (len(answers) == 1 and not _spans(answers[0], guesses)):
        return [()] * len(answers)
    from solver.ranking.ranking import Ranking  # numpy is imported only where sizes are weighed

    among = {name for values in answers for name in values}
    return Ranking(model, inputs, among, guesses).unlikely(answers, inputs)


def _spans(answer: Mapping[str, Value], guesses: Mapping[str, float]) -> bool:
    """Whether the largest number exceeds the smallest, or 1, by more than ``SPAN``."""
    numbers = [value for value in answer.values() if isinstance(value, float)]
    sizes = [abs(number) for number in (1.0, *numbers, *guesses.values()) if number]
    return max(sizes) / SPAN > min(sizes)
