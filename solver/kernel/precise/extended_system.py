"""A block to many digits: its residual and Jacobian at mpmath numbers, and Newton on them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from rulesheets.deadline import expect_time
from rulesheets.evaluate import Undefined, extended, extended_derivatives
from rulesheets.functions.extended import context
from solver.accuracy.effort import effort
from solver.kernel.code.block import BlockKernel
from solver.numerics.elimination import eliminate

SPARE = 8
"""Decimal digits of the working precision that rounding may take."""
MAX_ITERATIONS = 40
MAX_UNKNOWNS = 60
MAX_WORK = 60_000
"""Operations, as ``accuracy/effort.py`` counts them."""


class Unresolved(Exception):
    """More digits do not settle the block."""


class TooFewDigits(Unresolved):
    """Numbers are lost beside others that still more digits would keep."""


class Exhausted(Exception):
    """The work that may be done is; still more digits would take more."""


class Work:
    """How many operations may still be done to many digits; for all blocks of a path together."""

    def __init__(self, left: int = MAX_WORK) -> None:
        self.left = left

    def spend(self, count: int) -> None:
        """Raises Exhausted where there is nothing left."""
        self.left -= count
        if self.left < 0:
            raise Exhausted


class ExtendedSystem:
    """F(x) = 0 for the unknowns of a block, the ``known`` values taken exactly. Points are lists (n,)."""

    def __init__(self, kernel: BlockKernel, known: Mapping[str, Any], digits: int, work: Work) -> None:
        self.kernel, self.known, self.digits, self.work = kernel, known, digits, work
        self.mp = context(digits)
        self.size = sum(effort(form, digits) for form in kernel.forms)
        self.tiny = self.mp.mpf(10) ** (SPARE - digits)
        self.small = self.mp.mpf(10) ** (-7 * digits // 10)

    @property
    def usable(self) -> bool:
        """Whether the block is small enough, and its derivatives have formulas."""
        return len(self.kernel.unknowns) <= MAX_UNKNOWNS and all(self.kernel.partials)

    def point(self, x: Sequence[Any]) -> dict[str, Any]:
        return dict(zip(self.kernel.unknowns, x, strict=True))

    def residual(self, x: Sequence[Any]) -> list[Any]:
        """Raises Undefined outside the domain."""
        self.work.spend(self.size)
        values = {**self.known, **self.point(x)}
        return [extended(form, values, self.digits) for form in self.kernel.forms]

    def jacobian(self, x: Sequence[Any]) -> list[list[Any]]:
        """Rows ∂F_i/∂x_j. Raises Undefined where a slope has no value."""
        values = {**self.known, **self.point(x)}
        n = len(self.kernel.unknowns)
        self.work.spend(2 * self.size + n**3)
        flat = [extended(p, values, self.digits) for p in self.kernel.partials if p is not None]
        return [flat[i : i + n] for i in range(0, n * n, n)]

    def linearised(self, x: Sequence[Any]) -> tuple[list[list[Any]], list[Any]]:
        """Jacobian and residual, by one sweep of each equation where that has a value.

        Raises Undefined outside the domain, and where a slope has no value.
        """
        values = {**self.known, **self.point(x)}
        try:
            swept = [extended_derivatives(form, values, self.digits) for form in self.kernel.forms]
        except Undefined:  # a factor of a slope has no value: its formula may have
            return self.jacobian(x), self.residual(x)
        self.work.spend(3 * self.size + len(x) ** 3)
        zero = self.mp.zero
        rows = [[slopes.get(name, zero) for name in self.kernel.unknowns] for _, slopes in swept]
        return rows, [miss for miss, _ in swept]

    def newton(self, start: Sequence[Any]) -> list[Any] | None:
        """The root that Newton's method reaches from ``start``; None where it reaches none."""
        x = [self.mp.mpf(v) for v in start]
        try:
            for _ in range(MAX_ITERATIONS):
                expect_time()
                step = eliminate(*self.linearised(x), self.tiny)
                if step is None:
                    return None
                x = [v - d for v, d in zip(x, step, strict=True)]
                if self._settled(x, step):
                    return x
        except (Undefined, OverflowError):
            return None
        return None

    def _settled(self, x: Sequence[Any], step: Sequence[Any]) -> bool:
        """Whether the next step, which is quadratically smaller, would be lost in rounding."""
        size = max(abs(v) for v in x)
        return all(abs(d) <= self.small * max(abs(v), self.tiny * size) for v, d in zip(x, step, strict=True))
