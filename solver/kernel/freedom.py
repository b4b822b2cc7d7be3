"""Blocks that do not determine their unknowns: which move, along what, and whether that is so everywhere."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from solver.facts import RankLoss
from solver.kernel.question import Question

if TYPE_CHECKING:
    from numpy.typing import NDArray

RANK = 1e-9
STEP = 1e-2


def rank_loss(
    question: Question,
    point: Mapping[str, float],
    direction: Mapping[str, float],
    free: tuple[str, ...] = (),
) -> RankLoss:
    """The fact that a block leaves its unknowns free along ``direction`` at ``point``: those that move
    there, where it is not known which are."""
    free = free or tuple(name for name, slope in direction.items() if abs(slope) > 1e-9)
    return RankLoss(question.equations, free, direction, _everywhere(question, point))


def _everywhere(question: Question, point: Mapping[str, float]) -> bool:
    """Whether the Jacobian stays deficient as the known values move, with the equations still satisfied.

    A point of the solution set over unknowns *and* known values is displaced along the null space of
    the whole Jacobian and brought back by Gauss–Newton. If the unknowns' part of the Jacobian has lost
    rank there too, the equations repeat one another; if not, it is the values at hand that are special.
    """
    import numpy as np

    n = len(question.unknowns)
    start = np.array([*(point.get(name, 1.0) for name in question.unknowns), *question.known])
    if n == len(start):
        return True
    function = _Whole(question)
    try:
        with np.errstate(all="ignore"):  # what overflows is refused as not finite
            basis = function.null_space(start)
            for seed in range(3):
                mix = np.cos(np.arange(1, basis.shape[1] + 1) * (1.7 + seed))
                moved = function.returned(start + STEP * function.scale(start) * (basis @ mix))
                if moved is not None and function.rank(moved) == n:
                    return False
    except (ArithmeticError, ValueError, np.linalg.LinAlgError):
        return False
    return True


class _Whole:
    """The equations as functions of unknowns and known values together, scaled."""

    def __init__(self, question: Question) -> None:
        self.question = question
        self.n = len(question.unknowns)

    def residual(self, z: NDArray[Any]) -> NDArray[Any]:
        import numpy as np

        numbers = z.tolist()
        return np.array(self.question.kernel.residual(numbers[self.n :])(numbers[: self.n]))

    def scale(self, z: NDArray[Any]) -> NDArray[Any]:
        import numpy as np

        return np.where(z == 0.0, 1.0, np.abs(z))

    def jacobian(self, z: NDArray[Any]) -> NDArray[Any]:
        """Central differences in scaled variables, rows equilibrated."""
        import numpy as np

        columns = []
        for j, size in enumerate(self.scale(z)):
            h = np.zeros_like(z)
            h[j] = 6e-6 * size
            columns.append((self.residual(z + h) - self.residual(z - h)) / 1.2e-5)
        matrix = np.array(columns).T
        rows = np.abs(matrix).max(axis=1, initial=0.0)
        if not np.isfinite(rows).all():
            raise ValueError("the Jacobian is not finite")
        return matrix / np.where(rows > 0, rows, 1.0)[:, None]

    def null_space(self, z: NDArray[Any]) -> NDArray[Any]:
        import numpy as np

        _, singular, right = np.linalg.svd(self.jacobian(z))
        rank = int((singular > 1e-6 * singular[0]).sum())
        return np.asarray(right[rank:].T)

    def returned(self, z: NDArray[Any]) -> NDArray[Any] | None:
        """The nearest point of the solution set, by Gauss–Newton; None where it is not reached."""
        import numpy as np

        for _ in range(12):
            residual = self.residual(z)
            jacobian = np.array(
                [
                    (self.residual(z + h) - self.residual(z - h)) / (2 * h.max())
                    for h in np.diag(6e-6 * self.scale(z))
                ]
            ).T
            if not (np.isfinite(jacobian).all() and np.isfinite(residual).all()):
                return None
            z = z - np.linalg.lstsq(jacobian, residual, rcond=1e-10)[0]
        settled = np.abs(self.residual(z)).max() <= 1e-9 * max(1.0, float(np.abs(z).max()) ** 2)
        return z if settled and np.isfinite(z).all() else None

    def rank(self, z: NDArray[Any]) -> int:
        import numpy as np

        singular = np.linalg.svd(self.jacobian(z)[:, : self.n], compute_uv=False)
        return int((singular > 1e-5 * singular[0]).sum())


def null_by_rounding(
    matrix: Sequence[Sequence[float]], rhs: Sequence[float]
) -> tuple[list[float], list[float]] | None:
    """Least-squares solution and null vector of A x = b where A has lost rank to rounding, else None."""
    import numpy as np

    a, b = np.asarray(matrix, dtype=float), np.asarray(rhs, dtype=float)
    rows = np.abs(a).max(axis=1)
    if not (rows > 0).all():
        return None
    with np.errstate(all="ignore"):  # what overflows is refused as not finite
        a, b = a / rows[:, None], b / rows
        columns = np.abs(a).max(axis=0)
        columns[columns == 0] = 1.0
        scaled = a / columns
        if not (np.isfinite(scaled).all() and np.isfinite(b).all()):
            return None
        _, singular, right = np.linalg.svd(scaled)
        if singular[-1] > 1e-13 * singular[0]:
            return None
        solution = np.linalg.lstsq(scaled, b, rcond=1e-13)[0] / columns
        null = right[-1] / columns
        null = null / np.abs(null).max()
    if not (np.isfinite(solution).all() and np.isfinite(null).all()):
        return None
    return solution.tolist(), null.tolist()


def far_along(point: Mapping[str, float], direction: Mapping[str, float]) -> dict[str, float]:
    """A second point, as far from the first as that is large."""
    size = max(1.0, *(abs(v) for v in point.values()))
    reach = size / max(abs(d) for d in direction.values())
    return {n: v + (reach * direction[n] if math.isfinite(reach) else 0.0) for n, v in point.items()}
