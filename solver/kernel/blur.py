"""How far rounding leaves the point of a block open, and what is plainly no answer in spite of that."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from solver.accuracy.witness import BACKWARD, gross, size
from solver.kernel.question import Question
from solver.numerics.small_inverse import LARGEST, inverse

EPSILON = 2.0**-52
ORDINARY = 1e8
"""Condition up to which the backward error of an answer says enough."""


@dataclass(frozen=True, slots=True)
class Uncertainty:
    """``errors`` (n,) of the unknowns; ``steepness``: how far a rule moves with its variables, beside its
    terms, the largest of the block."""

    errors: list[float]
    steepness: float = 0.0


def uncertainty(question: Question, point: Mapping[str, float]) -> Uncertainty:
    """Forward error of the unknowns for the backward error that the witness admits: |J⁻¹|·t."""
    try:
        jacobian = question.jacobian(list(point.values()))
    except (ArithmeticError, ValueError):
        return Uncertainty(
            [0.0] * len(point)
        )  # a slope is infinite there: nothing speaks for a multiple root
    sizes = _sizes(question, point)
    steepness = max((moves / terms if terms else math.inf for moves, terms in sizes if moves), default=0.0)
    return Uncertainty(_blur(jacobian, sizes), steepness)


def is_ordinary(point: Mapping[str, float], found: Uncertainty) -> bool:
    """Whether rules and block are so well-conditioned at a point that it is near a root if the rules hold."""
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
    tolerance = [max(BACKWARD * moves, EPSILON * terms) for moves, terms in sizes]
    errors = _spread(jacobian, tolerance)
    return [error if math.isfinite(error) else math.inf for error in errors]


def _spread(jacobian: Sequence[Sequence[float]], tolerance: Sequence[float]) -> list[float]:
    """|J⁻¹|·t (n,) for a Jacobian (n, n); infinite where it is singular."""
    n = len(tolerance)
    if n <= LARGEST:
        rows = inverse(jacobian)
        if rows is None:
            return [math.inf] * n
        return [sum(abs(entry) * t for entry, t in zip(row, tolerance, strict=True)) for row in rows]
    import numpy as np

    try:
        inverted = np.linalg.inv(np.asarray(jacobian, dtype=float))
    except np.linalg.LinAlgError:
        return [math.inf] * n
    with np.errstate(all="ignore"):
        errors: list[float] = (np.abs(inverted) @ np.array(tolerance)).tolist()
    return errors
