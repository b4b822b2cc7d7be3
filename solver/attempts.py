"""Which methods were tried on a block, in order, and what each of them found."""

from __future__ import annotations

from enum import Enum

from rulesheets.record import dataclass


class Method(Enum):
    """The ways to solve a simultaneous block, in the order in which they are tried."""

    LINEAR = "elimination of linear equations"
    POLYNOMIAL = "exact count of the roots of one polynomial in {tear}"
    FORMULA = "elimination to a formula"
    RANGE = "search of the whole range of {tear}"
    BOXES = "subdivision of the ranges"
    STARTS = "damped Newton from the guess and many starts"
    FULL = "Newton at full length from the guess"
    HOMOTOPY = "homotopy from the guess"
    FULL_STARTS = "Newton at full length from many starts"
    EXTENDED = "refined in extended precision"
    HOMOTOPY_STARTS = "homotopy from many starts"


@dataclass(frozen=True, slots=True)
class Attempt:
    """``found`` answers that were new. ``complete`` where it proved that there are no others.

    ``iterations`` are those of all starts together, 0 where the method counts none.
    """

    method: Method
    found: int
    complete: bool = False
    iterations: int = 0
