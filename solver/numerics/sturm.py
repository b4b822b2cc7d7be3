"""Every real root of a polynomial with rational coefficients, counted exactly.

Sturm's theorem (J. C. F. Sturm, 1835; S. Basu, R. Pollack & M.-F. Roy, *Algorithms in Real Algebraic
Geometry*, 2006, section 2.2.2) on whole numbers: the coefficients are brought to a common denominator, and
points are floats, which are whole numbers over powers of two.
"""

from __future__ import annotations

import math
from fractions import Fraction
from itertools import pairwise
from typing import TYPE_CHECKING

from rulesheets.deadline import expect_time
from solver.numerics.interval_function import MAX, TINY, bracketed_root, split_point

if TYPE_CHECKING:
    from collections.abc import Sequence
    from typing import TypeAlias

    from solver.numerics.interval_function import ScalarFunction

    Whole: TypeAlias = list[int]
    """Coefficients of a polynomial, lowest degree first, the last one not 0."""

SPLITS = 400


def real_roots(
    coefficients: Sequence[Fraction], low: float = -math.inf, high: float = math.inf
) -> tuple[float, ...] | None:
    """The real roots in [low, high] of Σ c_k x^k, ascending, each the float nearest to where it changes sign.

    None where there is no such list: the polynomial is 0, or it has a multiple root (real or not), or a root
    beyond the floats or nearer to another one than floats can tell.
    """
    whole = _whole(coefficients)
    if not whole:
        return None
    chain = _sturm_chain(whole)
    if len(chain[-1]) > 1 or len(whole) == 1:
        return () if len(whole) == 1 else None
    reach = _reach(whole)
    low, high = max(low, -reach), min(high, reach)
    if not math.isfinite(reach) or low > high:
        return None if not math.isfinite(reach) else ()
    brackets = _isolated(chain, low, high)
    if brackets is None:
        return None
    at_low = (low,) if _sign(whole, low) == 0 else ()
    return at_low + tuple(_nearest(whole, *bracket) for bracket in brackets)


def simple_part(coefficients: Sequence[Fraction]) -> list[Fraction]:
    """The polynomial with the same roots, each of them once: p over the common divisor of p and p'."""
    whole = _whole(coefficients)
    if len(whole) < 2:
        return [Fraction(c) for c in whole]
    common = _sturm_chain(whole)[-1]
    rest, quotient = [Fraction(c) for c in whole], []
    while len(rest) >= len(common):
        expect_time()
        quotient.append(rest[-1] / common[-1])
        for k, c in enumerate(common):
            rest[len(rest) - len(common) + k] -= quotient[-1] * c
        rest.pop()
    return quotient[::-1]


def _whole(coefficients: Sequence[Fraction]) -> Whole:
    scale = math.lcm(*(c.denominator for c in coefficients)) if coefficients else 1
    return _primitive([int(c * scale) for c in coefficients])


def _primitive(polynomial: Whole) -> Whole:
    """Without zeros at the end and without a common factor."""
    while polynomial and polynomial[-1] == 0:
        polynomial = polynomial[:-1]
    common = math.gcd(*polynomial)
    return [c // common for c in polynomial] if common > 1 else polynomial


def _sturm_chain(polynomial: Whole) -> list[Whole]:
    """The polynomial, its derivative, and the remainders with their signs turned."""
    chain = [polynomial]
    following = _primitive([k * c for k, c in enumerate(polynomial)][1:])
    while following:
        expect_time()
        chain.append(following)
        following = _primitive([-c for c in _remainder(chain[-2], chain[-1])])
    return chain


def _remainder(dividend: Whole, divisor: Whole) -> Whole:
    """A positive multiple of the remainder."""
    rest, leading, n = list(dividend), divisor[-1], len(divisor)
    while len(rest) >= n:
        expect_time()
        factor, shift = rest[-1], len(rest) - n
        if leading < 0:
            factor = -factor
        rest = [abs(leading) * c for c in rest]
        for k, c in enumerate(divisor):
            rest[shift + k] -= factor * c
        rest.pop()
        while rest and rest[-1] == 0:
            rest.pop()
    return rest


def _reach(polynomial: Whole) -> float:
    """A bound of the size of every root: Cauchy's 1 + max |c_k / c_n|."""
    try:
        return 1.001 * (1.0 + max((abs(c / polynomial[-1]) for c in polynomial[:-1]), default=0.0))
    except OverflowError:
        return math.inf


def _isolated(chain: list[Whole], low: float, high: float) -> list[tuple[float, float]] | None:
    """Brackets [a, b] with one root each, ascending; None where floats can't tell two roots apart."""
    found: list[tuple[float, float]] = []
    open_ = [(low, _variations(chain, low), high, _variations(chain, high))]
    for _ in range(SPLITS):
        expect_time()
        if not open_:
            return sorted(found)
        a, at_a, b, at_b = open_.pop()
        if at_a == at_b:
            continue
        if at_a - at_b == 1 and _sign(chain[0], b) == 0:
            found.append((b, b))
        elif at_a - at_b == 1 and _sign(chain[0], a) != 0:
            found.append((a, b))
        else:
            middle = split_point(a, b)
            if not a < middle < b:
                return None
            at_middle = _variations(chain, middle)
            open_ += [(a, at_a, middle, at_middle), (middle, at_middle, b, at_b)]
    return None


def _variations(chain: list[Whole], x: float) -> int:
    """Changes of sign along the chain at x, zeros left out."""
    signs = [s for s in (_sign(polynomial, x) for polynomial in chain) if s]
    return sum(a != b for a, b in pairwise(signs))


def _nearest(polynomial: Whole, low: float, high: float) -> float:
    """The float nearest to the one root between two floats."""
    found = bracketed_root(_scaled(polynomial, low, high), low, high)
    side = _sign(polynomial, found)
    if not side:
        return found
    other = math.nextafter(found, high if side == _sign(polynomial, low) else low)
    middle = (Fraction(found) + Fraction(other)) / 2
    return other if _sign(polynomial, middle) == side else found


def _sign(polynomial: Whole, x: float | Fraction) -> int:
    number = _numerator(polynomial, x)
    return (number > 0) - (number < 0)


def _scaled(polynomial: Whole, low: float, high: float) -> ScalarFunction:
    """p(x) beside its size at the ends of a bracket, correctly rounded; 0 only where p is, and never
    infinite: between the ends p may be larger by more than floats hold."""
    degree = len(polynomial) - 1

    def exact(x: float) -> Fraction:
        return Fraction(_numerator(polynomial, x), x.as_integer_ratio()[1] ** degree)

    size = max(abs(exact(low)), abs(exact(high))) or 1

    def value(x: float) -> float:
        found = exact(x) / size
        least, most = (TINY, MAX) if found > 0 else (-TINY, -MAX)
        if abs(found) >= MAX:
            return most
        return float(found) or least if found else 0.0

    return value


def _numerator(polynomial: Whole, x: float | Fraction) -> int:
    """p(x) times the denominator of x to the power of the degree."""
    numerator, denominator = x.as_integer_ratio()
    total, power = polynomial[-1], denominator
    for c in reversed(polynomial[:-1]):
        total = total * numerator + c * power
        power *= denominator
    return total
