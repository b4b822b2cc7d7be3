"""The float next to a root that Newton's method in floats comes near to, and no nearer.

Where a rule loses digits as it is evaluated (``1 - cos(x)`` at a small x), residuals in floats end the search
some roundings away from the root. Computed to many digits they lead on: iterative refinement, the slopes
staying those of floats (N. J. Higham, *Accuracy and Stability of Numerical Algorithms*, 2002, section 25.2).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from rulesheets.evaluate import Undefined, extended
from rulesheets.functions.extended import context
from solver.kernel.question import Question
from solver.numerics.factor import as_matrix, factorise

DIGITS = 60
ROUNDS = 8
SETTLED = 1e-20
"""Share of its size by which the last step moves an unknown: no float shows it."""


def sharp_root(question: Question, start: Sequence[float], sizes: Sequence[float]) -> list[float] | None:
    """The root near ``start`` (n,), to the last place; None where the steps don't settle.

    ``sizes`` (n,) of the unknowns are what steps are measured by where an unknown is 0.
    """
    mp, names = context(DIGITS), question.unknowns
    try:
        factor = factorise(as_matrix(question.jacobian(list(start)), len(names)), sizes)
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


def _misses(question: Question, point: dict[str, Any]) -> list[Any]:
    at = {**question.here, **point}
    return [extended(form, at, DIGITS) for form in question.kernel.forms]


def _step(factor: Any, misses: Sequence[Any]) -> list[Any]:
    """J⁻¹ F, the misses brought to unit size for the floats that solve for it."""
    largest = max(map(abs, misses))
    if not largest:
        return [largest] * len(misses)
    return [largest * d for d in factor.solve([float(miss / largest) for miss in misses])]
