"""The one place that decides whether an iteration has converged.

Two scale-free measures are used. The *backward error* of equation i at x is
|F_i| / Σ_j |J_ij x_j|: the relative change of the unknowns that would explain the residual. The
*scaled step* of unknown j is |dx_j| / w_j with the weight w_j = max(|x_j|, scale_j).
"""

from __future__ import annotations

from collections.abc import Sequence
from enum import Enum

from solver.numerics.tolerances import EPS, RESIDUAL, STAGNATION, VANISHING


class Outcome(Enum):
    """The end of a search. Only ``CONVERGED`` stands for an isolated answer correct to rounding."""

    CONVERGED = "The residual vanishes to rounding at an isolated point."
    NO_ROOT = "It is proven that the range holds no root."
    SINGULAR_JACOBIAN = (
        "The residual vanishes to rounding, but the Jacobian loses rank there: "
        "the answer is not isolated, or it is a multiple one."
    )
    STALLED = "No step makes the residual smaller, and it does not vanish."
    LIMIT = "The limit on iterations was reached before the residual vanished."
    DOMAIN = "The residual or its Jacobian is undefined at the start or at the point approached."

    def __str__(self) -> str:
        return self.value

    @property
    def found(self) -> bool:
        """Whether the residual vanishes to rounding at the point returned."""
        return self in (Outcome.CONVERGED, Outcome.SINGULAR_JACOBIAN)


def residual_vanishes(residual: Sequence[float], sizes: Sequence[float]) -> bool:
    """``sizes[i]`` is Σ_j |J_ij x_j|, so that the test reads: backward error at rounding level."""
    return all(abs(r) <= RESIDUAL * size for r, size in zip(residual, sizes, strict=True))


def residual_is_rounding(residual: Sequence[float], sizes: Sequence[float]) -> bool:
    """Nothing beside ``sizes[i]`` = Σ_j |J_ij| w_j: for roots where the rows themselves vanish with x."""
    return all(abs(r) <= VANISHING * size for r, size in zip(residual, sizes, strict=True))


def falls(residual: Sequence[float], before: Sequence[float]) -> bool:
    """Whether a full step led on towards a root: it leaves a quarter of the residual at a double one,
    (1 - 1/m)^m of it at one of multiplicity m, and all of it at a minimum."""
    return max(map(abs, residual), default=0.0) <= 0.5 * max(map(abs, before), default=0.0)


def step_vanishes(step: Sequence[float], x: Sequence[float]) -> bool:
    """Every component of the step is lost in the last bit of x."""
    return all(abs(d) <= EPS * abs(v) for d, v in zip(step, x, strict=True))


def step_is_rounding(step_norm: float) -> bool:
    """The scaled step says no more than the last bits: where an unknown is 0 beside its scale, neither
    its own last bit nor the size of its rows can tell."""
    return step_norm <= 4 * EPS


def stagnates(step_norm: float, previous_norm: float) -> bool:
    """Quadratic contraction has ended at a step so small that only rounding explains it."""
    return step_norm <= STAGNATION and step_norm > 0.25 * previous_norm


def explains(residual: Sequence[float], predicted: Sequence[float], sizes: Sequence[float]) -> bool:
    """Whether the step accounts for the residual: F + J dx is small beside F, or beside ``sizes[i]``
    = Σ_j |J_ij| w_j. (``predicted`` is J dx. Where rank is lost at a minimum of |F| it does not.)"""
    return all(
        abs(r + p) <= max(0.5 * abs(r), VANISHING * size)
        for r, p, size in zip(residual, predicted, sizes, strict=True)
    )


def weights(x: Sequence[float], scale: Sequence[float]) -> list[float]:
    """w_j = max(|x_j|, scale_j), the unit in which a change of unknown j is measured."""
    return [max(abs(v), s) for v, s in zip(x, scale, strict=True)]


def scaled_norm(step: Sequence[float], weight: Sequence[float]) -> float:
    """The largest |dx_j| / w_j."""
    return max((abs(d) / w for d, w in zip(step, weight, strict=True)), default=0.0)
