"""Which methods were tried on a block, in order, and what each of them found."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum


class Method(Enum):
    """The ways to solve a simultaneous block: what each does, and its short name."""

    LINEAR = "elimination of linear equations", "elimination"
    POLYNOMIAL = "exact count of the roots of one polynomial in {tear}", "polynomial"
    FORMULA = "elimination to a formula", "formula"
    RANGE = "search of the whole range of {tear}", "range of {tear}"
    SUBSTITUTION = "substitution, and a search of the whole range of one unknown", "substitution"
    BOXES = "subdivision of the ranges", "boxes"
    SPARSE = "damped Newton with a sparse Jacobian", "sparse Newton"
    STARTS = "damped Newton from the guess and many starts", "damped Newton"
    CURVE = "search for a curve of answers", "curve"
    TRUST_REGION = "trust regions from the guess and many starts", "trust region"
    EXTENDED = "refined in extended precision", "extended precision"

    def __init__(self, told: str, short: str) -> None:
        self.told, self.short = told, short


@dataclass(frozen=True, slots=True)
class Attempt:
    """``found`` answers that were new. ``complete`` where it proved that there are no others.

    ``iterations`` are those of all starts together, 0 where the method counts none.
    """

    method: Method
    found: int
    complete: bool = False
    iterations: int = 0
