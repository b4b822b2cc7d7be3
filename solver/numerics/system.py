"""F(x) = 0 and its iterates, with every way of being undefined turned into None."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

from solver.numerics.linear_algebra import Factor, as_matrix, factorise, row_sizes
from solver.numerics.termination import weights

Residual: TypeAlias = Callable[[list[float]], Sequence[float]]
Jacobian: TypeAlias = Callable[[list[float]], Any]
"""Rows of ∂F_i/∂x_j as a sequence of sequences, or a scipy sparse matrix."""


@dataclass(frozen=True, slots=True)
class Point:
    """An iterate with its residual, Jacobian, weights and factored Jacobian."""

    x: list[float]
    residual: list[float]
    jacobian: Any
    weight: list[float]
    factor: Factor

    def correction(self, residual: Sequence[float]) -> list[float]:
        return [-d for d in self.factor.solve(residual)]


class System:
    """Residual and Jacobian with every way of being undefined turned into None."""

    def __init__(self, residual: Residual, jacobian: Jacobian, scale: Sequence[float]) -> None:
        self._residual, self._jacobian, self.scale = residual, jacobian, scale
        self.functions = residual, jacobian

    def residual_at(self, x: list[float]) -> list[float] | None:
        try:
            values = [float(v) for v in self._residual(x)]
        except (ArithmeticError, ValueError):
            return None
        return values if all(map(math.isfinite, values)) else None

    def point(self, x: list[float], residual: list[float] | None = None) -> Point | None:
        """The point x, or None where residual or Jacobian is undefined or infinite."""
        values = self.residual_at(x) if residual is None else residual
        if values is None:
            return None
        weight = weights(x, self.scale)
        try:
            matrix = as_matrix(self._jacobian(x), len(x))
        except (ArithmeticError, ValueError):
            return None
        if not all(map(math.isfinite, row_sizes(matrix, weight))):
            return None
        return Point(x, values, matrix, weight, factorise(matrix, weight))
