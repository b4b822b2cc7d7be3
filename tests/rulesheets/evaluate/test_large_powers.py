"""Powers with large exponents to many digits, held to exact whole numbers and to mpmath with many more."""

from __future__ import annotations

import mpmath
import pytest

import rulesheets
from rulesheets.evaluate import Undefined, extended

POWER = rulesheets.loads("y = x^z").equations[0].right


@pytest.mark.parametrize("digits", [50, 400])
@pytest.mark.parametrize(("x", "z"), [(1.0000001, 1e9), (-1.0000000000000002, 1e12), (0.3, -(2.0**30))])
def test_a_large_whole_exponent_keeps_all_digits(x: float, z: float, digits: int) -> None:
    found = extended(POWER, {"x": x, "z": z}, digits)
    with mpmath.workdps(900):
        expected = mpmath.mpf(x) ** int(z)
        assert abs(mpmath.mpf(found) / expected - 1) < mpmath.mpf(10) ** (1 - digits)


@pytest.mark.parametrize(
    ("x", "z"),
    [(2.0, 1e13), (-0.3, -1e200), (2.0, mpmath.mpf(2) ** 200_000), (-2.0, mpmath.mpf(2) ** 10**12)],
)
def test_an_exponent_beyond_counting_has_no_value(x: float, z: float) -> None:
    """Nor is it written out as a whole number first, which would take all time and memory."""
    with pytest.raises(Undefined):
        extended(POWER, {"x": x, "z": z}, 50)
