"""The error function and its complement to many digits, where mpmath takes long over them.

From some size of the argument on, where the power series has thousands of terms and the asymptotic one does
not reach the digits, the continued fraction of Laplace does it in hundreds (F. W. J. Olver et al. (eds.),
*NIST Handbook of Mathematical Functions*, 2010, 7.9.1). It is evaluated from its end in whole numbers.
"""

from __future__ import annotations

from math import ceil, log2, sqrt
from typing import Any, TypeAlias

Extended: TypeAlias = Any
"""A number of mpmath (which has no types of its own)."""

LEAST, FARTHEST = 4.0, 1e6
"""Arguments between which the continued fraction may be the quicker way."""
LONG = 600
"""Binary digits of a precision for which mpmath's series get slow."""
MOST = 1_200
"""Terms of it that take about as long as mpmath does."""
GUARD = 40
"""Binary digits that the rounding of its terms, and of their estimated number, may take."""


def erf(mp: Any, x: Extended) -> Extended:
    """erf(x) in the context ``mp``, to its precision."""
    if mp.prec < LONG or not LEAST < abs(x) < FARTHEST:
        return mp.erf(x)
    small = int(mp.prec - x * x / mp.ln2)  # digits of the complement that count
    if small < 0:
        return mp.erf(x)
    rest = _complement(mp, abs(x), small + GUARD)
    return mp.erf(x) if rest is None else mp.sign(x) * (1 - rest)


def erfc(mp: Any, x: Extended) -> Extended:
    """erfc(x) in the context ``mp``, to its precision."""
    if mp.prec < LONG or not LEAST < abs(x) < FARTHEST:
        return mp.erfc(x)
    if x < 0:
        return 1 + erf(mp, -x)
    found = _complement(mp, x, mp.prec)
    return mp.erfc(x) if found is None else +found


def _complement(mp: Any, x: Extended, bits: int) -> Extended | None:
    """erfc(x) of an x > 0 to so many binary digits; None where that takes too many terms."""
    count = _terms(float(x), bits)
    if count is None:
        return None
    working = bits + GUARD
    one = 1 << working
    squared = 2 * ceil(log2(float(x)) + 1)  # digits of x² before the point
    with mp.workprec(working + squared + GUARD):
        square = x * x
        share = int(mp.ldexp(1 / (2 * square), working))
        fraction = one
        for k in range(count, 0, -1):
            fraction = one + ((k * share) << working) // fraction
        return mp.exp(-square) / (x * mp.sqrt(mp.pi)) * one / fraction


def _terms(x: float, bits: int) -> int | None:
    """How many terms of 1 + c/(1 + 2c/(1 + 3c/…)), c = 1/(2x²), give so many binary digits: each takes the
    error of the next times a/f², a = kc, f = (1 + √(1 + 4a))/2."""
    share, left = 0.5 / (x * x), float(bits + 10)
    for k in range(1, MOST + 1):
        a = k * share
        f = 0.5 + 0.5 * sqrt(1.0 + 4.0 * a)
        left += log2(a) - 2.0 * log2(f)
        if left <= 0.0:
            return k
    return None
