"""One unknown: the real roots of a polynomial, and a root between two points."""

from __future__ import annotations

import math
import struct
import sys
from collections.abc import Callable, Iterator, Sequence
from fractions import Fraction
from functools import reduce
from itertools import pairwise
from typing import TypeAlias

from rulesheets.deadline import expect_time

# --- real roots of polynomials with rational coefficients, exactly ---
#
# Lists of coefficients begin with the lowest degree. The number of sign changes in Sturm's sequence
# at a, less that at b, is the number of roots in (a, b] (S. Basu, R. Pollack, M.-F. Roy,
# *Algorithms in Real Algebraic Geometry*, section 2.2).

Coefficients: TypeAlias = Sequence[Fraction]
LARGEST = 0x7FEF_FFFF_FFFF_FFFF
"""The place of the largest float."""
GROWTH = 4
"""By how much each step towards the other side of a root is longer than the one before."""


def simple_part(polynomial: Coefficients) -> list[Fraction]:
    """The polynomial with the same roots, each of them once: p over the common divisor of p and
    p'."""
    whole = _integers(polynomial)
    if len(whole) > 1:
        whole = _integers(_divided(whole, _sequence(whole, _slope(whole))[-1])[0])
    return list(map(Fraction, whole))


def common_divisor(one: Coefficients, other: Coefficients) -> list[Fraction]:
    """The greatest one of two polynomials, not both 0."""
    return list(map(Fraction, _sequence(_integers(one), _integers(other))[-1]))


def without_roots(polynomial: Coefficients, others: Coefficients) -> list[Fraction]:
    """The polynomial without those of its roots that are roots of another one."""
    whole, divisor = _integers(polynomial), _integers(others)
    while len(common := _sequence(whole, divisor)[-1]) > 1:
        whole = _integers(_divided(whole, common)[0])
    return list(map(Fraction, whole))


def real_roots(
    polynomial: Coefficients, low: float = -math.inf, high: float = math.inf
) -> tuple[float, ...] | None:
    """The real roots in [low, high], ascending, each the float nearest to where the polynomial
    changes sign.

    None if there is no such list: the polynomial is 0, or it has a multiple root (real or not), or
    a root beyond the floats or closer to another one than floats can tell.
    """
    whole = _integers(polynomial)
    sequence = _sequence(whole, _slope(whole))
    if len(sequence[-1]) != 1:
        return None
    least, most = (max(-LARGEST, min(LARGEST, _place(end))) for end in (low, high))
    ends = (-math.inf if low == -math.inf else least), (math.inf if high == math.inf else most)
    count = _changes(sequence, ends[0]) - _changes(sequence, ends[1])
    within = list(_isolated(sequence, least, most))
    found = [_nearest(sequence[0], *places) for places in within]
    if len(found) < count or len(set(found)) < len(found):
        return None
    at_the_end = not _sign(sequence[0], least) and [_float(least)]
    return (*(at_the_end or ()), *found)


def _sequence(whole: list[int], other: list[int]) -> list[list[int]]:
    """The remainders of Euclid's division, with changed signs; the last is the greatest common
    divisor. Of a polynomial and its slope it is Sturm's sequence."""
    found = [whole, other]
    while found[-1]:
        expect_time()
        found.append([-c for c in _integers(_divided(found[-2], found[-1])[1])])
    return found[:-1] or [[]]


def _slope(whole: list[int]) -> list[int]:
    return _integers([k * c for k, c in enumerate(whole)][1:])


def _integers(polynomial: Sequence[Fraction | int]) -> list[int]:
    """The polynomial times a positive number: integers without a common divisor, the last of them
    not 0."""
    common = math.lcm(*(c.denominator for c in polynomial))
    whole = [c.numerator * (common // c.denominator) for c in polynomial]
    while whole and not whole[-1]:
        whole.pop()
    divisor = math.gcd(*whole)
    return [c // divisor for c in whole]


def _divided(dividend: list[int], divisor: list[int]) -> tuple[list[int], list[int]]:
    """The quotient and the remainder of a positive multiple of the dividend."""
    rest, found, lead = list(dividend), list[int](), abs(divisor[-1])
    while len(rest) >= len(divisor):
        factor, shift = rest[-1] * (1 if divisor[-1] > 0 else -1), len(rest) - len(divisor)
        rest, found = [c * lead for c in rest], [*(c * lead for c in found), factor]
        for k, c in enumerate(divisor):
            rest[shift + k] -= factor * c
        rest.pop()
    return found[::-1], rest


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
    """Places of floats with a single root between them, or at the second; ascending."""
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


def _nearest(whole: list[int], first: int, last: int) -> float:
    """The float nearest to the only root between two places, by bisection: it begins next to the
    root in floats, in steps that grow until the other side is reached."""
    end = _sign(whole, last)
    if not end:
        return _float(last)
    largest = max(map(abs, whole))
    scaled = [c / largest for c in reversed(whole)]
    guess = bracketed_root(
        lambda x: reduce(lambda total, c: total * x + c, scaled), _float(first), _float(last)
    )
    near, reach = _place(guess), 1
    while last - first > 1:
        middle = near if first < near < last else (first + last) // 2
        side = _sign(whole, middle) * end  # of the place less the root
        if not side:
            return _float(middle)
        first, last, near = (
            (middle, last, middle + reach) if side < 0 else (first, middle, middle - reach)
        )
        reach *= GROWTH
    middle_of_both = (Fraction(_float(first)) + Fraction(_float(last))) / 2
    value = sum((c * middle_of_both**k for k, c in enumerate(whole)), Fraction(0)) * end
    return _float(first) if value > 0 else _float(last)


def _place(number: float) -> int:
    """The place of a float in the order of all floats; that of 0 is 0."""
    size: int = struct.unpack(">q", struct.pack(">d", abs(number)))[0]
    return size if number > 0.0 else -size


def _float(place: int) -> float:
    size: float = struct.unpack(">d", struct.pack(">q", abs(place)))[0]
    return math.copysign(size, place)


# --- a root between two points, to the last bit ---
#
# T. R. Chandrupatla, "A new hybrid quadratic/bisection algorithm for finding the zero of a
# nonlinear function without using derivatives", Advances in Engineering Software 28 (1997). The
# bisection halves the exponent where the bracket spans several decades, so that 1e-300 … 1e300
# takes a few steps, not a thousand.

ScalarFunction: TypeAlias = Callable[[float], float]
MAX = sys.float_info.max
TINY = 5e-324
STEPS = 300


def value_at(function: ScalarFunction, x: float) -> float:
    """f(x), nan where it is undefined."""
    try:
        return float(function(x))
    except (ArithmeticError, ValueError):
        return math.nan


def split_point(low: float, high: float) -> float:
    """A point between: 0 inside a box that holds it, the geometric mean over decades, else the
    middle.

    From 0 or infinity the exponent is doubled or halved, so that the whole line is about twenty
    deep.
    """
    if low < 0.0 < high or low == high == 0.0:
        return 0.0
    if high <= 0.0:
        return -split_point(-high, -low)
    if high == math.inf:
        return 1.0 if low == 0.0 else min(low * max(8.0, low), MAX)
    if low == 0.0:
        return math.sqrt(high) if high > 64.0 else max(high * min(0.125, high), TINY)
    if high > 16.0 * low:
        return math.sqrt(low) * math.sqrt(high)
    return low + (high - low) / 2


def bracketed_root(function: ScalarFunction, low: float, high: float) -> float:
    """The float of least |f| if f changes sign between ``low`` and ``high`` (both finite).

    f must be defined and of opposite sign at the ends; it need not be continuous
    (``is_zero_crossing`` distinguishes a root from a pole). If f is undefined inside, the last
    defined end is returned.
    """
    a, f_a = low, value_at(function, low)
    b, f_b = high, value_at(function, high)
    if f_a == 0.0 or f_b == 0.0:
        return a if f_a == 0.0 else b
    c, f_c, x = a, f_a, split_point(low, high)
    for _ in range(STEPS):
        expect_time()
        if x in (min(a, b), max(a, b)):
            break
        f = value_at(function, x)
        if f == 0.0:
            return x
        if math.isnan(f):
            break
        if (f > 0.0) == (f_a > 0.0):
            c, f_c = a, f_a
        else:
            c, f_c, b, f_b = b, f_b, a, f_a
        a, f_a = x, f
        x = _next_point(a, f_a, b, f_b, c, f_c)
    return a if abs(f_a) <= abs(f_b) else b


def _next_point(a: float, f_a: float, b: float, f_b: float, c: float, f_c: float) -> float:
    """Inverse quadratic interpolation if Chandrupatla's criterion allows it, else a bisection.

    Kept one float away from the ends, so that the bracket always shrinks until its ends are
    adjacent.
    """
    middle = split_point(min(a, b), max(a, b))
    if c == b or f_c in (f_a, f_b) or not math.isfinite(f_c) or not math.isfinite(f_b):
        return middle
    xi, phi = (a - b) / (c - b), (f_a - f_b) / (f_c - f_b)
    if not (phi * phi < xi and (1 - phi) ** 2 < 1 - xi):
        return middle
    step = f_a / (f_b - f_a) * f_c / (f_b - f_c) + (c - a) / (b - a) * f_a / (f_c - f_a) * f_b / (
        f_c - f_b
    )
    x = a + step * (b - a)
    inner = math.nextafter(min(a, b), math.inf), math.nextafter(max(a, b), -math.inf)
    if inner[0] > inner[1] or math.isnan(x):
        return middle
    return min(max(x, inner[0]), inner[1])


def is_zero_crossing(function: ScalarFunction, root: float, low: float, high: float) -> bool:
    """Whether f approaches 0 towards ``root``: at a pole it grows, at a jump it stays as it is.

    Compares |f(root)| with |f| a few thousand times sqrt(eps) away, within ``low`` … ``high``.
    """
    at_root = abs(value_at(function, root))
    if at_root == 0.0:
        return True
    reach = max(abs(root), 1e-290) * 1e-4
    beside = (
        value_at(function, max(low, root - reach)),
        value_at(function, min(high, root + reach)),
    )
    return at_root < 0.05 * max((abs(f) for f in beside if not math.isnan(f)), default=0.0)


def lowest_point(function: ScalarFunction, low: float, high: float) -> float:
    """The point of least |f| among the ends, the middle, 0, and the last point at which f is
    defined if it is so at one end only."""
    middle = low + (high - low) / 2
    candidates = [low, middle, high, *([0.0] if low <= 0.0 <= high else [])]
    sizes = {x: abs(value_at(function, x)) for x in candidates}
    known = [x for x in candidates if not math.isnan(sizes[x])] or candidates
    if math.isnan(sizes[low]) is not math.isnan(sizes[high]):
        inside, outside = (high, low) if math.isnan(sizes[low]) else (low, high)
        while (x := inside + (outside - inside) / 2) not in (inside, outside):
            inside, outside = (inside, x) if math.isnan(value_at(function, x)) else (x, outside)
        known, sizes[inside] = [*known, inside], abs(value_at(function, inside))
    return min(known, key=lambda x: (sizes[x], x != 0.0, abs(x - middle)))


def lowest_between(function: ScalarFunction, low: float, high: float) -> float:
    """Where f is least between two points, if it has one minimum there: golden sections and
    parabolas (R. P. Brent, *Algorithms for Minimization without Derivatives*, 1973, ch. 5)."""
    from scipy.optimize import fminbound  # takes longer to load than most solves

    return float(fminbound(function, low, high, xtol=1e-8 * (high - low)))
