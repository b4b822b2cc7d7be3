"""Whether the residual of a chain is 0 at a point, or only nothing beside numbers that cancel there.

Far out on the line of a tear floats cannot tell ``x + 2*(2 - x) + x - 3`` from 0. Here the chain is followed
in many digits, and what it misses by has to come of the last places of the numbers that it is made of.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Any

from rulesheets.evaluate import Undefined, extended
from rulesheets.evaluate.digits import context
from rulesheets.syntax.nodes import Expression, Name, Number, children, rebuilt
from solver.accuracy.rule_check import BACKWARD
from solver.kernel.code.chain import Chain

DIGITS = 60
"""Decimal digits of a number next to 1."""
STEP = 1e-20
"""Relative change of a number that tells how the residual depends on it."""
NOTHING = 1e-40
"""Residuals this small are what many digits round."""


def vanishes(chain: Chain, x: float, known: Mapping[str, float]) -> bool:
    """Whether the last residual of a chain is 0 at this value of its only tear, but for rounded numbers."""
    following = _Following(chain, x, known)
    try:
        miss = abs(following.residual())
        if miss <= NOTHING:
            return True
        moves = (abs(moved - following.residual()) / STEP for moved in following.moved())
        return bool(miss <= BACKWARD * sum(moves))
    except (Undefined, OverflowError, ZeroDivisionError):
        return False


class _Following:
    def __init__(self, chain: Chain, x: float, known: Mapping[str, float]) -> None:
        self.numbers: dict[str, float] = {}
        self.steps = [(step.name, self._named(step.expression)) for step in chain.assignments]
        self.tear, self.x = chain.tears[0], x
        self.digits = DIGITS + max(0, math.frexp(x)[1] // 3)
        self.numbers.update(known)

    def _named(self, expression: Expression) -> Expression:
        """The expression with names for its numbers that may have been rounded."""
        if isinstance(expression, Number) and not expression.value.is_integer():
            name = f"#number {expression.value!r}"
            self.numbers[name] = expression.value
            return Name(name)
        parts = children(expression)
        return rebuilt(expression, tuple(map(self._named, parts))) if parts else expression  # type: ignore[arg-type]

    def residual(self, moved: Mapping[str, Any] | None = None) -> Any:
        """The last residual, some of the numbers ``moved``. Raises Undefined."""
        mp = context(self.digits)
        at: dict[str, Any] = {**self.numbers, self.tear: mp.mpf(self.x), **(moved or {})}
        for name, expression in self.steps:
            at[name] = extended(expression, at, self.digits)
        return at[self.steps[-1][0]]

    def moved(self) -> Iterator[Any]:
        """The residual with each of the numbers changed by a share of ``STEP``."""
        mp = context(self.digits)
        for name, number in self.numbers.items():
            yield self.residual({name: mp.mpf(number) * (1 + mp.mpf(STEP))})
