"""Equations in as many unknowns, in many decimal digits: residual, Jacobian, Newton's method."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import Any

from rulesheets.deadline import expect_time
from rulesheets.evaluate import NotDifferentiable, Undefined, differentiate, extended, extended_derivatives
from rulesheets.functions.extended import context
from rulesheets.model import Equation
from rulesheets.syntax.construct import subtract
from rulesheets.syntax.nodes import Expression
from rulesheets.syntax.program import walk
from solver.numerics.elimination import Singular, eliminate_rows
from solver.numerics.refinement import ELIMINATED, solve_exactly

SPARE = 8
"""Decimal digits of the working precision that rounding may take."""
MAX_ITERATIONS = 40
MAX_UNKNOWNS = 60
MAX_WORK = 60_000
"""Operations."""


class Unresolved(Exception):
    """More digits do not settle the equations."""


class Work:
    """How many operations may still be done in many digits, for all systems of a path together."""

    def __init__(self, left: int = MAX_WORK) -> None:
        self.left = left

    def spend(self, count: int) -> None:
        """Raises Unresolved if nothing is left."""
        self.left -= count
        if self.left < 0:
            raise Unresolved


def linearized(
    forms: Sequence[Expression], unknowns: Sequence[str], values: Mapping[str, Any], digits: int
) -> tuple[list[list[Any]], list[Any]]:
    """Jacobian (m, n) of as many forms along the unknowns, and their values (m,). Raises Undefined."""
    zero = context(digits).zero
    swept = [extended_derivatives(form, values, digits) for form in forms]
    return [[slopes.get(name, zero) for name in unknowns] for _, slopes in swept], [miss for miss, _ in swept]


class ManyDigits:
    """F(x) = 0, with the ``known`` values taken as exact numbers. Points are lists (n,) of mpmath numbers."""

    def __init__(
        self,
        equations: Sequence[Equation],
        unknowns: Sequence[str],
        known: Mapping[str, Any],
        digits: int,
        work: Work,
    ) -> None:
        self.equations, self.unknowns = equations, tuple(unknowns)
        self.forms = [subtract(equation.left, equation.right) for equation in equations]
        names = {name for equation in equations for name in equation.names} - set(unknowns)
        self.known = {name: known[name] for name in names}
        self.digits, self.work, self.mp = digits, work, context(digits)
        self.size = sum(1 for form in self.forms for _ in walk(form))
        self.tiny = self.mp.mpf(10) ** (SPARE - digits)
        self.small = self.mp.mpf(10) ** (-7 * digits // 10)

    def point(self, x: Sequence[Any]) -> dict[str, Any]:
        return dict(zip(self.unknowns, x, strict=True))

    def linearised(self, x: Sequence[Any]) -> tuple[list[list[Any]], list[Any]]:
        """Jacobian (n, n) and residual (n,).

        Raises Undefined outside the domain, and if a slope has no value.
        """
        values = {**self.known, **self.point(x)}
        self.work.spend(3 * self.size + len(x) ** 3)
        try:
            return linearized(self.forms, self.unknowns, values, self.digits)
        except Undefined:  # perhaps the slope along a known number
            rows = [[extended(d, values, self.digits) for d in row] for row in self._partials]
            return rows, [extended(form, values, self.digits) for form in self.forms]

    @cached_property
    def _partials(self) -> list[list[Expression]]:
        """Raises Undefined if a rule has no derivative in closed form."""
        try:
            return [[differentiate(form, name) for name in self.unknowns] for form in self.forms]
        except NotDifferentiable:
            raise Undefined("derivative", (), self.forms[0]) from None

    def newton(self, start: Sequence[Any], sizes: Sequence[float] = ()) -> list[Any] | None:
        """The root that Newton's method reaches from ``start``; None if it reaches none.

        ``sizes`` (n,) of the terms that the unknowns are made of: one that is 0 comes out as their rounding.
        """
        x = [self.mp.mpf(v) for v in start]
        try:
            for _ in range(MAX_ITERATIONS):
                expect_time()
                step = self._step(*self.linearised(x))
                x = [v - d for v, d in zip(x, step, strict=True)]
                if self._settled(x, step, sizes or [float(max(map(abs, x)))] * len(x)):
                    return x
        except (Undefined, Singular, OverflowError):
            return None
        return None

    def _step(self, jacobian: Sequence[Sequence[Any]], misses: Sequence[Any]) -> list[Any]:
        """Raises Singular."""
        rows = [{j: slope for j, slope in enumerate(row) if slope} for row in jacobian]
        if len(rows) > ELIMINATED:
            return solve_exactly(rows, [misses])[0]
        return eliminate_rows(rows, [misses], self.tiny)[0]

    def _settled(self, x: Sequence[Any], step: Sequence[Any], sizes: Sequence[float]) -> bool:
        """Whether the next step, which is quadratically smaller, would be lost in rounding."""
        triples = zip(x, step, sizes, strict=True)
        return all(abs(d) <= self.small * max(abs(v), self.tiny * size) for v, d, size in triples)
