"""A simultaneous block at given numbers: every solution that can be found, and whether that is all."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from rulesheets import nodes
from rulesheets.construct import subtract
from rulesheets.evaluate import NotDifferentiable, differentiate, value
from rulesheets.model import Value, Variable
from rulesheets.nodes import Expression
from solver.facts import Conflict, DoubleRoot, Fact, NoRoot, OutOfRange, RankLoss
from solver.kernel.chain import Chain, Enclosure, chains, compile_chain
from solver.kernel.scalar import compile_expressions
from solver.kernel.step import in_range
from solver.numerics.linear import solve_linear
from solver.numerics.newton import NewtonLimits, newton
from solver.numerics.outcome import Outcome
from solver.path import rational
from solver.path.graph import ModelGraph
from solver.path.steps import SolveBlock
from solver.witness import testify

STARTS = 32
SEARCH_BOXES = 40_000
START_LIMITS = NewtonLimits(iterations=50, escapes=2)
HIGHEST_DEGREE = 12
SHARES = (0.137, 0.291, 0.433, 0.618, 0.787, 0.913)
MIN_SAMPLES = 3


@dataclass(frozen=True, slots=True)
class BlockOutcome:
    """``solutions``: values by unknown. ``facts`` explain what is missing or not isolated."""

    solutions: tuple[Mapping[str, float], ...] = ()
    complete: bool = False
    facts: tuple[Fact, ...] = ()
    free: tuple[str, ...] = ()


class BlockKernel:
    """Residual, Jacobian and chains of a block, compiled once for a path."""

    def __init__(self, graph: ModelGraph, block: SolveBlock) -> None:
        self.graph, self.block = graph, block
        self.equations = [graph.model.equations[e] for e in block.equations]
        self.unknowns = block.unknowns
        names = dict.fromkeys(name for e in self.equations for name in e.names)
        self.known = tuple(name for name in names if name not in self.unknowns)
        self.forms = [subtract(e.left, e.right) for e in self.equations]
        self.partials = [[_partial(form, unknown) for unknown in self.unknowns] for form in self.forms]
        self.linear = all(self._free_of_unknowns(p) for row in self.partials for p in row)
        arguments = (*self.unknowns, *self.known)
        self._residual = compile_expressions(self.forms, arguments)
        flat = [p or nodes.Number(0.0) for row in self.partials for p in row]
        self._flat = compile_expressions(flat, arguments)
        self.exact = all(p is not None for row in self.partials for p in row)
        self._chains: tuple[Chain, ...] | None = None
        self._compiled: dict[int, Callable[..., Any]] = {}

    def _free_of_unknowns(self, expression: Expression | None) -> bool:
        return expression is not None and not any(n in self.unknowns for n in nodes.names(expression))

    @property
    def variables(self) -> list[Variable]:
        return [self.graph.model.variables[name] for name in self.unknowns]

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

    def residual(self, known: Sequence[float]) -> Callable[[Sequence[float]], Sequence[float]]:
        return lambda x: self._residual(*x, *known)

    def jacobian(self, known: Sequence[float]) -> Callable[[Sequence[float]], list[Sequence[float]]]:
        n = len(self.unknowns)

        def rows(x: Sequence[float]) -> list[Sequence[float]]:
            flat = self._flat(*x, *known)
            return [flat[i : i + n] for i in range(0, n * n, n)]

        if self.exact:
            return rows
        return _differences(self.residual(known), n)


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


def solve_block(
    kernel: BlockKernel, values: Mapping[str, Value], guesses: Mapping[str, float]
) -> BlockOutcome:
    """All solutions of the block that can be found at the known ``values``."""
    return _Attempt(kernel, values, guesses).outcome()


class _Attempt:
    def __init__(
        self, kernel: BlockKernel, values: Mapping[str, Value], guesses: Mapping[str, float]
    ) -> None:
        self.kernel, self.values, self.guesses = kernel, values, guesses
        self.known = [values[name] for name in kernel.known]
        self.residual = kernel.residual(self.known)  # type: ignore[arg-type]
        self.jacobian = kernel.jacobian(self.known)  # type: ignore[arg-type]
        self.found: list[dict[str, float]] = []
        self.facts: list[Fact] = []
        self.best: tuple[float, dict[str, float]] = (math.inf, {})

    def outcome(self) -> BlockOutcome:
        if any(isinstance(v, str) for v in self.known):
            return BlockOutcome(facts=(NoRoot(self.kernel.block.equations, self.kernel.unknowns, True),))
        if self.kernel.linear:
            linear = self._linear()
            if linear is not None:
                return linear
        if len(self.kernel.block.tears) == 1 and (adrift := self._free_along_tear()):
            return adrift
        complete = self._by_tear() if len(self.kernel.block.tears) == 1 else False
        if not complete:
            complete = self._by_starts(few=bool(self.found)) or complete
        if not self.found and not any(isinstance(f, OutOfRange) for f in self.facts):
            best, misses = self.best[1], self._misses(self.best[1])
            block = self.kernel.block
            self.facts.append(NoRoot(block.equations, block.unknowns, complete, best, misses))
        return BlockOutcome(tuple(self.found), complete, tuple(self.facts))

    # --- linear blocks: decided, not iterated ---

    def _linear(self) -> BlockOutcome | None:
        block = self.kernel.block
        zero = [0.0] * len(self.kernel.unknowns)
        try:
            rhs = [-r for r in self.residual(zero)]
            matrix = self.jacobian(zero)
        except (ArithmeticError, ValueError):
            return None
        if not all(math.isfinite(v) for row in (*matrix, rhs) for v in row):
            return None
        facts = solve_linear(matrix, rhs)
        if facts.conflict:
            rows = tuple(block.equations[i] for i in facts.conflict)
            return BlockOutcome(complete=True, facts=(Conflict(rows, facts.miss, dict(self.values)),))
        assert facts.solution is not None
        unknowns = self.kernel.unknowns
        point = {n: v for n, v in zip(unknowns, facts.solution, strict=True) if v is not None}
        if facts.free:
            direction = dict(zip(unknowns, facts.nullspace[0], strict=True))
            free = tuple(unknowns[j] for j in facts.free)
            constant = all(
                not any(True for _ in nodes.names(p)) for row in self.kernel.partials for p in row if p
            )
            return BlockOutcome((point,), True, (RankLoss(block.equations, free, direction, constant),), free)
        if len(point) < len(unknowns):
            return None
        refined = newton(self.residual, self.jacobian, [point[n] for n in unknowns])
        best = dict(zip(unknowns, refined.x, strict=True)) if refined.outcome.found else point
        point = best if self._holds(best) else point
        if not self._holds(point):
            return None
        self._keep(point)
        return BlockOutcome(tuple(self.found), True, tuple(self.facts))

    # --- one tear: the whole range is searched ---

    def _by_tear(self) -> bool:
        from solver.numerics.isolation import IsolationLimits, isolate_roots

        limits = IsolationLimits(boxes=SEARCH_BOXES, alive=4_000)

        tear = self.kernel.block.tears[0]
        low, high = self._within(tear, *self._domain(tear))
        complete = True
        for place, chain in enumerate(self.kernel.chains()):
            enclosure = Enclosure(chain, self._known_numbers())
            slope = enclosure.slope if enclosure.slopes is not None else None
            search = isolate_roots(enclosure, slope, self._tear_value(place), low, high, limits)
            complete = complete and search.complete
            for root in (*search.roots, *(x for x, _ in search.touching)):
                self._from_tear(place, root)
        return complete

    def _free_along_tear(self) -> BlockOutcome | None:
        """Where the residual vanishes wherever it is tried, the tear is free and the rest moves with it."""
        for place, chain in enumerate(self.kernel.chains()):
            points = [p for p in map(self._along(place), self._samples(chain.tears[0])) if p is not None]
            if len(points) >= MIN_SAMPLES and all(self._holds(point) for point in points):
                block, first, second = self.kernel.block, points[0], points[1]
                span = second[chain.tears[0]] - first[chain.tears[0]]
                direction = {n: (second[n] - first[n]) / span for n in self.kernel.unknowns}
                fact = RankLoss(block.equations, self.kernel.unknowns, direction, everywhere=False)
                return BlockOutcome(({},), True, (fact,), self.kernel.unknowns)
        return None

    def _samples(self, tear: str) -> list[float]:
        low, high = self._domain(tear)
        if math.isfinite(low) and math.isfinite(high):
            return [low + (high - low) * share for share in SHARES]
        size = self._scale()[self.kernel.unknowns.index(tear)]
        middle = low if math.isfinite(low) else high if math.isfinite(high) else 0.0
        signs = (1.0, -1.0) if middle == 0.0 else (1.0,) if math.isfinite(low) else (-1.0,)
        return [middle + sign * size * share for sign in signs for share in SHARES]

    def _along(self, place: int) -> Callable[[float], dict[str, float] | None]:
        function, unknowns = self.kernel.chain_function(place), self.kernel.unknowns

        def point(x: float) -> dict[str, float] | None:
            try:
                return dict(zip(unknowns, function(x, *self.known), strict=False))
            except (ArithmeticError, ValueError):
                return None

        return point

    def _within(self, tear: str, low: float, high: float) -> tuple[float, float]:
        """A polynomial has its real roots within Cauchy's bound 1 + max|a_i/a_n|; elsewhere the range stays."""
        if len(self.kernel.unknowns) > 1:
            return low, high
        equation = self.kernel.equations[0]
        found = rational.equation(equation.left, equation.right, tear, HIGHEST_DEGREE)
        if found is None or len(found[0]) < 2:
            return low, high
        try:
            *lower, leading = (value(c, self.values) for c in found[0])
            reach = 1.001 * (1.0 + max(abs(c / leading) for c in lower))
        except (ArithmeticError, ValueError):
            return low, high
        return (max(low, -reach), min(high, reach)) if math.isfinite(reach) else (low, high)

    def _known_numbers(self) -> dict[str, Value]:
        return {name: self.values[name] for name in self.kernel.known}

    def _domain(self, name: str) -> tuple[float, float]:
        variable = self.kernel.graph.model.variables[name]
        turn = self.kernel.graph.turn(name)
        low, high = variable.low, variable.high
        if turn is None or (low > -math.inf and high < math.inf):
            return low, high
        if low > -math.inf:
            return low, low + turn
        return (high - turn, high) if high < math.inf else (-turn / 2, turn / 2)

    def _tear_value(self, place: int) -> Callable[[float], float]:
        function, known = self.kernel.chain_function(place), self.known
        return lambda x: function(x, *known)[-1]  # type: ignore[no-any-return]

    def _from_tear(self, place: int, root: float) -> None:
        try:
            numbers = self.kernel.chain_function(place)(root, *self.known)
        except (ArithmeticError, ValueError):
            return
        self._refine(numbers[: len(self.kernel.unknowns)])

    # --- several tears: from many starts ---

    def _by_starts(self, few: bool) -> bool:
        from solver.numerics.multistart import multistart

        ranges = [self._domain(name) for name in self.kernel.unknowns]
        count = STARTS // 4 if few else STARTS
        found = multistart(
            self.residual, self.jacobian, self._guess(), ranges, self._scale(), count, limits=START_LIMITS
        )
        for root in found.roots:
            self._refine(root.x)
        if found.best is not None:
            self._note_best(dict(zip(self.kernel.unknowns, found.best.x, strict=True)))
        return False

    def _guess(self) -> list[float]:
        return [self.guesses.get(name, 1.0) for name in self.kernel.unknowns]

    def _scale(self) -> list[float]:
        """Typical size of the unknowns: that of the guess, else of the numbers around them."""
        sizes = sorted(abs(v) for v in self.known if isinstance(v, float) and v)
        around = sizes[len(sizes) // 2] if sizes else 1.0
        return [
            90.0 if self.kernel.graph.turn(name) == 360.0 else abs(self.guesses.get(name, 0.0)) or around
            for name in self.kernel.unknowns
        ]

    # --- from a candidate to an answer ---

    def _refine(self, start: Sequence[float]) -> None:
        """Newton on the whole block, so that the digits do not depend on the tearing."""
        result = newton(self.residual, self.jacobian, start)
        candidates = [result.x, tuple(start)] if result.outcome.found else [tuple(start)]
        for x in candidates:
            point = dict(zip(self.kernel.unknowns, map(float, x), strict=True))
            self._note_best(point)
            if self._holds(point):
                if result.outcome is not Outcome.SINGULAR_JACOBIAN:
                    self._keep(point)
                elif not any(self._blurred(point, other) for other in self.found):
                    self._note_double(point)
                    self._keep(point)
                return

    def _blurred(self, one: Mapping[str, float], other: Mapping[str, float]) -> bool:
        """Whether two points are one multiple root: rounding spreads it over the root of the precision."""
        scales = dict(zip(self.kernel.unknowns, self._scale(), strict=True))
        return all(abs(v - other[n]) <= 1e-5 * max(abs(v), 0.01 * scales[n]) for n, v in one.items())

    def _note_best(self, point: dict[str, float]) -> None:
        if not all(in_range(v, point[v.name]) for v in self.kernel.variables):
            return
        try:
            size = max(abs(r) for r in self.residual(list(point.values())))
        except (ArithmeticError, ValueError):
            return
        if size < self.best[0]:
            self.best = (size, point)

    def _misses(self, point: Mapping[str, float]) -> tuple[float, ...]:
        return tuple(self.residual(list(point.values()))) if point else ()

    def _note_double(self, point: dict[str, float]) -> None:
        from solver.numerics.nullspace import null_direction

        direction = null_direction(self.jacobian(list(point.values())), list(point.values()))
        unknowns = self.kernel.unknowns
        moving = {n: d for n, d in zip(unknowns, direction, strict=True) if abs(d) > 1e-6}
        self.facts.append(DoubleRoot(self.kernel.block.equations, tuple(moving), moving))

    def _holds(self, point: Mapping[str, float]) -> bool:
        if not all(math.isfinite(v) for v in point.values()):
            return False
        everything = {**self.values, **point}
        return all(testify(equation, everything).holds for equation in self.kernel.equations)

    def _keep(self, point: dict[str, float]) -> None:
        wrapped = {name: self._wrapped(name, number) for name, number in point.items()}
        point = wrapped if wrapped != point and self._holds(wrapped) else point
        for variable in self.kernel.variables:
            if not in_range(variable, point[variable.name]):
                equation = self.kernel.block.equations[0]
                self.facts.append(OutOfRange(equation, variable.name, point[variable.name]))
                return
        if not any(_same(point, other) for other in self.found):
            self.found.append(point)

    def _wrapped(self, name: str, number: float) -> float:
        graph = self.kernel.graph
        turn, variable = graph.turn(name), graph.model.variables[name]
        if turn is None or variable.low > -math.inf or variable.high < math.inf:
            return number
        return _principal(number, turn)


def _principal(angle: float, turn: float) -> float:
    if -turn / 2 < angle <= turn / 2:
        return angle
    wrapped = math.remainder(angle, turn)
    return turn / 2 if wrapped == -turn / 2 else wrapped


def _same(one: Mapping[str, float], other: Mapping[str, float]) -> bool:
    return all(abs(v - other[n]) <= 1e-9 * max(abs(v), abs(other[n]), 1e-300) for n, v in one.items())
