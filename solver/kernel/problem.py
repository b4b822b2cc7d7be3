"""A block at given numbers: its residual, the ranges and sizes of its unknowns, and the rule check.

The budget counts the work that one solve may spend on proofs and last resorts. It counts
operations, not time, so it is the same on any machine. The unit is one operation of interval
arithmetic on the boxes of one level of a search. The outcome shows what was left out: a search that
was cut short does not claim to be complete. A request for more work also checks the clock: a time
limit ends the solve (``rulesheets/deadline.py``).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from functools import cached_property
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from rulesheets.deadline import expect_time
from rulesheets.evaluate import Undefined, derivatives, value
from rulesheets.model import Equation, Values
from solver.accuracy.rule_check import check_rule
from solver.accuracy.rule_sides import MANY, gross, size
from solver.kernel.block import BlockKernel
from solver.numerics.linear_algebra import (
    Array,
    Factor,
    SparseFactor,
    SparseMap,
    factorise,
    sparse_matrix,
)
from solver.numerics.tolerances import BACKWARD, BESIDE, EPS, SMALLEST_NORMAL
from solver.path.graph import within_half_turns

SOLVE = 60_000
BLOCK = 16_000
GLANCE = 1_500
"""The budget of a block whose proof would be useless, because something was already left out."""
ROUNDS = 40
LAST_RESORTS = 2
STEP, PLAN, SEARCH, FIRST_ROUND, ROUND, LAST_RESORT = 10, 50, 100, 300, 8_000, 100_000
"""The cost of other work, in the same unit: the first round of starts for each unknown."""


class Budget:
    """The remaining work of one solve, shared by all of its blocks and cases.

    ``thorough``: a proof was requested, whatever it costs. ``brief``: only the existence of an
    answer matters, and methods that rarely find one are left out; ``nearby``: only whether Newton's
    method leads to one, from the guesses or, without guesses, from one round of starts. ``every``:
    all answers of a block are kept; ``cut``: one was left out.
    """

    def __init__(self) -> None:
        self.thorough = self.brief = self.nearby = self.every = self.cut = False
        self.left = SOLVE
        self.used = 0
        self.of_block = BLOCK
        self.rounds = ROUNDS
        self.last_resorts = LAST_RESORTS

    def begin_block(self, proving: bool, shared: bool) -> None:
        """``proving``: whether a proof that a block has no other answers would still serve the
        whole.

        ``shared``: whether the block is one of many cases or values, which share the budget; others
        have their own.
        """
        expect_time()
        self.used += SEARCH
        self.shared = shared
        self.of_block = min(self.left if shared else BLOCK, BLOCK if proving else GLANCE)

    def levels(self, operations: int, most: int) -> int:
        """Whether so many levels of a search, each of so many operations, are within the budget."""
        expect_time()
        return min(most, self.of_block // max(operations, 1))

    def spend(self, work: int) -> None:
        self.used += work
        self.of_block = max(self.of_block - work, 0)
        if self.shared:
            self.left = max(self.left - work, 0)

    def another_round(self) -> bool:
        """Whether there may be one more round of starts, after the first of each block."""
        expect_time()
        if self.nearby:
            return False
        self.used += ROUND
        self.rounds -= self.shared
        return self.rounds >= 0

    def last_resort(self) -> bool:
        """Whether a search may be tried that costs more than all others and rarely helps."""
        expect_time()
        self.last_resorts -= 1
        if self.last_resorts < 0 or self.brief:
            return False
        self.used += LAST_RESORT
        return True


Point: TypeAlias = Mapping[str, float]
"""The values of the unknowns of a block."""
InputErrors: TypeAlias = Callable[[], Mapping[str, float]]
"""The error of each known number, computed on demand."""

Fits: TypeAlias = Callable[[Point], bool]
"""Whether an answer of a block lies in the case that was assumed."""


class BlockProblem:
    """The problem of a block. Points are lists of numbers in the order of ``unknowns``."""

    def __init__(
        self,
        kernel: BlockKernel,
        values: Values,
        guesses: Mapping[str, float],
        budget: Budget | None = None,
        fits: Fits | None = None,
    ) -> None:
        self.kernel, self.values, self.guesses = kernel, values, guesses
        self.fits = fits or (lambda point: True)
        self.budget = budget or Budget()
        self.here = {name: values[name] for name in kernel.known}
        self.unknowns = kernel.unknowns
        self.graph = kernel.graph
        self.turn, self.domain = kernel.graph.turn, kernel.domain
        self.variables = [kernel.graph.model.variables[name] for name in kernel.unknowns]
        self.equations = kernel.block.equations
        self.symbolic = any(isinstance(values[name], str) for name in kernel.known)
        self.known = [v for name in kernel.known if isinstance(v := values[name], float)]
        self.residual = kernel.residual(self.known)
        self._refusing: Equation | None = None

    @cached_property
    def jacobian(self) -> Callable[[Sequence[float]], list[Sequence[float]]]:
        return self.kernel.jacobian(self.known)

    @cached_property
    def sparse(self) -> SparseMap:
        """Residual and sparse Jacobian on arrays."""
        return self.kernel.sparse.at(self.known)

    def matrix(self, x: Sequence[float]) -> Any:
        """The Jacobian at a point (n,): that of a large block as a sparse matrix."""
        n = len(self.unknowns)
        if n <= MANY:
            return self.jacobian(list(x))
        return sparse_matrix(*self.sparse[1](np.asarray(x, dtype=float)), (n, n))

    def factor(self, x: Sequence[float], sizes: Sequence[float]) -> Factor:
        """The Jacobian at a point (n,), factored."""
        return factorise(self.matrix(x), sizes)

    def named(self, x: Sequence[float]) -> dict[str, float]:
        return dict(zip(self.unknowns, map(float, x), strict=True))

    def holds(self, point: Point) -> bool:
        """Whether the rule check accepts every equation of the block at the point, of numbers with
        digits."""
        if not all(v == 0.0 or SMALLEST_NORMAL <= abs(v) < math.inf for v in point.values()):
            return False
        everything = {**self.here, **point}
        left: Sequence[Any] = self.kernel.equations
        if len(left) > MANY:  # of many, those that do not clearly hold are checked one by one
            from solver.accuracy.alike import accepted

            _, left = accepted(self.graph.model, left, everything)
        # the rule that refused the last point mostly refuses the next
        ordered = sorted(left, key=lambda equation: equation is not self._refusing)
        refusing = next((e for e in ordered if not check_rule(e, everything).holds), None)
        self._refusing = refusing or self._refusing
        return refusing is None

    def outside(self, point: Point) -> str | None:
        """The first unknown that leaves its declared range."""
        return next((v.name for v in self.variables if not v.admits(point[v.name])), None)

    def inside(self, point: dict[str, float]) -> dict[str, float]:
        """The point with unknowns beyond an end of their range moved to that end, if the rules hold
        there.

        An unknown that is out of range only by rounding is still an answer.
        """
        moved = {v.name: v.nearest(point[v.name]) for v in self.variables}
        return moved if moved != point and self.holds(moved) else point

    @cached_property
    def _free_turns(self) -> dict[str, float]:
        """The whole turns of angles that have no declared range."""
        unbounded = (v.name for v in self.variables if v.low == -math.inf and v.high == math.inf)
        return {name: turn for name in unbounded if (turn := self.turn(name)) is not None}

    def wrapped(self, point: Point) -> dict[str, float]:
        """Angles without a declared range in (-180, 180], where the rules allow it."""
        moved = dict(point)
        for name, turn in self._free_turns.items():
            moved[name] = within_half_turns(point[name], turn)
        return moved if moved != point and self.holds(moved) else dict(point)

    def beside(self, point: Point, other: Point) -> dict[str, float]:
        """The point with its angles, if without a range, moved by turns next to another's."""
        moved = dict(point)
        for name, turn in self._free_turns.items():
            moved[name] += turn * round((other[name] - moved[name]) / turn)
        return moved

    @cached_property
    def scale(self) -> list[float]:
        """Typical size of the unknowns: that of the numbers around them. What is an answer depends
        on no guess."""
        sizes = sorted(abs(v) for v in self.known if v)
        around = sizes[len(sizes) // 2] if sizes else 1.0
        return [turn / 4 if (turn := self.turn(name)) else around for name in self.unknowns]

    def sizes_at(self, x: Sequence[float], share: float = 1.0) -> list[float]:
        """The sizes of the unknowns at a point (n,): at least a share of their typical size."""
        return [max(abs(v), share * size) for v, size in zip(x, self.scale, strict=True)]

    def is_far_out(self, point: Point) -> bool:
        """Whether some number is so large that floats of its size absorb ordinary ones."""
        sizes = self.named(self.scale)
        return any(abs(v) * EPS > sizes[name] for name, v in point.items())

    @cached_property
    def sizes(self) -> Array:
        """The size of every unknown (n,): that of its guess, else one suggested by the known
        numbers."""
        made = self.kernel.arrays.scalings.sizes(
            dict(zip(self.kernel.known, self.known, strict=True))
        )
        return np.array(
            [
                turn / 4
                if (turn := self.turn(name))
                else abs(self.guesses.get(name, 0.0)) or made[name]
                for name in self.unknowns
            ]
        )

    def periods(self, point: Point) -> tuple[float, ...]:
        """Sort key: nearest to the guesses; then the least arguments of periodic functions."""
        values = {**self.here, **point}
        try:
            most = max((abs(value(phase, values)) for phase in self.kernel.phases), default=0.0)
        except Undefined:
            most = math.inf
        return self._distance(point), most

    def _distance(self, point: Point) -> float:
        """The square of the distance from the guesses."""
        apart = [point[name] - self.guesses[name] for name in self.unknowns if name in self.guesses]
        return sum(d * d for d in apart)  # a power would raise where it overflows

    def negatives(self, point: Point) -> int:
        """How many numbers other than angles are negative."""
        return sum(v < 0.0 and self.turn(name) is None for name, v in point.items())

    def preference(self, point: Point) -> tuple[float, ...]:
        """Sort key: in the case that was assumed; nearest to the guesses; then fewest negative
        numbers other than angles; then angles by size, other numbers positive first."""
        first = next((name for name in self.kernel.block.tears), self.unknowns[0])
        number = point[first]
        behind = float(number < 0)
        by_size = (abs(number), behind) if self.turn(first) else (behind, abs(number))
        return not self.fits(point), self._distance(point), self.negatives(point), *by_size


# --- how far rounding leaves a point open ---


class Uncertainty(NamedTuple):
    """``errors`` (n,) of the unknowns; ``steepness``: how far a rule moves with its variables,
    relative to its terms, the largest of the block. ``relative``: for a large block the largest
    error relative to the size of its unknown, estimated at once."""

    errors: list[float]
    steepness: float = 0.0
    relative: float | None = None


def uncertainty(problem: BlockProblem, point: Point, share: float = BACKWARD) -> Uncertainty:
    """Forward error of the unknowns for a backward error, that which the rule check admits:
    |J⁻¹|·t."""
    if len(point) > MANY:
        return _sparse_uncertainty(problem, problem.sparse, point)
    everything = {**problem.here, **point}
    try:
        jacobian = problem.jacobian(list(point.values()))
    except (ArithmeticError, ValueError):
        # a slope is infinite there: nothing speaks for a multiple root
        return Uncertainty([0.0] * len(point), math.inf)
    sizes = [(size(rule, everything), gross(rule, everything)) for rule in problem.kernel.equations]
    steepness = max(
        (moves / terms if terms else math.inf for moves, terms in sizes if moves), default=0.0
    )
    tolerances = [max(share * moves, EPS * terms) for moves, terms in sizes]
    with np.errstate(all="ignore"):
        try:
            errors = np.abs(np.linalg.inv(jacobian)) @ tolerances
        except np.linalg.LinAlgError:
            errors = np.full(len(sizes), math.inf)
    return Uncertainty(np.where(np.isfinite(errors), errors, math.inf).tolist(), steepness)


def _sparse_uncertainty(problem: BlockProblem, sparse: SparseMap, point: Point) -> Uncertainty:
    """The same for a large block. An unknown near 0 is measured by the change that would move one
    of its rules by the size of its terms, with brackets multiplied out as its moves are."""
    from solver.accuracy.alike import evaluated, sizes_of

    found = evaluated(problem.graph.model, problem.kernel.equations, {**problem.here, **point})
    moves, gross = (np.where(np.isnan(size), np.inf, size) for size in (found.moves, found.gross))
    terms, x = np.fmax(gross, moves), np.array(list(point.values()))
    with np.errstate(all="ignore"):
        steepness = float(np.fmax.reduce(moves / gross, initial=0.0))
    entries = sparse[1](x)
    try:
        factor = SparseFactor(entries, len(x))
    except ArithmeticError:
        return Uncertainty([math.inf] * len(x), steepness, math.inf)
    weight = sizes_of(x, terms, *entries)
    relative = factor.spread(np.maximum(BACKWARD * moves, EPS * gross), weight)
    if not math.isfinite(relative):
        relative = math.inf
    return Uncertainty((relative * weight).tolist(), steepness, relative)


def is_beside_pole(problem: BlockProblem, point: Point, found: Uncertainty) -> bool:
    """Whether a rule has a divisor that may be 0 within the error bars of a point, however harmless
    its slopes: next to a removable 0/0 they are those of the limit."""
    if len(point) > MANY:
        asked = [*point.values()], problem.known, found.errors
        return problem.kernel.sparse.divides_by_nothing(*asked)
    reach, everything = dict(zip(point, found.errors, strict=True)), {**problem.here, **point}
    for divisor in problem.kernel.divisors:
        try:
            at, slopes = derivatives(divisor, everything)
        except Undefined:
            return True
        moves = sum(abs(slopes[name]) * far for name, far in reach.items() if slopes.get(name))
        if not moves < BESIDE * abs(at):  # it may be 0, or nearly
            return True
    return False
