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
from collections.abc import Iterator, Mapping
from math import inf, isfinite, prod
from typing import NamedTuple, TypeAlias

from rulesheets.deadline import expect_time
from rulesheets.model import Variable
from rulesheets.syntax import nodes
from rulesheets.syntax.nodes import Call, Expression, Name, Quotient, call, rebuilt, substitute
from solver.kernel.block import BlockKernel
from solver.kernel.chain import (
    MAX_CHAINS,
    RESIDUAL,
    Assignment,
    Chain,
    alternatives,
    assigned,
    is_exhaustive,
)
from solver.path import Circle, ClosedForm, Let, Parabola
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
MOST_TRIED = 8
"""Tears for which formulas are looked for."""
MOST_TEARS = 2
"""Tears of which the ranges are searched."""
LARGEST = 8
"""Unknowns of a block inside another."""

Ways: TypeAlias = tuple[tuple[Assignment, ...], ...]
"""The sequences of assignments, one for each preimage or branch."""


class Order(NamedTuple):
    """The blocks that follow from a tear, in order, and the rule that is left."""

    tear: str
    blocks: tuple[Block, ...]
    residual: int

    @property
    def effort(self) -> tuple[int, int]:
        sizes = [len(block.unknowns) for block in self.blocks]
        return max(sizes), sum(size * size for size in sizes)


def nested(kernel: BlockKernel) -> tuple[BlockKernel, ...]:
    """The block with a single tear, for a few tears; none if it has no such form."""
    key, kept = ("nested", kernel.block), kernel.graph.kernels
    if key not in kept:
        kept[key] = tuple(_nested(kernel)) if len(kernel.unknowns) <= MOST_UNKNOWNS else ()
    found: tuple[BlockKernel, ...] = kept[key]
    return found


def _nested(kernel: BlockKernel) -> Iterator[BlockKernel]:
    """Those whose tear stands in most rules first, and then in a finite range."""
    small = (order for order in _orders(kernel) if order.effort[0] <= LARGEST)
    forms = [chains for order in small if (chains := _chains(kernel.graph, order))]

    def preference(chains: tuple[Chain, ...]) -> tuple[int, bool, int]:
        (tear,) = chains[0].tears
        users = sum(tear in equation.names for equation in kernel.equations)
        return (
            len(chains) - users,
            not all(map(isfinite, kernel.domain(tear))),
            len(chains[0].assignments),
        )

    for chains in sorted(forms, key=preference)[:MOST_TEARS]:
        torn = BlockKernel(kernel.graph, kernel.block._replace(tears=chains[0].tears))
        torn.chains, torn.exhaustive = chains, True
        yield torn


def _orders(kernel: BlockKernel) -> list[Order]:
    """The best order for some tears that leave small blocks."""
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
            found.append((_order(part, graph.names[tear], over[-1]), part, over))
    found.sort(key=lambda one: one[0].effort)
    return [
        min((_order(part, first.tear, left) for left in over), key=lambda order: order.effort)
        for first, part, over in found[:MOST_TRIED]
    ]


def _order(part: Incidence, tear: str, left: int) -> Order:
    kept = tuple(e for e in part.block.equations if e != left)
    return Order(tear, block_triangular(part.restrict(Block(kept, part.block.unknowns))), left)


def _chains(graph: ModelGraph, order: Order) -> tuple[Chain, ...]:
    ways: list[Ways] = []
    angles: dict[str, tuple[str, str]] = {}
    for number, block in enumerate(order.blocks):
        names = [graph.names[unknown] for unknown in block.unknowns]
        equation = block.equations[0]
        if (
            len(names) == 1
            and (isolation := graph.isolation(equation, block.unknowns[0])) is not None
        ):
            if not is_exhaustive(graph, isolation):
                return ()
            found = alternatives(graph, isolation, f"#{number}")
        else:
            turning = [name for name in names if graph.is_turning(name)]
            if not all(_is_free(graph.model.variables[name]) for name in turning):
                return ()
            form = closed_form(
                [graph.model.equations[e] for e in block.equations], names, turning, order.tear
            )
            if form is None:
                return ()
            found, own = _formulas(graph, form, f"#{number}")
            if any(nodes.is_number(item.expression, 0.0) for way in found for item in way):
                return ()  # of x*y = 0 the formula is y = 0, and at x = 0 y may be anything
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


def _is_free(variable: Variable) -> bool:
    return variable.low == -inf and variable.high == inf


def _formulas(
    graph: ModelGraph, form: ClosedForm, prefix: str
) -> tuple[Ways, dict[str, tuple[str, str]]]:
    """The branches of a closed form, and the names of the cosine and the sine of its angles."""
    own = {
        name: prefix + name for formula in form for name in _given(formula) if name.startswith("#")
    }
    names = {name: Name(told) for name, told in own.items()}

    def of(expression: Expression) -> Expression:
        return substitute(expression, names)

    def item(name: str, expression: Expression, relational: bool = False) -> Assignment:
        variable = graph.model.variables.get(name)
        found = (
            Assignment(own[name], expression)
            if variable is None
            else assigned(variable, expression)
        )
        return found._replace(relational=relational)

    steps: list[Ways] = []
    angles: dict[str, tuple[str, str]] = {}
    for number, formula in enumerate(form):
        root = Assignment(f"{prefix}.{number}", nodes.ZERO, low=0.0)
        match formula:
            case Let(name, Call("atan2" | "atan2d", (Name(sine), Name(cosine))) as angle):
                angles[name] = own[cosine], own[sine]
                steps.append(((item(name, of(angle)),),))
            case Let(name, expression, divisor, size):
                relational = isinstance(expression, Quotient)
                reciprocal = isinstance(expression, Quotient) and expression.left == nodes.ONE
                low = 0.0 if size is not None and not divisor else -inf
                found = item(name, of(expression), relational=relational)
                found = found._replace(low=max(low, found.low), reciprocal=reciprocal)
                steps.append(((found,),))
            case Parabola(name):
                a, b, c = (of(part.expression) for part in formula[1:])
                root = root._replace(expression=b**2.0 - 4.0 * (a * c))
                square = call("sqrt", Name(root.name))
                roots = ((-b + square) / (2.0 * a), (-b + -square) / (2.0 * a))
                steps.append(tuple((root, item(name, value, relational=True)) for value in roots))
            case Circle(x, y):
                a, b, k, radius = (of(part.expression) for part in formula[2:])
                length = Assignment(f"{prefix}.{number}l", a**2.0 + b**2.0)
                root = root._replace(expression=Name(length.name) * radius - k**2.0)
                both = call("sqrt", Name(root.name)), -call("sqrt", Name(root.name))
                steps.append(
                    tuple(
                        (
                            *(length, root),
                            item(x, (a * k - b * s) / Name(length.name), relational=True),
                            item(y, (b * k + a * s) / Name(length.name), relational=True),
                        )
                        for s in both
                    )
                )
    return tuple(
        tuple(itertools.chain.from_iterable(way)) for way in itertools.product(*steps)
    ), angles


def _given(formula: Let | Parabola | Circle) -> tuple[str, ...]:
    return (formula.x, formula.y) if isinstance(formula, Circle) else (formula.name,)


def _with_sides(item: Assignment, angles: Mapping[str, tuple[str, str]]) -> Assignment:
    """An assignment with the cosines and sines of solved angles in place of functions of them."""
    if angles.keys().isdisjoint(nodes.names(item.expression)):
        return item
    return item._replace(expression=_by_sides(item.expression, angles))


def _by_sides(node: Expression, angles: Mapping[str, tuple[str, str]]) -> Expression:
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
    return rebuilt(node, tuple(_by_sides(part, angles) for part in nodes.children(node)))
