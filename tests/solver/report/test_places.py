"""Short names of files, and what a rule says."""

from __future__ import annotations

import pytest

import rulesheets
from solver.report.path import Places, short_names


def test_a_file_name_alone_where_it_is_unique() -> None:
    assert short_names(["/m/a/x.tk", "/m/a/y.tk"]) == {"/m/a/x.tk": "x.tk", "/m/a/y.tk": "y.tk"}


def test_a_folder_where_two_files_share_a_name() -> None:
    assert short_names(["/m/a/x.tk", "/m/b/x.tk"]) == {"/m/a/x.tk": "a/x.tk", "/m/b/x.tk": "b/x.tk"}


def test_a_name_that_ends_another_is_kept_apart() -> None:
    assert short_names(["x.tk", "/m/x.tk"]) == {"x.tk": "x.tk", "/m/x.tk": "m/x.tk"}


@pytest.mark.parametrize(
    ("written", "said"),
    [
        ("or(t <= 90,\n      t >= 270)", "or(t <= 90, t >= 270)"),
        ("and (b = 'x, or (t < 3,\n t > 100))", "and (b = 'x, or (t < 3, t > 100))"),
        ("(b = 'x or t = 2) and (t < 3)", "(b = 'x or t = 2) and (t < 3)"),
        ("not (t < 3) or (t > 5 and t < 9)", "not (t < 3) or (t > 5 and t < 9)"),
        ("and(t > 3)", "and(t > 3)"),
        ("(b = 'x or t = 2)", "(b = 'x or t = 2)"),
        ("(b = 'x) or (t = 2)", "(b = 'x) or (t = 2)"),
    ],
)
def test_an_arm_is_said_with_the_whole_of_its_condition(written: str, said: str) -> None:
    model = rulesheets.loads(f"if {written} then y = 1\n  else y = 2")
    places = Places(model)
    assert [places.said(e) for e in model.equations] == [f"if {said} then y = 1", "else y = 2"]
