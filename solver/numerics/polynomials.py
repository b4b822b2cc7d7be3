"""Real roots of polynomials with rational coefficients, exactly, by Sturm's theorem.

Lists of coefficients begin with the lowest degree. The number of sign changes in Sturm's sequence at a, less
that at b, is the number of roots in (a, b] (S. Basu, R. Pollack, M.-F. Roy, *Algorithms in Real Algebraic
Geometry*, section 2.2).
"""

from __future__ import annotations

import math
import struct
from collections.abc import Iterator, Sequence
from fractions import Fraction
from itertools import pairwise
from typing import TypeAlias

import numpy as np

from rulesheets.deadline import expect_time

Coefficients: TypeAlias = Sequence[Fraction]
LARGEST = 0x7FEF_FFFF_FFFF_FFFF
"""The place of the largest float."""


def simple_part(polynomial: Coefficients) -> list[Fraction]:
    """The polynomial with the same roots, each of them once: p over the common divisor of p and p'."""
    whole = _integers(polynomial)
    return list(map(Fraction, _quotient(whole, _sequence(whole)[-1]) if len(whole) > 1 else whole))


def real_roots(
    polynomial: Coefficients, low: float = -math.inf, high: float = math.inf
) -> tuple[float, ...] | None:
    """The real roots in [low, high], ascending, each the float nearest to where the polynomial changes sign.

    None where there is no such list: the polynomial is 0, or it has a multiple root (real or not), or a root
    beyond the floats or nearer to another one than floats can tell.
    """
    sequence = _sequence(_integers(polynomial))
    if len(sequence[-1]) != 1:
        return None
    least, most = (max(-LARGEST, min(LARGEST, _place(end))) for end in (low, high))
    ends = (-math.inf if low == -math.inf else least), (math.inf if high == math.inf else most)
    count = _changes(sequence, ends[0]) - _changes(sequence, ends[1])
    within = list(_isolated(sequence, least, most))
    guesses = _guesses(polynomial) if within else []
    found = [_nearest(sequence[0], *places, guesses) for places in within]
    if len(found) < count or len(set(found)) < len(found):
        return None
    at_the_end = not _sign(sequence[0], least) and [_float(least)]
    return (*(at_the_end or ()), *found)


def _sequence(whole: list[int]) -> list[list[int]]:
    """Sturm's sequence; its last member is the greatest common divisor of the polynomial and its slope."""
    found = [whole, _integers([Fraction(k * c) for k, c in enumerate(whole)][1:])]
    while found[-1]:
        expect_time()
        found.append([-c for c in _remainder(found[-2], found[-1])])
    return found[:-1] or [[]]


def _integers(polynomial: Coefficients) -> list[int]:
    """The polynomial times a positive number: integers without a common divisor, the last of them not 0."""
    common = math.lcm(*(c.denominator for c in polynomial))
    whole = [c.numerator * (common // c.denominator) for c in polynomial]
    while whole and not whole[-1]:
        whole.pop()
    divisor = math.gcd(*whole)
    return [c // divisor for c in whole]


def _remainder(dividend: list[int], divisor: list[int]) -> list[int]:
    """A positive multiple of the remainder."""
    rest, lead = list(dividend), abs(divisor[-1])
    while len(rest) >= len(divisor):
        factor, shift = rest[-1] * (1 if divisor[-1] > 0 else -1), len(rest) - len(divisor)
        rest = [c * lead for c in rest]
        for k, c in enumerate(divisor):
            rest[shift + k] -= factor * c
        rest.pop()
    return _integers([Fraction(c) for c in rest])


def _quotient(dividend: list[int], divisor: list[int]) -> list[int]:
    """Without its remainder, times a number."""
    rest, found = [Fraction(c) for c in dividend], list[Fraction]()
    while len(rest) >= len(divisor):
        factor, shift = rest[-1] / divisor[-1], len(rest) - len(divisor)
        for k, c in enumerate(divisor):
            rest[shift + k] -= factor * c
        rest.pop()
        found.append(factor)
    return _integers(found[::-1])


def _sign(whole: list[int], place: float) -> int:
    """The sign at a float, given by its place, or at an infinity."""
    if not math.isfinite(place):
        value = whole[-1] * (1 if place > 0 or len(whole) % 2 else -1)
    else:
        above, below = _float(int(place)).as_integer_ratio()
        value, scale = whole[-1], 1
        for c in reversed(whole[:-1]):
            scale *= below
            value = value * above + c * scale
    return (value > 0) - (value < 0)


def _changes(sequence: list[list[int]], place: float) -> int:
    signs = [sign for sign in (_sign(whole, place) for whole in sequence) if sign]
    return sum(a != b for a, b in pairwise(signs))


def _isolated(sequence: list[list[int]], first: int, last: int) -> Iterator[tuple[int, int]]:
    """Places of floats that have a single root between them, or at the second; ascending."""
    waiting = [(first, last, _changes(sequence, first), _changes(sequence, last))]
    while waiting:
        expect_time()
        first, last, before, after = waiting.pop()
        if before - after == 1:
            yield first, last
        elif before > after and last - first > 1:
            middle = (first + last) // 2
            between = _changes(sequence, middle)
            waiting += [(middle, last, between, after), (first, middle, before, between)]


def _nearest(whole: list[int], first: int, last: int, guesses: Sequence[float]) -> float:
    """The float nearest to the only root between two places, looked for from the guesses between them."""
    end = _sign(whole, last)
    if not end:
        return _float(last)

    def side(place: int) -> int:
        """The sign of the place less the root."""
        return _sign(whole, place) * end

    for start in [place for place in map(_place, guesses) if first < place < last]:
        guess, begun, stride = start, side(start), 1
        while first < guess < last and begun == (at := side(guess)) != 0:
            first, last = (guess, last) if at < 0 else (first, guess)
            guess, stride = guess - at * stride, 2 * stride
        if first < guess < last:
            first, last = (guess, last) if begun > 0 else (first, guess)
    while last - first > 1:
        middle = (first + last) // 2
        at = side(middle)
        if not at:
            return _float(middle)
        first, last = (middle, last) if at < 0 else (first, middle)
    middle_of_both = (Fraction(_float(first)) + Fraction(_float(last))) / 2
    value = sum((c * middle_of_both**k for k, c in enumerate(whole)), Fraction(0)) * end
    return _float(first) if value > 0 else _float(last)


def _guesses(polynomial: Coefficients) -> list[float]:
    """The real parts of the roots in floats, as far as these can tell."""
    largest = max(map(abs, polynomial))
    with np.errstate(all="ignore"):
        try:
            found = np.roots([float(c / largest) for c in reversed(polynomial)])
        except np.linalg.LinAlgError:
            return []
    return found.real[np.isfinite(found.real)].tolist()  # type: ignore[no-any-return]


def _place(number: float) -> int:
    """The place of a float in the order of all floats; that of 0 is 0."""
    size: int = struct.unpack(">q", struct.pack(">d", abs(number)))[0]
    return size if number > 0.0 else -size


def _float(place: int) -> float:
    """The float at a place."""
    size: float = struct.unpack(">d", struct.pack(">q", abs(place)))[0]
    return math.copysign(size, place)
