"""Newton's method on arrays, from many starts at once; and where to start."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from rulesheets.deadline import expect_time
from solver.numerics.linear_algebra import Array
from solver.numerics.tolerances import ARRIVED, NULL, ON_LINE

BatchFunction: TypeAlias = Callable[[Array], Array]

PATIENCE = 12
"""Steps without a gain of a tenth after which a start is abandoned."""
KEPT = 0.1
"""Share of the distance to the end of a range that a step beyond it leaves."""


def _solved(matrices: Array, rhs: Array) -> Array:
    """-A⁻¹ b for each of (k, n, n) and (k, n), nan if a row is 0; if a matrix is singular, all are
    regularised by rounding."""
    usable = (abs(matrices).max(axis=2) > 0.0).all(axis=1)
    matrices = np.where(usable[:, None, None], matrices, np.eye(matrices.shape[1]))
    try:
        found = np.linalg.solve(matrices, -rhs[:, :, None])[:, :, 0]
    except np.linalg.LinAlgError:
        turned = np.swapaxes(matrices, 1, 2)
        normal = turned @ matrices + 1e-12 * np.eye(matrices.shape[1])
        found = np.linalg.solve(normal, turned @ -rhs[:, :, None])[:, :, 0]
    return np.where(usable[:, None], found, np.nan)


def _least_norm(matrices: Array, rhs: Array) -> Array:
    """-A⁺ b for each of (k, m, n) and (k, m); singular values up to a share ``NULL`` of the largest
    are 0."""
    u, s, v = np.linalg.svd(matrices, full_matrices=False)
    inverse = np.where(s > NULL * s[:, :1], 1.0 / s, 0.0)
    parts: Any = inverse * np.einsum("kmi,km->ki", u, rhs)
    found: Array = -np.einsum("kin,ki->kn", v, np.where(inverse > 0.0, parts, 0.0))
    return found


class Iteration(NamedTuple):
    """``solved`` gives a step; the best of its ``lengths`` is taken, none of ``longest`` sizes of
    the unknowns or more. A step as short as ``arrived`` is the last one; there are at most
    ``most``."""

    solved: Callable[[Array, Array], Array]
    lengths: tuple[float, ...]
    longest: float
    arrived: float
    most: int


NEWTON = Iteration(_solved, (1.0, 0.3), 10.0, ARRIVED, 80)
GAUSS_NEWTON = Iteration(_least_norm, (1.0, 0.3, 0.05), 2.0, ON_LINE, 60)
"""Steps of least norm: they keep to the point of a curve that is nearest."""


def arrivals(
    residual: BatchFunction,
    jacobian: BatchFunction,
    starts: Array,
    scale: Array,
    by: Iteration = NEWTON,
    ranges: tuple[Array, Array] | None = None,
) -> Array:
    """The ends (m, n) of those ``starts`` (k, n) that reach a zero of F: Rⁿ → Rᵐ, in their order.

    ``residual`` maps (k, n) to (k, m), ``jacobian`` to (k, m, n), both nan outside their domain.
    ``scale`` (n,): typical sizes of the unknowns; ``ranges``: their lower and upper ends (n,),
    which iterates do not leave. The ends are neither polished nor made distinct.
    """
    with np.errstate(all="ignore"):
        f = residual(starts)
        place = np.flatnonzero(np.isfinite(f).all(axis=1))
        x, f = starts[place], f[place]
        best, idle = np.full(len(x), np.inf), np.zeros(len(x), dtype=int)
        arrived: list[tuple[int, Array]] = []
        for _ in range(by.most):
            expect_time()
            if not len(x):
                break
            weight = np.maximum(abs(x), scale)
            matrix = jacobian(x) * weight[:, None, :]
            rows = abs(matrix).sum(axis=2)
            rows = np.where(np.isfinite(rows) & (rows > 0.0), rows, np.inf)
            step = by.solved(np.nan_to_num(matrix / rows[:, :, None]), f / rows)
            length = abs(step).max(axis=1)
            step *= np.minimum(1.0, by.longest / np.maximum(length, 1e-300))[:, None]
            trials = np.stack(
                [_inside(x, x + share * (weight * step), ranges) for share in by.lengths]
            )
            values = residual(trials.reshape(-1, x.shape[1])).reshape(*trials.shape[:2], -1)
            norms = abs(values / rows).max(axis=2)
            norms = np.where(np.isfinite(norms), norms, np.inf)
            chosen, each = norms.argmin(axis=0), np.arange(len(x))
            x, f, norm = trials[chosen, each], values[chosen, each], norms[chosen, each]
            near, finite = length <= by.arrived, np.isfinite(norm)
            arrived += zip(place[near & finite].tolist(), x[near & finite], strict=True)
            gained = norm < 0.9 * best
            best, idle = np.where(gained, norm, best), np.where(gained, 0, idle + 1)
            going = ~near & finite & (idle < PATIENCE)
            x, f, place, best, idle = x[going], f[going], place[going], best[going], idle[going]
    ends = [end for _, end in sorted(arrived, key=lambda pair: pair[0])]
    return np.array(ends).reshape(len(ends), len(scale))


def _inside(x: Array, moved: Array, ranges: tuple[Array, Array] | None) -> Array:
    """Where a step beyond the end of a range stops: before it, as the end may not belong to it."""
    if ranges is None:
        return moved
    low, high = ranges
    moved = np.where((moved <= low) & (x > low), low + KEPT * (x - low), moved)
    return np.where((moved >= high) & (x < high), high - KEPT * (high - x), moved)


# --- where to start ---

Range = tuple[float, float]

DECADES = 3.0
"""An unbounded unknown is searched from 10⁻³ to 10³ times its size, on both sides."""


def spread(
    ranges: Sequence[Range], sizes: Sequence[float], count: int, offset: int = 0
) -> Iterator[list[float]]:
    """``count`` points that fill the ranges evenly, after the first ``offset``: the k-th at the
    shares k/φ^j, modulo 1, for j = 1 … n, with φ the positive root of φ^(n+1) = φ + 1."""
    n, phi = len(ranges), 2.0
    for _ in range(64):
        phi = (1.0 + phi) ** (1.0 / (n + 1))
    for k in range(offset + 1, offset + count + 1):
        yield [
            place((0.5 + k * phi**-j) % 1.0, *ends, size)
            for j, (ends, size) in enumerate(zip(ranges, sizes, strict=True), 1)
        ]


def place(share: float, low: float, high: float, size: float) -> float:
    """The point of a range at ``share`` in [0, 1): even over a finite range, else over some decades
    around ``size`` from its finite end, or on both sides of 0."""
    if math.isfinite(low) and math.isfinite(high):
        return low + share * (high - low)
    if math.isfinite(low):
        return low + _magnitude(share, size)
    if math.isfinite(high):
        return high - _magnitude(share, size)
    return _magnitude(2 * share - 1, size) if share >= 0.5 else -_magnitude(1 - 2 * share, size)


def _magnitude(share: float, size: float) -> float:
    """From 10⁻³ to 10³ times the size, most of them near it."""
    centred = 2.0 * share - 1.0
    return size * math.pow(10.0, DECADES * centred * abs(centred))
