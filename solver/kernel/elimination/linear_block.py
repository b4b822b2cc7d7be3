"""Linear blocks: decided by elimination, not iterated."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from fractions import Fraction

from rulesheets.evaluate import rounded_derivatives
from solver.accuracy.rule_check import ROUNDINGS
from solver.facts import BeyondFloats, Conflict
from solver.kernel.candidates import Answer
from solver.kernel.elimination.near_rank import (
    SMALLEST,
    Blur,
    free_to_witness,
    nearly_singular,
    undetermined,
)
from solver.kernel.freedom import far_along, null_by_rounding, rank_loss
from solver.kernel.outcome import BlockOutcome
from solver.kernel.question import Question
from solver.numerics.linear import EXACT_LIMIT, LinearOutcome, solve_linear
from solver.numerics.newton import newton


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
        return near and replace(near, doubtful=True)
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
    return abs(number) < SMALLEST


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
