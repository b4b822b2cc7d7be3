"""Powers with huge exponents to many digits, held to exact whole numbers and to mpmath with many
more."""

from __future__ import annotations

import mpmath
import pytest

import rulesheets
from rulesheets.evaluate import Undefined
from rulesheets.evaluate.digits import extended

POWER = rulesheets.loads("y = x^z").equations[0].right


@pytest.mark.parametrize("digits", [50, 400])
@pytest.mark.parametrize(
    ("x", "z"),
    [
        (1.0000001, 1e15),
        (-1.0000000000000002, 1e16 + 2),
        (-3.0, 2.0**53 - 1),
        (2.5, 1e20),
        (0.3, -(2.0**70)),
    ],
)
def test_a_huge_whole_exponent_keeps_all_digits(x: float, z: float, digits: int) -> None:
    found = extended(POWER, {"x": x, "z": z}, digits)
    with mpmath.workdps(900):
        expected = mpmath.mpf(x) ** int(z)
        assert abs(mpmath.mpf(found) / expected - 1) < mpmath.mpf(10) ** (1 - digits)


def test_a_huge_exponent_with_a_fraction_keeps_all_digits() -> None:
    context = mpmath.MPContext()
    context.dps = 300
    z = context.mpf(10) ** 20 + context.mpf(0.25)
    found = extended(POWER, {"x": 7.0, "z": z}, 50)
    with mpmath.workdps(300):
        expected = mpmath.exp(mpmath.mpf(z) * mpmath.ln(7))
        assert abs(mpmath.mpf(found) / expected - 1) < mpmath.mpf("1e-49")


def test_an_exponent_of_hundreds_of_digits() -> None:
    with mpmath.workdps(1100):
        for k in range(20):
            found = extended(POWER, {"x": -0.3 - k, "z": -1e200}, 800)
            expected = mpmath.mpf(-1e200) * mpmath.ln(0.3 + k)
            assert mpmath.almosteq(
                mpmath.ln(mpmath.mpf(found)), expected, rel_eps=mpmath.mpf("1e-990")
            )


@pytest.mark.parametrize(("x", "bits"), [(2.0, 200_000), (-2.0, 10**12)])
def test_an_exponent_beyond_counting_has_no_value(x: float, bits: int) -> None:
    """Nor is it written out as a whole number first, which would take all time and memory."""
    with pytest.raises(Undefined):
        extended(POWER, {"x": x, "z": mpmath.mpf(2) ** bits}, 50)
