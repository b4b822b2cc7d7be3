"""A block of several tears with its definitions substituted, where that leaves a single tear.

Where a rule of the block just says what one unknown is (``y = K*x``), its right side can stand for the
unknown everywhere else. An unknown that then occurs more than once in a rule may still be isolated from it
(``V*(K*x) + (1 - V)*x = z``), and a tear that gives all the others leaves one equation in one unknown,
whose whole range can be searched. (Substitution before tearing: Elmqvist & Otter, ESM 1994, 326-332.)
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from rulesheets.syntax import nodes
from rulesheets.syntax.nodes import Expression, Name, substitute, subtract
from solver.kernel.code.block import BlockKernel
from solver.kernel.code.chain import RESIDUAL, Assignment, Chain, through
from solver.path.isolate import Isolation, isolate

if TYPE_CHECKING:
    from rulesheets.syntax.nodes import Condition
    from solver.path.graph import ModelGraph
    from solver.path.steps import SolveBlock

    Equations = dict[int, tuple[Expression, Expression]]
    Definitions = list[tuple[str, Expression]]
    Order = list[tuple[int, str, Isolation]]

MOST_UNKNOWNS = 40
LONGEST = 12
"""Nodes of a right side that is worth repeating wherever its unknown occurs."""


class ReducedKernel(BlockKernel):
    """The kernel of a block that one chain with one tear covers."""

    def __init__(self, graph: ModelGraph, block: SolveBlock, chain: Chain) -> None:
        super().__init__(graph, replace(block, tears=chain.tears))
        self._chains = (chain,)
        self.exhaustive = True  # every isolation of the chain has one preimage


def reduced(kernel: BlockKernel) -> BlockKernel | None:
    """The same block with one tear, after substitution; None where that is not to be had."""
    kept = kernel.graph.kernels
    key = "reduced", kernel.block
    if key not in kept:
        chain = _chain(kernel.graph, kernel.block)
        kept[key] = None if chain is None else ReducedKernel(kernel.graph, kernel.block, chain)
    found: BlockKernel | None = kept[key]
    return found


def _chain(graph: ModelGraph, block: SolveBlock) -> Chain | None:
    if len(block.unknowns) > MOST_UNKNOWNS:
        return None
    bodies = (graph.model.equations[number] for number in block.equations)
    equations = {body.index: (body.left, body.right) for body in bodies}
    definitions = _substituted(equations, set(block.unknowns))
    if not definitions:
        return None
    left = [name for name in block.unknowns if name not in dict(definitions)]
    found = [(tear, order) for tear in left if (order := _order(equations, left, tear)) is not None]
    if not found:
        return None
    tear, order = min(found, key=lambda each: sum(isolation.cost for _, _, isolation in each[1]))
    assignments: list[Assignment] = []
    for number, (_, unknown, isolation) in enumerate(order):
        (steps,) = through(isolation, f"#{number}", graph.model.variables[unknown])
        assignments += steps
    for name, expression in reversed(definitions):
        variable = graph.model.variables[name]
        ends = variable.low, variable.high, variable.low_open, variable.high_open
        assignments.append(Assignment(name, expression, *ends))
    (last,) = equations.keys() - {equation for equation, _, _ in order}
    residual = Assignment(f"{RESIDUAL}{last}", subtract(*equations[last]))
    return Chain((tear,), (*assignments, residual), (residual.name,))


def _substituted(equations: Equations, unknowns: set[str]) -> Definitions:
    """Take definitions out of ``equations`` and put them in for what they define; the first of them first."""
    found: Definitions = []
    while (definition := _definition(equations, unknowns)) is not None:
        number, name, expression = definition
        del equations[number]
        unknowns = unknowns - {name}
        for other, sides in equations.items():
            if any(name in nodes.names(side) for side in sides):
                left, right = (substitute(side, {name: expression}) for side in sides)
                equations[other] = left, right
        found.append((name, expression))
    return found


def _definition(equations: Equations, unknowns: set[str]) -> tuple[int, str, Expression] | None:
    for number, (left, right) in equations.items():
        for one, other in ((left, right), (right, left)):
            if not isinstance(one, Name) or one.name not in unknowns:
                continue
            read = set(nodes.names(other)) & unknowns
            if read and one.name not in read and _length(other) <= LONGEST:
                return number, one.name, other
    return None


def _length(expression: Expression | Condition) -> int:
    return 1 + sum(map(_length, nodes.children(expression)))


def _order(equations: Equations, unknowns: list[str], tear: str) -> Order | None:
    """How the other unknowns follow from a tear, each from one equation in one way, if they do."""
    waiting, unsolved = dict(equations), set(unknowns) - {tear}
    order: Order = []
    moving = True
    while moving and unsolved:
        moving = False
        for number, sides in list(waiting.items()):
            open_ = {name for side in sides for name in nodes.names(side)} & unsolved
            if len(open_) != 1:
                continue
            (unknown,) = open_
            isolation = isolate(*sides, unknown)
            if isolation is None or isolation.branches > 1 or isolation.period:
                continue
            order.append((number, unknown, isolation))
            del waiting[number]
            unsolved.discard(unknown)
            moving = True
    return order if not unsolved and len(waiting) == 1 else None
