"""What records know of their own rounding, against many digits."""

from __future__ import annotations

import math
from pathlib import Path

import mpmath
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import rulesheets
import solver
from rulesheets.evaluate import Undefined
from rulesheets.evaluate.digits import extended
from rulesheets.model import Equation
from solver.accuracy.rule_check import check_rule
from solver.path.planner import planner
from solver.trace.flow import Flow, Numbers
from solver.trace.graph import NotCompilable

MODELS = Path(__file__).parents[3] / "models"
DIGITS = 640
"""Of the oracle: what it rounds in the largest of floats is nothing beside 1e-300."""
FUNCTIONS = st.sampled_from(
    ["sin", "cos", "exp", "sqrt", "atan", "abs", "tanh", "sind", "cosd", "ln"]
)


def expressions(leaves: st.SearchStrategy[str]) -> st.SearchStrategy[str]:
    return st.recursive(
        leaves,
        lambda inside: st.one_of(
            st.builds("({} {} {})".format, inside, st.sampled_from("+-*/"), inside),
            st.builds("{}({})".format, FUNCTIONS, inside),
            st.builds("({})^2".format, inside),
        ),
        max_leaves=6,
    )


def equation(text: str) -> Equation:
    return rulesheets.loads(f"{text}\n").equations[0]


@settings(max_examples=80, deadline=None)
@given(expressions(st.sampled_from(["x", "y"])), st.floats(0.01, 100), st.floats(-9, 9))
def test_the_error_bound_of_an_operation_holds(text: str, x: float, y: float) -> None:
    """Against many digits; bounds are of first order, so where they are small."""
    rule = equation(f"z = {text}")
    flow = Flow()
    numbers = Numbers(flow, {0: x, 1: y})
    try:
        exact = extended(rule.right, {"x": x, "y": y}, DIGITS)
        node = flow.expression(rule.right, {"x": flow.input(0), "y": flow.input(1)})
    except (Undefined, NotCompilable):
        return
    result, error = float(numbers(node)), numbers.error(node)
    if error < 1e-6 * abs(result) < 1e290:
        with mpmath.workdps(DIGITS):
            assert abs(mpmath.mpf(result) - exact) <= 1.01 * error + 1e-300


def test_the_nearest_to_the_guesses_comes_first_from_plans_too() -> None:
    text = "variables\n  a\n  x ~ -3\n  y ~ 5\nrules\n  x*x = a\n  y*y = a\n"
    plan = solver.prepare(rulesheets.loads(text), ["a"], ["x", "y"])
    for a in (4.0, 9.0, 16.0):
        assert plan(a) == (-math.sqrt(a), math.sqrt(a))
        right = solver.solve(rulesheets.loads(text), {"a": a})
        assert plan.all(a) == [(s["x"], s["y"]) for s in right.solutions]
        assert plan.sweep([a] * 20)["x"] == pytest.approx([-math.sqrt(a)] * 20)


def test_a_row_that_lacks_an_input_teaches_nothing() -> None:
    model = rulesheets.loads("x + y = 3\nx - y = 1\n")
    plan = solver.prepare(model, ["y"], ["x"])
    assert plan(math.nan) == plan(1.0) == (2.0,)
    assert planner(model) is not None


@settings(max_examples=25, deadline=None)
@given(
    st.floats(-2, 2).map(lambda power: 10.0**power),
    st.floats(1, 360),
    st.floats(-100, 100),
    st.floats(-100, 100),
)
def test_rules_hold_where_formulas_cancel(size: float, angle: float, x: float, y: float) -> None:
    """A distance and a direction between points that may be near to one another: the sine and the
    cosine that formulas give are then off the unit circle by more than their rounding."""
    model = rulesheets.loads(f"u = {x!r} + d*cosd(p)\nv = {y!r} + d*sind(p)\n")
    plan = solver.prepare(model, ["u", "v"], ["d", "p"])
    for distance in (30.0, size, 25.0, size):
        u, v = (
            centre + distance * turned(math.radians(angle))
            for centre, turned in ((x, math.cos), (y, math.sin))
        )
        if u == x or v == y:
            continue
        for d, p in (plan(u, v), *plan.all(u, v)):
            values = {"u": u, "v": v, "d": d, "p": p}
            assert all(check_rule(rule, values).holds for rule in model.equations), values


YEARS = st.integers(1, 40).map(float)
RATES = st.integers(1, 2000).map(lambda r: r / 1e4)


@settings(max_examples=20, deadline=None)
@given(
    st.lists(st.tuples(RATES, st.sampled_from([1.0, 12.0, 365.0]), YEARS), min_size=2, max_size=6)
)
def test_compound_interest_satisfies_its_rule_however_many_the_periods(
    rows: list[tuple[float, float, float]],
) -> None:
    """The rounding of 1 + r/n counts n*t times in a power, and a rule does not admit that."""
    model = rulesheets.loads("A = 2500*(1 + r/n)^(n*t)\n")
    plan = solver.prepare(model, ["r", "n", "t"], ["A"])
    called = [plan(*row)[0] for row in rows]
    swept = plan.sweep(*map(list, zip(*rows, strict=True)))["A"]
    for (r, n, t), *found in zip(rows, called, swept, strict=True):
        for amount in map(float, found):
            values = {"r": r, "n": n, "t": t, "A": amount}
            assert check_rule(model.equations[0], values).holds
            with mpmath.workdps(30):
                exact = 2500 * (1 + mpmath.mpf(r) / n) ** mpmath.mpf(n * t)
                slopes = 1 + 2 * r * t  # by A, by r and by t, as shares of A
                assert abs(mpmath.mpf(amount) / exact - 1) < 64 * 2.0**-52 * slopes


@pytest.mark.parametrize("x, n", [(-3.0, 3.0), (-1.0, 3.0), (1e-9, 1e9), (-1e-9, 1e9), (7.0, 0.5)])
def test_a_power_beside_one_for_any_base(x: float, n: float) -> None:
    model = rulesheets.loads("A = (1 + x)^n\n")
    for first in (0.01, -3.0):
        plan = solver.prepare(model, ["x", "n"], ["A"])
        plan(first, 100.0)
        for _ in range(2):
            assert math.isclose(plan(x, n)[0], solver.solve(model, {"x": x, "n": n})["A"])


def test_a_rule_that_floats_cannot_decide_is_left_to_a_solve() -> None:
    """k/(1 + k) is so near to 1 that its last place is 2e-14 of what the rule says of k."""
    text = (
        "k = a*exp(-d/8.314*(1/t - 1/360))\n0.9990485 = sqrt(k/(1 + k))\n35876.17 = 8.314*t*ln(k)\n"
    )
    model = rulesheets.loads(text)
    plan = solver.prepare(model, ["a"])
    rows = [0.4, 0.41, 0.43]
    swept = plan.sweep(rows)
    for place, a in enumerate(rows):
        for found in (plan(a), [swept[name][place] for name in plan.want]):
            values = {"a": a, **dict(zip(plan.want, map(float, found), strict=True))}
            assert all(check_rule(rule, values).holds for rule in model.equations)


NEARLY = {
    "d = acosd(R/(R + h))": {"R": 6371e3, "h": 1.7},
    "cosd(d) = R/(R + h)": {"R": 6371e3, "h": 1.7},
    "v = c*sqrt(1 - 1/(1 + K/m)^2)": {"c": 3e8, "K": 1e-3, "m": 938.0},
    "E = sqrt(p^2 + m^2) - m": {"p": 1e-3, "m": 938.0},
    "h = R - sqrt(R^2 - s^2)": {"R": 6371e3, "s": 100.0},
    "y = sqrt(x + 1) - sqrt(x)": {"x": 1e8},
    "y = 1 - cosd(x)": {"x": 0.01},
    "y = ln(1 + x)/x - 1 + x/2": {"x": 1e-3},
}
"""Rules whose terms cancel, or whose function is steep, at these numbers."""


@pytest.mark.parametrize("rule", NEARLY)
def test_rules_hold_where_they_lose_digits(rule: str) -> None:
    """A solve takes more digits here than floats have; so must what a record gives for it."""
    model, known = rulesheets.loads(rule), NEARLY[rule]
    (wanted,) = (name for name in model.variables if name not in known)
    plan = solver.prepare(model, known, [wanted])
    rows = [[v * (1.0 + 0.003 * k) for v in known.values()] for k in range(5)]
    swept = plan.sweep(*map(list, zip(*rows, strict=True)))[wanted]
    for row, found in zip(rows, swept, strict=True):
        for value in (float(found), plan(*row)[0]):
            values = {**dict(zip(known, row, strict=True)), wanted: value}
            assert check_rule(model.equations[0], values).holds, values


@pytest.mark.parametrize(
    ("rule", "first", "then"),
    [
        ("A = 2500*(1 + r/n)^(n*t)", (0.05, 1.0, 1.0), (0.05, 365.0, 30.0)),
        ("d = acosd(R/(R + h))", (6371e3, 2e6), (6371e3, 1.7)),
        ("E = sqrt(p^2 + m^2) - m", (900.0, 938.0), (1.0, 938.0)),
        ("y = 1 - cosd(x)", (80.0,), (0.01,)),
        ("c = sqrt(a^2 + b^2 - 2*a*b*cosd(t))", (3.0, 4.0, 60.0), (101.17, 101.15, 1e-3)),
    ],
)
def test_rules_hold_in_rows_that_lose_digits_after_one_that_does_not(
    rule: str, first: tuple[float, ...], then: tuple[float, ...]
) -> None:
    model = rulesheets.loads(rule)
    wanted, *known = sorted(model.variables, key=lambda name: not rule.startswith(name))
    known = [name for name in model.variables if name in known]
    plan = solver.prepare(model, known, [wanted])
    plan(*first)
    for share in (1.0, 1.003, 0.98, 1.05):
        row = [share * v for v in then]
        values = {**dict(zip(known, row, strict=True)), wanted: plan(*row)[0]}
        assert check_rule(model.equations[0], values).holds, values


BACKWARD = {
    "A = P*(1 + r/8760)^(8760*t)": ({"P": 1000.0, "t": 10.0}, "A", "r", 0.05),
    "pay = P*(r/1200)/(1 - (1 + r/1200)^(-n))": ({"P": 2.5e5, "n": 360.0}, "pay", "r", 4.5),
    "K = S*(1 + i)^n + m*((1 + i)^n - 1)/i": (
        {"S": 2e4, "m": 450.0, "n": 360.0},
        "K",
        "i",
        0.004,
    ),
    "dip = acosd(R/(R + h))": ({"h": 2.0}, "dip", "R", 6.4e6),
    "s = R - sqrt(R^2 - c^2)": ({"c": 1.0}, "s", "R", 50.0),
    "s = a*(cosh(L/(2*a)) - 1)": ({"L": 20.0}, "s", "a", 500.0),
    "q = V*(exp(t/tau) - 1)": ({"V": 10.0, "t": 1e-4}, "q", "tau", 5.0),
    "s = R*(1 - cosd(asind(c/R)))": ({"c": 1.0}, "s", "R", 500.0),
}
"""Rules that lose digits of an unknown: other inputs, what is given, what is wanted, and its number
somewhere."""


@pytest.mark.parametrize("rule", BACKWARD)
@settings(max_examples=2, deadline=None)
@given(st.lists(st.floats(0.7, 1.4), min_size=2, max_size=4))
def test_what_a_rule_loses_digits_of_is_found_to_the_digits_that_it_admits(
    rule: str, shares: list[float]
) -> None:
    others, known, wanted, somewhere = BACKWARD[rule]
    model = rulesheets.loads(rule)
    plan = solver.prepare(model, [known], [wanted], others)
    numbers = [
        solver.solve(model, {**others, wanted: share * somewhere})[known] for share in shares
    ]
    swept = plan.sweep([*numbers])[wanted]
    for number, row in zip(numbers, swept, strict=True):
        every = solver.solve(model, {**others, known: number}).solutions
        for found in (plan(number), *plan.all(number), (row,)):
            values = {**others, known: number, wanted: float(found[0])}
            assert check_rule(model.equations[0], values).holds
            assert any(math.isclose(found[0], one[wanted], rel_tol=1e-9) for one in every)


@settings(max_examples=15, deadline=None)
@given(st.integers(40, 150), st.integers(40, 150), st.floats(0.05, 0.95), st.floats(-0.05, 0.05))
def test_both_sides_of_a_triangle_beside_a_flat_one(
    a: int, b: int, share: float, moved: float
) -> None:
    """... by two sides and an angle, though the law of cosines leaves few digits of a short one."""
    model = rulesheets.load(MODELS / "triangle" / "model.tk")
    widest = math.degrees(math.asin(min(a / b, 1.0)))
    plan = solver.prepare(model, ["A"], ["c"], {"a": a / 10, "b": b / 10, "c": None})
    for angle in (share * widest, share * widest * (1.0 + moved)):
        height = b * math.sin(math.radians(angle)) / 10
        along, half = b * math.cos(math.radians(angle)) / 10, math.sqrt((a / 10) ** 2 - height**2)
        sides = [side for side in (along - half, along + half) if side > 1e-9]
        assert sorted(row[0] for row in plan.all(angle)) == pytest.approx(sides, rel=1e-9)
