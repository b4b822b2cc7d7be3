"""What ranking needs of numbers, of whatever kind they are."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

LEAST = 1e-300
MOST = 1e300


class Arithmetic(NamedTuple):
    """``there``: the number, or another one for nan; ``decade``: its logarithm, within those of the ends."""

    there: Callable[[Any, float], Any]
    largest: Callable[[Sequence[Any]], Any]
    rounded: Callable[[Any], Any]
    decade: Callable[[Any], Any]


FLOATS = Arithmetic(
    lambda number, other: number if number == number else other,
    max,
    lambda number: round(number) if abs(number) < MOST else number,
    lambda number: math.log10(min(max(abs(number), LEAST), MOST)),
)
