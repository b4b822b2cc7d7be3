"""Derivatives of an answer as central differences at 50 digits, from the active rules and nothing
else.

The perturbed answers are found by Newton steps with the pseudo-inverse of the float Jacobian, taken
of all active rules at once, on residuals of 50 digits: no path, no block and no derivative of the
solver is used.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import Any

import mpmath
import numpy as np

from rulesheets.evaluate import Undefined, derivatives, holds
from rulesheets.evaluate.digits import extended
from rulesheets.model import Equation, Model, Value
from rulesheets.syntax.nodes import Name, Symbol

DIGITS = 50
STEP = mpmath.mpf(10) ** -12


class Differences:
    """Central differences at one answer."""

    def __init__(self, model: Model, values: Mapping[str, Value], inputs: Collection[str]) -> None:
        self.values = values
        self.equations = [e for e in model.equations if _active(model, e, values, inputs)]
        read = dict.fromkeys(name for e in self.equations for name in e.names)
        self.unknowns = [name for name in read if name not in inputs]
        self.size = np.array([abs(values[n]) or 1.0 for n in self.unknowns])
        rows = [self._row(e) for e in self.equations]
        self.row_size = np.abs(rows).max(axis=1)
        self.inverse = np.linalg.pinv(rows / self.row_size[:, None], rcond=1e-15)

    def _row(self, equation: Equation) -> Any:
        left, right = (
            derivatives(side, self.values)[1] for side in (equation.left, equation.right)
        )
        slopes = [left.get(n, 0.0) - right.get(n, 0.0) for n in self.unknowns]
        return np.array(slopes) * self.size

    def answer(self, given: str | None = None, step: Any = 0) -> dict[str, Any]:
        """The answer to 50 digits where one input is moved by ``step``."""
        with mpmath.workdps(DIGITS):
            point = {n: v if isinstance(v, str) else mpmath.mpf(v) for n, v in self.values.items()}
            if given is not None:
                point[given] += step
            for _ in range(60):
                misses = [
                    extended(e.left, point, DIGITS) - extended(e.right, point, DIGITS)
                    for e in self.equations
                ]
                scaled = [m / float(s) for m, s in zip(misses, self.row_size, strict=True)]
                largest = max(map(abs, scaled))
                if largest < mpmath.mpf(10) ** -44:
                    return point
                move = self.inverse @ np.array([float(m / largest) for m in scaled])
                for name, size, part in zip(self.unknowns, self.size, move, strict=True):
                    point[name] -= mpmath.mpf(float(size)) * mpmath.mpf(float(part)) * largest
            raise AssertionError(f"the oracle does not converge: {mpmath.nstr(largest)}")

    def by(self, given: str) -> dict[str, float]:
        """d/d(given) of every unknown."""
        with mpmath.workdps(DIGITS):
            step = STEP * (abs(mpmath.mpf(self.values[given])) or 1)
            above, below = self.answer(given, step), self.answer(given, -step)
            return {name: float((above[name] - below[name]) / (2 * step)) for name in self.unknowns}


def _active(
    model: Model, equation: Equation, values: Mapping[str, Value], inputs: Collection[str]
) -> bool:
    if not all(name in values for name in equation.names):
        return False
    for side in (equation.left, equation.right):
        if isinstance(side, Symbol) or (
            isinstance(side, Name) and isinstance(values[side.name], str)
        ):
            return False
    try:
        return all(
            holds(model.conditions[p.condition], values, inputs) is p.holds for p in equation.guard
        )
    except (KeyError, Undefined):
        return False
