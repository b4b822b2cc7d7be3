"""Newton's method for large sparse systems, damped by the natural monotonicity test.

P. Deuflhard, *Newton Methods for Nonlinear Problems* (2004), section 3.3: a step is accepted if the
correction by the same Jacobian at its end is shorter. The test does not depend on the scaling of
rules. Steps out of the domain, where the residual is nan, are shortened.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from solver.numerics.linear_algebra import PANEL, Array, Map, SparseFactor, Triplets
from solver.numerics.newton import stagnates
from solver.numerics.tolerances import (
    CONVERGED,
    DAMPING,
    EPS,
    FAST,
    LEAST,
    REFINABLE,
    ROUNDINGS,
    STAGNATION,
)

ITERATIONS = 100
SHORTEST, SHORTEST_POSITIVE = 2.0**-12, 2.0**-6
"""The least share of a step that is tried; where unknowns are kept positive, one that is held back
by 0 stays so."""
LONGER = 4.0
"""The first share of a step that is tried, beside that of the step before."""
POSITIVE_DEFINITE: dict[str, Any] = {
    "permc_spec": "MMD_AT_PLUS_A",
    "diag_pivot_thresh": 0.0,
    "panel_size": PANEL,
    "options": {"SymmetricMode": True},
}
"""How SuperLU factors such a matrix: without a search for pivots, in an order for its own pattern,
not that of its square."""
REFINEMENTS = 3
BACKWARDS = 0.9
"""The largest share of a positive unknown that one step may take, where they are kept positive."""


class SparseRoot(NamedTuple):
    """The end of the method, and whether its last correction was at most rounding.

    ``alone``: the length of a full step, relative to the unknowns, from which on each was much
    shorter than the one before. At a root close to another one, or at a multiple root, they are
    not.
    """

    x: Array
    converged: bool
    alone: float = 0.0


def itself(x: Array) -> Array:
    """The identity."""
    return x


@np.errstate(all="ignore")
def sparse_newton(
    residual: Map,
    jacobian: Callable[[Array], Triplets],
    start: Array,
    sizes: Array | None = None,
    positive: bool = False,
    explicit: Map = itself,
    limit: float | None = None,
) -> SparseRoot:
    """Search a root of F: Rⁿ → Rⁿ from ``start`` (n,) with typical magnitudes ``sizes`` (n,).

    Without sizes the first step, to where the linearised equations hold, gives them. ``positive``:
    unknowns that are positive stay so. ``explicit`` (n,) → (n,) replaces unknowns that equations
    give explicitly: Newton's method on the reduced system. With a ``limit`` the step of each
    unknown is cut to that share of its size, and corrections need not become shorter.
    """
    x = explicit(start)
    f = residual(x)
    if not np.isfinite(f).all():
        return SparseRoot(x, False)
    share, before, last, alone = 1.0, math.inf, 0.0, 0.0
    for count in range(ITERATIONS):
        slopes = jacobian(x)
        try:
            factor = SparseFactor(slopes, len(x))
        except ArithmeticError:
            return SparseRoot(x, False)
        step = -factor.solve(f)
        if sizes is None:
            sizes = np.maximum(np.abs(step), LEAST * (float(np.abs(step).max()) or 1.0))
        weight = np.maximum(np.abs(x), sizes)
        length = _length(step, weight)
        if not np.isfinite(length):
            return SparseRoot(x, False)
        if before > STAGNATION:
            alone = (
                max(alone, before) if last == 1.0 and length <= FAST * before < math.inf else 0.0
            )
        first = share if limit is None else 1.0
        found = _shortened(residual, factor, x, step, weight, positive, first, explicit, limit)
        if count == 0 and not positive and limit is None and (found is None or found[2] < 1.0):
            found = _twice(residual, jacobian, x + step, weight, length) or found
        if found is not None:
            x, f, share = found
        if found is None or length <= CONVERGED or stagnates(length, before) or not f.any():
            converged = found is not None or length <= STAGNATION
            converged = converged or length <= ROUNDINGS * _length(
                _noise(factor, slopes, x), weight
            )
            end = _refined(residual, factor, x, weight) if converged else x
            return SparseRoot(end, converged, alone)
        share, before, last = min(LONGER * share, 1.0), length, share
    return SparseRoot(x, False)


def _twice(
    residual: Map, jacobian: Callable[[Array], Triplets], x: Array, weight: Array, length: float
) -> tuple[Array, Array, float] | None:
    """The point after a second full step from ``x``, if the correction there is shorter than the
    first one: a second step may repair what one worsens, as with bars that turn (the watchdog of R.
    M. Chamberlain et al., Math. Programming Study 16 (1982) 1-17)."""
    f = residual(x)
    if not np.isfinite(f).all():
        return None
    try:
        factor = SparseFactor(jacobian(x), len(x))
    except ArithmeticError:
        return None
    x = x - factor.solve(f)
    f = residual(x)
    shorter = np.isfinite(f).all() and _length(factor.solve(f), weight) <= length / 2.0
    return (x, f, 1.0) if shorter else None


def _noise(factor: SparseFactor, slopes: Triplets, x: Array) -> Array:
    """The step (n,) that rounding of the terms of the rules alone may cause."""
    data, rows, columns = slopes
    gross = np.bincount(rows, np.abs(data * x[columns]), minlength=len(x))
    return factor.solve(EPS * np.random.default_rng(0).choice([-1.0, 1.0], len(x)) * gross)


def _refined(residual: Map, factor: SparseFactor, x: Array, weight: Array) -> Array:
    """The last digits by residuals in extended precision (N. J. Higham, *Accuracy and Stability of
    Numerical Algorithms*, 2002, section 25.2), as long as that contracts fast; the point unchanged
    if a function has none."""
    before = REFINABLE
    for _ in range(REFINEMENTS):
        try:
            step = factor.solve(np.asarray(residual(x.astype(np.longdouble)), dtype=float))
        except TypeError:
            return x
        length = _length(step, weight)
        if not length <= FAST * before:
            return x
        x, before = x - step, length
    return x


def _shortened(
    residual: Map,
    factor: SparseFactor,
    x: Array,
    step: Array,
    weight: Array,
    positive: bool,
    share: float,
    explicit: Map,
    limit: float | None,
) -> tuple[Array, Array, float] | None:
    """The point after the longest share of the step, by halves from ``share``, that shortens the
    correction; its residual, and the share.

    With a ``limit`` the step need only stay in the domain, each unknown cut to its part of it, as
    circuit simulators limit voltages (L. W. Nagel, *SPICE2*, 1975): an unknown that is led far off
    does not hold back the others.
    """
    length, longest = _length(step, weight), np.inf if limit is None else limit * weight
    while share >= (SHORTEST_POSITIVE if positive else SHORTEST):
        moved = x + np.clip(share * step, -longest, longest)
        ahead = explicit(
            np.where((x > 0.0) & positive, np.maximum(moved, (1.0 - BACKWARDS) * x), moved)
        )
        there = residual(ahead)
        if np.isfinite(there).all():
            left = _length(factor.solve(there), weight) if limit is None else 0.0
            if left <= (1.0 - share / 2.0) * length or left <= CONVERGED:
                return ahead, there, share
        share /= 2.0
    return None


def _length(step: Array, weight: Array) -> float:
    sizes = np.abs(step / weight)
    largest = float(np.max(sizes, initial=0.0))
    return (
        largest * float(np.sqrt(np.mean((sizes / largest) ** 2)))
        if 0.0 < largest < math.inf
        else largest
    )


def sparse_least_squares(entries: Triplets, shape: tuple[int, int], rhs: Array) -> Array:
    """The x (n,) for which |A x - b| is least, and |x| nearly so: the normal equations of
    Tikhonov."""
    import scipy.sparse.linalg

    data, rows, columns = entries
    matrix = scipy.sparse.csr_array((data, (rows, columns)), shape=shape)
    normal = (matrix.T @ matrix + DAMPING * scipy.sparse.eye_array(shape[1])).tocsc()
    factor = scipy.sparse.linalg.splu(normal, **POSITIVE_DEFINITE)
    return np.asarray(factor.solve(matrix.T @ rhs))
