"""What ``import solver`` offers, and that it costs nothing until it is used."""

from __future__ import annotations

import pickle
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import rulesheets
import solver

ROOT = Path(__file__).parent.parent.parent


@pytest.mark.parametrize("name", solver.__all__)
def test_every_name_leads_to_what_it_says(name: str) -> None:
    assert getattr(solver, name).__name__ == name
    assert name in dir(solver)


def test_an_unknown_name_is_an_attribute_error() -> None:
    with pytest.raises(AttributeError, match="'solver' has no attribute 'solv'"):
        _ = solver.solv


LENS = "variables\n  f = 50\n  u = 200\n  v\nrules\n  1/f = 1/u + 1/v"


@pytest.mark.parametrize(
    ("call", "said"),
    [
        (lambda m: rulesheets.loads(b"x = 1"), "a text is needed, and this is of the type bytes"),
        (lambda m: solver.solve("lens.tk"), "a Model is needed, which rulesheets.load gives"),
        (lambda m: solver.prepare(None, ["u"]), "this is of the type NoneType"),
        (lambda m: solver.sweep({}, {"u": [1.0]}), "this is of the type dict"),
        (
            lambda m: solver.solve(m, ["f"]),
            "inputs are a mapping of names to values, not of the type list",
        ),
        (lambda m: solver.solve(m, guesses="f=3"), "guesses are a mapping of names to values"),
        (lambda m: solver.solve(m, {3: 1.0}), "a variable is named by a text, and 3 is none"),
        (lambda m: solver.solve(m, want=[3]), "a variable is named by a text, and 3 is none"),
    ],
)
def test_what_has_another_type_is_told_in_words(call: Callable[[Any], object], said: str) -> None:
    with pytest.raises(TypeError, match=re.escape(said)):
        call(rulesheets.loads(LENS))


def test_a_whole_number_beyond_the_floats_is_not_finite() -> None:
    with pytest.raises(rulesheets.RuleSheetError, match="f = inf is not finite"):
        solver.solve(rulesheets.loads(LENS), {"f": 10**400})


def test_an_answer_too_many_is_told() -> None:
    result = solver.solve(rulesheets.loads("x^2 = 2"))
    with pytest.raises(IndexError, match="there is no answer 2: answers are 0 to 1"):
        result.sensitivity(answer=2)


def test_no_processes_are_too_few() -> None:
    with pytest.raises(ValueError, match="0 is no number of processes"):
        solver.sweep(rulesheets.loads(LENS), {"u": [1.0]}, jobs=0)


def test_what_is_returned_reads_in_a_line() -> None:
    model = rulesheets.loads(LENS, name="lens")
    assert repr(model) == "<Model lens: 3 variables, 1 equation>"
    assert repr(solver.solve(model, {"u": 100})) == "<Result solved, 1 answer: v = 100>"
    assert repr(solver.solve(model, {"v": 60})) == "<Result inconsistent, no answer>"
    assert repr(solver.prepare(model, ["u"], ["v"])) == "<Plan (u) -> (v)>"
    table = solver.sweep(model, {"u": [50.0, 75.0]}, ["v"])
    assert repr(table) == "<Table of 2 rows, 1 solved: u, v, answers>"


@pytest.mark.parametrize("prove", [False, pytest.param(True, id="proved")])
def test_models_and_results_pickle_whatever_was_found_out_about_them(prove: bool) -> None:
    if prove:
        pytest.importorskip("flint")
    model = rulesheets.load("offset_slider_crank")
    for angle in (-30.0, -20.0):
        result = solver.solve(
            model, {"thetaAO": None, "xB": 9.5}, guesses={"thetaAO": angle}, prove=prove
        )
    again = pickle.loads(pickle.dumps(result))
    assert again == result
    for one, other in zip(again.solutions, result.solutions, strict=True):
        assert (one.error, one.radius, one.worst_residual) == (
            other.error,
            other.radius,
            other.worst_residual,
        )
    assert (
        again.sensitivity(["vB"], ["xB"])["vB", "xB"]
        == result.sensitivity(["vB"], ["xB"])["vB", "xB"]
    )
    assert solver.solve(pickle.loads(pickle.dumps(model)), {"thetaAO": 12.0})[
        "xB"
    ] == pytest.approx(solver.solve(model, {"thetaAO": 12.0})["xB"], rel=1e-15)
