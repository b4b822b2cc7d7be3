"""A root between two points of opposite sign, to the last bit.

T. R. Chandrupatla, *A new hybrid quadratic/bisection algorithm for finding the zero of a nonlinear
function without using derivatives*, Advances in Engineering Software 28 (1997). The bisection halves the
exponent where the bracket spans several decades, so that 1e-300 … 1e300 takes a few steps, not a thousand.
"""

from __future__ import annotations

import math
import sys
from typing import TYPE_CHECKING

from rulesheets.deadline import expect_time

if TYPE_CHECKING:
    from collections.abc import Callable
    from typing import TypeAlias

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
    """A point between: 0 inside a box that holds it, the geometric mean over decades, else the middle.

    From 0 or infinity the exponent is doubled or halved, so that the whole line is about twenty deep.
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
    """The float of least |f| where f changes sign between ``low`` and ``high`` (both finite).

    f must be defined and of opposite sign at the ends; it need not be continuous (``is_zero_crossing``
    tells a root from a pole). Where f is undefined inside, the last defined end is returned.
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
    """Inverse quadratic interpolation where Chandrupatla's criterion allows it, else a bisection.

    Kept one float away from the ends, so that the bracket always shrinks until its ends are adjacent.
    """
    middle = split_point(min(a, b), max(a, b))
    if c == b or f_c in (f_a, f_b) or not math.isfinite(f_c) or not math.isfinite(f_b):
        return middle
    xi, phi = (a - b) / (c - b), (f_a - f_b) / (f_c - f_b)
    if not (phi * phi < xi and (1 - phi) ** 2 < 1 - xi):
        return middle
    step = f_a / (f_b - f_a) * f_c / (f_b - f_c) + (c - a) / (b - a) * f_a / (f_c - f_a) * f_b / (f_c - f_b)
    x = a + step * (b - a)
    inner = math.nextafter(min(a, b), math.inf), math.nextafter(max(a, b), -math.inf)
    if inner[0] > inner[1] or math.isnan(x):
        return middle
    return min(max(x, inner[0]), inner[1])


def is_zero_crossing(function: ScalarFunction, root: float, low: float, high: float) -> bool:
    """Whether f fades away towards ``root``: at a pole it grows, at a jump it stays as it is.

    Compares |f(root)| with |f| a few thousand times sqrt(eps) away, within ``low`` … ``high``.
    """
    at_root = abs(value_at(function, root))
    if at_root == 0.0:
        return True
    reach = max(abs(root), 1e-290) * 1e-4
    beside = (value_at(function, max(low, root - reach)), value_at(function, min(high, root + reach)))
    return at_root < 0.05 * max((abs(f) for f in beside if not math.isnan(f)), default=0.0)


def lowest_point(function: ScalarFunction, low: float, high: float) -> float:
    """The point of least |f|: of all floats of a narrow interval, by golden section in a wide one."""
    candidates = _floats_between(low, high, 64) or [_golden_section(function, low, high), low, high]
    if low <= 0.0 <= high:
        candidates.append(0.0)
    middle = low + (high - low) / 2
    return min(candidates, key=lambda x: (_magnitude(function, x), x != 0.0, abs(x - middle)))


def _magnitude(function: ScalarFunction, x: float) -> float:
    f = abs(value_at(function, x))
    return math.inf if math.isnan(f) else f


def _floats_between(low: float, high: float, limit: int) -> list[float]:
    """All floats from low to high, or none where there are more than ``limit``."""
    floats = [low]
    while floats[-1] < high:
        if len(floats) == limit:
            return []
        floats.append(math.nextafter(floats[-1], math.inf))
    return floats


def _golden_section(function: ScalarFunction, low: float, high: float) -> float:
    ratio = (math.sqrt(5.0) - 1) / 2
    for _ in range(90):
        expect_time()
        left, right = high - ratio * (high - low), low + ratio * (high - low)
        if _magnitude(function, left) <= _magnitude(function, right):
            high = right
        else:
            low = left
    return low + (high - low) / 2
