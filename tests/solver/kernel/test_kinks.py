"""Kinks, flat stretches and ends of domains of a residual in one unknown."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest

import rulesheets
import solver
from solver import Status

TAX = """\
t1 = 0.1*min(inc, 10000)
t2 = 0.15*min(max(inc - 10000, 0), 30000)
t3 = 0.25*max(inc - 40000, 0)
tax = t1 + t2 + t3
net = inc - tax
avg = tax/inc
"""
HEATING = "T = -50 + min(q, 104.5)/2.09 + max(q - 438.5, 0)/4.18"
NOZZLE = """\
M = sqrt(5*((500/pe)^(1/3.5) - 1))
V = M*sqrt(401.8*T)
T = 300/(1 + 0.2*M^2)
m = pe/(287*T)*V*A
"""


@pytest.mark.parametrize(("net", "inc"), [(9000.0, 1e4), (34500.0, 4e4), (42000.0, 5e4)])
def test_a_root_at_kinks_is_the_only_one(net: float, inc: float) -> None:
    result = solver.solve(rulesheets.loads(TAX), {"net": net})
    assert [s["inc"] for s in result.solutions] == [pytest.approx(inc, rel=1e-14)]
    assert result.complete


def test_points_of_a_stretch_of_answers_are_none() -> None:
    assert solver.solve(rulesheets.loads(TAX), {"avg": 0.1}).status is Status.PARTIAL
    result = solver.solve(rulesheets.loads(HEATING), {"T": 0.0})
    assert result.status is Status.PARTIAL
    assert "q" in result.undetermined


def test_a_value_at_a_kink_rests_on_more_than_last_places() -> None:
    sheet = HEATING + "\nq = Q/m"
    result = solver.solve(rulesheets.loads(sheet), {"Q": 43.85, "m": 0.1})
    assert result.status is Status.SOLVED
    assert abs(float(result["T"])) < 1e-13


def test_an_answer_at_the_end_of_a_domain_is_found() -> None:
    result = solver.solve(rulesheets.loads(NOZZLE), {"m": 0.0, "A": 5.0})
    assert result.status is Status.SOLVED
    assert result["pe"] == pytest.approx(500.0, rel=1e-12)


def test_floats_that_absorb_what_is_asked_give_no_answer() -> None:
    rules = rulesheets.loads("boxes = int(n/4)\nrest = n - 4*boxes")
    assert solver.solve(rules, {"rest": 5.145}).status is not Status.SOLVED


def test_a_value_below_a_jump_that_is_not_reached_is_none() -> None:
    """Ten for one boiler would take a load of 10, at which there are two."""
    rules = rulesheets.loads("n = min(2, 1 + step(load, 10))\neach = load/n")
    assert [s["load"] for s in solver.solve(rules, {"each": 10.0}).solutions] == [20.0]
    assert len(solver.solve(rules, {"each": 5.0}).solutions) == 2


def test_equal_capacity_flows_are_no_double_root() -> None:
    """Beside the kink of a minimum and a maximum the heat flow changes to first order."""
    rules = """
Q = eps*min(Ch, Cc)*(90 - 20)
Cr = min(Ch, Cc)/max(Ch, Cc)
eps = 1 - exp(-(1 - exp(-NTU*Cr))/Cr)
NTU = 4/min(Ch, Cc)
Ch = 2
"""
    model = rulesheets.loads(rules)
    heat = solver.solve(model, {"Cc": 2.0})["Q"]
    result = solver.solve(model, {"Q": heat})
    assert str(result.status) == "solved"
    assert [answer["Cc"] for answer in result.solutions] == [2.0]


ROOTS: dict[str, Callable[[float], float]] = {
    "sqrt(d)": math.sqrt,
    "(3*d/(5 + 2*d))^(2/3)": lambda d: (3 * d / (5 + 2 * d)) ** (2 / 3),
    "d*(d/(1 + d))^0.4": lambda d: d * (d / (1 + d)) ** 0.4,
}


@pytest.mark.parametrize("y", [-0.5, 0.2, 1.0, 4.0])
@pytest.mark.parametrize("root", ROOTS)
def test_a_root_of_what_is_0_has_no_slope_before_a_kink(root: str, y: float) -> None:
    """As the flow over a flood plain below its height."""
    points = np.linspace(-6.0, 8.0, 70_001) + 3e-5
    misses = np.array([ROOTS[root](max(x - 2, 0)) + x**3 / 8 - x / 2 - y for x in points])
    crossings = points[:-1][np.diff(np.sign(misses)) != 0]
    rules = f"d = max(x - 2, 0)\nf = {root}\ny = f + x^3/8 - x/2"
    result = solver.solve(rulesheets.loads(rules), {"y": y})
    assert sorted(s["x"] for s in result.solutions) == pytest.approx(crossings, abs=1e-3)
    assert result.complete
