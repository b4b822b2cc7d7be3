"""Differences of exponentials: all their roots are known, however they are written."""

from __future__ import annotations

import itertools
import math

import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy.optimize import brentq

import rulesheets
import solver

WRITTEN = [
    "y = A*exp(-a*t) - B*exp(-b*t)",
    "e1 = exp(-a*t)\ne2 = B*exp(-b*t)\ny = A*e1 - e2",
    "y = A*(exp(-t*a) - B/A*exp(-b*t))",
    "y = A/exp(a*t) - B*c^t\nc = exp(-b)",
]
NUMBERS = st.integers(1, 99).map(lambda n: n / 10)


@pytest.mark.parametrize("rules", WRITTEN)
@settings(max_examples=25, deadline=None)
@given(NUMBERS, NUMBERS, NUMBERS, NUMBERS, st.floats(-2.0, 2.0))
def test_every_time_is_found(
    rules: str, above: float, a: float, below: float, b: float, share: float
) -> None:
    """Between its ends and its only extremum the difference is monotone."""
    assume(abs(a - b) >= 0.1)

    def difference(t: float) -> float:
        return above * math.exp(-a * t) - below * math.exp(-b * t)

    top = math.log(above * a / (below * b)) / (a - b)
    y = round(share * difference(top), 3)
    assume(abs(y - difference(top)) > 1e-3 < abs(y))
    ends = top - 30.0, top, top + 300.0
    pieces = list(itertools.pairwise(ends))
    roots = [
        brentq(lambda t: difference(t) - y, *pair, xtol=1e-13)
        for pair in pieces
        if (difference(pair[0]) - y) * (difference(pair[1]) - y) < 0.0
    ]
    given = {"A": above, "a": a, "B": below, "b": b, "y": y}
    result = solver.solve(rulesheets.loads(rules), given)
    if not roots:
        assert str(result.status) == "infeasible"
        return
    assert str(result.status) == "solved" and result.complete
    assert sorted(float(s["t"]) for s in result.solutions) == pytest.approx(sorted(roots), rel=1e-6)
