"""The float next to a root that Newton's method in floats comes near to, and no nearer.

Where a rule loses digits as it is evaluated (``1 - cos(x)`` at a small x), residuals in floats end the search
some roundings away from the root. Computed to many digits they lead on: iterative refinement, the slopes
staying those of floats (N. J. Higham, *Accuracy and Stability of Numerical Algorithms*, 2002, section 25.2).
At a root of multiplicity m, where slopes vanish, too, Newton's steps shrink by (m - 1)/m each: m is told
from two of them, and m times the second leads to the root (E. Schröder, Math. Ann. 2 (1870) 317-365).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from rulesheets.evaluate import Undefined, extended
from rulesheets.evaluate.digits import context
from solver.accuracy.digits import linearized
from solver.kernel.question import Question
from solver.numerics.elimination import eliminate

DIGITS = 60
ROUNDS = 8
MULTIPLE_DIGITS, MULTIPLE_ROUNDS = 150, 16
"""At a root of multiplicity m the residual is the m-th power of the distance."""
MOST = 8
"""Multiplicity that is looked for."""
REGULAR = 0.02
"""By how much the shrinking of steps may miss that of a multiplicity."""
SETTLED = 1e-20
"""Share of its size by which the last step moves an unknown: no float shows it."""


def sharp_root(question: Question, start: Sequence[float], sizes: Sequence[float]) -> list[float] | None:
    """The root near ``start`` (n,), to the last place; None where the steps don't settle.

    ``sizes`` (n,) of the unknowns are what steps are measured by where an unknown is 0.
    """
    mp, names = context(DIGITS), question.unknowns
    try:
        factor = question.factor(start, sizes)
        if factor.rank < factor.columns:
            return None
        x = [mp.mpf(v) for v in start]
        for _ in range(ROUNDS):
            step = _step(factor, _misses(question, dict(zip(names, x, strict=True))))
            x = [v - d for v, d in zip(x, step, strict=True)]
            if all(abs(d) <= SETTLED * max(abs(v), size) for v, d, size in zip(x, step, sizes, strict=True)):
                return [float(v) for v in x]
    except (Undefined, ArithmeticError, ValueError):
        return None
    return None


def multiple_root(question: Question, start: Sequence[float], sizes: Sequence[float]) -> list[float] | None:
    """The multiple root near ``start`` (n,), to the last place; None where the steps tell of none."""
    mp, names = context(MULTIPLE_DIGITS), question.unknowns
    x, before = [mp.mpf(v) for v in start], None
    try:
        for _ in range(MULTIPLE_ROUNDS):
            at = {**question.here, **dict(zip(names, x, strict=True))}
            rows, misses = linearized(question.kernel.forms, names, at, MULTIPLE_DIGITS)
            step = eliminate(rows, misses) if any(misses) else None
            if step is None:  # nothing is missed here, or no slope is left
                return [float(v) for v in x] if not any(misses) else None
            length = max(abs(d) / size for d, size in zip(step, sizes, strict=True))
            many = _multiplicity(length / before) if before else 1
            x = [v - many * d for v, d in zip(x, step, strict=True)]
            if many > 1 and length * many <= SETTLED:
                return [
                    float(v) if abs(v) > SETTLED * size else 0.0 for v, size in zip(x, sizes, strict=True)
                ]
            before = length if many == 1 else None
    except (Undefined, ArithmeticError, ValueError):
        return None
    return None


def _multiplicity(shrinking: Any) -> int:
    """m, where steps shrink by (m - 1)/m; else 1."""
    many = round(float(1 / (1 - shrinking))) if shrinking < 1 - 1 / (2 * MOST) else 1
    return many if 1 < many <= MOST and abs(shrinking - (many - 1) / many) <= REGULAR else 1


def _misses(question: Question, point: dict[str, Any]) -> list[Any]:
    at = {**question.here, **point}
    return [extended(form, at, DIGITS) for form in question.kernel.forms]


def _step(factor: Any, misses: Sequence[Any]) -> list[Any]:
    """J⁻¹ F, the misses brought to unit size for the floats that solve for it."""
    largest = max(map(abs, misses))
    if not largest:
        return [largest] * len(misses)
    return [largest * d for d in factor.solve([float(miss / largest) for miss in misses])]
