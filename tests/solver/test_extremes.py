"""Numbers at the ends of the floats, and unknowns with more whole turns than can be listed."""

from __future__ import annotations

from typing import Any

import pytest

import rulesheets
import solver
from solver import Result


def solve(rules: str, variables: str = "", **inputs: Any) -> Result:
    text = f"variables\n{variables}\nrules\n{rules}\n" if variables else f"{rules}\n"
    return solver.solve(rulesheets.loads(text), inputs)


def test_a_step_that_overflows_in_floats_is_taken_in_more_digits() -> None:
    result = solve("w^2/x^1.5 = 0.25", x=1e240)
    assert [solution["w"] for solution in result.solutions] == pytest.approx([5e179, -5e179], rel=1e-15)


def test_a_value_beyond_floats_is_not_called_impossible() -> None:
    result = solve("ln(x) = 800")
    assert str(result.status) == "failed"
    assert [diagnosis.code for diagnosis in result.diagnoses] == ["S551"]


def test_nothing_is_proven_absent_where_no_search_looks() -> None:
    result = solve("x - sin(x) = 1e200")
    assert str(result.status) != "infeasible"


def test_answers_of_any_size_are_put_in_order() -> None:
    result = solve("x^2 = 1e300", variables="x ~ 1")
    assert [solution["x"] for solution in result.solutions] == pytest.approx([1e150, -1e150], rel=1e-15)
    assert str(solve("x^2/1e250 = 1e280", variables="x ~ 1e-150").status) == "solved"


def test_a_range_with_too_many_turns_to_list_is_not_called_empty() -> None:
    result = solve("sin(1e6/w) = 0.5", variables="w in [-12, 5.7]")
    assert str(result.status) == "solved"
    assert not result.complete
    assert all(-12 <= float(str(solution["w"])) <= 5.7 for solution in result.solutions)


def test_a_pole_that_floats_step_over_is_no_value() -> None:
    """tan(pi/2) has none, although the float next to π/2 has a tangent."""
    assert str(solve("tan(pi/2) = x").status) != "solved"
