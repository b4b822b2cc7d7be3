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

ASTRAY = 1e-6
"""The share of its terms by which a rule is missed at a candidate that is none, such as a zero of a squared
rule: far more than what the rounding of a closed form leaves."""

# --- has an iteration converged? ---

CONVERGED = 64 * EPS
"""Length of a correction, relative to the unknowns, that is left of rounding in a rule of 64 operations."""

RESIDUAL = 4 * EPS
"""Relative change of the unknowns that explains a residual, taken as rounding."""

VANISHING = 1e-13
"""Residual over the size of its row that counts as nothing: some hundreds of ε."""

DEGENERATE = 1e-5
"""Scaled step left over at a multiple root: a double root is known to the root of ε, a threefold one to its
cube root, 6e-6."""

ARRIVED = 1e-9
"""Scaled step after which a start on arrays has arrived; its end is polished later."""

ON_LINE = 1e-11
"""The same onto a curve of answers, which nothing polishes."""

REFINABLE = 1e-5
"""Length of a correction, relative to the unknowns, of which the first refinement is a small part."""

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

NARROW = 1e-12
"""Width of a box, relative to its place, below which it is not cut: some thousand ε."""

EVEN = 1e3
"""Largest ratio of slopes across a box from whose ends an interval Newton step is worth taking."""

HOME = 1e-7
"""Scaled distance from its start at which a curve is closed: the root of the rounding of its points."""

LEAST = 1e-9
"""Size of an unknown that a first step leaves alone, beside the largest."""

# --- is a matrix singular? ---

INDEPENDENT = 1e-11
"""Share of the largest pivot (rows and columns equilibrated) below which a row adds nothing: 5e4 ε, for
slopes come with the rounding of whole paths."""

FLAT_TANGENT = 1e-11
"""Smallest singular value, over the largest, of a Jacobian whose null space is still a line; as above."""

NULL = 1e-8
"""Share of the largest singular value up to which others count as 0, on the way to a curve of answers."""

DAMPING = 1e-6
"""What is added to the diagonal of normal equations, whose rows are of size 1, where they leave some free."""

MEETING = 1e-5
"""Smallest singular value this near to a point where branches meet, rows having the unit size that they reach
along the curve."""

MOVES = 1e-8
"""Share of a null vector above which an unknown takes part in it: the root of ε, to which a null vector of a
pair of close singular values is known."""

TURNING = 1e-9
"""Part of a unit tangent along the parameter at which a start counts as a turning point."""

CONSISTENT = 1e-11
"""What rows of a singular linear system may miss beside their terms, and yet not contradict one another."""
