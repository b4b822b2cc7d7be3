"""Floats as their shortest decimals, a whole array at once.

The text of a float is the shortest decimal that reads back as the same float, and of several the nearest, as
``repr`` writes it (Steele & White, "How to print floating-point numbers accurately", 1990), without
a trailing ``.0``. Between 1e-4 and 1e16, where decimals have no exponent, it takes no search:

* ``D = x·10^k`` with 17 digits before the point is known exactly: 10^k is a float for k ≤ 22, and
  the error of the product is a float, too (Dekker 1971);
* decimals read back as x if they lie within half the gap between x and its neighbours, which is 0.5 to
  12 units of D. Of the decimals of 15 digits (100 units apart) at most one does, of those of 16 the
  nearest does if any, and of 17 digits the nearest always;
* if one of 15 digits does, the shortest is that one without its trailing zeros.

Every other float (and where rounding leaves a doubt which decimal lies within) is left to ``repr``.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from solver.files.columns import Array

WIDTH = 40
"""Bytes of a cell: the longest text has 24, and 17 digits are laid behind any point at once."""

_LEAST, _MOST = -4, 15
"""Powers of ten between which a decimal has no exponent."""
_POWERS = np.array([float(f"1e{n}") for n in range(_LEAST, _MOST + 2)])
_SCALES = np.array([float(f"1e{16 - n}") for n in range(_LEAST, _MOST + 1)])
_SPLIT = 134217729.0
_EXPONENT = np.int64(0x7FF0000000000000)
_DOUBT = 1e-9

_FOUR = np.array([f"{n:04}".encode() for n in range(10_000)]).view(np.uint32)
_ZEROS = np.array([4 - len(f"{n:04}".rstrip("0")) for n in range(10_000)], dtype=np.int8)
"""Four digits at once: their characters, and how many zeros they end with."""

_BLANK = np.frombuffer(b"0" * WIDTH, dtype=f"V{WIDTH}")[0]
_MINUS, _POINT, _ZERO = np.frombuffer(b"-.0", dtype=np.uint8)


def decimals(numbers: Array, cells: NDArray[np.uint8], starts: Array) -> NDArray[np.intp]:
    """Write the texts of floats (n,) into a buffer, each into WIDTH bytes from its start.

    Returns their lengths (n,). What follows a text in its cell means nothing. NaN is the empty text.
    """
    with np.errstate(invalid="ignore"):  # there are NaN that signal
        numbers = numbers + 0.0
    size = np.abs(numbers)
    plain = (size >= _POWERS[0]) & (size < _POWERS[-1])
    power, digits, doubt = _shortest(np.where(plain, size, 1.0))
    lengths = _laid_out(power + _LEAST + 1, digits, numbers < 0, cells, starts)
    for place in np.flatnonzero(~plain | doubt):
        text = _spelled(float(numbers[place]))
        cells[starts[place] : starts[place] + len(text)] = np.frombuffer(text, dtype=np.uint8)
        lengths[place] = len(text)
    return lengths


def _spelled(number: float) -> bytes:
    return b"" if number != number else repr(number).removesuffix(".0").encode()


def _shortest(size: Array) -> tuple[Array, Array, Array]:
    """The power of the first digit (from ``_LEAST``), 17 digits as an integer, and where there is doubt."""
    power = np.searchsorted(_POWERS, size, side="right") - 1
    scale = _SCALES[power]
    product = size * scale
    error = _product_error(size, scale, product)
    rounded = np.rint(error)
    whole = product.astype(np.int64) + rounded.astype(np.int64)
    rest = error - rounded
    bits = size.view(np.int64)
    reach = (bits & _EXPONENT).view(np.float64) * scale * 2.0**-53

    tenths, hundredths = whole // 10, whole // 100
    by_ten = (whole - 10 * tenths) + rest
    by_hundred = (whole - 100 * hundredths) + rest
    from_ten = np.minimum(by_ten, 10.0 - by_ten)
    from_hundred = np.minimum(by_hundred, 100.0 - by_hundred)
    sixteen, fifteen = from_ten < reach, from_hundred < reach
    digits = np.where(
        fifteen,
        (hundredths + (by_hundred > 50.0)) * 100,
        np.where(sixteen, (tenths + (by_ten > 5.0)) * 10, whole),
    )
    doubt = np.abs(from_hundred - reach) < _DOUBT
    doubt |= ~fifteen & (np.abs(from_ten - reach) < _DOUBT)
    doubt |= ~fifteen & sixteen & (np.abs(by_ten - 5.0) < _DOUBT)
    doubt |= ~sixteen & (np.abs(np.abs(rest) - 0.5) < _DOUBT)
    doubt |= (bits & ~_EXPONENT == 0) & (from_hundred != 0)  # a power of two is nearer to its lower neighbour
    doubt |= (digits < 10**16) | (digits >= 10**17)
    return power, np.where(doubt, 10**16, digits), doubt


def _product_error(one: Array, other: Array, product: Array) -> Array:
    """What rounding took from a product (Dekker 1971, "A floating-point technique")."""
    stretched = _SPLIT * one
    one_high = stretched - (stretched - one)
    one_low = one - one_high
    stretched = _SPLIT * other
    other_high = stretched - (stretched - other)
    other_low = other - other_high
    error: Array = one_low * other_low - (
        ((product - one_high * other_high) - one_low * other_high) - one_high * other_low
    )
    return error


def _laid_out(
    before: Array, digits: Array, negative: Array, cells: NDArray[np.uint8], starts: Array
) -> NDArray[np.intp]:
    """Write sign, digits and point, the point after ``before`` digits; return the lengths.

    Digits are laid twice, up to the point and behind it. Where the number is below 1, zeros come first.
    """
    characters, used = _characters(digits)
    whole = before > 0
    first = starts + negative
    behind = np.where(whole, first + before + 1, first + 2 - before)
    windows(cells, WIDTH)[starts] = _BLANK
    cells[starts] = np.where(negative, _MINUS, _ZERO)
    seventeen = windows(cells, 17)
    source = windows(characters.ravel(), 17)
    rows = np.arange(len(digits)) * characters.shape[1] + 3
    seventeen[np.where(whole, first, behind)] = source[rows]
    seventeen[behind] = source[rows + np.maximum(before, 0)]
    cells[first + np.maximum(before, 1)] = _POINT
    lengths: NDArray[np.intp] = (
        np.where(whole, np.where(used > before, used + 1, before), used + 2 - before) + negative
    )
    return lengths


def windows(buffer: NDArray[np.uint8], width: int) -> NDArray[np.void]:
    """Every stretch of ``width`` bytes of a buffer as one element, to be read and written at once."""
    count = len(buffer) - width + 1
    return np.ndarray((count,), dtype=f"V{width}", buffer=buffer, strides=(1,))


def _characters(digits: Array) -> tuple[Array, Array]:
    """The 17 digits as characters (n, 40), from the fourth on, and how many of them no zeros trail."""
    upper = digits // 10**8
    first, upper = np.divmod(upper.astype(np.uint32), np.uint32(10**8))
    lower = (digits % 10**8).astype(np.uint32)
    groups = (first, *np.divmod(upper, np.uint32(10**4)), *np.divmod(lower, np.uint32(10**4)))
    characters = np.empty((len(digits), 10), dtype=np.uint32)
    for place, group in enumerate(groups):
        characters[:, place] = _FOUR[group]
    zeros = _ZEROS[groups[4]]
    for place in (3, 2, 1):
        more = np.flatnonzero(zeros == 16 - 4 * place)
        zeros[more] += _ZEROS[groups[place][more]]
    return characters.view(np.uint8), 17 - zeros.astype(np.intp)
