"""Linear blocks: decided by elimination, not iterated; and those with full rank only by rounding.

Some have full rank by less than the errors of their known numbers: the error bar of a computed
number, the last place of a given one. If these errors can make the matrix singular, and the
equations then hold along a line, they determine nothing there, whatever elimination finds for the
given digits (to first order: G. W. Stewart & J. Sun, *Matrix Perturbation Theory*, 1990, section
IV.3).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from fractions import Fraction
from typing import Any

import numpy as np

from rulesheets.evaluate import Undefined, rounded_derivatives, value
from rulesheets.model import Values
from rulesheets.syntax import nodes
from rulesheets.syntax.nodes import Expression
from solver.accuracy.digits import linearized
from solver.accuracy.rule_check import check_rule
from solver.accuracy.rule_sides import perturbation
from solver.facts import BeyondFloats, Conflict, RankLoss
from solver.kernel.candidates import Answer, BlockOutcome
from solver.kernel.problem import BlockProblem, InputErrors
from solver.numerics.elimination import EXACT_LIMIT, LinearOutcome, solve_linear
from solver.numerics.linear_algebra import Array, equilibrated
from solver.numerics.newton import newton
from solver.numerics.tolerances import (
    CANCELLED,
    CLEAR,
    EXAMINED,
    FREE,
    NEARLY,
    REGULAR,
    ROUNDINGS,
    SMALLEST_NORMAL,
    STILL,
)
from solver.path.polynomial import UNIT, NoForm, in_parts


class Perturbed:
    """The block of a ``problem`` whose known numbers, given ones included, may be ``off`` by
    ``slack`` times as much, by name, and the numbers in its rules by as many half units of their
    last places."""

    def __init__(self, problem: BlockProblem, off: Mapping[str, float], slack: float) -> None:
        self.problem, self.slack = problem, slack
        self.off = {name: slack * error for name, error in off.items()}

    def reach(self, w: Sequence[float], z: Sequence[float]) -> float:
        """How far w·A z, which is w·(F(z) - F(0)) of linear rules F, moves to first order as every
        number moves within its error; infinite if that is unknown."""
        here, forms = self.problem.here, self.problem.kernel.forms
        there, zeros = self.problem.named(z), dict.fromkeys(self.problem.unknowns, 0.0)
        parts = [
            (sign * share, form, {**here, **point})
            for sign, point in ((1.0, there), (-1.0, zeros))
            for share, form in zip(w, forms, strict=True)
        ]
        return perturbation(parts, self.off, self.slack)

    def holds(self, point: Mapping[str, float]) -> bool:
        """Whether the rule check accepts every equation, or errors of the known numbers explain the
        residual.

        Rounding in floats may account for a part of it, if its size is known.
        """
        problem = self.problem
        everything = {**problem.here, **point}
        misses = problem.residual(list(point.values()))
        rules = zip(misses, problem.kernel.forms, problem.kernel.equations, strict=True)
        return all(
            abs(miss)
            <= perturbation([(1.0, form, everything)], self.off) + _noise(form, everything)
            < math.inf
            or check_rule(equation, everything).holds
            for miss, form, equation in rules
        )


def _noise(form: Expression, values: Values) -> float:
    try:
        return rounded_derivatives(form, values)[2]
    except Undefined:
        return 0.0


SECOND_ORDER = 2.0**-90
"""An upper bound of the computed least singular value of a scaled matrix, if it is 0 exactly."""

WITNESSED = 128.0
"""Half units of a last place by which the rule check lets numbers differ: how far those may be that
say the same where it would be refused, or nothing of an unknown be left, for less."""

FAR = 1.7
"""The distance of a second point from the first, relative to its size."""


def undetermined(
    problem: BlockProblem,
    matrix: Sequence[Sequence[Any]],
    rhs: Sequence[Any],
    exact: Callable[[float], Any],
    off: InputErrors,
    singular: bool = False,
    slack: float = 1.0,
) -> BlockOutcome | None:
    """The unknowns that a block with this nearly singular matrix (n, n) leaves free, or its
    contradiction; None if it determines its unknowns.

    ``exact`` converts the numbers of ``matrix`` and ``rhs`` to exact ones. ``singular``: the matrix
    is known to be, to all digits. ``slack``: numbers may be so many times as far ``off``.
    """
    near = _NearlySingular.of(matrix, rhs)
    if near is None:
        return None
    with np.errstate(all="ignore"):  # what overflows is no point at which a rule holds
        try:
            moved = Perturbed(problem, off(), slack)
            lost = near.lost(exact, moved, SECOND_ORDER if singular else 0.0)
            if not lost:
                return None
            point = next(filter(moved.holds, map(problem.named, near.points(len(lost)))), None)
            if point is None:
                return near.contradiction(problem, len(lost))
            # a second point, further from the first than that is large: at just its size, unknowns
            # that are each other's negatives would become 0, where nothing of a rule is left to go
            # by
            reach = FAR * max(1.0, *map(abs, point.values()))
            directions = list(map(problem.named, lost))
            if not all(
                moved.holds({n: v + reach * z[n] for n, v in point.items()}) for z in directions
            ):
                return None
        except (ArithmeticError, ValueError):
            return None
    free = tuple(n for n in problem.unknowns if any(abs(d[n]) > STILL for d in directions))
    dependent = tuple(problem.equations[i] for i in near.dependent(len(lost)))
    return left_free(problem, point, directions[0], free, dependent)


def _free_within_check(
    problem: BlockProblem,
    matrix: Sequence[Sequence[Any]],
    rhs: Sequence[Any],
    off: InputErrors,
    instead: BlockOutcome | None,
    singular: bool = False,
) -> BlockOutcome | None:
    """The freedom of a nearly singular block within the backward error of the rule check, if the
    outcome ``instead`` for its given digits is useless: refused, or 0 for all, which any scale
    satisfies.

    Numbers copied from one answer agree to their last places, not to half of one.
    """
    if instead is not None and instead.answers:
        zeros = dict.fromkeys(problem.unknowns, 0.0)
        if instead.free or not Perturbed(problem, off(), WITNESSED).holds(zeros):
            return instead
    found = undetermined(problem, matrix, rhs, Fraction, off, singular, WITNESSED)
    return found if found is not None and found.free else instead


class _NearlySingular:
    """The singular value decomposition of the scaled matrix: its small singular values."""

    def __init__(self, matrix: Sequence[Sequence[Any]], rhs: Sequence[Any]) -> None:
        self.matrix = matrix
        a, b = np.array(matrix, dtype=float), np.array(rhs, dtype=float)
        self.rows = np.abs(a).max(axis=1)
        self.rows[self.rows == 0] = 1.0
        self.rows = np.maximum(self.rows, SMALLEST_NORMAL)
        self.a, self.b = a / self.rows[:, None], b / self.rows
        self.columns = np.abs(self.a).max(axis=0)
        self.columns[self.columns == 0] = 1.0
        self.u, self.s, self.v = np.linalg.svd(self.a / self.columns)
        kept = len(a) - int((self.s <= EXAMINED * self.s[0]).sum())
        self.left = (self.u[:, kept:].T / self.rows).tolist()
        self.right = (self.v[kept:] / self.columns).tolist()

    @classmethod
    def of(cls, matrix: Sequence[Sequence[Any]], rhs: Sequence[Any]) -> _NearlySingular | None:
        """None if no singular value is small."""
        with np.errstate(all="ignore"):
            try:
                near = cls(matrix, rhs)
            except (ArithmeticError, ValueError, np.linalg.LinAlgError):
                return None
        return near if near.left else None

    def lost(
        self, exact: Callable[[float], Any], moved: Perturbed, least: float
    ) -> list[list[float]]:
        """Null directions (n,) of the singular matrix nearby, the largest entry of each 1."""
        found = []
        for w, z in zip(self.left, self.right, strict=True):
            terms = (
                exact(p) * exact(a) * exact(q)
                for p, row in zip(w, self.matrix, strict=True)
                for a, q in zip(row, z, strict=True)
                if a
            )
            if float(abs(sum(terms, exact(0.0)))) <= moved.reach(w, z) + least < math.inf:
                size = max(map(abs, z))
                found.append([q / size for q in z])
        return found

    def points(self, lost: int) -> Iterator[list[float]]:
        """The solution of least scaled norm with the last singular values replaced by 0; then that
        with 0 for its numbers that are only rounding, which no rule between them admits."""
        kept = len(self.s) - lost
        scaled = self.v[:kept].T @ ((self.u.T @ self.b)[:kept] / self.s[:kept])
        sizes = np.abs(scaled)
        for share in (0.0, CANCELLED):
            yield (np.where(sizes > share * sizes.max(), scaled, 0.0) / self.columns).tolist()
        # then that with the unknowns that are left free held there, and all others to their last
        # places
        left, free = self.dependent(lost), _pivots(self.v[kept:])
        matrix, rhs = np.delete(self.a, left, axis=0), np.delete(self.b, left)
        point = scaled / self.columns
        others = np.delete(matrix, free, axis=1).tolist()
        solution = solve_linear(others, (rhs - matrix[:, free] @ point[free]).tolist()).solution
        if solution is not None and None not in solution:
            point[np.delete(np.arange(len(point)), free)] = solution
            yield point.tolist()

    def dependent(self, lost: int) -> list[int]:
        """Rows that follow from the others: pivots of the combinations (lost, n) that are 0 = 0."""
        return _pivots(self.u[:, len(self.s) - lost :].T)

    def contradiction(self, problem: BlockProblem, lost: int) -> BlockOutcome:
        """The equations whose left sides combine to 0 = 0, and the combination of their right
        sides."""
        scaled = self.u[:, len(self.s) - lost :].T
        worst = scaled[np.argmax(np.abs(scaled @ self.b))]
        involved = [i for i, share in enumerate(worst) if abs(share) > STILL]
        last = involved[-1]
        miss = float(worst @ self.b / worst[last] * self.rows[last])
        rows = tuple(problem.equations[i] for i in involved)
        return BlockOutcome(complete=True, facts=(Conflict(rows, miss, dict(problem.values)),))


def _pivots(rows: Array) -> list[int]:
    """The columns of the pivots of rows (k, n) as they are eliminated in turn."""
    found, left = list[int](), rows.copy()
    for k, row in enumerate(left):
        found.append(int(np.argmax(np.abs(row))))
        left[k + 1 :] -= np.outer(left[k + 1 :, found[-1]] / row[found[-1]], row)
    return found


def solve_linear_block(problem: BlockProblem, off: InputErrors) -> BlockOutcome | None:
    """The outcome of a block that is linear in its unknowns; None if numbers are not finite.

    ``off``: the errors of the known numbers.
    """
    try:  # where every unknown is 0, by one sweep of each equation, uncompiled
        at_zero = {**problem.here, **dict.fromkeys(problem.unknowns, 0.0)}
        matrix, residual = linearized(problem.kernel.forms, problem.unknowns, at_zero)
    except ArithmeticError:
        return None
    rhs = [-r for r in residual]
    if not all(math.isfinite(v) for row in (*matrix, rhs) for v in row):
        return None
    facts = solve_linear(matrix, rhs)
    if facts.conflict:
        rows = tuple(problem.equations[i] for i in facts.conflict)
        against = Conflict(rows, facts.miss, dict(problem.values))
        conflict = BlockOutcome(complete=True, facts=(against,), doubtful=_rounded(problem, facts))
        return _free_within_check(problem, matrix, rhs, off, conflict, singular=True)
    assert facts.solution is not None
    point = {n: v for n, v in zip(problem.unknowns, facts.solution, strict=True) if v is not None}
    for column, number in enumerate(facts.solution):
        if number is not None and math.isinf(number):
            reader = next(i for i, row in enumerate(matrix) if row[column])
            fact = BeyondFloats(problem.equations[reader], problem.unknowns[column])
            return BlockOutcome(facts=(fact,))
    if facts.free:
        direction = dict(zip(problem.unknowns, facts.nullspace[0], strict=True))
        dependent = tuple(problem.equations[i] for i in facts.dependent)
        return left_free(
            problem, point, direction, tuple(problem.unknowns[j] for j in facts.free), dependent
        )
    if len(point) < len(problem.unknowns):
        return None
    near = len(matrix) <= EXACT_LIMIT and _NearlySingular.of(matrix, rhs) is not None
    found = undetermined(problem, matrix, rhs, Fraction, off) if near else None
    found = found or _regular(problem, point)
    if near or found is None:
        found = _free_within_check(problem, matrix, rhs, off, found)
    return found._replace(doubtful=True) if near and found is not None else found


def _rounded(problem: BlockProblem, facts: LinearOutcome) -> bool:
    """Whether a contradiction may come only from the rounding of the constant terms."""
    point = {**problem.here, **dict.fromkeys(problem.unknowns, 0.0)}
    noise = (rounded_derivatives(problem.kernel.forms[row], point)[2] for row in facts.conflict)
    total = sum(abs(share) * size for share, size in zip(facts.multipliers, noise, strict=True))
    return facts.miss is not None and abs(facts.miss) <= ROUNDINGS * total


def _regular(problem: BlockProblem, point: dict[str, float]) -> BlockOutcome | None:
    """The solution; refined if rounding of the right-hand side would spoil it."""
    if not problem.holds(point):
        point = problem.named(newton(problem.residual, problem.jacobian, list(point.values())).x)
        if not problem.holds(point):
            return None
    point = problem.inside(problem.wrapped(point))
    outside = problem.outside(point)
    if outside is not None:
        return BlockOutcome.out_of_range(problem.equations, outside, point[outside])
    return BlockOutcome((Answer(point),), complete=True)


# --- what a block leaves free ---


def left_free(
    problem: BlockProblem,
    point: Mapping[str, float],
    direction: Mapping[str, float],
    free: tuple[str, ...],
    dependent: tuple[int, ...] = (),
) -> BlockOutcome:
    """The outcome of a block that leaves unknowns ``free``, along ``direction`` at ``point``."""
    with np.errstate(all="ignore"):
        try:
            everywhere = stays_deficient(problem, point)
        except (ArithmeticError, np.linalg.LinAlgError):
            everywhere = False
    there = {**problem.here, **dict.fromkeys(problem.unknowns, 1.0), **point}
    fact = RankLoss(problem.equations, free, direction, everywhere, there, dependent)
    fixed = {name: number for name, number in point.items() if name not in free}
    complete = problem.kernel.linear or not fixed  # elsewhere others may have other values
    return BlockOutcome((Answer(fixed),), complete=complete, facts=(fact,), free=free)


STEP_ALONG = 1e-2
"""Share of the size of a variable by which a point is displaced."""


def stays_deficient(problem: BlockProblem, point: Mapping[str, float]) -> bool:
    """Whether the Jacobian stays deficient as the known values move, with the equations still
    satisfied.

    A point of the solution set over unknowns *and* known values is displaced along the null space
    of the whole Jacobian and brought back by Gauss–Newton. If the unknowns' part of the Jacobian
    has lost rank there too, the equations are dependent; if not, the given values are special.

    Numpy's warnings are silenced by the caller. Raises ArithmeticError and LinAlgError.
    """
    n, names = len(problem.unknowns), (*problem.unknowns, *problem.kernel.known)
    z = np.array([*(point.get(name, 1.0) for name in problem.unknowns), *problem.known])
    if n == len(z):
        return True

    def at(z: Array) -> tuple[Array, Array]:
        """Jacobian (m, k) over unknowns and known values (k,), and residual (m,)."""
        values = dict(zip(names, z.tolist(), strict=True))
        rows, misses = linearized(problem.kernel.forms, names, values)
        return np.array(rows), np.array(misses)

    def size(z: Array) -> Array:
        return np.where(z, np.abs(z), 1.0)

    rank, right = _rank(at(z)[0] * size(z), FREE)
    for seed in range(3):
        mix = [math.cos((k + 1) * (1.7 + seed)) for k in range(len(z) - rank)]
        moved = z + STEP_ALONG * size(z) * (mix @ right[rank:])
        for _ in range(12):
            jacobian, miss = at(moved)
            moved = moved - np.linalg.lstsq(jacobian, miss, rcond=FREE)[0]
        jacobian, miss = at(moved)
        arrived = np.abs(miss).max() <= NEARLY * max(1.0, np.abs(moved).max() ** 2)
        if arrived and _rank((jacobian * size(moved))[:, :n], REGULAR)[0] == n:
            return False
    return True


def _rank(jacobian: Array, share: float) -> tuple[int, Array]:
    """The rank of a matrix with its rows equilibrated, and its right singular vectors."""
    _, values, right = np.linalg.svd(equilibrated(jacobian, np.ones(jacobian.shape[1]))[0])
    return int((values > share * values[0]).sum()), right


# --- contradictions between products ---
#
# ``x*y = 6`` contradicts ``x*y = 7``: every rule is linear in its monomials, which are products of
# powers of parts that are not sums.

MAX_RULES = 40


def contradiction(problem: BlockProblem) -> Conflict | None:
    """The rules of a block that contradict each other, as shown by linear algebra."""
    forms = problem.kernel.forms
    if len(forms) > MAX_RULES:
        return None
    unknowns = frozenset(problem.unknowns)

    def number(part: Expression) -> Fraction | None:
        return (
            Fraction(value(part, problem.here)) if unknowns.isdisjoint(nodes.names(part)) else None
        )

    try:
        meaning = dict[Expression, str]()
        rows = [in_parts(form, number, meaning) for form in forms]
        columns = list(dict.fromkeys(monomial for row in rows for monomial in row if monomial))
        matrix = [[float(row.get(monomial, 0.0)) for monomial in columns] for row in rows]
        rhs = [-float(row.get(UNIT, 0.0)) for row in rows]
    except (NoForm, Undefined, ArithmeticError, ValueError):
        return None
    facts = solve_linear(matrix, rhs)
    size = max(
        (abs(m * rhs[row]) for row, m in zip(facts.conflict, facts.multipliers, strict=True)),
        default=0.0,
    )
    if not facts.conflict or abs(facts.miss) <= CLEAR * size:
        return None
    with suppress(Undefined):
        if _rounded(problem, facts):
            return None
    equations = tuple(problem.equations[row] for row in facts.conflict)
    return Conflict(equations, facts.miss, dict(problem.values))
