"""Answers that only a removable 0/0 lets pass are refused; true ones beside such a place are
found."""

from __future__ import annotations

import math
from collections.abc import Mapping

import mpmath
import numpy as np
import pytest

import rulesheets
import solver
from benchmarks.check_fuzz import examine
from solver import Result

POLYTROPIC = "p1*V1^g = p2*V2^g\nwork = (p2*V2 - p1*V1)/(g - 1)"
GAS = {"p1": 101.0, "V1": 1.2, "V2": 0.0857142857}
LOAN = "payment = debt*rate/(1 - (1 + rate)^(-term))"
TRIANGLE = "A + B + C = 180\na = 2*R*sind(A)\nb = 2*R*sind(B)\nc = 2*R*sind(C)"
EXCHANGER = """\
dT1 = Thi - Tco
dT2 = Tho - Tci
Q = mh*cph*(Thi - Tho)
Q = mc*cpc*(Tco - Tci)
A = Q/(U*LM)
Q = U*A*(dT1 - dT2)/ln(dT1/dT2)
"""
FIN = """\
k*(Tw - Ts)/L = h*(Ts - Ta) + eps*5.67e-8*(Ts^4 - Ta^4)
hr = eps*5.67e-8*(Ts^2 + Ta^2)*(Ts + Ta)
m = sqrt(2*(h + hr)/(k*t))
"""
MOTION = "v = u + acc*t\ns = (v^2 - u^2)/(2*acc)\nmean = s/t"


def solved(rules: str, inputs: Mapping[str, float]) -> Result:
    return solver.solve(rulesheets.loads(rules), inputs)


def exponent(work: float) -> float:
    """The exponent of the polytropic change that takes so much work, in many digits."""
    p, v, w = map(mpmath.mpf, GAS.values())
    with mpmath.workdps(40):
        return float(
            mpmath.findroot(
                lambda g: (p * (v / w) ** g * w - p * v) / (g - 1) - work,
                (1.01, 2.5),
                solver="anderson",
            )
        )


def test_a_quotient_of_rounding_errors_is_no_exponent() -> None:
    result = solved(POLYTROPIC, {**GAS, "work": 487.702})
    assert [solution["g"] for solution in result.solutions] == pytest.approx(
        [exponent(487.702)], rel=1e-14
    )
    assert result.complete


def test_a_quotient_of_rounding_errors_below_a_root_is_no_conductivity() -> None:
    """With k = 0 the root is of 0/0, and has no slope: hr = -h beside k = 1e-17 gives it any
    value."""
    given = {"Tw": 400.0, "Ta": 300.0, "h": 15.0, "eps": 0.8, "L": 0.03, "t": 0.002}
    forward = solved(FIN, {**given, "k": 45.0})
    m = forward["m"]
    assert isinstance(m, float)
    result = solved(FIN, {**given, "m": m})
    assert [solution["k"] for solution in result.solutions] == pytest.approx([45.0], rel=1e-13)


@pytest.mark.parametrize("share", [0.0, 0.3])
def test_answers_without_a_slope_stand(share: float) -> None:
    """At an end of a domain, on either side of it, and where the slope of a root is infinite."""
    edges = solved("cos(asin(x*y)) = 1e-9\nx = y", {})
    assert sorted(solution["x"] for solution in edges.solutions) == [-1.0, 1.0]
    roots = solved("sqrt(x - a) + y = 0\nx + y = a", {"a": share})
    assert sorted(solution["x"] for solution in roots.solutions) == pytest.approx(
        [share, share + 1.0]
    )


def test_prepared_calls_and_sweeps_refuse_it_too() -> None:
    works = np.linspace(400.0, 600.0, 7)
    plan = solver.prepare(rulesheets.loads(POLYTROPIC), ["work"], ["g"], GAS)
    expected = [exponent(work) for work in works]
    assert [plan(work)[0] for work in works] == pytest.approx(expected, rel=1e-14)
    assert [len(plan.all(work)) for work in works] == [1] * 7
    assert plan.sweep(works)["g"] == pytest.approx(expected, rel=1e-14)
    columns = {"work": works, **{name: np.full(7, value) for name, value in GAS.items()}}
    assert solver.sweep(rulesheets.loads(POLYTROPIC), columns)["g"] == pytest.approx(
        expected, rel=1e-14
    )


def test_a_triangle_has_no_endless_circumcircle() -> None:
    result = solved(TRIANGLE, {"a": 7.0, "b": 5.0, "c": 8.0})
    radius = 7.0 * 5.0 * 8.0 / (4.0 * math.sqrt(10.0 * 3.0 * 5.0 * 2.0))
    assert {round(abs(float(solution["R"])), 12) for solution in result.solutions} == {
        round(radius, 12)
    }


def test_a_heat_exchanger_without_heat_is_no_answer() -> None:
    """With Q = 0 the mean temperature difference is 0/0."""
    flows = {"mh": 2.0, "cph": 4.18, "mc": 3.0, "cpc": 2.1, "Thi": 110.0, "Tci": 20.0}
    result = solved(EXCHANGER, {"LM": 49.2965, "U": 0.5, **flows})

    def miss(heat: mpmath.mpf) -> mpmath.mpf:
        hot, cold = 90 - heat / mpmath.mpf(2 * 4.18), 90 - heat / mpmath.mpf(3 * 2.1)
        return (hot - cold) / mpmath.log(hot / cold) - 49.2965

    heat = float(mpmath.findroot(miss, (200.0, 350.0), solver="anderson"))
    assert [solution["Q"] for solution in result.solutions] == pytest.approx([heat], rel=1e-12)


def test_a_motion_of_steady_speed_has_no_acceleration_made_of_rounding() -> None:
    acceleration, result = 0.5, solved(MOTION, {"u": 2.0, "t": 4.0, "mean": 3.0})
    assert [solution["acc"] for solution in result.solutions] == pytest.approx(
        [acceleration], rel=1e-14
    )


@pytest.mark.parametrize("off", [1e-4, -1e-4, 1e-7, 1e-9])
def test_an_exponent_close_to_one_is_found(off: float) -> None:
    with mpmath.workdps(40):
        p, v, w = map(mpmath.mpf, GAS.values())
        g = 1 + mpmath.mpf(off)
        work = float((p * (v / w) ** g * w - p * v) / (g - 1))
        slope = mpmath.diff(lambda g: (p * (v / w) ** g * w - p * v) / (g - 1), g)
    unsure = math.ulp(work) / float(slope)
    result = solved(POLYTROPIC, {**GAS, "work": work})
    assert any(abs(float(s["g"]) - float(g)) <= unsure + math.ulp(1.0) for s in result.solutions)


@pytest.mark.parametrize("rate", [1e-3, 1e-6, 1e-9])
def test_a_rate_close_to_zero_is_found(rate: float) -> None:
    with mpmath.workdps(40):
        r = mpmath.mpf(rate)
        payment = float(1200 * r / (1 - (1 + r) ** -12))
    result = solved(LOAN, {"payment": payment, "debt": 1200.0, "term": 12.0})
    unsure = math.ulp(payment) / 650.0
    assert any(abs(float(s["rate"]) - rate) <= unsure for s in result.solutions)


@pytest.mark.parametrize("term", [35.0, 36.0, 59.0])
def test_a_loan_paid_back_in_equal_parts_has_hardly_a_rate(term: float) -> None:
    """The nearest float to debt/term is the payment at a rate of some 1e-18, beside the 0/0."""
    payment = 20000.0 / term
    result = solved(LOAN, {"payment": payment, "debt": 20000.0, "term": term})
    rate = result["rate"]
    assert isinstance(rate, float)
    with mpmath.workdps(120):
        r = mpmath.mpf(rate)
        here, above = (
            20000 * x / (1 - (1 + x) ** -int(term)) - payment for x in (r, r * (1 + 1e-12))
        )
        assert abs(here) <= abs(above - here)


def test_a_small_true_answer_stands() -> None:
    result = solved("x + y = 1 + 1e-13\nx*y = 1e-13", {})
    assert sorted(float(s["x"]) for s in result.solutions) == pytest.approx([1e-13, 1.0], rel=1e-3)


@pytest.mark.parametrize("first", range(0, 60, 10))
def test_everyday_sheets_list_no_false_answer_and_refuse_no_true_one(first: int) -> None:
    told = [line for seed in range(first, first + 10) for line in examine(seed)[1]]
    assert [line for line in told if ": missed" not in line] == []


CHARGING = "tau = R*C\nV = Vs*(1 - exp(-t/tau))\nI = (Vs - V)/R"


@pytest.mark.parametrize(
    ("given", "unknown"),
    [({"Vs": 9.0}, "R"), ({"V": -6.489131190095712}, "Vs"), ({"Vs": 230.0}, "R")],
)
def test_a_current_is_no_quotient_of_rounding_errors(
    given: Mapping[str, float], unknown: str
) -> None:
    """Without resistance exp(-t/tau) is 0, and the voltages differ by nothing but rounding: from
    there Newton's method leaves the domain of the rules."""
    current = 5.3422740636261445e-05
    result = solved(CHARGING, {"C": 1e-5, "t": 0.6, "I": current, **given})
    for answer in result.solutions:
        drop = mpmath.mpf(answer["Vs"]) * mpmath.exp(-0.6 / (mpmath.mpf(answer["R"]) * 1e-5))
        assert float(drop / answer["R"]) == pytest.approx(current, rel=1e-9)
    assert bool(result.solutions) == ("Vs" in given)


def test_angle_of_which_no_digit_means_anything_is_no_answer() -> None:
    """Of 1e99 the sine is known, but for an angle an ulp beside it the sine may be anything."""
    text = (
        "sag = rad*(1 - cos(th/2))\nchord = 2*rad*sin(th/2)\ns = rad*th\nsag = 0.4026586064386497\n"
    )
    result = solver.solve(rulesheets.loads(text + "chord = 0.9808662561216678"))
    assert str(result.status) == "solved"
    assert result["rad"] == pytest.approx(0.5, rel=1e-12)
    assert max(abs(answer["th"]) for answer in result.solutions) < 1e6


def test_answer_at_the_hole_of_a_mean_is_none_however_smooth_the_mean_is_there() -> None:
    """The mean of equal differences is 0/0. Beside that its slopes are harmless, and its digits are
    noise."""
    result = solved("m = (a - b)/ln(a/b)", {"a": 40.0, "m": 40.0})
    assert str(result.status) != "solved"
    result = solved("m = (a - b)/ln(a/b)", {"a": 40.0, "m": 39.0})
    assert (40.0 - result["b"]) / math.log(40.0 / result["b"]) == pytest.approx(39.0, rel=1e-12)


def test_a_double_root_at_exact_numbers_is_no_pole() -> None:
    """Two washings get 1 - (Lu/(Lu + W))^2 of the oil: all of it where there is nothing else, x =
    1."""
    rules = """oil = x*100
Lu = 0.6*(100 - oil)
x1 = oil/(Lu + 80)
u1 = Lu*x1
x2 = u1/(Lu + 80)
e1 = oil - u1
e2 = u1 - Lu*x2
1 = (e1 + e2)/oil"""
    result = solver.solve(rulesheets.loads(rules))
    assert result.status is solver.Status.SINGULAR
    assert result.solutions[0]["x"] == pytest.approx(1.0, abs=1e-6)
