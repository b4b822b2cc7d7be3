"""scipy's solvers for systems of equations, to be measured beside ours."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from solver.numerics.plain_newton import PlainEnd
from solver.numerics.system import Jacobian, Residual

METHODS = ("hybr", "lm", "least_squares")


def scipy_root(residual: Residual, jacobian: Jacobian, start: Sequence[float], method: str) -> PlainEnd:
    """``scipy.optimize.root`` (hybr, lm) or ``least_squares``, with the exact Jacobian and tight tolerances.

    Success is what scipy says of itself. Evaluations of the residual count as iterations.
    """
    import numpy as np
    from scipy.optimize import least_squares, root

    def values(x: Any) -> Any:
        return np.array(residual(x.tolist()))

    def slopes(x: Any) -> Any:
        return np.array(jacobian(x.tolist()))

    try:
        with np.errstate(all="ignore"):
            if method == "least_squares":
                found = least_squares(values, start, jac=slopes, xtol=1e-15, ftol=1e-15, gtol=1e-15)
            else:
                found = root(values, start, jac=slopes, method=method, tol=1e-14)
    except (ArithmeticError, ValueError, np.linalg.LinAlgError):
        return PlainEnd(False, tuple(start), 0)
    x = tuple(float(v) for v in found.x)
    return PlainEnd(bool(found.success) and all(map(np.isfinite, x)), x, int(found.nfev))
