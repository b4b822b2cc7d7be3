"""The equations of a linear block as its known numbers may as well be: off by an error each."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from rulesheets.evaluate import Undefined, derivatives, rounded_derivatives
from rulesheets.model import Value
from rulesheets.nodes import Expression
from solver.accuracy.last_places import blur, half_unit, with_named_numbers
from solver.accuracy.witness import BACKWARD, size, testify
from solver.kernel.question import Question

NUDGE = 1e-5
"""Relative step of the differences that tell how a coefficient depends on a known number."""
LEAST = 1e-150
"""What an equation is allowed to miss by, at least, and at most 1 by that."""


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
        return sum(self._moved(name, error, w, z) for name, error in self.moves.items())

    def _moved(self, name: str, error: float, w: Sequence[float], z: Sequence[float]) -> float:
        number = self.at[name]
        assert isinstance(number, float)
        if not math.isfinite(error):
            return math.nan
        step = max(NUDGE * abs(number), error)
        try:
            ahead, behind = (self._product({**self.at, name: number + s}, w, z) for s in (step, -step))
        except Undefined:
            return math.nan
        return abs(ahead - behind) / (2 * step) * error

    def _product(self, at: Mapping[str, Value], w: Sequence[float], z: Sequence[float]) -> float:
        slopes = (derivatives(form, at)[1] for form in self.forms)
        names = self.question.unknowns
        return sum(
            p * sum(row.get(n, 0.0) * q for n, q in zip(names, z, strict=True))
            for p, row in zip(w, slopes, strict=True)
        )

    def holds(self, point: Mapping[str, float]) -> bool:
        """Whether the witness accepts every equation, or what is known may be as far off as it misses.

        Floats may have made up as much of that as they round, if it is known how much that is.
        """
        question = self.question
        everything = {**question.here, **point}
        misses = question.residual(list(point.values()))
        return all(
            abs(miss) <= blur(form, everything, self.off) + _noise(form, everything) < math.inf
            or testify(equation, everything).holds
            for miss, form, equation in zip(
                misses, question.kernel.forms, question.kernel.equations, strict=True
            )
        )

    def allowances(self, point: Mapping[str, float]) -> list[float]:
        """What each equation may miss by: as its known numbers are off, or the witness admits."""
        everything = {**self.question.here, **point}
        rows = zip(self.question.kernel.forms, self.question.kernel.equations, strict=True)
        found = (blur(form, everything, self.off) + BACKWARD * size(e, everything) for form, e in rows)
        return [min(max(allowed, LEAST), 1.0 / LEAST) for allowed in found]


def _noise(form: Expression, values: Mapping[str, Value]) -> float:
    try:
        return rounded_derivatives(form, values)[2]
    except Undefined:
        return 0.0


def _of(known: Mapping[str, float], off: Mapping[str, float]) -> dict[str, float]:
    return {name: off[name] for name in known if name in off}
