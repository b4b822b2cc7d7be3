"""The rule of which answer comes first, as operations of a record.

``Ranking`` is written over numbers of any kind; here they are nodes of a program. Of the keys of the answers
as much is written down as orders them at the sample; where that comes out alike for two of them, another
record has the word.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import reduce
from itertools import combinations
from typing import Any

from solver.ranking.arithmetic import LEAST, MOST, Arithmetic
from solver.ranking.ranking import Ranking
from solver.trace.flow import Flow, NotCompilable

NOISE = 1e-13
"""Powers and factors below this are what rounding has left of 0."""


class Number:
    """A node of a program, with the operators of numbers; a ``logical`` one counts as 0 or 1."""

    def __init__(self, flow: Flow, node: int, logical: bool = False) -> None:
        self.flow, self.node, self.logical = flow, node, logical

    @property
    def number(self) -> int:
        """The node as a number."""
        flow = self.flow
        return (
            flow.add("where", self.node, flow.constant(1.0), flow.constant(0.0))
            if self.logical
            else self.node
        )

    def _of(self, other: Any) -> int:
        return other.number if isinstance(other, Number) else self.flow.constant(float(other))

    def _with(self, operation: str, left: Any, right: Any, logical: bool = False) -> Number:
        return Number(self.flow, self.flow.add(operation, self._of(left), self._of(right)), logical)

    def __add__(self, other: Any) -> Number:
        return self._with("add", self, other)

    __radd__ = __add__

    def __sub__(self, other: Any) -> Number:
        return self._with("sub", self, other)

    def __rsub__(self, other: Any) -> Number:
        if self.logical and other == 1.0:
            return Number(self.flow, self.flow.add("not", self.node), True)
        return self._with("sub", other, self)

    def __mul__(self, other: Any) -> Any:
        if not isinstance(other, Number):
            return 0.0 if abs(other) < NOISE else self if other == 1.0 else self._with("mul", self, other)
        if self.logical and other.logical:
            return self & other
        if self.logical or other.logical:
            chosen, number = (self, other) if self.logical else (other, self)
            zero = self.flow.constant(0.0)
            return Number(self.flow, self.flow.add("where", chosen.node, number.node, zero))
        return self._with("mul", self, other)

    __rmul__ = __mul__

    def __truediv__(self, other: Any) -> Number:
        return self._with("div", self, other)

    def __rtruediv__(self, other: Any) -> Number:
        return self._with("div", other, self)

    def __abs__(self) -> Number:
        return Number(self.flow, self.flow.add("abs", self.number))

    def __neg__(self) -> Number:
        return Number(self.flow, self.flow.add("neg", self.number))

    def __lt__(self, other: Any) -> Number:
        return self._with("lt", self, other, True)

    def __gt__(self, other: Any) -> Number:
        return self._with("lt", other, self, True)

    def __le__(self, other: Any) -> Number:
        return self._with("le", self, other, True)

    def __ge__(self, other: Any) -> Number:
        return self._with("le", other, self, True)

    def __ne__(self, other: Any) -> Number:  # type: ignore[override]
        return Number(self.flow, self.flow.add("not", self._with("eq", self, other, True).node), True)

    def __and__(self, other: Any) -> Number:
        return Number(self.flow, self.flow.add("and", self.node, other.node), True)

    __hash__ = None  # type: ignore[assignment]


def order(
    flow: Flow,
    ranking: Ranking,
    answers: Sequence[Sequence[int | None]],
    given: Sequence[int | None],
    numbers: Callable[[int], float],
) -> tuple[list[tuple[int, ...]], list[int]]:
    """What sorts the answers, and the conditions under which it tells them apart.

    ``answers`` are the nodes of the names that the ranking reads, ``given`` those of the known ones, None for
    one that has no number; ``numbers`` tells what a node is at the sample.
    """

    def recorded(node: int | None) -> Any:
        return math.nan if node is None else Number(flow, node)

    rows = [[recorded(node) for node in answer] for answer in answers]
    zero = tuple(node is not None and numbers(node) == 0.0 for node in given)
    there = [node for node, none in zip(given, zero, strict=True) if node is not None and not none]
    guards = [flow.add("not", flow.add("eq", node, flow.constant(0.0))) for node in there]
    found = ranking.keys_on(_arithmetic(flow), rows, [recorded(node) for node in given], zero)
    keys = [tuple(_node(flow, part) for part in key) for key in found]
    decides = 0
    for one, other in combinations(keys, 2):
        pairs = enumerate(zip(one, other, strict=True))
        place = next((place for place, (a, b) in pairs if numbers(a) != numbers(b)), None)
        if place is None:
            raise NotCompilable
        decides = max(decides, place)
    keys = [key[: decides + 1] for key in keys]
    for one, other in combinations(keys, 2):
        same = [flow.add("eq", a, b) for a, b in zip(one, other, strict=True)]
        guards.append(flow.add("not", reduce(lambda a, b: flow.add("and", a, b), same)))
    return keys, guards


def _node(flow: Flow, value: Any) -> int:
    return value.number if isinstance(value, Number) else flow.constant(float(value))


def _arithmetic(flow: Flow) -> Arithmetic:
    """The rule's arithmetic on nodes. What has no number at the sample has none in any row."""

    def larger(one: Any, other: Any) -> Any:
        if not isinstance(one, Number) and not isinstance(other, Number):
            return max(one, other)
        logical = [isinstance(n, Number) and n.logical for n in (one, other)]
        if all(logical):
            return Number(flow, flow.add("or", one.node, other.node), True)
        if any(logical) and 0.0 in (one, other):
            return one if logical[0] else other
        return Number(flow, flow.add("max", _node(flow, one), _node(flow, other)))

    def decade(value: Any) -> Any:
        if not isinstance(value, Number):
            return math.log10(min(max(abs(value), LEAST), MOST))
        return Number(flow, flow.call("log10", larger(abs(value), LEAST).node))

    def there(value: Any, other: float) -> Any:
        return value if isinstance(value, Number) or value == value else other

    def rounded(value: Any) -> Any:
        return Number(flow, flow.add("rint", value.node)) if isinstance(value, Number) else round(value)

    return Arithmetic(there, lambda values: reduce(larger, values), rounded, decade)
