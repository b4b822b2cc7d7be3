"""Quotients that are 0/0 at a point: searched with proof all the same."""

from __future__ import annotations

import math
from pathlib import Path

import mpmath
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import brentq

import rulesheets
import solver
from rulesheets.evaluate import Undefined, value
from solver.kernel.emitter import IntervalEmitter

LOAN = rulesheets.load(str(Path(__file__).parents[3] / "models" / "loan" / "model.tk"))
RATES = solver.prepare(LOAN, ["payment", "term"], ["rate"])
BERNOULLI = solver.prepare(
    rulesheets.loads("variables\n  a = 0.5\n  x in [-8, 8]\nrules\n  x/(exp(x) - 1) = a\n"),
    ["a"],
    ["x"],
)
SINC = solver.prepare(
    rulesheets.loads("variables\n  a = 0.5\n  x in [-10, 10]\nrules\n  sin(x)/x = a\n"),
    ["a"],
    ["x"],
)


@settings(max_examples=15, deadline=None)
@given(st.floats(0.0005, 0.03), st.integers(6, 120))
def test_a_loan_has_one_rate_and_it_is_proven(rate: float, term: int) -> None:
    payment = 12000.0 * rate / -mpmath.expm1(-term * mpmath.log1p(rate))
    verdict, found = RATES.judged((float(payment), float(term)))
    (leaf,) = verdict.leaves
    assert str(verdict.status) == "solved" and found.complete
    with mpmath.workdps(40):
        exact = mpmath.findroot(
            lambda r: float(payment) * -mpmath.expm1(-term * mpmath.log1p(r)) - 12000 * r,
            (rate, 1.001 * rate),
        )
    assert leaf.branch.values["rate"] == pytest.approx(float(exact), rel=1e-12)


def test_a_payment_that_never_pays_a_loan_back_is_proven_to_have_no_rate() -> None:
    """At no interest 36 payments of 333.33 are due."""
    verdict, found = RATES.judged((333.0, 36.0))
    assert str(verdict.status) == "infeasible" and found.complete


@settings(max_examples=15, deadline=None)
@given(st.floats(0.01, 7.5).filter(lambda a: abs(a - 1.0) > 1e-6))
def test_a_quotient_that_falls_through_its_gap_has_one_answer(a: float) -> None:
    """x/(exp(x) - 1) falls from 8 to 0; at x = 0 it is 0/0, its limit 1 on either side."""
    verdict, found = BERNOULLI.judged((a,))
    if a < 8 / math.expm1(8):
        return
    ends = (-8.0, -1e-12) if a > 1 else (1e-12, 8.0)
    exact = brentq(lambda x: x / math.expm1(x) - a, *ends, xtol=1e-14)
    (leaf,) = verdict.leaves
    assert str(verdict.status) == "solved"
    assert found.complete or abs(a - 1.0) < 1e-3  # a hair from the gap floats cannot tell
    assert leaf.branch.values["x"] == pytest.approx(exact, rel=1e-9)


@pytest.mark.parametrize(
    ("a", "answers"), [(0.5, 2), (-0.1, 4), (0.0, 6), (0.12, 6), (-0.3, 0), (1.5, 0)]
)
def test_every_answer_on_either_side_of_a_gap_is_counted(a: float, answers: int) -> None:
    """sin(x)/x on [-10, 10]: one arch, and ripples of 0.128 at 7.7 and of -0.217 at 4.5 on either
    side."""
    verdict, found = SINC.judged((a,))
    assert len(verdict.leaves if str(verdict.status) == "solved" else ()) == answers
    assert found.complete


GEOMETRIC = rulesheets.loads(
    "variables\n  a = 2\n  n = 10\n  r > 0\nrules\n  S = a*(1 - r^n)/(1 - r)\n"
)


@settings(max_examples=15, deadline=None)
@given(st.floats(3.0, 500.0).filter(lambda S: abs(S - 20.0) > 1e-3))
def test_a_geometric_series_has_one_ratio_beside_its_gap(S: float) -> None:
    """At r = 1, where S would be 20, its sum by formula is 0/0."""
    result = solver.solve(GEOMETRIC, {"S": S})
    exact = brentq(lambda r: 2.0 * sum(r**k for k in range(10)) - S, 1e-3, 5.0, xtol=1e-14)
    (solution,) = result.solutions
    assert result.complete
    assert solution["r"] == pytest.approx(exact, rel=1e-9)


EXCHANGER = rulesheets.loads(
    "rules\n  Q = Ch*(Thi - Tho)\n  Q = Cc*(Tco - Tci)\n  dT1 = Thi - Tco\n  dT2 = Tho - Tci\n"
    "  LMTD = (dT1 - dT2)/ln(dT1/dT2)\n  Q = UA*LMTD\n"
)


@settings(max_examples=15, deadline=None)
@given(st.floats(0.3, 3.0).filter(lambda ratio: abs(ratio - 1.0) > 1e-3), st.floats(0.2, 3.0))
def test_a_flow_through_an_exchanger_is_the_only_one(ratio: float, units: float) -> None:
    """Between equal differences of temperature their mean is 0/0. Effectiveness: Kays and London,
    1984."""
    hot, cold = 4000.0, 4000.0 / ratio
    least, share = min(hot, cold), min(hot, cold) / max(hot, cold)
    fade = math.exp(-units * (1.0 - share))
    heat = least * 130.0 * (1.0 - fade) / (1.0 - share * fade)
    given = {"Thi": 420.0, "Tci": 290.0, "Cc": cold, "UA": units * least}
    result = solver.solve(EXCHANGER, {**given, "Tho": 420.0 - heat / hot})
    (solution,) = result.solutions
    assert result.complete
    assert solution["Ch"] == pytest.approx(hot, rel=1e-6)
    result = solver.solve(EXCHANGER, {**given, "Ch": hot})  # temperatures that may be anything
    (solution,) = result.solutions
    assert result.complete
    assert solution["Q"] == pytest.approx(heat, rel=1e-9)


DIFFERENCES = (
    "(u - v)/ln(u/v)",
    "a*(u - v)/(ln(u) - ln(v))",
    "(u^3 - v^3)/(u - v)",
    "(1/u - 1/v)/(u - v)",
    "(sqrt(u) - sqrt(v))/(u - v)",
    "(exp(u) - exp(v))/(u^0.7 - v^0.7)",
    "(tan(u) - tan(v))/(v - u)",
    "((u^2 - 1)^1.5 - (v^2 - 1)^1.5)/(u - v)",
    "(abs(u) - abs(v))/(u - v)",
    "(sin(u) - sin(v))/(atan(u) - atan(v))",
    "u^v/a^v",
    "a^u/(v^u + a^u)",
)


@settings(max_examples=300, deadline=None)
@given(
    st.sampled_from(DIFFERENCES),
    *[st.floats(-4.0, 4.0).map(lambda x: round(x, 3))] * 2,
    *[st.floats(0.0, 3.0)] * 2,
    *[st.floats(0.0, 1.0)] * 2,
)
def test_bounds_of_a_quotient_of_differences_hold_at_every_point(
    text: str, u: float, v: float, wide: float, high: float, along: float, across: float
) -> None:
    """A logarithmic mean is bounded by those of its ends, others as any quotient."""
    expression = rulesheets.loads(f"variables\n  a = 1.5\nrules\n  y = {text}\n").equations[0].right
    emitter = IntervalEmitter(("u", "v"), ("a",))
    low, top = emitter.function(emitter.of(expression))(1.5)(u, u + wide, v, v + high)
    try:
        at = value(expression, {"a": 1.5, "u": u + along * wide, "v": v + across * high})
    except (Undefined, ZeroDivisionError):
        return
    slack = 1e-6 * abs(at) + 1e-9  # of the floats that it is evaluated in
    assert not (math.isnan(low) and math.isnan(top))
    assert low - slack <= at <= top + slack


@settings(max_examples=30, deadline=None)
@given(st.floats(20.0, 80.0), st.floats(0.9, 1.1), st.sampled_from(["dT1", "Thi", "Tci"]))
def test_a_mean_difference_of_temperature_has_one_answer(
    dT2: float, ratio: float, unknown: str
) -> None:
    """Asked backward between fixed differences, and where they may be equal."""
    dT1 = round(dT2 * ratio, 6) + 1e-6
    text = "rules\n  dT1 = Thi - Tco\n  dT2 = Tho - Tci\n  LM = (dT1 - dT2)/ln(dT1/dT2)\n"
    known = {"Thi": 60.0 + dT1, "Tco": 60.0, "Tho": 20.0 + dT2, "Tci": 20.0}
    mean = mpmath.mpf(dT1 - dT2) / mpmath.log(mpmath.mpf(dT1) / mpmath.mpf(dT2))
    given = {**known, "LM": float(mean), unknown: None}
    result = solver.solve(rulesheets.loads(text), {n: v for n, v in given.items() if v is not None})
    assert str(result.status) == "solved" and len(result.solutions) == 1
    assert result.complete or abs(dT1 / dT2 - 1.0) < 1e-4


@pytest.mark.parametrize(("n", "C"), [(1.5, 2.5), (3.0, 0.7), (-0.4, 11.0)])
def test_an_exponent_that_a_quotient_of_powers_gives_is_the_only_one(n: float, C: float) -> None:
    """Hill's equation: C^n/(K^n + C^n) rises or falls with n, and tends to 0 and 1."""
    model = rulesheets.loads("rules\n  E = 100*C^n/(K^n + C^n)\n")
    E = 100 * C**n / (2**n + C**n)
    result = solver.solve(model, {"C": C, "K": 2.0, "E": E})
    assert [answer["n"] for answer in result.solutions] == pytest.approx([n], rel=1e-12)
    assert result.complete


def test_what_a_product_with_zero_leaves_open_divides_as_any_number() -> None:
    """m2*m1 = 0 holds for any m2 where m1 = 0, so that a/m2 is not a*m1/0."""
    rules = "m1 = s^2 - 4\nm2*m1 = c\np = a/m2\np + exp(s) + m1 = 9"
    result = solver.solve(rulesheets.loads(rules), {"c": 0.0, "a": 6.0})
    found = sorted(answer["s"] for answer in result.solutions)
    assert found == pytest.approx([-2.0, 2.0], rel=1e-12)
