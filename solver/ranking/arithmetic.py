"""What ranking needs of numbers, for single ones and for arrays of them."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import reduce
from typing import Any, NamedTuple

import numpy as np

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

ARRAYS = Arithmetic(
    lambda column, other: np.where(np.isnan(column), other, column),
    lambda columns: reduce(np.maximum, columns),
    np.rint,
    lambda column: np.log10(np.clip(np.abs(column), LEAST, MOST)),
)
