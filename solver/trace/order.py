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

from solver.compiled.flow import Flow, NotCompilable
from solver.ranking.arithmetic import LEAST, MOST, Arithmetic
from solver.ranking.ranking import Ranking


class Number:
    """A node of a program, with the operators of numbers; a logical one counts as 0 or 1."""

    def __init__(self, flow: Flow, node: int, logical: bool = False) -> None:
        self.flow, self.node, self.logical = flow, node, logical

    def _number(self, other: Any) -> int:
        if isinstance(other, Number):
            if not other.logical:
                return other.node
            one, zero = self.flow.constant(1.0), self.flow.constant(0.0)
            return self.flow.add("where", other.node, one, zero)
        return self.flow.constant(float(other))

    def _with(self, operation: str, left: Any, right: Any) -> Number:
        return Number(self.flow, self.flow.add(operation, self._number(left), self._number(right)))

    def _compared(self, left: Any, right: Any, operation: str = "lt") -> Number:
        return Number(self.flow, self.flow.add(operation, self._number(left), self._number(right)), True)

    def __add__(self, other: Any) -> Number:
        return self._with("add", self, other)

    def __radd__(self, other: Any) -> Number:
        return self._with("add", other, self)

    def __sub__(self, other: Any) -> Number:
        return self._with("sub", self, other)

    def __rsub__(self, other: Any) -> Number:
        return self._with("sub", other, self)

    def __mul__(self, other: Any) -> Number:
        return self._with("mul", self, other)

    def __rmul__(self, other: Any) -> Number:
        return self._with("mul", other, self)

    def __truediv__(self, other: Any) -> Number:
        return self._with("div", self, other)

    def __rtruediv__(self, other: Any) -> Number:
        return self._with("div", other, self)

    def __abs__(self) -> Number:
        return Number(self.flow, self.flow.add("abs", self._number(self)))

    def __neg__(self) -> Number:
        return Number(self.flow, self.flow.add("neg", self._number(self)))

    def __lt__(self, other: Any) -> Number:
        return self._compared(self, other)

    def __gt__(self, other: Any) -> Number:
        return self._compared(other, self)

    def __le__(self, other: Any) -> Number:
        return self._compared(self, other, "le")

    def __ge__(self, other: Any) -> Number:
        return self._compared(other, self, "le")

    def __ne__(self, other: Any) -> Number:  # type: ignore[override]
        return Number(self.flow, self.flow.add("not", self._compared(self, other, "eq").node), True)

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
    if isinstance(value, Number):
        return abs(value).node if value.logical else value.node
    return flow.constant(float(value))


def _arithmetic(flow: Flow) -> Arithmetic:
    """The rule's arithmetic on nodes. What has no number at the sample has none in any row."""

    def number(value: Any) -> Number:
        return value if isinstance(value, Number) else Number(flow, flow.constant(float(value)))

    def larger(one: Any, other: Any) -> Any:
        if not isinstance(one, Number) and not isinstance(other, Number):
            return max(one, other)
        a, b = number(one), number(other)
        left, right = (_node(flow, n) for n in (a, b))
        return Number(flow, flow.add("where", flow.add("lt", left, right), right, left))

    def decade(value: Any) -> Any:
        if not isinstance(value, Number):
            return math.log10(min(max(abs(value), LEAST), MOST))
        size = larger(abs(value), LEAST)
        return Number(
            flow, flow.call("log10", flow.add("where", (size < MOST).node, size.node, number(MOST).node))
        )

    def there(value: Any, other: float) -> Any:
        return value if isinstance(value, Number) or value == value else other

    def rounded(value: Any) -> Any:
        return Number(flow, flow.add("rint", value.node)) if isinstance(value, Number) else round(value)

    return Arithmetic(there, lambda values: reduce(larger, values), rounded, decade)
