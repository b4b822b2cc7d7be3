"""The equations of a linear block as its known numbers may as well be: off by an error each."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction
from typing import Any

from rulesheets.evaluate import Undefined, derivatives, rounded_derivatives
from rulesheets.model import Value
from rulesheets.nodes import Expression
from solver.accuracy.last_places import blur, half_unit, with_named_numbers
from solver.accuracy.witness import BACKWARD, size, testify
from solver.kernel.question import Question
from solver.numerics.elimination import Singular, eliminate_rows

NUDGE = 1e-5
"""Relative step of the differences that tell how a coefficient depends on a known number."""
LEAST = 1e-150
"""What an equation is allowed to miss by, at least, and at most 1 by that."""

DIGITS, ROUNDS = 20, 60
"""Of the numbers that bound a spectral radius, for their exponents more than their digits; steps of it."""


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

    def keeps_rank(self, matrix: Sequence[Sequence[Any]], exact: Callable[[float], Any]) -> bool:
        """Whether the matrix (n, n) is regular however the numbers in it move by what they may be off.

        It is if the spectral radius of |A⁻¹|·E is less than 1, E being how far its entries move (J. Rohn,
        "Systems of linear interval equations", Linear Algebra Appl. 126 (1989)).
        Singular vectors do not tell where entries differ by more than floats have digits. ``exact`` makes
        numbers of the kind of ``matrix``.
        """
        from rulesheets.functions.extended import context

        n, off = len(matrix), self._entries_move()
        unit = [[exact(float(i == j)) for i in range(n)] for j in range(n)]
        try:
            columns = eliminate_rows([dict(enumerate(row)) for row in matrix], unit)
        except Singular:
            return False
        big = context(DIGITS)
        inverse = [[_as(abs(columns[j][i]), big) for j in range(n)] for i in range(n)]
        spread = [
            [sum(a * big.mpf(e[j]) for a, e in zip(row, off, strict=True)) for j in range(n)]
            for row in inverse
        ]
        x = [big.one] * n
        for _ in range(ROUNDS):
            ahead = [
                v + sum(b * w for b, w in zip(row, x, strict=True)) for v, row in zip(x, spread, strict=True)
            ]
            if max(v / w for v, w in zip(ahead, x, strict=True)) < 2:  # bounds 1 + the radius from above
                return True
            x = ahead
        return False

    def _entries_move(self) -> list[list[float]]:
        """How far the entries of the matrix (n, n) move, at most; infinite where that is not known."""
        names, n = self.question.unknowns, len(self.question.unknowns)
        total = [[0.0] * n for _ in range(n)]
        for name, error in self.moves.items():
            number = self.at[name]
            assert isinstance(number, float)
            step = max(NUDGE * abs(number), error)
            try:
                ahead, behind = (self._slopes({**self.at, name: number + s}) for s in (step, -step))
            except Undefined:
                return [[math.inf] * n for _ in range(n)]
            for row, up, down in zip(total, ahead, behind, strict=True):
                for j, unknown in enumerate(names):
                    row[j] += abs(up.get(unknown, 0.0) - down.get(unknown, 0.0)) / (2 * step) * error
        return total

    def _slopes(self, at: Mapping[str, Value]) -> list[dict[str, float]]:
        return [derivatives(form, at)[1] for form in self.forms]

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
        names = self.question.unknowns
        return sum(
            p * sum(row.get(n, 0.0) * q for n, q in zip(names, z, strict=True))
            for p, row in zip(w, self._slopes(at), strict=True)
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


def _as(number: Any, big: Any) -> Any:
    return big.mpf(number.numerator) / number.denominator if isinstance(number, Fraction) else big.mpf(number)


def _noise(form: Expression, values: Mapping[str, Value]) -> float:
    try:
        return rounded_derivatives(form, values)[2]
    except Undefined:
        return 0.0


def _of(known: Mapping[str, float], off: Mapping[str, float]) -> dict[str, float]:
    return {name: off[name] for name in known if name in off}
