"""scipy's methods for systems of equations: a last resort, and what a chart measures beside ours."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from rulesheets.deadline import expect_time
from solver.numerics.system import Jacobian, Residual

TRUST_REGIONS = ("lm", "hybr")
METHODS = ("hybr", "lm", "least_squares")
TIGHT = 1e-14
"""The relative tolerance asked for: some tens of ε, which is the least that they accept."""


@dataclass(frozen=True, slots=True)
class ScipyRoot:
    """``success`` is what scipy says of itself; ``evaluations`` are those of the residual."""

    x: tuple[float, ...]
    success: bool
    evaluations: int


def scipy_root(
    residual: Residual,
    jacobian: Jacobian,
    start: Sequence[float],
    method: str,
    scale: Sequence[float] | None = None,
    tolerance: float = TIGHT,
) -> ScipyRoot:
    """``scipy.optimize.root`` (hybr, lm) or ``least_squares`` from ``start`` (n,), with the exact Jacobian.

    ``scale`` (n,): typical magnitudes of the unknowns, else scipy takes its own from the Jacobian. Where the
    residual is undefined it is taken as nan, at which the methods give up. ``tolerance`` is relative.
    """
    from scipy.optimize import least_squares, root  # takes longer to import than most solves

    def values(x: Any) -> Any:
        expect_time()
        try:
            return np.array(residual(x.tolist()), dtype=float)
        except (ArithmeticError, ValueError):
            return np.full(len(start), np.nan)

    def slopes(x: Any) -> Any:
        return np.array(jacobian(x.tolist()), dtype=float)

    try:
        with np.errstate(all="ignore"):
            if method == "least_squares":
                found = least_squares(values, start, slopes, xtol=tolerance, ftol=tolerance, gtol=tolerance)
            else:
                diagonal = {} if scale is None else {"diag": [1.0 / abs(s) if s else 1.0 for s in scale]}
                found = root(values, start, jac=slopes, method=method, tol=tolerance, options=diagonal)
    except (ArithmeticError, ValueError, np.linalg.LinAlgError):
        return ScipyRoot(tuple(start), False, 0)
    x = tuple(float(v) for v in found.x)
    return ScipyRoot(x, bool(found.success) and bool(np.isfinite(found.x).all()), int(found.nfev))
