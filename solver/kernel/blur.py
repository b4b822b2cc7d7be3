"""How far rounding leaves the point of a block open, and what is plainly no answer in spite of that."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from solver.accuracy.rule_check import BACKWARD, gross, size
from solver.kernel.question import SPARSE, Question, Sparse
from solver.numerics.linear_algebra import inverse
from solver.numerics.sparse_newton import SparseFactor

EPSILON = 2.0**-52
ORDINARY = 1e8
"""Condition up to which the backward error of an answer says enough."""


@dataclass(frozen=True, slots=True)
class Uncertainty:
    """``errors`` (n,) of the unknowns; ``steepness``: how far a rule moves with its variables, beside its
    terms, the largest of the block. ``relative``: of a large block the largest error beside the size of its
    unknown, estimated at once.
    """

    errors: list[float]
    steepness: float = 0.0
    relative: float | None = None


def uncertainty(question: Question, point: Mapping[str, float]) -> Uncertainty:
    """Forward error of the unknowns for the backward error that the rule check admits: |J⁻¹|·t."""
    if len(point) > SPARSE and question.sparse is not None:
        return _sparse_uncertainty(question, question.sparse, point)
    try:
        jacobian = question.jacobian(list(point.values()))
    except (ArithmeticError, ValueError):
        return Uncertainty(
            [0.0] * len(point)
        )  # a slope is infinite there: nothing speaks for a multiple root
    sizes = _sizes(question, point)
    return Uncertainty(_blur(jacobian, sizes), _steepness(sizes))


def _sparse_uncertainty(question: Question, sparse: Sparse, point: Mapping[str, float]) -> Uncertainty:
    """The same of a large block. An unknown near 0 is measured by what would move one of its rules by as much
    as the terms of that are. Linear rules are not steep, however much cancels in their brackets."""
    straight = zip(question.kernel.straight, _sizes(question, point), strict=True)
    sizes = [(moves, max(moves, terms) if linear else terms) for linear, (moves, terms) in straight]
    x = np.array(list(point.values()))
    entries = sparse[1](x)
    try:
        factor = SparseFactor(entries, len(x))
    except ArithmeticError:
        return Uncertainty([math.inf] * len(x), _steepness(sizes), math.inf)
    slopes, rows, columns = entries
    terms, reach = np.array([term for _, term in sizes]), np.full(len(x), np.inf)
    with np.errstate(all="ignore"):
        np.minimum.at(reach, columns, np.where(slopes, terms[rows] / np.abs(slopes), np.inf))
    weight = np.maximum(np.abs(x), np.where(np.isfinite(reach), reach, 0.0))
    weight = np.where(weight > 0.0, weight, 1.0)
    relative = factor.spread(np.array(_tolerances(sizes)), weight)
    if not math.isfinite(relative):
        relative = math.inf
    return Uncertainty((relative * weight).tolist(), _steepness(sizes), relative)


def _steepness(sizes: Sequence[tuple[float, float]]) -> float:
    return max((moves / terms if terms else math.inf for moves, terms in sizes if moves), default=0.0)


def is_ordinary(point: Mapping[str, float], found: Uncertainty) -> bool:
    """Whether rules and block are so well-conditioned at a point that it is near a root if the rules hold."""
    if found.relative is not None:
        return found.steepness <= ORDINARY and found.relative <= ORDINARY * EPSILON
    return found.steepness <= ORDINARY and all(
        error <= ORDINARY * EPSILON * abs(v)
        for error, v in zip(found.errors, point.values(), strict=True)
        if v
    )


def astray(question: Question, point: Mapping[str, float], share: float) -> bool:
    """Whether a point that was computed is plainly no answer: an equation misses by more than a share of its
    terms, and than what rounding of the point itself explains. A number that cancellation has left no digit
    of says nothing against the others.
    """
    x, here = list(point.values()), {**question.here, **point}
    try:
        misses = question.residual(x)
        far = [
            abs(miss) > share * gross(equation, here)
            for miss, equation in zip(misses, question.kernel.equations, strict=True)
        ]
        if not any(far):
            return False
        jacobian = question.jacobian(x)
    except (ArithmeticError, ValueError):
        return False
    off = _blur(jacobian, _sizes(question, point))
    explained = [sum(abs(s) * e for s, e in zip(row, off, strict=True) if s) for row in jacobian]
    return any(is_far and abs(m) > e for is_far, m, e in zip(far, misses, explained, strict=True))


def _sizes(question: Question, point: Mapping[str, float]) -> list[tuple[float, float]]:
    """How far each rule moves with its variables, and the size of its terms."""
    everything = {**question.here, **point}
    return [(size(rule, everything), gross(rule, everything)) for rule in question.kernel.equations]


def _blur(jacobian: Sequence[Sequence[float]], sizes: Sequence[tuple[float, float]]) -> list[float]:
    errors = _spread(jacobian, _tolerances(sizes))
    return [error if math.isfinite(error) else math.inf for error in errors]


def _tolerances(sizes: Sequence[tuple[float, float]]) -> list[float]:
    return [max(BACKWARD * moves, EPSILON * terms) for moves, terms in sizes]


def _spread(jacobian: Sequence[Sequence[float]], tolerance: Sequence[float]) -> list[float]:
    """|J⁻¹|·t (n,) for a Jacobian (n, n); infinite where it is singular."""
    inverted = inverse(jacobian)
    if inverted is None:
        return [math.inf] * len(tolerance)
    with np.errstate(all="ignore"):
        errors: list[float] = (np.abs(inverted) @ np.array(tolerance)).tolist()
    return errors
