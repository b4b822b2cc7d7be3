"""The program of a record: a graph of operations, the results of each answer, and their conditions.

On arrays the endings are all answers of a row in their order, none of them twice; if the order is
not known beforehand they are exchanged in pairs by selections (an insertion sort without branches,
stable as the list is). Conditions implied by others, by the ranges of the numbers, are left out: a
number lies in up to three intervals, below zero, at zero and above. Rounding is monotonic, so the
ends of a result come from the ends of its operands by the operation itself (R. E. Moore, Interval
Analysis, 1966, without outward rounding). Comparisons are decided only for numbers that are
required to be finite.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Iterator, Sequence, Set
from dataclasses import dataclass
from itertools import product
from typing import Any, NamedTuple, TypeAlias

from rulesheets.model import reached
from solver.trace.flow import Flow
from solver.trace.graph import LOGICAL, OPERATIONS, NotCompilable, computed_from
from solver.trace.order import UNORDERED, Order, Ranked


class Ending(NamedTuple):
    """One answer as nodes of the graph: the wanted values (a symbol by its name), which count if
    all of ``holds`` is true."""

    results: tuple[int | str, ...]
    holds: tuple[int, ...]

    def without(self, conditions: Collection[int]) -> Ending:
        return self._replace(holds=tuple(one for one in self.holds if one not in conditions))


@dataclass(slots=True)
class Box:
    """Ranges of the numeric inputs: the ends of each. ``uses`` counts the answers given there."""

    ends: tuple[float, ...]
    uses: int = 0


class Program(NamedTuple):
    """``inputs`` is the number of inputs; ``symbols`` are the inputs, by place, that must have
    these values.

    The endings are all answers of a row, in the order of the sample; ``order`` gives that of a row.
    If one of them does not count, none does. ``brief`` computes only the first answer of most rows:
    of its endings only the first one has to count. If answers are iterated, ``ranked`` orders them.
    Each input lies within the ``box``. The conditions ``watches`` show that cases without an answer
    still have none.
    """

    flow: Flow
    inputs: int
    endings: tuple[Ending, ...]
    symbols: tuple[tuple[int, str], ...] = ()
    order: Order = UNORDERED
    brief: Program | None = None
    ranked: Ranked | None = None
    box: Box | None = None
    watches: frozenset[int] = frozenset()

    @property
    def wanted(self) -> tuple[int, ...]:
        """Every node that is read of the answers."""
        return *self.holds, *(r for e in self.endings for r in e.results if isinstance(r, int))

    @property
    def holds(self) -> tuple[int, ...]:
        """All conditions of the answers."""
        return tuple(dict.fromkeys(check for ending in self.endings for check in ending.holds))


def checks_and_bounds(flow: Flow, conditions: Sequence[int]) -> tuple[list[int], dict[int, int]]:
    """Conditions, and the numbers that others require to be finite, separately."""
    finite = {n: int(flow.nodes[n][1]) for n in conditions if flow.nodes[n][0] == "finite"}
    return [n for n in dict.fromkeys(conditions) if n not in finite], finite


def counts(flow: Flow, conditions: Sequence[int], quick: bool = False) -> int:
    """The node that is true if conditions hold; ``quick``: by a shorter, sufficient test."""
    checks, numbers = checks_and_bounds(flow, conditions)
    holds = flow.over("and", (_straight(flow, check, quick) for check in checks))
    opposites = [n for n in computed_from(flow, checks) if flow.nodes[n][0] in ("not", "xor")]
    # rows have no sines of huge angles (nan), and nan is not less
    read = computed_from(flow, opposites)
    sines = sorted(n for n in read if flow.nodes[n][0] in ("sind", "cosd"))
    finite = dict.fromkeys((*numbers.values(), *sines))
    return (
        flow.add("and", holds, flow.node("finite", flow.over("add", finite))) if finite else holds
    )


def _straight(flow: Flow, condition: int, quick: bool) -> int:
    """A condition without its short cuts, which are useless if every row computes everything.

    With ``quick`` a short cut replaces the whole, but not its opposite.
    """
    kind, *parts = flow.nodes[condition]
    if kind == "sooner":
        return _straight(flow, int(parts[0 if quick else 1]), quick)
    if kind in ("and", "or", "not", "xor"):
        quick = quick and kind in ("and", "or")
        return flow.add(str(kind), *(_straight(flow, int(part), quick) for part in parts))
    return condition


def each_of(flow: Flow, conditions: Iterable[int]) -> Iterator[int]:
    for condition in conditions:
        kind, *parts = flow.nodes[condition]
        if kind == "and":
            yield from each_of(flow, map(int, parts))
        else:
            yield condition


class AllAnswers(NamedTuple):
    """``symbols`` (one for each wanted name) are the words that a column of symbols has the numbers
    of, or None.

    ``places`` are the wanted values of each place; ``there`` tells whether they differ from those
    of all earlier places. All of it counts if the node ``holds`` is true.
    """

    places: list[tuple[int, ...]]
    there: tuple[int, ...]
    symbols: tuple[tuple[str, ...] | None, ...]
    holds: int


def every(program: Program, in_order: bool, quick: bool) -> AllAnswers:
    """All answers of every row, sorted, or else unsorted; ``quick`` as in ``counts``.

    Raises NotCompilable if a column mixes symbols and numbers.
    """
    flow, order = program.flow, program.order
    symbols = tuple(map(_words, zip(*(ending.results for ending in program.endings), strict=True)))
    holds = counts(flow, program.holds, quick)
    pairs = [zip(ending.results, symbols, strict=True) for ending in program.endings]
    places = [
        tuple(flow.constant(float(w.index(str(r)))) if w else int(r) for r, w in pair)
        for pair in pairs
    ]
    if in_order:
        holds = flow.over("and", (holds, *order.conditions))
        rows = (row + key for row, key in zip(places, order.keys, strict=True))
        places = _sorted(flow, rows, len(symbols))
    there = [  # the values of a place differ from those of all earlier ones
        flow.over("and", (flow.add("not", flow.alike(before, place)) for before in places[:at]))
        for at, place in enumerate(places)
    ]
    return AllAnswers(places, tuple(there), symbols, holds)


def _words(column: tuple[int | str, ...]) -> tuple[str, ...] | None:
    """The possible symbols of a wanted variable."""
    words = {result for result in column if isinstance(result, str)}
    if words and not all(isinstance(result, str) for result in column):
        raise NotCompilable
    return tuple(sorted(words)) or None


def _sorted(flow: Flow, rows: Iterable[tuple[int, ...]], width: int) -> list[tuple[int, ...]]:
    """The first nodes of so many rows, sorted by the others."""
    placed: list[tuple[int, ...]] = []
    for row in rows:
        placed.append(row)
        for at in range(len(placed) - 1, 0, -1):
            one, other = placed[at - 1 : at + 1]
            swap = _less(flow, other[width:], one[width:])
            placed[at - 1 : at + 1] = (
                tuple(flow.add("where", swap, a, b) for a, b in zip(*pair, strict=True))
                for pair in ((other, one), (one, other))
            )
    return [row[:width] for row in placed]


def _less(flow: Flow, one: tuple[int, ...], other: tuple[int, ...]) -> int:
    """Lexicographic order."""
    less = flow.false
    for a, b in reversed(list(zip(one, other, strict=True))):
        less = flow.add("or", flow.add("lt", a, b), flow.add("and", flow.add("eq", a, b), less))
    return less


Range: TypeAlias = tuple[float, float]
Pieces: TypeAlias = tuple[Range, ...]
"""Closed ranges, none of them across zero, in their order."""

LEAST, MOST = math.ulp(0.0), 1e300
ANY: Pieces = ((-math.inf, -LEAST), (0.0, 0.0), (LEAST, math.inf))
_MONOTONIC = frozenset({"add", "sub", "mul", "div", "neg", "sqrt", "abs"})
_WITHIN = dict.fromkeys(("sind", "cosd", "sin", "cos"), 1.0 + 1e-9)
_WITHIN |= {"directiond": 180.1, "atan2d": 180.1, "direction": 3.15, "atan2": 3.15}
_INHERITING = frozenset({"add", "sub", "mul", "neg", "abs", "sqrt", "sind", "cosd", "sin", "cos"})
"""Operations without a finite result if an operand has none."""


def joined(ranges: Iterable[Range]) -> Pieces:
    """The union of the intervals of some ranges."""
    all_of = list(ranges)
    below = [(a, min(b, -LEAST)) for a, b in all_of if a < 0.0]
    zero = [(0.0, 0.0) for a, b in all_of if a <= 0.0 <= b]
    above = [(max(a, LEAST), b) for a, b in all_of if b > 0.0]
    return tuple((min(s)[0], max(b for _, b in s)) for s in (below, zero, above) if s)


def shared(one: Iterable[Range], other: Iterable[Range]) -> Pieces:
    """The intersection of some ranges with others."""
    pairs = ((max(a, c), min(b, d)) for (a, b), (c, d) in product(one, other))
    return joined((a, b) for a, b in pairs if a <= b)


def simplified(program: Program) -> Program:
    """The same program without conditions that others imply, and without their operands."""
    return _Simplification(program).program()


class _Simplification:
    """The known ranges of the nodes of a record if all its conditions hold."""

    def __init__(self, program: Program) -> None:
        self.old, self.flow, self.order = program, program.flow, program.order
        self.ranges: dict[int, Pieces] = {}
        self.nodes: dict[int, int] = {}
        """The simplified form of each node."""
        self.checks, self.finite = checks_and_bounds(self.flow, program.holds)
        self.sure = self._with(self.finite.values())

    def program(self) -> Program:
        old, order = self.old, self.order
        kept: dict[int, int] = {}
        for check in dict.fromkeys(each_of(self.flow, self.checks)):
            self._meet([check])
            if self.nodes[check] != self.flow.true:
                kept[check] = self.nodes[check]
                self._assume(check, True)
        self._meet((*old.wanted, *order.nodes))
        heads = self._heads()
        kept |= {one: self.nodes[one] for one, number in self.finite.items() if number in heads}
        endings = tuple(
            Ending(
                tuple(r if isinstance(r, str) else self.nodes[r] for r in ending.results),
                tuple(
                    dict.fromkeys(
                        kept[one] for one in each_of(self.flow, ending.holds) if one in kept
                    )
                ),
            )
            for ending in old.endings
        )
        keys = tuple(tuple(self.nodes[n] for n in key) for key in order.keys)
        asked = tuple(self.nodes[n] for n in order.conditions if self.nodes[n] != self.flow.true)
        usual = tuple((self.nodes[n], low, high) for n, low, high in order.usual)
        return old._replace(endings=endings, order=Order(keys, asked, usual))

    def _meet(self, wanted: Iterable[int]) -> None:
        """Simplify nodes and their operands, with their ranges."""
        for node in sorted(computed_from(self.flow, wanted, self.nodes)):
            self.nodes[node] = self._left_of(node)
            if self.flow.nodes[node][0] not in LOGICAL:
                self.ranges[node] = self._range(node)
            self._spread(node, self.sure)

    def _left_of(self, node: int) -> int:
        flow = self.flow
        kind, *rest = flow.nodes[node]
        read = flow.operands[node]
        new = [self.nodes[part] for part in read]
        if kind in ("and", "or", "not", "xor"):
            return flow.add(str(kind), *new)
        if kind in ("lt", "le", "eq"):
            told = self._decided(str(kind), *read)
            return flow.node(kind, *new) if told is None else flow.constant(told)
        if kind == "sooner" and flow.value_of(new[0]) is not None:
            return new[0] if flow.value_of(new[0]) else new[1]
        if kind == "where" and flow.value_of(new[0]) is not None:
            return new[1 if flow.value_of(new[0]) else 2]
        return flow.node(kind, *rest[: len(rest) - len(read)], *new)

    def _range(self, node: int) -> Pieces:
        kind, *rest = self.flow.nodes[node]
        read = [self.ranges.get(part, ANY) for part in self.flow.operands[node]]
        name = rest[0] if kind == "call" else kind
        if kind == "const":
            value: Any = rest[0]
            return ANY if isinstance(value, bool) or value != value else joined([(value, value)])
        if name in _WITHIN:
            return joined([(-_WITHIN[str(name)], _WITHIN[str(name)])])
        if kind in ("where", "max"):
            return joined((*read[-2], *read[-1]))
        if kind not in _MONOTONIC or (kind == "div" and (0.0, 0.0) in read[1]):
            return ANY
        alike = len(rest) == 2 and rest[0] == rest[1]
        pairs = zip(*read, strict=True) if alike else product(*read)
        return joined(filter(None, (self._ends(str(kind), pair) for pair in pairs)))

    def _ends(self, kind: str, pieces: Iterable[Range]) -> Range | None:
        corners = (corner for corner in product(*pieces) if kind != "sqrt" or corner[0] >= 0.0)
        ends = [OPERATIONS[kind].value(*corner) for corner in corners]
        numbers = [float(end) for end in ends if end == end]
        return (min(numbers), max(numbers)) if numbers else None

    # --- comparisons ---

    def _decided(self, kind: str, a: int, b: int) -> bool | None:
        """The outcome of a comparison if it is the same in all rows."""
        if not {a, b} <= self.sure:
            return None
        signs = set[int]()  # those that ``a - b`` can have
        for (low, high), (least, most) in product(self.ranges[a], self.ranges[b]):
            can = (-1, low < most), (0, low <= most and least <= high), (1, high > least)
            signs.update(sign for sign, possible in can if possible)
        wanted = {"lt": {-1}, "le": {-1, 0}, "eq": {0}}[kind]
        return signs <= wanted if signs <= wanted or not signs & wanted else None

    # --- ranges from conditions ---

    def _assume(self, node: int, holds: bool) -> None:
        self.nodes[node] = self.flow.constant(holds)
        kind, *parts = self.flow.nodes[node]
        if kind == "not":
            self._assume(int(parts[0]), not holds)
        for number, pieces in self._said(node, holds).items():
            self.ranges[number] = pieces
            for other in (self.flow.number(sign, number) for sign in ("abs", "neg")):
                if other in self.ranges:
                    self.ranges[int(other)] = self._range(int(other))

    def _said(self, node: int, holds: bool) -> dict[int, Pieces]:
        """The ranges of numbers for which a condition holds, or does not."""
        kind, *rest = self.flow.nodes[node]
        if kind not in ("lt", "le", "eq") or not all(self.ranges[int(part)] for part in rest):
            return {}
        a, b = (int(part) for part in rest)
        if kind != "eq" and not holds:
            kind, a, b = "le" if kind == "lt" else "lt", b, a
        low, high = self.ranges[a][0][0], self.ranges[b][-1][1]
        if kind == "lt":
            low, high = math.nextafter(low, math.inf), math.nextafter(high, -math.inf)
        if kind != "eq":
            return dict([*self._within(a, -math.inf, high), *self._within(b, low, math.inf)])
        if holds:
            return dict(self._within(a, self.ranges[b][0][0], high))
        zero = self.ranges[b] == ((0.0, 0.0),)
        return {a: tuple(piece for piece in self.ranges[a] if piece[0])} if zero else {}

    def _within(self, node: int, low: float, high: float) -> Iterator[tuple[int, Pieces]]:
        """A number between two others, and the numbers of which it is the size or the opposite."""
        pieces = shared(self.ranges[node], [(low, high)])
        yield node, pieces
        kind, *parts = self.flow.nodes[node]
        if kind in ("abs", "neg"):
            inside, signs = int(parts[0]), (-1.0, 1.0) if kind == "abs" else (-1.0,)
            ends = [(min(s * a, s * b), max(s * a, s * b)) for a, b in pieces for s in signs]
            yield inside, shared(self.ranges[inside], ends)

    # --- numbers that are finite with others ---

    def _with(self, finite: Iterable[int], known: Set[int] = frozenset()) -> set[int]:
        """The nodes that are finite if these are, and those known to be."""

        def inherited(node: int) -> Iterable[int]:
            kind, *parts = self.flow.nodes[node]
            return map(int, parts if kind in _INHERITING else parts[:1] if kind == "div" else ())

        return reached(finite, inherited, known) | known

    def _heads(self) -> set[int]:
        """Of numbers that must be finite, a set whose finiteness implies that of all."""
        heads, sure = set[int](), set[int]()
        for node in sorted({*self.finite.values()}, reverse=True):
            if node not in sure:
                heads.add(node)
                sure = self._with([node], sure)
        for node in sorted(n for n in heads if self._bounded(n)):
            sure = self._with(heads - {node})
            for part in sorted(computed_from(self.flow, [node])):
                self._spread(part, sure)
            if node in sure:
                heads.remove(node)
        return heads

    def _spread(self, node: int, sure: set[int]) -> None:
        """Finite numbers give a finite number if it is not too large."""
        kind, name, *_ = self.flow.nodes[node]
        known = kind in _MONOTONIC - {"sqrt"} or (name if kind == "call" else kind) in _WITHIN
        whole = kind == "const" or (known and sure.issuperset(self.flow.operands[node]))
        if whole and self._bounded(node):
            sure.add(node)

    def _bounded(self, node: int) -> bool:
        return all(a > -MOST and b < MOST for a, b in self.ranges[node])
