"""Tolerances, each with its reason. All are shares: of a value, of a row's terms, of a largest number."""

from __future__ import annotations

import sys

EPS = sys.float_info.epsilon
"""ε, the distance from 1 to the next float, 2⁻⁵²."""

UNIT_ROUNDOFF = EPS / 2
"""How far rounding to the nearest float may move a number."""

SMALLEST_NORMAL = sys.float_info.min
"""Numbers below it, 2⁻¹⁰²², have fewer digits than others."""

# --- does a rule hold? ---

BACKWARD = 64 * EPS
"""A rule holds if values within so much of those reported satisfy it: they come from some 60 roundings."""

STEEP = 1e-6
"""The share of its sides that a rule may change by with its values, to be judged by its slopes: squared, as
what slopes leave out is, it is below BACKWARD."""

ROUNDINGS = 4
"""How many times the rounding of an evaluation may come out larger than to first order."""

# --- has an iteration converged? ---

CONVERGED = 64 * EPS
"""Length of a correction, relative to the unknowns, that is left of rounding in a rule of 64 operations."""

STAGNATION = 1e-7
"""Length of a correction, relative to the unknowns, at which an end of contraction is put down to rounding:
in exact numbers the next one would be its square, 1e-14. Rules of condition 1e8 are as noisy."""

ON_CURVE = 1e-12
"""Scaled length of the last correction to a curve: some thousand ε, the rounding of its equations."""

FAST = 0.1
"""Contraction factor below which full Newton steps are trusted. (A double root has 1/4 exactly.)"""

ESCAPED = 1e-3
"""Relative tolerance of the descent that leads away from where Newton's direction is of no use: any point
elsewhere will do."""

TIGHT = 1e-14
"""The relative tolerance asked of scipy: some tens of ε, which is the least that its methods accept."""

# --- are two ends one root? ---

SAME_ROOT = 1e-9
"""Relative difference of two ends of Newton's method that are one root, ill-conditioned up to some 1e6 ε."""

SAME_SINGULAR_ROOT = 1e-4
"""The same at a multiple root: a threefold one is known to the cube root of ε, 6e-6, times its condition."""

# --- is a matrix singular? ---

INDEPENDENT = 1e-11
"""Share of the largest pivot (rows and columns equilibrated) below which a row adds nothing: 5e4 ε, for
slopes come with the rounding of whole paths."""

FLAT_TANGENT = 1e-11
"""Smallest singular value, over the largest, of a Jacobian whose null space is still a line; as above."""

MOVES = 1e-8
"""Share of a null vector above which an unknown takes part in it: the root of ε, to which a null vector of a
pair of close singular values is known."""

TURNING = 1e-9
"""Part of a unit tangent along the parameter at which a start counts as a turning point."""

CONSISTENT = 1e-11
"""What rows of a singular linear system may miss beside their terms, and yet not contradict one another."""
