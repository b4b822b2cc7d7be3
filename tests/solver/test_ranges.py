"""Ranges that a sheet declares: what lies beyond an end by rounding alone is that end; nothing else
is."""

from __future__ import annotations

import pytest

import rulesheets
import solver

SHEETS = {
    "step": ("x + 0.7 = a", 0.8, 1.0),
    "linear block": ("x + y = a\n  3*x - y = 0.2", 0.2, 1.0),
    "polynomial block": ("x + y = a\n  x*y = 0.12", 1.3, 0.7),
    "search": ("exp(x) + y = a\n  y = x", 1.2051709180756477, 1.6498588075760032),
}
"""Rules, and what makes x the low and the high end of [0.1, 0.3]."""


def solved(rules: str, a: float) -> solver.Result:
    sheet = f"variables\n  x in [0.1, 0.3]\n  y\n  a\nrules\n  {rules}"
    return solver.solve(rulesheets.loads(sheet), {"a": a}, want=["x"])


@pytest.mark.parametrize("name", SHEETS)
@pytest.mark.parametrize("ulps", [-2, -1, 0, 1, 2])
@pytest.mark.parametrize("end", [0, 1])
def test_an_answer_at_the_end_of_a_range_is_found(name: str, ulps: int, end: int) -> None:
    rules, *ends = SHEETS[name]
    result = solved(rules, ends[end] * (1 + ulps * 2.0**-52))
    assert str(result.status) == "solved"
    assert [s["x"] for s in result.solutions] == pytest.approx([(0.1, 0.3)[end]], rel=1e-14)
    assert 0.1 <= result.solutions[0]["x"] <= 0.3


@pytest.mark.parametrize("name", SHEETS)
def test_an_answer_beyond_the_end_is_none(name: str) -> None:
    rules, low, high = SHEETS[name]
    outward = 1e-12 if high > low else -1e-12
    for a in (low * (1 - outward), high * (1 + outward)):
        assert str(solved(rules, a).status) == "infeasible"


def test_an_end_that_is_left_out_stays_out() -> None:
    result = solver.solve(
        rulesheets.loads("variables\n  x > 0\n  a\nrules\n  a = x + 1e3"), {"a": 1e3 - 1e-13}
    )
    assert str(result.status) == "infeasible"


@pytest.mark.parametrize("point", [0, 1])
@pytest.mark.parametrize(
    "rules", ["cos(x - a) - 1 = (x - a)^2", "cos(x - a) - 1 = y^2\n  exp(y) = 1 + x - a"]
)
def test_a_range_of_one_point_that_is_a_multiple_root(rules: str, point: int) -> None:
    sheet = f"variables\n  x in [{point}, {point}]\n  y in [0, 0]\n  a = {point}\nrules\n  {rules}"
    result = solver.solve(rulesheets.loads(sheet), want=["x"])
    assert result.status is solver.Status.SINGULAR
    assert result["x"] == point


WIDE = {
    "crank": ("a b", "3*cosd(a) + 8*cosd(b) = 9.79\n3*sind(a) = 2 + 8*sind(b)"),
    "triangle": (
        "A B C",
        "2*sind(B) = 3*sind(A)\n3^2 = 2^2 + 4^2 - 2*2*4*cosd(B)\nA + B + C = 180",
    ),
    "four bars": ("a b", "2*cos(a) + 3*cos(b) = 4\n2*sin(a) - 3*sin(b) = 0.5"),
    "hyperbola": ("x y", "x^2 + y^2 = 5\nx*y = 2"),
    "equilibrium": ("x y", "x^2/((1 - x - y)*(2 - x)) = 3\ny*(x + y)/(1 - x - y) = 0.2"),
}


@pytest.mark.parametrize("names, rules", WIDE.values(), ids=WIDE)
def test_a_wide_range_loses_no_answer(names: str, rules: str) -> None:
    """Of four bars, ranges of 1e8 have room for 1e15 pairs of whole turns: only some are looked
    at."""
    free = solver.solve(
        rulesheets.loads(f"variables\n{names.replace(' ', chr(10))}\nrules\n{rules}\n")
    )
    ranges = "\n".join(f"{name} in [-1e8, 1e8]" for name in names.split())
    wide = solver.solve(rulesheets.loads(f"variables\n{ranges}\nrules\n{rules}\n"))
    inside = [
        answer for answer in free.solutions if all(abs(float(v)) <= 1e8 for v in answer.values())
    ]
    assert inside
    for answer in inside:
        assert any(dict(other) == pytest.approx(dict(answer), rel=1e-9) for other in wide.solutions)
