"""Every name in a sheet's own rules has its row and counts for the status."""

from __future__ import annotations

import json

import numpy
import pytest

import rulesheets
import solver
from solver.report.sheet import result_csv, result_json, sheet_rows

NETWORK = """variables
  q1 = 10
  q17
rules
  (q1, q3) = (q2 + q3, 2*q2)
  q17 = q3 - q2
"""

PASSED = """variables
  phi = 45
  b
rules
  call line(phi; m)
  call height(phi, m; b)
function line(phi; m)
rules
  m*cosd(phi) = sind(phi)
function height(phi, m; b)
rules
  if phi = 90 then b = 5 else b = 5*m
"""


def test_unnamed_variables_are_printed_after_those_of_the_section() -> None:
    result = solver.solve(rulesheets.loads(NETWORK))
    assert [row.name for row in sheet_rows(result)] == ["q1", "q17", "q3", "q2"]
    assert [row.split(",")[2] for row in result_csv(result).splitlines()[1:]] == [
        "q1",
        "q17",
        "q3",
        "q2",
    ]
    assert set(json.loads(result_json(result))["solutions"][0]) == {"q1", "q17", "q3", "q2"}
    assert "q2 = 3.333333333" in repr(result)


def test_an_unnamed_variable_without_a_value_is_not_solved() -> None:
    result = solver.solve(rulesheets.loads(NETWORK + "  q4 + q5 = q17\n"))
    assert str(result.status) == "partial"
    assert result.status.exit_code == 1
    assert set(result.undetermined) == {"q4", "q5"}
    assert (
        solver.solve(rulesheets.loads(NETWORK + "  q4 + q5 = q17\n"), want=["q17"]).status.exit_code
        == 0
    )


def test_a_sweep_has_a_column_for_every_name() -> None:
    table = solver.sweep(rulesheets.loads(NETWORK), {"q1": numpy.array([3.0, 6.0])})
    assert list(table["q2"]) == pytest.approx([1.0, 2.0])


def test_a_slope_that_becomes_infinite_spoils_no_answer() -> None:
    sheet = rulesheets.loads(PASSED)
    steep = solver.solve(sheet, {"phi": 90.0})
    assert (str(steep.status), steep["b"], steep["m"]) == ("solved", 5.0, None)
    assert "m" not in steep.wanted
    assert [row.name for row in sheet_rows(steep)] == ["phi", "b", "m"]
    assert solver.solve(sheet)["m"] == pytest.approx(1.0)


def test_a_result_that_becomes_infinite_is_missed() -> None:
    sheet = rulesheets.loads(PASSED.replace("call height(phi, m; b)", "b = 5"))
    assert str(solver.solve(sheet, {"phi": 90.0}).status) == "infeasible"
