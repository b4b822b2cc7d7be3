"""A block with several tears as one with a single tear: smaller blocks inside it are solved by
formula.

With one unknown of a block known, the others often follow from smaller blocks, one after another:
the loop of a linkage for its angles, then lines for its velocities. Where each of these is one
isolated rule or has a closed form, they are assignments of a chain, with two branches for each
circle and parabola, and one rule is left as its residual. (Substitution before tearing: Elmqvist &
Otter, ESM 1994, 326-332.)
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable, Iterator, Mapping
from functools import cache, partial
from math import ceil, inf, isfinite, prod
from operator import attrgetter
from typing import Any, NamedTuple, TypeAlias

from rulesheets.deadline import expect_time
from rulesheets.syntax import nodes
from rulesheets.syntax.nodes import (
    Call,
    Expression,
    Name,
    Quotient,
    call,
    rebuilt,
    substitute,
    walk,
)
from solver.kernel.block import BlockKernel, candidates
from solver.kernel.chain import (
    MAX_CHAINS,
    RESIDUAL,
    Assignment,
    Chain,
    Ways,
    alternatives,
    assigned,
    is_exhaustive,
)
from solver.path import Coefficient, Let
from solver.path.elimination import closed_form
from solver.path.graph import ModelGraph
from solver.path.polynomial import CIRCULAR, Generators, NoForm
from solver.structure.decomposition import (
    Block,
    Incidence,
    block_triangular,
    dulmage_mendelsohn,
    maximum_matching,
)

MOST_UNKNOWNS = 40
MOST_TRIED, MOST_LEFT = 8, 16
"""Tears for which formulas are looked for, and the rules for each that are left out in turn."""
MOST_TEARS, MOST_FORMS = 2, 4
"""Tears of which the ranges are searched, and forms of a tear for what others leave open."""
LARGEST, LARGER = 8, 3
"""Unknowns of a block inside another; and how many times as many as with another rule left out."""

Angles: TypeAlias = dict[str, tuple[str, str]]
"""The names of the cosine and the sine of angles."""
Solved: TypeAlias = Callable[[Block, str], tuple[Ways, Angles]]
"""The ways to solve a block, given a tear."""


class Order(NamedTuple):
    """The blocks that follow from a tear, in order, and the rule that is left. A tear is endless
    if its range is."""

    tear: str
    is_endless: bool
    blocks: tuple[Block, ...]
    residual: int

    @property
    def effort(self) -> tuple[int, int]:
        sizes = [len(block.unknowns) for block in self.blocks]
        return max(sizes), sum(size * size for size in sizes)


class Form(NamedTuple):
    """The chains of an order, and the divisors at whose zeros they do not bound an unknown."""

    is_endless: bool
    length: int
    residual: int
    divisors: frozenset[Expression]
    chains: tuple[Chain, ...]

    @classmethod
    def of(cls, order: Order, chains: tuple[Chain, ...]) -> Form:
        items = [item for chain in chains for item in chain.assignments]
        meaning: dict[Expression, Expression] = {
            Name(item.name): item.expression for item in items if item.name.startswith("#")
        }
        below = (i.expression.right for i in items if isinstance(i.expression, Quotient))
        divisors = frozenset(meaning.get(divisor, divisor) for divisor in below)
        length = len(walk(*(item.expression for item in items)))
        return cls(order.is_endless, length, order.residual, divisors, chains)


def nested(kernel: BlockKernel) -> tuple[BlockKernel, ...]:
    """The block with a single tear, for a few tears; none if it has no such form."""
    key, kept = ("nested", kernel.block), kernel.graph.kernels
    if key not in kept:
        kept[key] = tuple(_nested(kernel)) if len(kernel.unknowns) <= MOST_UNKNOWNS else ()
    found: tuple[BlockKernel, ...] = kept[key]
    return found


def _nested(kernel: BlockKernel) -> Iterator[BlockKernel]:
    """Those with a finite range of the tear first, and then the shortest formulas: these bound the
    residual best. Of one tear several follow one another: a divisor that vanishes in one may be
    missing in another."""
    forms = dict[str, list[Form]]()
    solved = cache(partial(_solved, kernel.graph))
    for order in _orders(kernel):
        chains = _chains(kernel.graph, order, solved) if order.effort[0] <= LARGEST else ()
        if chains:
            forms.setdefault(order.tear, []).append(Form.of(order, chains))
    best = sorted(map(_least_alike, forms.values()), key=lambda pair: pair[0][:2])[:MOST_TEARS]
    for form in itertools.chain.from_iterable(best):
        block = kernel.block._replace(tears=form.chains[0].tears, residuals=(form.residual,))
        torn = BlockKernel(kernel.graph, block)
        torn.chains, torn.exhaustive = form.chains, True
        yield torn


def _least_alike(forms: Iterable[Form]) -> list[Form]:
    """The shortest form, and others that share the fewest divisors with those before."""
    others = sorted(forms, key=attrgetter("length"))
    chosen = [others.pop(0)]
    while others and len(chosen) < MOST_FORMS:
        common = frozenset.intersection(*(form.divisors for form in chosen))
        shared = [len(form.divisors & common) for form in others]
        chosen.append(others[shared.index(min(shared))])
        others = [form for form in others if form.divisors != chosen[-1].divisors]
    return chosen


def _orders(kernel: BlockKernel) -> Iterator[Order]:
    """Orders for some tears that leave small blocks, each with several rules that may be left."""
    graph, equations = kernel.graph, tuple(sorted(kernel.block.equations))
    unknowns = sorted(graph.number[name] for name in kernel.unknowns)
    found: list[tuple[Order, Incidence, tuple[int, ...]]] = []
    for tear in unknowns:
        expect_time()
        others = tuple(u for u in unknowns if u != tear)
        occurs = {e: tuple(u for u in graph.occurs[e] if u in others) for e in equations}
        part = Incidence(
            occurs, {e: {} for e in equations}, len(graph.names), Block(equations, others)
        )
        matching = maximum_matching(part)
        if not matching.single_unknowns:
            over = dulmage_mendelsohn(part, matching).over.equations
            name = graph.names[tear]
            endless = not all(map(isfinite, kernel.domain(name)))
            found.append((_order(part, name, endless, over[-1]), part, over))
    found.sort(key=lambda one: (one[0].is_endless, one[0].effort))
    for first, part, over in found[:MOST_TRIED]:
        rules = over[:: ceil(len(over) / MOST_LEFT)]
        orders = [_order(part, first.tear, first.is_endless, left) for left in rules]
        largest = LARGER * min(order.effort[0] for order in orders)
        yield from (order for order in orders if order.effort[0] <= largest)


def _order(part: Incidence, tear: str, endless: bool, left: int) -> Order:
    kept = tuple(e for e in part.block.equations if e != left)
    blocks = block_triangular(part.restrict(Block(kept, part.block.unknowns)))
    return Order(tear, endless, blocks, left)


def _chains(graph: ModelGraph, order: Order, solved: Solved) -> tuple[Chain, ...]:
    ways: list[Ways] = []
    angles: Angles = {}
    for block in order.blocks:
        found, own = solved(block, order.tear)
        if not found:
            return ()
        angles |= own
        ways.append(tuple(tuple(_with_sides(item, angles) for item in way) for way in found))
    if prod(map(len, ways)) > MAX_CHAINS:
        return ()
    rule = graph.model.equations[order.residual]
    last = _with_sides(Assignment(f"{RESIDUAL}{order.residual}", rule.left - rule.right), angles)
    return tuple(
        Chain((order.tear,), (*itertools.chain.from_iterable(way), last), (last.name,))
        for way in itertools.product(*ways)
    )


def _solved(graph: ModelGraph, block: Block, tear: str) -> tuple[Ways, Angles]:
    """The preimages or branches of a block inside another; none if they may not be all."""
    names, prefix = [graph.names[unknown] for unknown in block.unknowns], f"#{block.equations[0]}"
    if (
        len(names) == 1
        and (isolation := graph.isolation(block.equations[0], block.unknowns[0])) is not None
    ):
        every = is_exhaustive(graph, isolation)
        return alternatives(graph, isolation, prefix) if every else (), {}
    turning = [name for name in names if graph.is_turning(name)]
    rules = [graph.model.equations[e] for e in block.equations]
    if any(graph.model.variables[name].ranged for name in turning) or (
        (form := closed_form(rules, names, turning, tear)) is None
    ):
        return (), {}
    start = _Assignments(graph, prefix, {})
    found = tuple(branch.items for branch, _ in candidates(form, start, {}))
    if any(nodes.is_number(item.expression, 0.0) for way in found for item in way):
        return (), {}  # of x*y = 0 the formula is y = 0, and at x = 0 y may be anything
    return found, start.angles


class _Assignments:
    """The closed form of a block as assignments, for a ``prefix`` of their own names: the numbers
    are expressions, and whatever must not be negative is assigned and bounded."""

    def __init__(
        self, graph: ModelGraph, prefix: str, angles: Angles, items: tuple[Assignment, ...] = ()
    ) -> None:
        self.graph, self.prefix, self.angles, self.items = graph, prefix, angles, items

    def fork(self) -> _Assignments:
        return _Assignments(self.graph, self.prefix, self.angles, self.items)

    def let(self, formula: Let, known: Mapping[str, Name]) -> Name:
        number = substitute(formula.expression, known)
        match formula.expression:
            case Call("atan2" | "atan2d", (Name(sine), Name(cosine))):
                self.angles[formula.name] = known[cosine].name, known[sine].name
        low = 0.0 if formula.size is not None and not formula.divisor else -inf
        item = self._assigned(formula.name, number, low)
        if isinstance(number, Quotient):
            item = item._replace(relational=True, reciprocal=number.left == nodes.ONE)
        return self._added(item)

    def coefficient(self, part: Coefficient, known: Mapping[str, Name]) -> Expression:
        return substitute(part.expression, known)

    def apart(self, divisor: Expression) -> Name:
        return self._added(Assignment(f"{self.prefix}.{len(self.items)}", divisor))

    def square_roots(self, one: Expression, other: Expression) -> tuple[Expression, ...]:
        square = self.apart(one - other)
        self.items = (*self.items[:-1], self.items[-1]._replace(low=0.0))
        return call("sqrt", square), -call("sqrt", square)

    def roots(self, a: Expression, b: Expression, c: Expression) -> tuple[Expression, ...]:
        """Each by one formula: intervals have no sign of b."""
        both = self.square_roots(b**2.0, 4.0 * (a * c))
        return tuple((-b + root) / (2.0 * a) for root in both)

    def kept(self, formula: Any, found: Mapping[str, Expression]) -> dict[str, Name]:
        items = {name: self._assigned(name, number) for name, number in found.items()}
        return {n: self._added(item._replace(relational=True)) for n, item in items.items()}

    def _assigned(self, name: str, number: Expression, low: float = -inf) -> Assignment:
        variable = self.graph.model.variables.get(name)
        if variable is None:
            return Assignment(self.prefix + name, number, low)
        item = assigned(variable, number)
        return item._replace(low=max(low, item.low))

    def _added(self, item: Assignment) -> Name:
        self.items = (*self.items, item)
        return Name(item.name)


def _with_sides(item: Assignment, angles: Angles) -> Assignment:
    """An assignment with the cosines and sines of solved angles in place of functions of them."""
    if angles.keys().isdisjoint(nodes.names(item.expression)):
        return item
    return item._replace(expression=_by_sides(item.expression, angles))


def _by_sides(node: Expression, angles: Angles) -> Expression:
    if angles.keys().isdisjoint(nodes.names(node)):
        return node
    if isinstance(node, Call) and node.function in CIRCULAR:
        generators = Generators(frozenset(angles), angles)
        try:
            found = generators.polynomial(node).expression(generators.meaning)
        except NoForm:
            return node
        told = {
            f"#{k} {n}": Name(side)
            for n, sides in angles.items()
            for k, side in zip("cs", sides, strict=True)
        }
        return substitute(found, told)
    return rebuilt(node, tuple(_by_sides(part, angles) for part in node.parts))
