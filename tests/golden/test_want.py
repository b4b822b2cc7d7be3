"""A name that is wanted alone has all its values of the whole sheet, and no other without a
reason."""

from __future__ import annotations

import math
from collections.abc import Iterator

import pytest

import solver

from .questions import WANTED, Question, questions
from .record import ANSWERS, kept

SAMPLE = {"corpus": 2, "redistributions": 40, "everyday": 150}
"""Of each source every so many-th question is solved."""
SAME, ROUNDING = 1e-9, 1e-13
"""Two values are one if they differ by so much of the larger, or of the largest in the list."""


def values_of(result: solver.Result, name: str) -> list[float | str]:
    return [answer[name] for answer in result.solutions]


def among(value: float | str, others: list[float | str]) -> bool:
    if isinstance(value, str):
        return value in others
    numbers = [other for other in others if not isinstance(other, str)]
    least = ROUNDING * max(map(abs, (value, *numbers)))
    return any(math.isclose(value, other, rel_tol=SAME, abs_tol=least) for other in numbers)


@pytest.mark.parametrize("source", SAMPLE)
def test_what_is_wanted_has_all_its_values(source: str) -> None:
    asked = questions(source)[1 :: SAMPLE[source]]
    assert asked
    found = ((one.id, *fault) for one in asked for fault in faults(one))
    assert list(found) == []


def test_the_record_of_what_is_wanted_has_the_values_of_the_others() -> None:
    """Of questions and lists that are recorded whole."""
    record, lost = dict(kept()), {}
    for id_, alone in record.items():
        source, _, asked = id_.partition("/")
        if source != "want":
            continue
        label, name = asked.rsplit(" ? ", 1)
        others = (record[of] for one in WANTED if (of := f"{one}/{label}") in record)
        whole = next(others, {"status": "new"})
        if whole["status"] == "solved" != alone["status"]:
            lost[id_] = alone["status"]
        elif whole["status"] == "solved" and alone["answers"] <= ANSWERS:
            place, told = whole["names"].index(name), [value for (value,) in alone["values"]]
            values = (row[place] for row in whole["values"])
            if missing := [value for value in values if not among(value, told)]:
                lost[id_] = missing
    assert lost == {}


def faults(question: Question) -> Iterator[tuple[str, object]]:
    """The wanted names with another status, a value too few, or one that no rule refuses on the
    whole sheet, of two names."""
    model, inputs, guesses = question.read(), dict(question.inputs), dict(question.guesses)
    whole = solver.solve(model, inputs, guesses=guesses)
    if str(whole.status) != "solved" or any(note.code == "S593" for note in whole.diagnoses):
        return
    asked = [name for name in whole.wanted if name not in whole.inputs]
    for name in asked[:: max(1, (len(asked) + 1) // 2)]:
        alone = solver.solve(model, inputs, [name], guesses)
        told, known = values_of(alone, name), values_of(whole, name)
        if str(alone.status) != "solved":
            yield name, alone.status
        elif lost := [value for value in known if not among(value, told)]:
            yield name, lost
        for value in told if whole.complete else ():
            if not among(value, known):
                again = solver.solve(model, {**inputs, name: value}, guesses=guesses)
                if str(again.status) not in ("infeasible", "inconsistent", "failed"):
                    yield name, value
