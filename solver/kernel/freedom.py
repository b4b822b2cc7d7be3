"""Blocks that do not determine their unknowns: which move, along what, and whether that is so everywhere."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from itertools import chain

from solver.facts import RankLoss
from solver.kernel.question import Question
from solver.numerics.linear_algebra import decompose

RANK = 1e-9
STEP = 1e-2
NUDGE = 6e-6
"""Shares of the size of a variable: by which a point is displaced, and by which differences are taken."""
FAR = 1.7
"""How far a second point is taken from a first, in sizes of that."""


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
    n = len(question.unknowns)
    start = [*(point.get(name, 1.0) for name in question.unknowns), *question.known]
    if n == len(start):
        return True
    function = _Whole(question)
    try:
        basis = function.null_space(start)
        for seed in range(3):
            mix = [math.cos((k + 1) * (1.7 + seed)) for k in range(len(basis))]
            way = [sum(c * v[j] for c, v in zip(mix, basis, strict=True)) for j in range(len(start))]
            steps = zip(start, function.scale(start), way, strict=True)
            moved = function.returned([z + STEP * size * part for z, size, part in steps])
            if moved is not None and function.rank(moved) == n:
                return False
    except (ArithmeticError, ValueError):
        return False
    return True


class _Whole:
    """The equations as functions of unknowns and known values together."""

    def __init__(self, question: Question) -> None:
        self.question = question
        self.n = len(question.unknowns)

    def residual(self, z: Sequence[float]) -> Sequence[float]:
        return self.question.kernel.residual(z[self.n :])(z[: self.n])

    def scale(self, z: Sequence[float]) -> list[float]:
        return [abs(v) or 1.0 for v in z]

    def jacobian(self, z: Sequence[float]) -> list[list[float]]:
        """Central differences in scaled variables, rows equilibrated. Raises ValueError where one has no
        bounds."""
        rows = self._differences(z, [1.0] * len(z))
        if not _finite(rows):
            raise ValueError("the Jacobian is not finite")
        sizes = [max(map(abs, row)) or 1.0 for row in rows]
        return [[a / size for a in row] for row, size in zip(rows, sizes, strict=True)]

    def _differences(self, z: Sequence[float], units: Sequence[float]) -> list[list[float]]:
        """What each equation rises by, to either side of z, for a unit of each variable."""
        columns = []
        for j, (size, unit) in enumerate(zip(self.scale(z), units, strict=True)):
            above, below = (
                self.residual([*z[:j], z[j] + step, *z[j + 1 :]]) for step in (NUDGE * size, -NUDGE * size)
            )
            columns.append([(a - b) / (2 * NUDGE * unit) for a, b in zip(above, below, strict=True)])
        return [list(row) for row in zip(*columns, strict=True)]

    def null_space(self, z: Sequence[float]) -> list[list[float]]:
        found = decompose(self.jacobian(z))
        vectors: list[list[float]] = found.right[found.rank(1e-6) :].tolist()
        return vectors

    def returned(self, z: Sequence[float]) -> Sequence[float] | None:
        """The nearest point of the solution set, by Gauss–Newton; None where it is not reached."""
        for _ in range(12):
            miss, rows = self.residual(z), self._differences(z, self.scale(z))
            if not _finite([miss, *rows]):
                return None
            found = decompose(rows)
            step = found.least(miss, found.rank(1e-10))
            z = [v - change for v, change in zip(z, step, strict=True)]
        settled = max(map(abs, self.residual(z))) <= 1e-9 * max(1.0, max(map(abs, z)) ** 2)
        return z if settled and _finite([z]) else None

    def rank(self, z: Sequence[float]) -> int:
        return decompose([row[: self.n] for row in self.jacobian(z)]).rank(1e-5)


def _finite(rows: Sequence[Sequence[float]]) -> bool:
    return all(map(math.isfinite, chain.from_iterable(rows)))


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
    """A second point, further from the first than that is large: at just its size, unknowns that are each
    other's negatives would become 0, where nothing of a rule is left to go by."""
    size = max(1.0, *(abs(v) for v in point.values()))
    reach = FAR * size / max(abs(d) for d in direction.values())
    return {n: v + (reach * direction[n] if math.isfinite(reach) else 0.0) for n, v in point.items()}
