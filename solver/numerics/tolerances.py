"""Tolerances, each with its reason.

Most are shares: of a value, of a row's terms, of a largest number.
"""

from __future__ import annotations

import sys
from fractions import Fraction

EPS = sys.float_info.epsilon
"""ε, the distance from 1 to the next float, 2⁻⁵²."""

UNIT_ROUNDOFF = EPS / 2
"""How far rounding to the nearest float may move a number."""

SMALLEST_NORMAL = sys.float_info.min
"""Numbers below it, 2⁻¹⁰²², have fewer digits than others."""

# --- does a rule hold? ---

BACKWARD = 64 * EPS
"""A rule holds if values within so much of those reported satisfy it: they come from some 60
roundings."""

STEEP = 1e-6
"""The share of its sides that a rule may change by with its values, to be judged by its slopes:
squared, as what slopes leave out is, it is below BACKWARD."""

ROUNDINGS = 4
"""How many times the rounding of an evaluation may come out larger than to first order."""

HIDDEN = 2.0**-6
"""Share of what a rule admits that its rounding may be, for steps by residuals to count."""

ASTRAY = 1e-6
"""The share of its terms by which a rule is missed at a candidate that is none, such as a zero of a
squared rule: far more than what the rounding of a closed form leaves."""

# --- has an iteration converged? ---

CONVERGED = 64 * EPS
"""Length of a correction, relative to the unknowns, that is left of rounding in a rule of 64
operations."""

RESIDUAL = 4 * EPS
"""Relative change of the unknowns that explains a residual, taken as rounding."""

VANISHING = 1e-13
"""Residual over the size of its row that counts as nothing: some hundreds of ε."""

DEGENERATE = 1e-5
"""Scaled step left over at a multiple root: a double root is known to the root of ε, a threefold
one to its cube root, 6e-6."""

ARRIVED = 1e-9
"""Scaled step after which a start on arrays has arrived; its end is polished later."""

ON_LINE = 1e-11
"""The same onto a curve of answers, which nothing polishes."""

REFINABLE = 1e-5
"""Length of a correction, relative to the unknowns, of which the first refinement is a small
part."""

STAGNATION = 1e-7
"""Length of a correction, relative to the unknowns, at which an end of contraction is put down to
rounding: in exact numbers the next one would be its square, 1e-14. Rules of condition 1e8 are as
noisy."""

ON_CURVE = 1e-12
"""Scaled length of the last correction to a curve: some thousand ε, the rounding of its
equations."""

FAST = 0.1
"""Contraction factor below which full Newton steps are trusted. (A double root has 1/4 exactly.)"""

ESCAPED = 1e-3
"""Relative tolerance of the descent that leads away from where Newton's direction is of no use: any
point elsewhere will do."""

TIGHT = 1e-14
"""The relative tolerance asked of scipy: some tens of ε, which is the least that its methods
accept."""

NARROW = 1e-12
"""Width of a box, relative to its place, below which it is not cut: some thousand ε."""

HOME = 1e-7
"""Scaled distance from its start at which a curve is closed: the root of the rounding of its
points."""

LEAST = 1e-9
"""Size of an unknown that a first step leaves alone, beside the largest."""

# --- is a matrix singular? ---

ON_RULES = 1e-12
"""Largest residual, relative to the slopes of a rule, of a point on which rules are to hold."""

REPEATED = 1e-7
"""Share of its size below which the slopes of a rule there follow from those of other rules."""

INDEPENDENT = 1e-11
"""Share of the largest pivot (rows and columns equilibrated) below which a row adds nothing: 5e4 ε,
for slopes come with the rounding of whole paths."""

FLAT_TANGENT = 1e-11
"""Smallest singular value, over the largest, of a Jacobian whose null space is still a line; as
above."""

EXAMINED = 1e-9
"""Share of the largest singular value below which one is examined, rows and columns scaled."""

REGULAR = 1e-5
"""Share of the largest singular value that all reach if a matrix has lost no rank: well above
FREE."""

STILL = 1e-9
"""Share of the largest move along a null direction of a linear block below which an unknown, or a
rule, has no part in it."""

NULL_ENTRY = 1e-10
"""The same of an entry of a null vector of unit length, by singular values of scaled rows."""

NULL = 1e-8
"""Share of the largest singular value up to which others count as 0, on the way to a curve of
answers."""

DAMPING = 1e-6
"""Added to the diagonal of normal equations, whose rows are of size 1, if they leave some free."""

MEETING = 1e-5
"""Smallest singular value this near to a point where branches meet, rows having the unit size that
they reach along the curve."""

MOVES = 1e-8
"""Share of a null vector above which an unknown, or a rule, takes part in it: the root of ε, to
which a null vector of a pair of close singular values is known."""

TURNING = 1e-9
"""Part of a unit tangent along the parameter at which a start counts as a turning point."""

CONSISTENT = 1e-11
"""Residual of rows of a singular linear system, relative to their terms, that is no
contradiction."""

# --- how far may rounding go? ---

CANCELLED = 1e-12
"""Share of the terms of a difference that may be no more than their rounding: some thousand ε."""

DELICATE = 1e-6
"""Distance of a target beyond the end of an image, relative to its terms, that lost digits explain:
the root of CANCELLED."""

HALF = 2.0**-26
"""Relative error of a number of which half the digits are known, √ε: those of a double root."""

SAFETY = 4.0
"""How many times too short error bars may be: they are estimates, by sixteen samples."""

VAGUE = 1e-13
"""Relative error from which on an answer is solved again in more digits: some hundreds of ε."""

LOST = 1e-9
"""Relative error of a value from which on a contradiction further on may come of it."""

MEANINGLESS = 1e6
"""Error over size of a number that rounding alone has made: a multiple root of floats is not that
vague."""

NO_DIGIT = 0.5
"""Relative error of a number of which no digit is known: it may well be 0."""

ORDINARY = 1e8
"""Condition up to which the backward error of an answer says enough: half the digits are left."""

FAINTEST = 1e-200
"""The move of a rule with its values below which products of slopes may underflow."""

CLEAR = 1e-9
"""Share of its terms that a number must exceed for its sign to be taken as known, whatever rounding
did to the inputs: such a miss is a contradiction, such a discriminant has a sign."""

UNCANCELLED = 1e-13
"""The same, relative to the terms before anything cancelled: hundreds of ε."""

NEARLY = 1e-9
"""Share of its terms that an equation misses by at a point worth a closer look."""

BESIDE_HOLE, ROUGHLY = 1e-7, 1e-3
"""Relative distance from a point where rules are 0/0 at which floats still keep half of their
digits; and the share of its terms that an equation may miss by there, for its limit to be looked
at."""

# --- are two numbers, two answers, two roots one? ---

ROUNDED = 8 * EPS
"""Relative difference of two numbers that are the same but for a few roundings."""

NEIGHBOURS = 2 * EPS
"""Relative difference of two floats next to the same number."""

SAME_VALUE = 1e-9
"""Relative difference of a number computed in two ways: well above the rounding of either, if its
condition is below some 1e6."""

SAME_TURN = 1e-12
"""Share of a turn that rounding may miss the beginning of a turn by: some thousand ε."""

LOST_TURN = 1e-3
"""Share of a turn that the rounding of the number it is added to must stay below, for turns to
differ."""

SMALL = 1e-3
"""Share of its typical size by which an unknown is measured that is smaller: it may be 0."""

SAME_END = 1e-6
"""Relative difference of two ends of starts on arrays that are one: ARRIVED, for condition up to
1e3."""

SAME_ANSWER = 1e-11
"""Relative difference of answers that may be one, if their error bars say so."""

COVERED = 1e-12
"""Relative difference of well-conditioned numbers that are one: some thousand ε."""

MULTIPLE = 1e-4
"""An answer that rounding leaves open by more than this, relative to its size, is a multiple
root."""

PLATEAU = 1e-7
"""Relative width of a group of roots that counts as a stretch on which a rule with jumps is
constant: much wider than ε, and narrower than prices to the cent."""

SIMPLE = 1e-10
"""The same, below which it is a simple root, even if Newton's method stalled in the rounding of a
rule."""

BLUR = 3e-3
"""How far rounding spreads a multiple root, relative to its size: ε to the sixth root, for
multiplicity 6."""

VANISHED = 1e-150
"""A number this small relative to its typical size is 0, if the rules hold at 0: its square
underflows."""


# --- numbers of many digits ---

PRECISIONS = 50, 100, 200, 340, 400
"""Decimal digits, by turns: so many more that two that agree are not both rounding. The last two
show the least of floats, 2e-308, beside 1."""

MAX_UNKNOWNS = 60
"""Unknowns of a block up to which it is solved in so many digits."""

SPARE = 8
"""Decimal digits of a working precision that rounding may take."""

COMMON = 1e-6
"""Relative difference of two precisions that have some digits in common."""

AGREEMENT = 1e-18
"""Relative difference of two precisions that no float can show."""

REFINED = 1e-20
"""Share of its size by which the last step of a refinement moves an unknown: no float shows it."""

SETTLED = 1e-30
"""Relative length of the last step of Newton's method in 60 digits: half of them."""

NOTHING = 1e-40
"""Residuals of this size, for numbers of size 1, are rounding errors of 60 digits."""

CLOSE = 1e-5
"""Relative distance of a root from another whose fold it shares."""

DRIFT = 1e-2
"""How far a root may lie from the float answer that it is taken for, relative to its size."""

FOLD = 1e-2
"""How far from the start a fold may lie, relative to the size of the unknowns."""

SUSPECT = 1e-3
"""Least singular value of the Jacobian, beside the terms of the equations, of a root with a
sibling: the root of CLOSE, as a fold is a parabola."""

# --- polynomials with exact coefficients ---

TOUCHING = Fraction(1, 10**9)
"""An extremum this near to 0, relative to its terms, may be a double root split by rounding of
inputs; a coefficient may be nothing but this rounding."""

POLISHED = 1e-2
"""Relative distance of an answer from the point that was refined to it."""

# --- a curve of answers ---

FREE = 1e-7
"""Share of the largest singular value of the scaled Jacobian up to which a direction is left
free."""

MOVED = 1e-9
"""Share of its size by which an unknown moves that is free."""

BESIDE = 0.25
"""The largest share of a divisor that the error bars of its variables may have."""

BESIDE_ROOT = 1e-4
"""How far from an answer its rules are tried, as a share of it: no special point, and far enough
for what changes to first order to stand out from rounding and from second order."""

CORNER, STEEPER = 1e-2, 3.0
"""The share of the distance from an answer by which a rule changes that does so to first order; and
how many times as much it then changes less than at twice the distance."""
