"""The singular value decomposition of a tiny matrix, to solve with: a singular point needs no numpy."""

from __future__ import annotations

from math import isfinite
from typing import TYPE_CHECKING

from solver.numerics.nullspace import decompose
from solver.numerics.termination import EPS

if TYPE_CHECKING:
    from collections.abc import Sequence

TINY = 6
"""Up to so many rows and columns plain Python takes less than half a millisecond over it."""


class TinyFactor:
    """Of an m × n matrix of any rank, as ``factor.DenseFactor``: 0 where some number is not finite."""

    def __init__(self, matrix: Sequence[Sequence[float]], weight: Sequence[float]) -> None:
        self._weight = weight
        sizes = [sum(abs(a * w) for a, w in zip(row, weight, strict=True)) for row in matrix]
        if not all(map(isfinite, sizes)):
            sizes, matrix = [0.0] * len(matrix), [[0.0] * len(weight)] * len(matrix)
        self._row_scale = [size or 1.0 for size in sizes]
        self._singular = decompose(
            [
                [a * w / size for a, w in zip(row, weight, strict=True)]
                for row, size in zip(matrix, self._row_scale, strict=True)
            ]
        )
        self.columns = len(weight)
        self.rank = self._singular.rank(2 * max(len(matrix), len(weight)) * EPS)

    def solve(self, rhs: Sequence[float]) -> list[float]:
        scaled = [b / size for b, size in zip(rhs, self._row_scale, strict=True)]
        least = self._singular.least(scaled, self.rank)
        return [w * v for w, v in zip(self._weight, least, strict=True)]

    def condition(self) -> float:
        if self.rank < self.columns:
            return float("inf")
        return self._singular.values[0] / self._singular.values[-1]
