"""Quotients times their divisors: ``w*b = a`` holds where b is 0, too, and with a for ``w*b`` lists
are known to be whole."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest

import rulesheets
import solver
from solver import Status

SHEET = "w*b = a\nb = ({})\na = {}\nv = w*b + x"
BELOW: dict[str, Callable[[float], float]] = {
    "x - 2": lambda x: x - 2,
    "exp(x/3) - 2": lambda x: math.exp(x / 3) - 2,
    "ln(x^2 + 1) - x/5": lambda x: math.log(x**2 + 1) - x / 5,
}
ABOVE: dict[str, Callable[[float], float]] = {
    "exp(x/4) - 3": lambda x: math.exp(x / 4) - 3,
    "x^3 - 4*x": lambda x: x**3 - 4 * x,
}
POINTS = np.linspace(-40.0, 40.0, 80_001) + 1e-5


@pytest.mark.parametrize("v", [-1.3, 0.4, 7.0])
@pytest.mark.parametrize("above", ABOVE)
@pytest.mark.parametrize("below", BELOW)
def test_a_scan_finds_the_same(below: str, above: str, v: float) -> None:
    misses = [ABOVE[above](x) + x - v for x in POINTS]
    crossings = POINTS[:-1][np.diff(np.sign(misses)) != 0]
    result = solver.solve(rulesheets.loads(SHEET.format(below, above)), {"v": v})
    assert result.status is Status.SOLVED
    assert sorted(float(s["x"]) for s in result.solutions) == pytest.approx(crossings, abs=2e-3)
    assert result.complete
    for answer in result.solutions:
        x = float(answer["x"])
        assert answer["w"] == pytest.approx(ABOVE[above](x) / BELOW[below](x), rel=1e-9)


STILL = """ln(F/W) = 1/(alpha - 1)*ln(xF*(1 - xW)/(xW*(1 - xF))) + ln((1 - xW)/(1 - xF))
D = F - W
D*yD = F*xF - W*xW
rec = 100*D*yD/(F*xF)"""


@pytest.mark.parametrize("unknown", ["xF", "xW"])
@pytest.mark.parametrize(("xF", "xW"), [(0.5, 0.3), (0.8, 0.25), (0.1, 0.05)])
def test_a_still_from_which_nothing_is_drawn_recovers_nothing(
    unknown: str, xF: float, xW: float
) -> None:
    """Where xF is xW nothing is drawn, and the concentration of it may be any."""
    given = {"F": 100.0, "alpha": 2.4, "xF": xF, "xW": xW}
    model = rulesheets.loads(STILL)
    rec = solver.solve(model, given)["rec"]
    found = solver.solve(model, {**given, "rec": rec, unknown: None})
    assert [answer[unknown] for answer in found.solutions] == pytest.approx([given[unknown]])
    assert found.complete
