"""The ranking of answers as operations of a record.

``Ranking`` is written over numbers of any kind; here they are nodes of a program. The keys of the
answers are written as far as they order them at the sample; if that part is equal for two of them,
another record decides. Over ranges of numbers the ranking shows in which the order of the sample is
kept: interval arithmetic without outward rounding, since the ranking compares at a resolution of a
millionth.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import partial, reduce
from itertools import combinations, pairwise, product
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from solver.ranking.ranking import LEAST, MOST, Arithmetic, Key, Ranking, is_measured
from solver.trace.flow import Flow
from solver.trace.graph import NotCompilable
from solver.trace.number import Number, node_of
from solver.trace.ranges import Pair, Ranges

SAFETY = 2.0
"""The factor by which all moves together may exceed the sum of single ones."""


class KeyRanges:
    """The keys of answers over ranges of the numbers that the ranking reads."""

    def __init__(self, ranked: Ranked, zero: tuple[bool, ...]) -> None:
        ranking, answers, given = ranked
        table, places = Flow(), dict[int, int]()
        rows = [
            [
                None if node is None else table.input(places.setdefault(node, len(places)))
                for node in row
            ]
            for row in (*answers, given)
        ]
        keys = keys_as_nodes(table, ranking, rows[:-1], rows[-1], zero)
        self.places, self.parts = places, len(keys[0])
        self._ranges = Ranges(table, [part for key in keys for part in key])

    def __call__(self, ends: Mapping[int, Pair]) -> list[list[Pair]]:
        """For each answer the pairs of the parts of its key, from those (spans,) of the nodes."""
        found = self._ranges([ends[node] for node in self.places])
        return [found[at : at + self.parts] for at in range(0, len(found), self.parts)]


def before(
    one: Sequence[Pair], other: Sequence[Pair], known: Sequence[tuple[Key, Key]] = ()
) -> NDArray[np.bool_]:
    """Whether one key is less than another for all numbers in the ranges, (spans,).

    ``known`` are both keys at some points, as ``spread`` takes them: for parts that are not counts,
    their distances decide if the ranges do not.
    """
    sooner, alike = np.False_, np.True_
    for place, (a, b) in enumerate(zip(one, other, strict=True)):
        sooner = sooner | (alike & (a[1] < b[0]))
        level = a[1] <= b[0]
        if known and is_measured(place):
            apart = [float(second[place] - first[place]) for first, second in known]
            sooner = sooner | (alike & ~level & (apart[0] > spread(apart)))
            level = level | (not any(apart))
        alike = alike & level
    return np.asarray(sooner)


def spread(numbers: Sequence[float]) -> float:
    """The combined effect of all moves: first the old value, then two values for each input."""
    here, there = numbers[0], numbers[1:]
    pairs = zip(there[::2], there[1::2], strict=True)
    return SAFETY * sum(max(abs(one - here), abs(other - here)) for one, other in pairs)


FACTORS = (10.0, 5.0, 3.0, 2.0, 1.5, 1.2, 1.1, 1.05, 1.02, 1.01)
"""The ranges around numbers of the sample for which the order may be known, the widest first."""
FAR = 1e200
"""Numbers up to which one may be anything."""
TURNED = 30.0
"""The same for angles, in degrees for a factor of 2."""


Ends: TypeAlias = tuple[tuple[int, float, float], ...]


class Order(NamedTuple):
    """The order of answers: by ``keys``, under ``conditions`` that make these decide.

    If the nodes of ``usual`` lie between their ends the answers are in the order of the sample,
    whatever the keys are, and if those of ``first`` do the first one is the first.
    """

    keys: tuple[tuple[int, ...], ...] = ()
    conditions: tuple[int, ...] = ()
    usual: Ends = ()
    first: Ends = ()

    @property
    def nodes(self) -> tuple[int, ...]:
        """Every node that is read to sort the answers."""
        return (
            *self.conditions,
            *(n for key in self.keys for n in key),
            *(n for n, _, _ in self.usual),
        )


UNORDERED = Order()


class Ranked(NamedTuple):
    """The input of the ``ranking``: nodes of the names of each answer, and of the given ones; None
    for one without a number."""

    ranking: Ranking
    answers: tuple[tuple[int | None, ...], ...]
    given: tuple[int | None, ...]


def order(
    flow: Flow,
    ranked: Ranked,
    numbers: Callable[[int], float],
    beforehand: bool,
    double: Sequence[bool],
) -> Order:
    """Sorts answers that are in order at the sample; ``beforehand``: and the ranges in which this
    is known. Those at ``double`` roots come last.

    ``numbers`` gives the value of a node at the sample. Raises NotCompilable if the ranking does
    not distinguish the answers of the sample.
    """

    ranking, answers, given = ranked
    zero = tuple(node is not None and numbers(node) == 0.0 for node in given)
    told = list[int]()
    for node, none in zip(given, zero, strict=True):  # numbers suggest sizes if they are not 0
        if node is not None:
            told.append(flow.is_zero(node) if none else flow.add("not", flow.is_zero(node)))
    found = zip(double, keys_as_nodes(flow, ranking, answers, given, zero), strict=True)
    keys = [(flow.constant(float(last)), *key) for last, key in found]
    decides = 0
    for one, other in combinations(keys, 2):
        pairs = enumerate(zip(one, other, strict=True))
        place = next((place for place, (a, b) in pairs if numbers(a) != numbers(b)), None)
        if place is None:
            raise NotCompilable
        decides = max(decides, place)
    keys = [key[: decides + 1] for key in keys]
    told += [flow.add("not", flow.alike(*pair)) for pair in combinations(keys, 2)]
    needed = tuple(node for node in told if node != flow.true)
    if not beforehand:
        return Order(tuple(keys), needed)
    asked = partial(_usual, flow, ranked, KeyRanges(ranked, zero), numbers)
    usual = asked(pairwise)
    first = usual if len(keys) == 2 else asked(lambda some: product(some[:1], some[1:]))
    return Order(tuple(keys), needed, usual, first)


def keys_as_nodes(
    flow: Flow,
    ranking: Ranking,
    answers: Sequence[Sequence[int | None]],
    given: Sequence[int | None],
    zero: tuple[bool, ...],
) -> list[tuple[int, ...]]:
    """The nodes of the parts of each answer's key; ``zero`` marks the given numbers that are 0."""
    known, *rows = [
        [math.nan if node is None else Number(flow, node) for node in nodes]
        for nodes in (given, *answers)
    ]
    found = ranking.keys_on(_arithmetic(flow), rows, known, zero)
    return [tuple(node_of(flow, part) for part in key) for key in found]


def _usual(
    flow: Flow,
    ranked: Ranked,
    keys: KeyRanges,
    numbers: Callable[[int], float],
    pairs: Callable[[Sequence[Any]], Iterable[tuple[Any, Any]]],
) -> Ends:
    """The widest ranges around the sample in which the ranking is known to order pairs of
    answers."""
    ranking, answers, given = ranked
    angles = dict(zip(ranking.names, ranking.angles, strict=True))
    kinds = dict[int, bool]()
    for answer in (*answers, given):
        names = ranking.known if answer is given else ranking.read
        for name, node in zip(names, answer, strict=True):
            if node is not None:
                kinds[node] = kinds.get(node, True) and angles.get(name, False)

    def told(ends: Mapping[int, Pair]) -> list[bool]:
        found = np.logical_and.reduce([before(*pair) for pair in pairs(keys(ends))])
        return [bool(one) for one in found]

    ends = {n: _around(flow, n, numbers(n), angle) for n, angle in kinds.items()}
    found = told(ends)
    if True not in found:
        return ()
    widest = found.index(True)
    ranges = {n: (float(low[widest]), float(high[widest])) for n, (low, high) in ends.items()}
    varying = {n for n in ranges if flow.value_of(n) is None}
    zeros = {node for node in given if node is not None and numbers(node) == 0.0}
    kept = varying - _free(told, ranges, sorted(varying - zeros))
    return tuple((n, *ranges[n]) for n in sorted(kept))


def _free(
    told: Callable[[Mapping[int, Pair]], list[bool]],
    ranges: Mapping[int, tuple[float, float]],
    nodes: Sequence[int],
) -> set[int]:
    """The nodes that may have any value: each is tried alone, then with all earlier ones of this
    kind."""

    def opened(compared: Any) -> list[bool]:
        turns = dict.fromkeys(found, 0) | {node: turn for turn, node in enumerate(waiting)}
        spans = np.arange(len(waiting))
        free = {n: compared(turns.get(n, len(waiting)), spans) for n in ranges}
        ends = (
            (n, (np.where(free[n], -FAR, a), np.where(free[n], FAR, b)))
            for n, (a, b) in ranges.items()
        )
        return told(dict(ends))

    found, waiting = set[int](), list(nodes)
    alone = opened(np.equal) if waiting else []
    waiting = [node for node, free in zip(waiting, alone, strict=True) if free]
    while waiting:
        count = [*opened(np.less_equal), False].index(False)
        found.update(waiting[:count])
        waiting = waiting[count + 1 :]
    return found


def _around(flow: Flow, node: int, number: float, angle: bool) -> Pair:
    """The ends (factors,) of the ranges around a number."""
    factors = np.array(FACTORS)
    if flow.value_of(node) is not None or not math.isfinite(number):
        return np.full(factors.shape, number), np.full(factors.shape, number)
    if angle:
        return number - TURNED * (factors - 1.0), number + TURNED * (factors - 1.0)
    ends = number / factors, number * factors
    return np.minimum(*ends), np.maximum(*ends)


def _arithmetic(flow: Flow) -> Arithmetic:
    """The ranking's arithmetic on nodes; one without a number at the sample never has one."""

    def larger(one: Any, other: Any) -> Any:
        if not isinstance(one, Number) and not isinstance(other, Number):
            return max(one, other)
        logical = [isinstance(n, Number) and n.logical for n in (one, other)]
        if all(logical):
            return Number(flow, flow.add("or", one.node, other.node))
        if any(logical) and 0.0 in (one, other):
            return one if logical[0] else other
        return Number(flow, flow.add("max", node_of(flow, one), node_of(flow, other)))

    def decade(value: Any) -> Any:
        if not isinstance(value, Number):
            return math.log10(min(max(abs(value), LEAST), MOST))
        return Number(flow, flow.call("log10", larger(abs(value), LEAST).node))

    def there(value: Any, other: float) -> Any:
        return value if isinstance(value, Number) or value == value else other

    def rounded(value: Any) -> Any:
        return (
            Number(flow, flow.add("rint", value.node))
            if isinstance(value, Number)
            else round(value)
        )

    return Arithmetic(there, lambda values: reduce(larger, values), rounded, decade)
