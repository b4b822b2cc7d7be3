"""The equations of a linear block as its known numbers may as well be: off by an error each."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence

from rulesheets.evaluate import Undefined, derivatives, rounded_derivatives
from rulesheets.model import Value
from rulesheets.nodes import Expression
from solver.accuracy.last_places import blur, half_unit, with_named_numbers
from solver.accuracy.rule_check import check_rule
from solver.kernel.question import Question

NUDGE = 1e-5
"""Relative step of the differences that tell how a coefficient depends on a known number."""


class Perturbed:
    """The block of a ``question`` with its known numbers, given ones included, ``off`` by ``slack`` times so
    much, by name; the numbers that stand in its rules by as many half units of their last places."""

    def __init__(self, question: Question, off: Mapping[str, float], slack: float) -> None:
        self.question = question
        self.off = off if slack == 1.0 else {name: slack * error for name, error in off.items()}
        numbers: dict[str, float] = {}
        self.forms = [with_named_numbers(form, numbers) for form in question.kernel.forms]
        known = {n: v for n, v in question.here.items() if isinstance(v, float)}
        self.at: dict[str, Value] = {**known, **numbers, **dict.fromkeys(question.unknowns, 0.0)}
        own = {name: slack * half_unit(number) for name, number in numbers.items()}
        self.moves = {n: error for n, error in {**own, **_of(known, self.off)}.items() if error}

    def reach(self, w: Sequence[float], z: Sequence[float]) -> float:
        """How far w·A z moves as every number moves by what it may be off; nan where that is not known."""
        total = 0.0
        for moved in self._moved():
            rows = (sum(d * q for d, q in zip(row, z, strict=True)) for row in moved)
            total += abs(sum(p * far for p, far in zip(w, rows, strict=True)))
        return total

    def _moved(self) -> Iterator[list[list[float]]]:
        """How far the entries of the matrix (n, n) go with each number that moves; nan where that is not
        known."""
        names, n = self.question.unknowns, len(self.question.unknowns)
        for name, error in self.moves.items():
            number = self.at[name]
            assert isinstance(number, float)
            step = max(NUDGE * abs(number), error)
            try:
                ahead, behind = (self._slopes({**self.at, name: number + s}) for s in (step, -step))
            except Undefined:
                yield [[math.nan] * n for _ in range(n)]
                continue
            share = error / step / 2  # nan of an infinite error
            yield [
                [(up.get(u, 0.0) - down.get(u, 0.0)) * share for u in names]
                for up, down in zip(ahead, behind, strict=True)
            ]

    def _slopes(self, at: Mapping[str, Value]) -> list[dict[str, float]]:
        return [derivatives(form, at)[1] for form in self.forms]

    def holds(self, point: Mapping[str, float]) -> bool:
        """Whether the rule check accepts every equation, or what is known may be as far off as it misses.

        Floats may have made up as much of that as they round, if it is known how much that is.
        """
        question = self.question
        everything = {**question.here, **point}
        misses = question.residual(list(point.values()))
        return all(
            abs(miss) <= blur(form, everything, self.off) + _noise(form, everything) < math.inf
            or check_rule(equation, everything).holds
            for miss, form, equation in zip(
                misses, question.kernel.forms, question.kernel.equations, strict=True
            )
        )


def _noise(form: Expression, values: Mapping[str, Value]) -> float:
    try:
        return rounded_derivatives(form, values)[2]
    except Undefined:
        return 0.0


def _of(known: Mapping[str, float], off: Mapping[str, float]) -> dict[str, float]:
    return {name: off[name] for name in known if name in off}
