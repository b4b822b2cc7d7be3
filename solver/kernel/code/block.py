"""A simultaneous block of a path: residual, Jacobian and the chains of its tearing, compiled when used."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Any

from rulesheets.evaluate import NotDifferentiable, derivatives, differentiate
from rulesheets.model import Value, Variable
from rulesheets.syntax import nodes
from rulesheets.syntax.nodes import Expression, subtract
from solver.kernel.code.chain import Chain, chains, compile_chain, directions, exhaustive, jumps
from solver.kernel.code.scalar import compile_expressions
from solver.kernel.code.sparse_system import SparseSystem
from solver.path.graph import ModelGraph
from solver.path.isolate import is_linear
from solver.path.steps import SolveBlock

if TYPE_CHECKING:
    from solver.kernel.code.block_arrays import BlockArrays
    from solver.kernel.code.enclosure import Enclosure
    from solver.path.closed_form import ClosedForm


class BlockKernel:
    """Residual, Jacobian and chains of a block, each compiled once for a path, when it is first used."""

    def __init__(self, graph: ModelGraph, block: SolveBlock) -> None:
        self.graph, self.block = graph, block
        self.equations = [graph.model.equations[e] for e in block.equations]
        self.unknowns = block.unknowns
        names = dict.fromkeys(name for e in self.equations for name in e.names)
        unknowns = frozenset(self.unknowns)
        self.known = tuple(name for name in names if name not in unknowns)
        self.forms = [subtract(e.left, e.right) for e in self.equations]
        self._chains: tuple[Chain, ...] | None = None
        self._others: tuple[BlockKernel, ...] | None = None
        self._enclosures: dict[int, Enclosure] = {}
        self._compiled: dict[int, Callable[..., Any]] = {}

    @cached_property
    def jumps(self) -> bool:
        """Whether an equation may jump, where its Jacobian does not show it."""
        return any(jumps(form) or any(directions(form)) for form in self.forms)

    @property
    def smooth(self) -> bool:
        """Whether every equation has its derivatives by formula."""
        return all(self.partials)

    def domain(self, name: str) -> tuple[float, float]:
        """Where to search an unknown: its declared range, and of an angle no more than one turn."""
        variable, turn = self.graph.model.variables[name], self.graph.turn(name)
        low, high = variable.low, variable.high
        if turn is None or (low > -math.inf and high < math.inf):
            return low, high
        if low > -math.inf:
            return low, low + turn
        return (high - turn, high) if high < math.inf else (-turn / 2, turn / 2)

    @property
    def finite(self) -> bool:
        """Whether boxes can be searched: finite ranges, and equations that are smooth by formula."""
        ends = (end for name in self.unknowns for end in self.domain(name))
        return not self.jumps and self.smooth and all(map(math.isfinite, ends))

    @cached_property
    def exhaustive(self) -> bool:
        return exhaustive(self.graph, self.block)

    @cached_property
    def divisors(self) -> tuple[Expression, ...]:
        """What the equations divide by that depends on unknowns."""
        unknowns = frozenset(self.unknowns)
        found = (divisor for form in self.forms for divisor in divisors(form))
        return tuple(h for h in found if not unknowns.isdisjoint(nodes.names(h)))

    @cached_property
    def linear(self) -> bool:
        """Whether every equation, as it is written, is linear in the unknowns."""
        return all(self.straight)

    @cached_property
    def straight(self) -> list[bool]:
        """Which equations, as they are written, are linear in the unknowns."""
        unknowns = frozenset(self.unknowns)
        return [is_linear(form, unknowns) for form in self.forms]

    @cached_property
    def closed(self) -> ClosedForm | None:
        """Formulas for the unknowns, where elimination leads to them."""
        from solver.path.elimination import closed_form

        turning = [name for name in self.unknowns if self.graph.is_turning(name)]
        return closed_form(self.equations, self.unknowns, turning)

    @cached_property
    def partials(self) -> list[Expression | None]:
        return [_partial(form, unknown) for form in self.forms for unknown in self.unknowns]

    @cached_property
    def _residual(self) -> Callable[..., Sequence[float]]:
        return compile_expressions(self.forms, (*self.unknowns, *self.known))

    @cached_property
    def _flat(self) -> Callable[..., Sequence[float]]:
        flat = [partial or nodes.Number(0.0) for partial in self.partials]
        return compile_expressions(flat, (*self.unknowns, *self.known))

    @cached_property
    def sparse(self) -> SparseSystem | None:
        """The block as a sparse system; None where a derivative has no formula."""
        try:
            return SparseSystem(self.forms, self.unknowns, self.known)
        except NotDifferentiable:
            return None

    @cached_property
    def arrays(self) -> BlockArrays:
        from solver.kernel.code.block_arrays import BlockArrays

        return BlockArrays(self)

    @property
    def variables(self) -> list[Variable]:
        return [self.graph.model.variables[name] for name in self.unknowns]

    def others(self) -> tuple[BlockKernel, ...]:
        """The same block torn elsewhere."""
        if self._others is None:
            self._others = tuple(BlockKernel(self.graph, block) for block in self.block.others)
        return self._others

    def chains(self) -> tuple[Chain, ...]:
        if self._chains is None:
            self._chains = chains(self.graph, self.block)
        return self._chains

    def chain_function(self, place: int) -> Callable[..., Any]:
        """``f(*tears, *known)`` gives the unknowns in order and then the residuals."""
        if place not in self._compiled:
            chain = self.chains()[place]
            results = (*self.unknowns, *chain.residuals)
            self._compiled[place] = compile_chain(chain, self.known, results)
        return self._compiled[place]

    def enclosure(self, place: int) -> Enclosure:
        """Bounds of the residual of a chain over boxes of its tear."""
        from solver.kernel.code.enclosure import Enclosure

        if place not in self._enclosures:
            self._enclosures[place] = Enclosure(self.chains()[place], self.known)
        return self._enclosures[place]

    def residual(self, known: Sequence[float]) -> Callable[[Sequence[float]], Sequence[float]]:
        return lambda x: self._residual(*x, *known)

    def jacobian(self, known: Sequence[float]) -> Callable[[Sequence[float]], list[Sequence[float]]]:
        n = len(self.unknowns)

        def rows(x: Sequence[float]) -> list[Sequence[float]]:
            flat = self._flat(*x, *known)
            return [flat[i : i + n] for i in range(0, n * n, n)]

        return rows if all(self.partials) else _differences(self.residual(known), n)

    def at_zero(self, values: Mapping[str, Value]) -> tuple[list[float], list[list[float]]]:
        """Residual and Jacobian where every unknown is 0, by one sweep of each equation, uncompiled.

        Raises ArithmeticError where they are undefined.
        """
        point = {**values, **dict.fromkeys(self.unknowns, 0.0)}
        swept = [derivatives(form, point) for form in self.forms]
        return [r for r, _ in swept], [[slopes.get(u, 0.0) for u in self.unknowns] for _, slopes in swept]


def _partial(form: Expression, unknown: str) -> Expression | None:
    try:
        return differentiate(form, unknown)
    except NotDifferentiable:
        return None


def _differences(
    residual: Callable[[Sequence[float]], Sequence[float]], n: int
) -> Callable[[Sequence[float]], list[Sequence[float]]]:
    """Central differences, for the few functions whose derivative has no formula."""

    def rows(x: Sequence[float]) -> list[Sequence[float]]:
        columns = []
        for j in range(n):
            h = 6e-6 * max(abs(x[j]), 1e-3)
            up, down = list(x), list(x)
            up[j], down[j] = x[j] + h, x[j] - h
            columns.append([(a - b) / (2 * h) for a, b in zip(residual(up), residual(down), strict=True)])
        return [list(row) for row in zip(*columns, strict=True)]

    return rows


def kernel_of(graph: ModelGraph, block: SolveBlock) -> BlockKernel:
    """The kernel of a block, the same each time it is met."""
    kernels: dict[SolveBlock, BlockKernel] = graph.kernels
    if block not in kernels:
        kernels[block] = BlockKernel(graph, block)
    return kernels[block]


def divisors(expression: Expression) -> Iterator[Expression]:
    """What a rule divides by, with variables in it (a power of it, or the cosine in a tangent)."""
    stack: list[Any] = [expression]
    while stack:
        node = stack.pop()
        match node:
            case nodes.Quotient(_, divisor) if nodes.names(divisor):
                yield divisor
            case nodes.Power(base, exponent) if nodes.names(base) and not _is_positive(exponent):
                yield base
            case nodes.Call("tan" | "tand" as function, arguments):
                yield nodes.Call(function.replace("tan", "cos"), arguments)
        stack.extend(nodes.children(node))


def _is_positive(exponent: Expression) -> bool:
    return isinstance(exponent, nodes.Number) and exponent.value > 0.0
