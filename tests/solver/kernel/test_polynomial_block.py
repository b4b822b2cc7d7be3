"""Blocks that lead to one polynomial: every answer, and none where exact counting says so."""

from __future__ import annotations

import random

import pytest

import rulesheets
import solver
from solver.attempts import Method


def solved(sheet: str, **inputs: float) -> solver.Result:
    return solver.solve(rulesheets.loads(sheet), inputs)


def methods(result: solver.Result) -> list[Method]:
    return [attempt.method for attempts in result.attempts.values() for attempt in attempts]


CUBIC = "y = x^3 - 6*x^2\ny + 11*x = k"


@pytest.mark.parametrize(("k", "roots"), [(6.0, [1, 2, 3]), (0.0, [0]), (5.0, None), (1e6, None)])
def test_roots_of_a_cubic(k: float, roots: list[float] | None) -> None:
    result = solved(CUBIC, k=k)
    assert str(result.status) == "solved"
    assert result.complete
    assert k == 1e6 or methods(result) == [Method.POLYNOMIAL]
    for solution in result.solutions:
        x = solution["x"]
        assert x**3 - 6 * x**2 + 11 * x == pytest.approx(k, rel=1e-13, abs=1e-13)
    if roots is not None:
        assert sorted(s["x"] for s in result.solutions) == pytest.approx(roots, abs=1e-15)


def test_planted_roots_of_random_blocks() -> None:
    draw = random.Random(3)
    for _ in range(20):
        roots = sorted(draw.sample(range(-9, 10), 4))
        a, b, c, d = roots
        sheet = f"u = (x - ({a}))*(x - ({b}))\nw = (x - ({c}))*(x - ({d}))\nu*w = v\nv = 0*x"
        result = solved(sheet)
        assert result.complete
        assert sorted(s["x"] for s in result.solutions) == pytest.approx(roots, abs=1e-12)


def test_no_real_root_is_proven() -> None:
    result = solved("y = x^4 + x\ny + 2*x^2 = -k", k=3.0)
    assert str(result.status) == "infeasible"


def test_a_double_root_is_no_matter_of_counting() -> None:
    """At k = 4 an extremum touches: what rounding leaves of that is for the general search to say."""
    result = solved("y = x^3 - 3*x\ny + 2 = k", k=4.0)
    assert Method.POLYNOMIAL not in methods(result)
    assert any(s["x"] == pytest.approx(2.0) for s in result.solutions)


def test_a_range_leaves_out_roots() -> None:
    sheet = "variables\nx in [1.5, 10]\ny\nk = 6\nrules\ny = x^3 - 6*x^2\ny + 11*x = k"
    result = solved(sheet)
    assert sorted(s["x"] for s in result.solutions) == pytest.approx([2, 3])
    assert result.complete


def test_a_range_of_another_unknown_leaves_out_roots() -> None:
    sheet = "variables\nx\ny in [-20, -10]\nk = 6\nrules\ny = x^3 - 6*x^2\ny + 11*x = k"
    result = solved(sheet)
    assert sorted(s["x"] for s in result.solutions) == pytest.approx([2])
