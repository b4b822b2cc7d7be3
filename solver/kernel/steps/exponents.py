"""``base^x = target`` for a base that has no logarithm: real powers of it take whole exponents only."""

from __future__ import annotations

import math
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Exponents:
    """``values`` are candidates, to be tried in the equation; ``anything``: every positive exponent does."""

    values: tuple[float, ...] = ()
    complete: bool = True
    anything: bool = False


def exponents(base: float, target: float) -> Exponents:
    """The exponents that may take ``base`` ≤ 0 to ``target``: 0 to any positive one is 0, 0 to 0 is 1."""
    if base == 0.0:
        return Exponents((0.0,) if target == 1.0 else (), anything=target == 0.0)
    if base == -1.0 and abs(target) == 1.0:
        return Exponents((0.0 if target > 0.0 else 1.0,), complete=False)
    if base == -1.0 or target == 0.0:
        return Exponents()
    return Exponents((float(round(math.log(abs(target)) / math.log(-base))),))
