"""Rules that are inequalities: asked of answers, wherever answers come from."""

from __future__ import annotations

import math

import numpy
import pytest

import rulesheets
import solver
from rulesheets.format import format_sheet
from rulesheets.parse.sections import parse
from rulesheets.syntax import Source


def solve(text: str, **inputs: float) -> solver.Result:
    return solver.solve(rulesheets.loads(text), inputs)


def values(result: solver.Result, name: str) -> list[object]:
    return [solution[name] for solution in result.solutions]


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("x^2 = 9\nx > 0", [3.0]),
        ("x^2 = 9\n0 >= x", [-3.0]),
        ("x^2 = 9\nx >= 3", [3.0]),
        ("x^2 = 9\nx <> 3", [-3.0]),
        ("x^2 = 9\nx ≠ -3", [3.0]),
        ("x^2 = 9\n-4 < x ≤ 2 < 5", [-3.0]),
        ("x^2 = 9\nif x > 0 then x < 2", [-3.0]),
        ("c = 1\nx^2 = 9\nif c = 1 then x < 0 else x > 0", [-3.0]),
        ("call f(9; x)\nfunction f(a; x)\nrules\n x^2 = a\n x > 0", [3.0]),
        ("variables\n L = 8\n x in [0, L/2]\nrules\n x^2 = 9", [3.0]),
        ("variables\n L = 2\n x < -L\nrules\n x^2 = 9", [-3.0]),
        ("x^3 - 6*x^2 + 11*x = 6\nx + 1 > 2\n x^2 < 8", [2.0]),
        ("kind = 'tall\nx^2 = 9\nkind <> 'tall", []),
    ],
)
def test_answers_that_break_a_requirement_are_not_listed(text: str, expected: list[float]) -> None:
    result = solve(text)
    assert values(result, "x") == pytest.approx(expected)
    assert str(result.status) == ("solved" if expected else "infeasible")
    assert result.complete


def test_a_requirement_without_an_answer_is_named_with_what_it_lacks() -> None:
    result = solve("D^2 = 9\nD > d", d=4.0)
    assert (str(result.status), result.solutions) == ("infeasible", ())
    (diagnosis,) = result.diagnoses
    assert (diagnosis.code, diagnosis.variables) == ("S535", ("D", "d"))
    assert diagnosis.labels[0].span.text == "D > d"
    assert "missed by 1" in diagnosis.message


def test_inputs_alone_can_break_a_requirement() -> None:
    result = solve("c = a + b\na > b", a=1.0, b=2.5)
    assert str(result.status) == "infeasible"
    assert (
        "a = 1 and b = 2.5 do not meet this requirement: it is missed by 1.5"
        in result.diagnoses[0].message
    )


def test_equal_sides_are_not_called_a_miss_of_nothing() -> None:
    (diagnosis,) = solve("D^2 = 9\nD > d", d=3.0).diagnoses
    assert diagnosis.message == "no answer meets this requirement: its sides are equal"


def test_only_what_is_proven_is_infeasible() -> None:
    text = "exp(x) + sin(y) = 4\nx*y + cos(x + y) = 2\nx + y > 1000"
    result = solve(text)
    assert str(result.status) == ("infeasible" if result.complete else "failed")
    assert not result.solutions


@pytest.mark.parametrize(
    ("relation", "holds"), [("<", False), ("<=", True), (">", False), (">=", True), ("<>", False)]
)
def test_equal_within_the_comparison_tolerance(relation: str, holds: bool) -> None:
    result = solve(f"x = 0.1 + 0.2\nx {relation} 0.3")
    assert (str(result.status) == "solved") is holds


def test_a_requirement_is_met_by_the_exact_value_not_by_the_rounded_one() -> None:
    """x - 1e9 in floats is off by more than the tolerance; the answer of the rules is 0.1 exactly
    enough."""
    assert str(solve("x = 1e9 + 0.5\ny = x - 1e9\ny >= 0.5").status) == "solved"


def test_a_requirement_tells_where_to_search() -> None:
    result = solve("sind(t) = 0.5\nt > 360")
    assert result.solutions
    assert all(
        math.isclose(math.sin(math.radians(t)), 0.5) and t > 360 for t in values(result, "t")
    )


@pytest.mark.parametrize(
    ("rules", "complete"),
    [
        ("phi >= 0\nphi <= 90\np = -phi", True),
        ("phi >= 0\nphi <= 180\np = 180 - phi", True),
        ("phi >= 0\np = -phi", False),  # phi = 413.1, too
        ("p >= 0\np <= 400\np = -phi", False),
    ],
)
def test_an_angle_that_a_sum_gives_has_no_turns_of_its_own(rules: str, complete: bool) -> None:
    result = solve(f"0.6 = cosd(phi)\n{rules}\nx = 3*cosd(p)")
    assert str(result.status) == "solved" and result.complete is complete


def test_plans_and_sweeps_leave_out_the_same_answers() -> None:
    sheet = rulesheets.loads("D*D = d\nif d > 20 then D < 0 else D > 1.5")
    plan = solver.prepare(sheet, ["d"])
    numbers = numpy.array([1.0, 4.0, 9.0, 16.0, 25.0, 36.0])
    swept = plan.sweep(numbers)
    for number, column, status in zip(numbers, swept["D"], swept.status, strict=True):
        expected = values(solver.solve(sheet, {"d": float(number)}), "D")
        assert bool(status == 0) is bool(expected)
        assert [column] == pytest.approx(expected) if expected else math.isnan(column)
    assert plan(9.0) == (3.0,)
    assert plan.all(25.0) == [(-5.0,)]
    with pytest.raises(solver.Unsolved, match="requirement"):
        plan(1.0)


def test_repeated_solves_keep_to_requirements() -> None:
    sheet = rulesheets.loads("D*D = d\nD > 1.5")
    for number in (4.0, 9.0, 16.0, 25.0, 1.0):
        assert values(solver.solve(sheet, {"d": number}), "D") == (
            [math.sqrt(number)] if number > 1.5 else []
        )


def test_requirements_of_what_takes_a_search_are_not_asked() -> None:
    sheet = rulesheets.loads("y = 2*x\nz^2 = x + 8\nz > 5")
    assert solver.solve(sheet, {"x": 1.0}, want=["y"])["y"] == 2.0
    assert str(solver.solve(sheet, {"x": 1.0}).status) == "infeasible"


def test_requirements_are_formatted_as_they_are_read() -> None:
    rows = "variables\n  L\n  x in [0, L/2]\n  y > L, < 9\n"
    text = f"{rows}\nrules\n  0 < x <= y < 2*L\n  if x > 1 then y <> x else y > 3\n"
    assert format_sheet(parse(Source("sheet.tk", text))) == text


@pytest.mark.parametrize(
    ("text", "status"),
    [
        ("x = 2*a\ny = a - 3\ny > 0", "infeasible"),
        ("x = 2*a\ny = a - 3\nz = y^2\nz > 0\nz < 5", "solved"),
        ("x = 2*a\ny = a - 3\nz = x + y\nz > 5", "infeasible"),
    ],
)
def test_requirements_on_what_is_not_wanted_are_asked(text: str, status: str) -> None:
    model = rulesheets.loads(text)
    assert str(solver.solve(model, {"a": 1.0}, want=["x"]).status) == status
    assert str(solver.solve(model, {"a": 1.0}).status) == status
    prepared = solver.prepare(model, {"a": 1.0}, ["x"])
    if status == "solved":
        assert prepared(1.0) == (2.0,)
    else:
        with pytest.raises(solver.Unsolved):
            prepared(1.0)
