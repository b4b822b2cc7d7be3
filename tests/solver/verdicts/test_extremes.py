"""At its extreme a rule has a double root, alone and in a block, in degrees and in radians."""

from __future__ import annotations

import math

import pytest

import rulesheets
import solver
from solver import Status
from tests.sampling import sampled

EXTREMES = [
    ("3 - 2*(x - 1)^2", 3.0, 1.0),
    ("x^2 - 4*x + 1", -3.0, 2.0),
    ("cos(x)", 1.0, 0.0),
    ("cos(x)", -1.0, math.pi),
    ("1 - cos(x)", 2.0, math.pi),
    ("3*sin(x)", 3.0, math.pi / 2),
    ("1 - cosd(x)", 2.0, 180.0),
    ("9.81*sind(2*x)", 9.81, 45.0),
    ("cosd(x)^2", 0.0, 90.0),
    ("2*cosh(x/2)", 2.0, 0.0),
    ("x^2/(1 + x^2)", 0.0, 0.0),
    ("x + 1/x", 2.0, 1.0),
    ("sqrt(25 - x^2)", 5.0, 0.0),
    ("300/(1 + 0.2*x^2)", 300.0, 0.0),
    ("exp(-x^2)", 1.0, 0.0),
]
ALONE, BLOCK = "y = {}", "w - ({}) = x\nw = x + y"
EVERY = [*((ALONE, *one) for one in EXTREMES), *sampled([(BLOCK, *one) for one in EXTREMES], 2)]


@pytest.mark.parametrize(("sheet", "form", "y", "x"), EVERY)
def test_an_extreme_is_singular(sheet: str, form: str, y: float, x: float) -> None:
    result = solver.solve(rulesheets.loads(sheet.format(form)), {"y": y})
    assert result.status is Status.SINGULAR
    assert any(solution["x"] == pytest.approx(x, abs=1e-9) for solution in result.solutions)


@pytest.mark.parametrize(("form", "y", "x"), EXTREMES)
def test_short_of_it_there_are_pairs(form: str, y: float, x: float) -> None:
    """Both on this side of the extreme, and none on the other."""
    bend = 1e-3 if "d(" not in form else 1.0
    value = solver.solve(rulesheets.loads(ALONE.format(form)), {"x": x + bend})["y"]
    result = solver.solve(rulesheets.loads(ALONE.format(form)), {"y": value})
    assert result.status is Status.SOLVED
    assert len(result.solutions) in (2, 4)
    beyond = solver.solve(rulesheets.loads(ALONE.format(form)), {"y": 2 * y - float(value)})
    assert beyond.status is Status.INFEASIBLE


@pytest.mark.parametrize(
    ("form", "x"), [("x^3", 0.0), ("x*abs(x)", 0.0), ("abs(x - 1)", 1.0), ("x^(2/3)", 0.0)]
)
def test_what_crosses_or_bends_is_one_answer(form: str, x: float) -> None:
    result = solver.solve(rulesheets.loads(ALONE.format(form)), {"y": 0.0})
    assert (result.status, result["x"]) == (Status.SOLVED, x)


def test_a_range_that_holds_several_extremes_lists_them() -> None:
    sheet = "variables\n  x in [0, 720]\n  y\nrules\n  y = cosd(x)"
    result = solver.solve(rulesheets.loads(sheet), {"y": 1.0})
    assert sorted(float(s["x"]) for s in result.solutions) == [0.0, 360.0, 720.0]
    assert result.status is Status.SINGULAR
