"""Roots at which floats stall far off come out to the last place, and are named as what they are."""

from __future__ import annotations

import pytest

import rulesheets
import solver

TRIPLE = ["ln(x/{a}) = x/{a} - 1 - (x/{a} - 1)^2/2", "sin(x - {a}) = x - {a} - (x - {a})^3/6"]
QUADRUPLE = ["cos(x - {a}) = 1 - (x - {a})^2/2", "exp(x - {a}) = 1 + x - {a} + (x - {a})^2/2 + (x - {a})^3/6"]


@pytest.mark.parametrize("a", ["3.3"])
@pytest.mark.parametrize("rule", [*TRIPLE, *QUADRUPLE])
def test_a_root_of_high_multiplicity(rule: str, a: str) -> None:
    result = solver.solve(rulesheets.loads(rule.format(a=a)))
    assert result.status is solver.Status.SINGULAR
    assert [solution["x"] for solution in result.solutions] == [float(a)]
    assert [(d.code, d.variables) for d in result.diagnoses] == [("S541", ("x",))]


def test_two_of_them_in_a_block() -> None:
    """To third order the first rule asks for x*y = 0."""
    result = solver.solve(rulesheets.loads("exp(x*y) = 1 + x*y + (x*y)^2/2\nx + y = 2"))
    assert result.status is solver.Status.SINGULAR
    assert sorted((s["x"], s["y"]) for s in result.solutions) == [(0.0, 2.0), (2.0, 0.0)]
