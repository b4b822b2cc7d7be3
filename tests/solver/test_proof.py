"""Proofs: radii that hold the exact answer, and none where there is nothing to prove."""

from __future__ import annotations

import sys
from fractions import Fraction
from pathlib import Path
from typing import Any

import mpmath
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

pytest.importorskip("flint")

import rulesheets
import solver
from benchmarks.interval_systems import SYSTEMS, IntervalSystem, economics, more_cosnard, yamamura
from rulesheets.diagnosis import RuleSheetError
from rulesheets.evaluate import Undefined
from rulesheets.evaluate.balls import FUNCTIONS, around, ball, precision, whole_power
from rulesheets.evaluate.digits import Digits, context, extended
from solver.__main__ import main
from tests.oracles import slider_crank as oracle
from tests.oracles.slider_crank import Crank
from tests.sampling import sampled

MODELS = Path(__file__).parent.parent.parent / "models"
PAPER = Crank(3.0, 8.0, 2.0, -15.0, -10.0, -30.0)
QUANTITIES = ("xB", "vB", "omegaAB", "aB", "alphaAB")


def proved(text: str, **options: Any) -> Any:
    return solver.solve(rulesheets.loads(text), prove=True, **options)


def assert_proved(result: Any, count: int) -> None:
    assert str(result.status) == "solved"
    assert len(result.solutions) == count
    assert result.complete
    for solution in result.solutions:
        assert solution.proof.proved, solution.proof.obstacle
        assert solution.proof.nearest


@pytest.mark.parametrize("name", ["offset_slider_crank", "offset_slider_crank_slope_free"])
def test_the_crank_in_both_modes(name: str) -> None:
    model = rulesheets.load(MODELS / name / "model.tk")
    forward = solver.solve(model, prove=True)
    assert_proved(forward, 1)
    exact = oracle.forward(PAPER)
    for quantity in QUANTITIES:
        solution = forward.solutions[0]
        assert solution[quantity] == float(exact[quantity])
        assert abs(solution[quantity] - exact[quantity]) <= solution.radius[quantity] <= 1e-13
    driven = solver.solve(model, {"xB": 9.79, "thetaAO": None}, prove=True)
    assert_proved(driven, 2)
    angles = [float(angle) for angle in oracle.crank_angles(3.0, 8.0, 2.0, 9.79)]
    assert sorted(solution["thetaAO"] for solution in driven.solutions) == angles


@pytest.mark.parametrize("angle", [0.0, 90.0, 180.0, 270.0])
def test_the_crank_where_the_rod_rests(angle: float) -> None:
    """The rod's velocity is a square root of exactly 0 there."""
    result = solver.solve(
        rulesheets.load(MODELS / "offset_slider_crank/model.tk"), {"thetaAO": angle}, prove=True
    )
    assert_proved(result, 1)
    exact = oracle.forward(Crank(3.0, 8.0, 2.0, -15.0, -10.0, angle))
    for quantity in QUANTITIES:
        assert result[quantity] == float(exact[quantity])


def test_the_crank_a_hair_before_dead_centre() -> None:
    model = rulesheets.load(MODELS / "offset_slider_crank" / "model.tk")
    given = {"xB": 11 * (1 - 1e-14), "offset": 0.0, "vB": -4.0, "aB": -70.0}
    result = solver.solve(
        model, {**given, "thetaAO": None, "omegaAO": None, "alphaAO": None}, prove=True
    )
    assert_proved(result, 2)
    angles = [float(angle) for angle in oracle.crank_angles(3.0, 8.0, 0.0, given["xB"])]
    assert sorted(solution["thetaAO"] for solution in result.solutions) == angles


@pytest.mark.parametrize(
    "name", ["four_link_chain", "rigid_link_chain", "whitworth_quick_return", "kepler"]
)
def test_linkages(name: str) -> None:
    result = solver.solve(rulesheets.load(MODELS / name / "model.tk"), prove=True)
    assert str(result.status) == "solved"
    assert all(solution.proof.proved for solution in result.solutions)


@pytest.mark.parametrize(
    ("rules", "count"),
    [
        ("3*x^3 - 200*x^2 - x - 1 = 0", 1),
        ("-13 + x + ((5 - y)*y - 2)*y = 0\n-29 + x + ((y + 1)*y - 14)*y = 0", 1),
        ("10000*x*y = 1\nexp(-x) + exp(-y) = 1.0001", 2),
        (f"x^2 + y^2 = 1\n(x - {2 * (1 - 1e-14)!r})^2 + y^2 = 1", 2),
        ("x^2 + y^2 = 1\n(x - 1)^2 + y^2 = 1", 2),
    ],
    ids=["cubic", "Freudenstein-Roth", "Powell badly scaled", "circles nearly touching", "circles"],
)
def test_known_numbers_of_roots(rules: str, count: int) -> None:
    assert_proved(proved(rules), count)


def test_the_root_of_the_cubic_lies_within_its_radius() -> None:
    solution = proved("3*x^3 - 200*x^2 - x - 1 = 0").solutions[0]
    with mpmath.workdps(60):
        exact = mpmath.findroot(lambda x: 3 * x**3 - 200 * x**2 - x - 1, 66.67)
    assert abs(solution["x"] - exact) <= solution.radius["x"] <= 1e-14


def test_a_double_root_is_not_proved() -> None:
    result = proved("x^2 + y^2 = 1\n(x - 2)^2 + y^2 = 1")
    assert str(result.status) == "singular"
    assert not any(solution.proof.proved for solution in result.solutions)


@settings(max_examples=30, deadline=None)
@given(
    st.lists(st.integers(-20, 20), min_size=9, max_size=9),
    st.lists(st.integers(-9, 9), min_size=3, max_size=3),
)
def test_linear_systems_against_fractions(entries: list[int], rhs: list[int]) -> None:
    rows = [entries[i : i + 3] for i in (0, 3, 6)]
    (a, b, c), (d, e, f), (g, h, k) = rows
    determinant = a * (e * k - f * h) - b * (d * k - f * g) + c * (d * h - e * g)
    if determinant == 0:
        return
    text = "\n".join(f"{p}*x + {q}*y + {r}*z = {s}" for (p, q, r), s in zip(rows, rhs, strict=True))
    solution = proved(text).solutions[0]
    exact = Fraction(
        rhs[0] * (e * k - f * h) - b * (rhs[1] * k - f * rhs[2]) + c * (rhs[1] * h - e * rhs[2])
    )
    x = exact / determinant
    assert solution.proof.proved
    assert abs(Fraction(solution["x"]) - x) <= Fraction(solution.radius.get("x", 0.0))
    assert solution["x"] == float(x)


ONE_ARGUMENT = sorted(
    name
    for name in FUNCTIONS
    if name not in {"pi", "e", "atan2", "atan2d", "mod", "step", "min", "max", "beta", "jn", "yn"}
)


@pytest.mark.parametrize("name", ONE_ARGUMENT)
@settings(max_examples=12, deadline=None)
@given(st.floats(-30.0, 30.0))
def test_balls_hold_the_value_of_every_function(name: str, x: float) -> None:
    try:
        exact = Digits({}, 60).functions[name](context(60).mpf(x))
    except (ValueError, ZeroDivisionError, OverflowError):
        return
    with precision(250):
        found = FUNCTIONS[name](ball(x))
        if found.is_finite():
            assert abs(found - ball(exact)) < 1e-40 * (1 + abs(ball(exact)))


@given(st.integers(1, 9), st.floats(-4, 4), st.floats(0, 3), st.floats(-1, 1))
def test_a_ball_around_zero_has_powers(
    exponent: int, middle: float, radius: float, part: float
) -> None:
    with precision(100):
        for centre in (middle, 0.0):
            base = around(ball(centre), radius)
            inside = centre + radius * part
            assert not base.contains(ball(inside)) or whole_power(base, exponent).overlaps(
                ball(inside) ** exponent
            )


def test_a_root_with_a_zero_is_proved() -> None:
    """The cube roots of one."""
    roots = proved("x^3 - 3*x*y^2 = 1\n3*x^2*y - y^3 = 0").solutions
    assert len(roots) == 3
    assert all(root.proof.nearest for root in roots)
    (one,) = (root for root in roots if root["y"] == 0.0)
    assert one.radius == {"x": 0.0, "y": 0.0}


def test_balls_refuse_what_is_undefined() -> None:
    from rulesheets.evaluate.balls import enclosing_ball
    from rulesheets.syntax.nodes import Call, Name, Number, Quotient

    for expression in (
        Call("sqrt", (Name("x"),)),
        Quotient(Number(1.0), Name("x")),
        Call("ln", (Name("x"),)),
    ):
        with precision(100), pytest.raises(Undefined):
            enclosing_ball(expression, {"x": ball(-1).union(ball(1))})


def test_the_command_tells_what_is_proved(capsys: pytest.CaptureFixture[str]) -> None:
    assert (
        main(["solve", "offset_slider_crank", "--clear", "thetaAO", "--set", "xB=9.79", "--prove"])
        == 0
    )
    out = capsys.readouterr().out
    assert "proved: 2 answers, every number the float nearest to the exact one" in out
    assert "proved: there are no others" in out


def test_without_the_extra_it_says_how_to_get_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "flint", None)
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    with pytest.raises(RuleSheetError) as caught:
        proved("x = 1")
    assert "pip install 'backsolve[proof]'" in caught.value.diagnoses[0].notes


def test_extended_values_agree_with_balls() -> None:
    from rulesheets.evaluate.balls import enclosing_ball

    equation = rulesheets.loads("y = sind(x)^2/3 + exp(-x/7) - ln(x)*atan2d(x, 2)").equations[0]
    with precision(200):
        held = enclosing_ball(equation.right, {"x": ball(1.7)})
        assert abs(held - ball(extended(equation.right, {"x": 1.7}, 50))) < 1e-45


@pytest.mark.parametrize(
    "system",
    sampled([*SYSTEMS, more_cosnard(12), yamamura(5), economics(6)], 2),
    ids=lambda system: system.name,
)
def test_classic_systems_have_their_roots_and_no_others(system: IntervalSystem) -> None:
    assert_proved(proved(system.sheet), system.roots)


def test_powers_of_numbers_that_may_be_zero_are_enclosed() -> None:
    """x = 0 in a cubic and in its slope; the ball around it holds both signs."""
    assert_proved(
        proved("variables\n x in [-1, 1]\n y in [0, 9]\nrules\n x^3*y + x = 0\n y^2 + x^2*y = 4"), 1
    )


def test_an_empty_range_is_proved_empty() -> None:
    text = "variables\n x in [3, 10]\n y in [3, 10]\nrules\n x^2 + y = 11\n x + y^2 = 7"
    assert str(proved(text).status) == "infeasible"
