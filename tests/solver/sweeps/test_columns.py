"""Columns of a sweep as a program gives them, and names given alone: read as meant, or refused in
words."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import rulesheets
import solver
from rulesheets.diagnosis import RuleSheetError

LINE = rulesheets.loads("y = 2*x + a\nif s = 'up then z = y else z = -y")


def swept(values: Any) -> list[float]:
    plan = solver.prepare(LINE, ["x"], ["y"], given={"a": 1.0})
    found = plan.sweep(values)["y"].tolist()
    assert solver.sweep(LINE, {"x": values}, want="y", given={"a": 1.0})["y"].tolist() == found
    return found


@pytest.mark.parametrize(
    "values",
    [
        [1, 2.0],
        (1, 2),
        range(1, 3),
        np.array([1, 2], dtype=">f8"),
        np.array([1, 2], dtype="f4"),
        np.array([1, 2], dtype=np.uint8),
        np.array([1, 2], dtype=object),
        np.arange(1.0, 5.0)[:2:1],
        np.arange(1.0, 4.0)[::-1][1:][::-1],
        memoryview(np.array([1.0, 2.0])),
    ],
)
def test_whatever_holds_numbers_is_a_column(values: Any) -> None:
    assert swept(values) == [3.0, 5.0]


def test_numbers_come_one_by_one() -> None:
    plan = solver.prepare(LINE, ["x"], ["y"], given={"a": 1.0})
    assert plan.sweep(x for x in (1.0, 2.0))["y"].tolist() == [3.0, 5.0]
    assert solver.sweep(LINE, {"x": iter([1.0]), "a": iter([4.0])}, want=["y"])["y"].tolist() == [
        6.0
    ]


def test_a_number_that_is_lacking_is_none_or_nan() -> None:
    table = solver.prepare(LINE, ["x"], ["y"], given={"a": 1.0}).sweep([None, 2.0, np.nan])
    assert [str(table.STATUSES[code]) for code in table.status] == ["partial", "solved", "partial"]
    assert table["y"][1] == 5.0


def test_symbols_and_numbers_share_a_column() -> None:
    plan = solver.prepare(LINE, ["s", "y"], ["z"])
    assert plan.sweep(["up", 3.0, "'up"], [1.0, 1.0, 2.0])["z"].tolist() == [1.0, -1.0, 2.0]
    lacking = plan.sweep(["up", "up", None], [1.0, None, None])
    assert [str(lacking.STATUSES[code]) for code in lacking.status] == [
        "solved",
        "partial",
        "partial",
    ]


@pytest.mark.parametrize(
    ("values", "says"),
    [
        (np.zeros((2, 3)), "that of x is 2x3"),
        ([[1.0], [1.0, 2.0]], "neither a number|there are lists"),
        (np.array([1j]), "1j is not a valid value for x"),
        (["1", "2"], "'1' is not a valid value for x: a text is read as a symbol"),
        ([{}], "neither a number nor a symbol"),
    ],
)
def test_what_is_no_column_is_said(values: Any, says: str) -> None:
    plan = solver.prepare(LINE, ["x"], ["y"], given={"a": 1.0})
    with pytest.raises(ValueError, match=says):
        plan.sweep(values)
    with pytest.raises(ValueError, match=says):
        solver.sweep(LINE, {"x": values}, want=["y"], given={"a": 1.0})


def test_a_plan_tells_how_many_columns_it_wants() -> None:
    plan = solver.prepare(LINE, ["x", "a"], ["y"])
    with pytest.raises(TypeError, match="prepared for 2 columns, not for 1"):
        plan.sweep([1.0])
    with pytest.raises(ValueError, match="needs an input"):
        solver.sweep(LINE, {}, want=["y"])
    with pytest.raises(ValueError, match="x stands twice"):
        solver.prepare(LINE, ["x", "a", "x"], ["y"])


def test_a_name_alone_is_one_name() -> None:
    assert solver.prepare(LINE, "x", "y", given={"a": 1.0})(2.0) == (5.0,)
    result = solver.solve(LINE, {"x": 1.0, "a": 1.0}, want="y")
    assert result.wanted == ("y",)
    assert result.sensitivity("y", "x")["y", "x"] == 2.0


@pytest.mark.parametrize("value", [[1.0], np.array([1.0]), 1j, {}, b"x"])
def test_what_is_no_value_of_an_input_is_said(value: Any) -> None:
    with pytest.raises(RuleSheetError) as refused:
        solver.solve(LINE, {"x": value})
    (diagnosis,) = refused.value.diagnoses
    assert diagnosis.code == "E406"
    assert "not a valid value for x" in diagnosis.message
