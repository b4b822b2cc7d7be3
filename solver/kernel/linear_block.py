"""Linear blocks: decided by elimination, not iterated; and those that have full rank by accident.

Some have it by less than what their known numbers leave open. A number that was computed is good to its
error, one that was given to its last place. Where that is enough to make the matrix singular, and the
equations hold all along the line that it leaves then, they determine nothing there, whatever elimination
makes of the digits at hand (to first order: G. W. Stewart & J. Sun, *Matrix Perturbation Theory*, 1990,
section IV.3).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from fractions import Fraction
from typing import Any

import numpy as np

from rulesheets.evaluate import Undefined, derivatives, rounded_derivatives
from rulesheets.model import Value
from rulesheets.syntax.nodes import Expression
from solver.accuracy.rule_check import blur, check_rule, half_unit, with_named_numbers
from solver.facts import BeyondFloats, Conflict
from solver.kernel.candidates import Answer, BlockOutcome
from solver.kernel.question import Question, rank_loss
from solver.numerics.linear_algebra import EXACT_LIMIT, LinearOutcome, solve_linear
from solver.numerics.newton import newton
from solver.numerics.tolerances import ROUNDINGS, SMALLEST_NORMAL

NUDGE = 1e-5
"""Relative step of the differences that tell how a coefficient depends on a known number."""


class Perturbed:
    """The block of a ``question`` with its known numbers, given ones included, ``off`` by ``slack`` times so
    much, by name; the numbers that stand in its rules by as many half units of their last places."""

    def __init__(self, question: Question, off: Mapping[str, float], slack: float) -> None:
        self.question = question
        self.off = off if slack == 1.0 else {name: slack * error for name, error in off.items()}
        numbers: dict[str, float] = {}
        self.forms = [with_named_numbers(form, numbers) for form in question.kernel.forms]
        known = {n: v for n, v in question.here.items() if isinstance(v, float)}
        self.at: dict[str, Value] = {**known, **numbers, **dict.fromkeys(question.unknowns, 0.0)}
        own = {name: slack * half_unit(number) for name, number in numbers.items()}
        self.moves = {n: error for n, error in {**own, **_of(known, self.off)}.items() if error}

    def reach(self, w: Sequence[float], z: Sequence[float]) -> float:
        """How far w·A z moves as every number moves by what it may be off; nan where that is not known."""
        total = 0.0
        for moved in self._moved():
            rows = (sum(d * q for d, q in zip(row, z, strict=True)) for row in moved)
            total += abs(sum(p * far for p, far in zip(w, rows, strict=True)))
        return total

    def _moved(self) -> Iterator[list[list[float]]]:
        """How far the entries of the matrix (n, n) go with each number that moves; nan where that is not
        known."""
        names, n = self.question.unknowns, len(self.question.unknowns)
        for name, error in self.moves.items():
            number = self.at[name]
            assert isinstance(number, float)
            step = max(NUDGE * abs(number), error)
            try:
                ahead, behind = (self._slopes({**self.at, name: number + s}) for s in (step, -step))
            except Undefined:
                yield [[math.nan] * n for _ in range(n)]
                continue
            share = error / step / 2  # nan of an infinite error
            yield [
                [(up.get(u, 0.0) - down.get(u, 0.0)) * share for u in names]
                for up, down in zip(ahead, behind, strict=True)
            ]

    def _slopes(self, at: Mapping[str, Value]) -> list[dict[str, float]]:
        return [derivatives(form, at)[1] for form in self.forms]

    def holds(self, point: Mapping[str, float]) -> bool:
        """Whether the rule check accepts every equation, or what is known may be as far off as it misses.

        Floats may have made up as much of that as they round, if it is known how much that is.
        """
        question = self.question
        everything = {**question.here, **point}
        misses = question.residual(list(point.values()))
        return all(
            abs(miss) <= blur(form, everything, self.off) + _noise(form, everything) < math.inf
            or check_rule(equation, everything).holds
            for miss, form, equation in zip(
                misses, question.kernel.forms, question.kernel.equations, strict=True
            )
        )


def _noise(form: Expression, values: Mapping[str, Value]) -> float:
    try:
        return rounded_derivatives(form, values)[2]
    except Undefined:
        return 0.0


def _of(known: Mapping[str, float], off: Mapping[str, float]) -> dict[str, float]:
    return {name: off[name] for name in known if name in off}


SUSPECT = 1e-9
"""Share of the largest singular value below which one is worth a closer look, rows and columns scaled."""
STILL = 1e-9
"""Share of the largest move along a null direction below which an unknown stays where it is."""
SECOND_ORDER = 2.0**-90
"""What the least singular value of a scaled matrix comes out as, at most, for vectors right to a float's last
places, where it is 0."""

WITNESSED = 128.0
"""Half units of a last place by which the rule check lets numbers differ: how far those may be that say the
same where it would be refused, or nothing of an unknown be left, for less."""

Blur = Callable[[], Mapping[str, float]]
"""How far each known number may be off, worked out when it is asked for."""


def nearly_singular(matrix: Sequence[Sequence[float]]) -> bool:
    """Whether a matrix (n, n), rows and columns scaled, has a small singular value."""
    with np.errstate(all="ignore"):
        try:
            return bool(_Nearly(matrix, [0.0] * len(matrix)).left)
        except np.linalg.LinAlgError:
            return False


def undetermined(
    question: Question,
    matrix: Sequence[Sequence[Any]],
    rhs: Sequence[Any],
    exact: Callable[[float], Any],
    off: Blur,
    singular: bool = False,
    slack: float = 1.0,
) -> BlockOutcome | None:
    """What a block with this matrix (n, n), which is nearly singular, leaves free, or how it contradicts
    itself; None where it determines its unknowns.

    ``matrix`` and ``rhs`` hold numbers of the kind that ``exact`` makes of floats. ``singular``: the matrix
    is known to be, to all the digits at hand. ``slack``: numbers may be so many times as far ``off``.
    """
    with np.errstate(all="ignore"):  # what overflows is no point at which a rule holds
        try:
            return _undetermined(question, _Nearly(matrix, rhs), exact, off, singular, slack)
        except (ArithmeticError, ValueError, np.linalg.LinAlgError):
            return None


def _undetermined(
    question: Question,
    near: _Nearly,
    exact: Callable[[float], Any],
    off: Blur,
    singular: bool,
    slack: float,
) -> BlockOutcome | None:
    if not near.left:
        return None
    moved = Perturbed(question, off(), slack)
    lost = near.lost(exact, moved, SECOND_ORDER if singular else 0.0)
    if not lost:
        return None
    point = question.named(near.point(len(lost)))
    directions = [question.named(z) for z in lost]
    if not moved.holds(point):
        return near.contradiction(question, len(lost))
    if not all(moved.holds(far_along(point, direction)) for direction in directions):
        return None
    free = tuple(n for n in question.unknowns if any(abs(d[n]) > STILL for d in directions))
    fact = rank_loss(question, point, directions[0])
    return BlockOutcome(
        (Answer({n: v for n, v in point.items() if n not in free}),), complete=True, facts=(fact,), free=free
    )


def free_to_witness(
    question: Question,
    matrix: Sequence[Sequence[Any]],
    rhs: Sequence[Any],
    exact: Callable[[float], Any],
    off: Blur,
    instead: BlockOutcome,
) -> BlockOutcome:
    """What a nearly singular block leaves free within the backward error of the rule check, where the outcome
    that its digits at hand have ``instead`` is worth nothing: refused, or 0 for all, as any scale times 0 is.

    Numbers that were read off one answer agree to their last places, not to half of one.
    """
    if instead.free or (instead.answers and not _homogeneous(question, off)):
        return instead
    found = undetermined(question, matrix, rhs, exact, off, slack=WITNESSED)
    return found if found is not None and found.free else instead


def _homogeneous(question: Question, off: Blur) -> bool:
    """Whether the block holds with 0 for all of its unknowns."""
    return Perturbed(question, off(), WITNESSED).holds(dict.fromkeys(question.unknowns, 0.0))


class _Nearly:
    """The singular value decomposition of the scaled matrix: what of it is small."""

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
        kept = len(a) - int((self.s <= SUSPECT * self.s[0]).sum())
        self.left = (self.u[:, kept:].T / self.rows).tolist()
        self.right = (self.v[kept:] / self.columns).tolist()

    def lost(self, exact: Callable[[float], Any], moved: Perturbed, least: float) -> list[list[float]]:
        """Null directions (n,) of what the matrix may as well be, the largest entry of each 1."""
        found = []
        for w, z in zip(self.left, self.right, strict=True):
            terms = (
                exact(p) * a * exact(q)
                for p, row in zip(w, self.matrix, strict=True)
                for a, q in zip(row, z, strict=True)
                if a
            )
            if float(abs(sum(terms, exact(0.0)))) <= moved.reach(w, z) + least:
                size = max(map(abs, z))
                found.append([q / size for q in z])
        return found

    def point(self, lost: int) -> list[float]:
        """The solution of least scaled norm with the last singular values taken for 0."""
        kept = len(self.s) - lost
        y = (self.u.T @ self.b)[:kept] / self.s[:kept]
        point: list[float] = ((self.v[:kept].T @ y) / self.columns).tolist()
        return point

    def contradiction(self, question: Question, lost: int) -> BlockOutcome:
        """The equations whose left sides make up 0 = 0, and what their right sides make up instead."""
        scaled = self.u[:, len(self.s) - lost :].T
        worst = scaled[np.argmax(np.abs(scaled @ self.b))]
        involved = [i for i, share in enumerate(worst) if abs(share) > STILL]
        last = involved[-1]
        miss = float(worst @ self.b / worst[last] * self.rows[last])
        rows = tuple(question.equations[i] for i in involved)
        return BlockOutcome(complete=True, facts=(Conflict(rows, miss, dict(question.values)),))


FAR = 1.7
"""How far a second point is taken from a first, in sizes of that."""


def solve_linear_block(question: Question, off: Blur) -> BlockOutcome | None:
    """The outcome of a block that is linear in its unknowns; None where numbers are not finite.

    ``off`` tells how far the known numbers may be.
    """
    try:
        residual, matrix = question.kernel.at_zero(question.here)
    except ArithmeticError:
        return None
    rhs = [-r for r in residual]
    if not all(math.isfinite(v) for row in (*matrix, rhs) for v in row):
        return None
    facts = solve_linear(matrix, rhs)
    if facts.conflict:
        rows = tuple(question.equations[i] for i in facts.conflict)
        conflict = BlockOutcome(
            complete=True,
            facts=(Conflict(rows, facts.miss, dict(question.values)),),
            doubtful=_rounded(question, facts),
        )
        found = _dependent(question, matrix, rhs) or conflict
        small = len(matrix) <= EXACT_LIMIT
        return free_to_witness(question, matrix, rhs, Fraction, off, found) if small else found
    assert facts.solution is not None
    point = {n: v for n, v in zip(question.unknowns, facts.solution, strict=True) if v is not None}
    beyond = _beyond_floats(question, matrix, facts, math.isinf)
    if beyond is not None:
        return beyond
    if facts.free:
        direction = dict(zip(question.unknowns, facts.nullspace[0], strict=True))
        free = tuple(question.unknowns[j] for j in facts.free)
        return _free(question, point, direction, free)
    if len(point) < len(question.unknowns):
        return None
    if len(matrix) <= EXACT_LIMIT and nearly_singular(matrix):
        lost = undetermined(question, matrix, rhs, Fraction, off)
        near = lost or _regular(question, point) or _dependent(question, matrix, rhs)
        near = near and free_to_witness(question, matrix, rhs, Fraction, off, near)
        return near and near._replace(doubtful=True)
    regular = _regular(question, point) or _dependent(question, matrix, rhs)
    return regular or _beyond_floats(question, matrix, facts, _below_floats)


def _beyond_floats(
    question: Question,
    matrix: Sequence[Sequence[float]],
    facts: LinearOutcome,
    lost: Callable[[float], bool],
) -> BlockOutcome | None:
    """The first unknown whose exact value no float holds; None where there is none."""
    assert facts.solution is not None
    for column, number in enumerate(facts.solution):
        if number is not None and lost(number):
            reader = next(i for i, row in enumerate(matrix) if row[column])
            fact = BeyondFloats(question.equations[reader], question.unknowns[column])
            return BlockOutcome(facts=(fact,))
    return None


def _below_floats(number: float) -> bool:
    return abs(number) < SMALLEST_NORMAL


def _rounded(question: Question, facts: LinearOutcome) -> bool:
    """Whether a contradiction may come of the rounding of the constant terms alone."""
    point = {**question.here, **dict.fromkeys(question.unknowns, 0.0)}
    noise = (rounded_derivatives(question.kernel.forms[row], point)[2] for row in facts.conflict)
    total = sum(abs(share) * size for share, size in zip(facts.multipliers, noise, strict=True))
    return facts.miss is not None and abs(facts.miss) <= ROUNDINGS * total


def _regular(question: Question, point: dict[str, float]) -> BlockOutcome | None:
    """The solution; refined where the right-hand side was rounded so much that it does not hold as it is."""
    if not question.holds(point):
        point = question.named(newton(question.residual, question.jacobian, list(point.values())).x)
        if not question.holds(point):
            return None
    point = question.inside(question.wrapped(point))
    outside = question.outside(point)
    if outside is not None:
        return BlockOutcome.out_of_range(question.equations, outside, point[outside])
    return BlockOutcome((Answer(point),), complete=True)


def _dependent(
    question: Question, matrix: Sequence[Sequence[float]], rhs: Sequence[float]
) -> BlockOutcome | None:
    """Equations that repeat one another but for rounding: two points far apart satisfy them all."""
    found = null_by_rounding(matrix, rhs)
    if found is None:
        return None
    point, direction = question.named(found[0]), question.named(found[1])
    if not (question.holds(point) and question.holds(far_along(point, direction))):
        return None
    free = tuple(name for name, slope in direction.items() if abs(slope) > 1e-9)
    return _free(question, {n: v for n, v in point.items() if n not in free}, direction, free)


def _free(
    question: Question, point: dict[str, float], direction: dict[str, float], free: tuple[str, ...]
) -> BlockOutcome:
    fact = rank_loss(question, point, direction)
    return BlockOutcome((Answer(point),), complete=True, facts=(fact,), free=free)


def null_by_rounding(
    matrix: Sequence[Sequence[float]], rhs: Sequence[float]
) -> tuple[list[float], list[float]] | None:
    """Least-squares solution and null vector of A x = b where A has lost rank to rounding, else None."""
    a, b = np.asarray(matrix, dtype=float), np.asarray(rhs, dtype=float)
    rows = np.abs(a).max(axis=1)
    if not (rows > 0).all():
        return None
    with np.errstate(all="ignore"):  # what overflows is refused as not finite
        a, b = a / rows[:, None], b / rows
        columns = np.abs(a).max(axis=0)
        columns[columns == 0] = 1.0
        scaled = a / columns
        if not (np.isfinite(scaled).all() and np.isfinite(b).all()):
            return None
        _, singular, right = np.linalg.svd(scaled)
        if singular[-1] > 1e-13 * singular[0]:
            return None
        solution = np.linalg.lstsq(scaled, b, rcond=1e-13)[0] / columns
        null = right[-1] / columns
        null = null / np.abs(null).max()
    if not (np.isfinite(solution).all() and np.isfinite(null).all()):
        return None
    return solution.tolist(), null.tolist()


def far_along(point: Mapping[str, float], direction: Mapping[str, float]) -> dict[str, float]:
    """A second point, further from the first than that is large: at just its size, unknowns that are each
    other's negatives would become 0, where nothing of a rule is left to go by."""
    size = max(1.0, *(abs(v) for v in point.values()))
    reach = FAR * size / max(abs(d) for d in direction.values())
    return {n: v + (reach * direction[n] if math.isfinite(reach) else 0.0) for n, v in point.items()}
