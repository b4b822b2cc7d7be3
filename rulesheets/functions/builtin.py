"""What the language knows about one built-in function."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import inf
from typing import TypeAlias

from rulesheets.nodes import Expression

Branches: TypeAlias = Callable[[Expression], tuple[Expression, ...]]
Partials: TypeAlias = Callable[[tuple[Expression, ...]], tuple[Expression | None, ...]]


@dataclass(frozen=True)
class Preimage:
    """How ``f(x) = t`` is solved for ``x``.

    ``branches(t)`` lists every solution within one ``period`` of x (all of them where ``period``
    is None), the principal one first. They are solutions wherever ``t`` lies in the image, the
    interval from ``low`` to ``high`` without the ends that are marked open.
    """

    branches: Branches
    low: float = -inf
    high: float = inf
    low_open: bool = False
    high_open: bool = False
    period: float | None = None

    def reaches(self, target: float) -> bool:
        """Whether ``target`` lies in the image, so that a solution exists."""
        above = target > self.low if self.low_open else target >= self.low
        below = target < self.high if self.high_open else target <= self.high
        return above and below


@dataclass(frozen=True)
class Builtin:
    """A row of the table of functions.

    ``arity`` is the least and the greatest number of arguments (None: any number).
    ``value`` maps floats to a float and, like the functions of ``math``, raises ValueError,
    ZeroDivisionError or OverflowError where it has none.
    ``derivatives(arguments)`` are the partial derivatives as trees, one per argument, None
    where there is no formula. At a jump or a kink they are those of one side.
    ``preimage`` is there for functions of one argument that formulas can undo.
    ``domain`` is the closed hull of where a function of one argument is defined.
    """

    name: str
    arity: tuple[int, int | None]
    value: Callable[..., float]
    derivatives: Partials
    preimage: Preimage | None = None
    domain: tuple[float, float] = (-inf, inf)

    def accepts(self, count: int) -> bool:
        """Whether the function can be called with ``count`` arguments."""
        least, most = self.arity
        return least <= count and (most is None or count <= most)
