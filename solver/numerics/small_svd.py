"""The singular value decomposition of a small matrix in plain Python: a few unknowns need no numpy.

One-sided Jacobi rotations make the columns of A V orthogonal (M. R. Hestenes, 1958); their lengths are the
singular values, to a relative error that no scaling of the columns spoils (J. Demmel & K. Veselić, *Jacobi's
method is more accurate than QR*, 1992).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from solver.numerics.termination import EPS

if TYPE_CHECKING:
    from collections.abc import Sequence

LARGEST = 12
"""Order up to which one takes less than a few milliseconds, and a few of them less than to import numpy."""
SWEEPS = 40
"""Six or seven do, and a few more where singular values lie close together."""


@dataclass(frozen=True, slots=True)
class Decomposition:
    """``values`` (n,), descending; ``right``: as many orthonormal vectors (n,), ``images``: A times each."""

    values: list[float]
    right: list[list[float]]
    images: list[list[float]]

    def rank(self, share: float) -> int:
        """How many values are larger than a share of the largest."""
        return sum(value > share * self.values[0] for value in self.values)

    def least(self, rhs: Sequence[float], rank: int) -> list[float]:
        """x (n,) of least norm with |A x - rhs| least, along the first ``rank`` of the right vectors."""
        x = [0.0] * len(self.values)
        for value, right, image in zip(self.values[:rank], self.right, self.images, strict=False):
            length = sum(a * b for a, b in zip(image, rhs, strict=True)) / value / value
            x = [v + length * r for v, r in zip(x, right, strict=True)]
        return x


def decomposed(matrix: Sequence[Sequence[float]]) -> Decomposition:
    """Of finite numbers (m, n) of ordinary size. Where m < n, the last n - m values are 0 to rounding."""
    columns = [list(column) for column in zip(*matrix, strict=True)]
    n = len(columns)
    # what belongs to a column goes below it, so that one rotation turns both
    stacked = [[*column, *(float(i == j) for i in range(n))] for j, column in enumerate(columns)]
    m = len(matrix)
    negligible = (EPS * math.sqrt(sum(a * a for column in columns for a in column))) ** 2
    for _ in range(SWEEPS):
        turned = [_rotated(stacked, i, j, m, negligible) for i in range(n - 1) for j in range(i + 1, n)]
        if not any(turned):
            break
    lengths = [math.hypot(*column[:m]) for column in stacked]
    order = sorted(range(n), key=lambda j: -lengths[j])
    return Decomposition(
        [lengths[j] for j in order], [stacked[j][m:] for j in order], [stacked[j][:m] for j in order]
    )


def _rotated(stacked: list[list[float]], i: int, j: int, m: int, negligible: float) -> bool:
    """Whether two columns had still to be turned in their plane; then they are orthogonal."""
    one, other = stacked[i], stacked[j]
    alpha = sum([a * a for a in one[:m]])
    beta = sum([b * b for b in other[:m]])
    gamma = sum([a * b for a, b in zip(one[:m], other[:m], strict=True)])
    if abs(gamma) <= max(m * EPS * math.sqrt(alpha * beta), negligible):
        return False
    zeta = (beta - alpha) / (2.0 * gamma)
    tangent = math.copysign(1.0, zeta) / (abs(zeta) + math.hypot(1.0, zeta))
    cosine = 1.0 / math.hypot(1.0, tangent)
    sine = cosine * tangent
    stacked[i] = [cosine * a - sine * b for a, b in zip(one, other, strict=True)]
    stacked[j] = [sine * a + cosine * b for a, b in zip(one, other, strict=True)]
    return True
