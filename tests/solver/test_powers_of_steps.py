"""Powers undone in direct steps, at any size: the exponent of the root is no float."""

from __future__ import annotations

import mpmath
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import rulesheets
import solver

EXPONENTS = (1.5, 2.5, 0.3, 3.0, 7.0, -1.5, -3.0, 1.0 / 3.0)


@settings(max_examples=60, deadline=None)
@given(st.sampled_from(EXPONENTS), st.floats(-60.0, 60.0))
def test_a_power_is_undone_to_the_last_places(exponent: float, decades: float) -> None:
    """By as many as the rounding of the power given is worth."""
    target = 10.0**decades
    with mpmath.workdps(60):
        exact = mpmath.mpf(target) ** (1 / mpmath.mpf(exponent))
    if not 1e-300 < exact < 1e300:
        return
    model = rulesheets.loads(f"variables\n  z\n  t = {target!r}\nrules\n  z^({exponent!r}) = t\n")
    result = solver.solve(model)
    assert result.status is solver.Status.SOLVED
    assert abs(result["z"] / exact - 1) <= 4 * 2.0**-52 * (1 + 1 / abs(exponent))


def test_a_root_far_out_is_no_refusal() -> None:
    result = solver.solve(rulesheets.loads("z^1.5 = 5.533371702678215e299"))
    assert result["z"] == pytest.approx(6.74e199, rel=1e-15)
