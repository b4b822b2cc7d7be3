"""What programs read: JSON and CSV."""

from __future__ import annotations

import csv
import io
import json
from dataclasses import replace

from solver.report.sheet import error_json, result_csv, result_json
from solver.solution.solving import Result, Solution


def test_the_json_object_of_a_solve(solved: Result) -> None:
    found = json.loads(result_json(solved))
    assert list(found) == [
        "status",
        "solutions",
        "complete",
        "undetermined",
        "diagnoses",
        "path",
        "units",
    ]
    assert found["units"] == {"a": "mm", "b": "mm", "c": "mm"}
    assert found["status"] == "solved"
    assert found["complete"] is True
    assert found["solutions"] == [{"a": 3, "b": 4, "c": c, "kind": "right"} for c in (5, -5)]
    assert [step["unknowns"] for step in found["path"]] == [["c"], ["f.angle"]]


def test_locals_come_with_explain_or_when_wanted(solved: Result) -> None:
    assert "f.angle" in json.loads(result_json(solved, explain=True))["solutions"][0]
    wanted = replace(solved, wanted=("f.angle",))
    assert "f.angle" in json.loads(result_json(wanted))["solutions"][0]


def test_diagnoses_carry_their_rules(unsolved: Result) -> None:
    (diagnosis,) = json.loads(result_json(unsolved))["diagnoses"]
    assert diagnosis["code"] == "S501"
    assert diagnosis["severity"] == "error"
    assert diagnosis["rules"] == [
        {"file": "sheets/hypotenuse.tk", "line": 1, "text": "c^2 = a^2 + b^2"}
    ]
    assert diagnosis["variables"] == ["b", "c"]
    assert json.loads(error_json(unsolved.diagnoses)) == {
        "status": "error",
        "diagnoses": [diagnosis],
    }


def test_numbers_that_are_not_finite_never_appear(solved: Result) -> None:
    answer = Solution({"a": 3.0, "b": float("inf"), "c": float("nan")})
    assert json.loads(result_json(replace(solved, solutions=(answer,))))["solutions"] == [
        {"a": 3.0}
    ]


def test_csv_has_the_columns_of_the_variable_sheet(solved: Result) -> None:
    rows = list(csv.DictReader(io.StringIO(result_csv(solved))))
    assert list(rows[0]) == ["St", "Input", "Name", "Output", "Unit", "Comment"]
    assert [(row["St"], row["Input"], row["Name"], row["Output"]) for row in rows] == [
        ("", "3", "a", ""),
        ("", "4", "b", ""),
        ("G", "1", "c", "5"),
        ("", "'right", "kind", ""),
    ]
