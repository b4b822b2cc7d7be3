"""The chart: references against a closed form, marks that tell right from wrong, and the
command."""

from __future__ import annotations

import math
from fractions import Fraction
from pathlib import Path
from typing import Any

import mpmath
import pytest

pytest.importorskip("matplotlib")

import rulesheets
import solver
from solver.__main__ import main
from solver.commands import Request
from solver.commands.chart import (
    chart_csv,
    chart_table,
    exact_state,
    measure,
    plain_newton,
)
from solver.numerics.elimination import eliminate
from solver.numerics.newton import METHODS, scipy_root
from solver.pictures import Measurement
from solver.pictures.plot import chart_picture
from tests.oracles.slider_crank import Crank, forward

pytest.importorskip("flint")

CRANK = Path(__file__).parents[3] / "models" / "offset_slider_crank" / "model.tk"


@pytest.fixture(scope="module")
def crank() -> rulesheets.Model:
    return rulesheets.load(CRANK)


@pytest.fixture(scope="module")
def marks(crank: rulesheets.Model) -> tuple[Measurement, ...]:
    return tuple(measure(Request(crank, {}, {}, None)))


def test_the_reference_is_right_to_fifty_digits(crank: rulesheets.Model) -> None:
    result = solver.solve(crank)
    found = exact_state(crank, result.solutions[0], result.inputs)
    assert found is not None
    _, state = found
    exact = forward(Crank(3.0, 8.0, 2.0, -15.0, -10.0, -30.0))
    with mpmath.workdps(50):
        for name in ("xB", "vB", "omegaAB", "aB", "alphaAB", "m2"):
            assert abs(state[name] / exact[name] - 1) < mpmath.mpf(10) ** -47


def test_every_method_is_measured(marks: tuple[Measurement, ...]) -> None:
    families = {mark.family for mark in marks}
    scipy = {f"scipy {method}" for method in METHODS}
    ours = {"backsolve", "backsolve, prepared", "backsolve, proved"}
    assert families == {*ours, "Newton", *scipy}
    assert all(mark.seconds > 0 for mark in marks)
    newton = [mark for mark in marks if mark.family == "Newton"]
    assert [mark.tolerance for mark in newton] == [10.0**-k for k in range(2, 16)]
    assert newton[0].error > 1e-10 > 1e-14 > newton[-1].error
    assert all(mark.error < 1e-15 for mark in marks if mark.family in ours)


def test_the_proof_tells_the_radius_of_its_numbers(marks: tuple[Measurement, ...]) -> None:
    (proof,) = (mark for mark in marks if mark.family == "backsolve, proved")
    assert proof.radius is not None
    assert proof.error <= proof.radius <= 2.0**-52
    assert all(mark.radius is None for mark in marks if mark is not proof)


def test_without_the_extra_there_is_no_proof_on_the_chart(
    crank: rulesheets.Model, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("solver.commands.chart.can_prove", lambda: False)
    found = list(measure(Request(crank, {}, {}, ("xB",))))
    assert "backsolve" in {mark.family for mark in found}
    assert "backsolve, proved" not in {mark.family for mark in found}


def test_over_an_input_the_references_follow_the_guards(crank: rulesheets.Model) -> None:
    """At 90° the rod's angular velocity is 0, and the rules that give its sign change."""
    found = list(measure(Request(crank, {}, {}, None), "thetaAO", [80.0, 90.0, 100.0]))
    for method in ("backsolve", "backsolve, prepared", "backsolve, proved"):
        ours = [mark for mark in found if mark.method == method]
        assert [mark.at for mark in ours] == [80.0, 90.0, 100.0]
        assert all(mark.status == "solved" and mark.error < 1e-13 for mark in ours)


def test_scipy_may_call_a_minimum_a_success() -> None:
    """least_squares ends at the minimum of |x³ - 2x + 2| near 0.8 and is content; hybr says it is
    none."""

    def residual(x: Any) -> list[float]:
        return [x[0] ** 3 - 2 * x[0] + 2]

    def slope(x: Any) -> list[list[float]]:
        return [[3 * x[0] ** 2 - 2]]

    content = scipy_root(residual, slope, [0.9], "least_squares")
    assert content.success
    assert content.x[0] == pytest.approx(math.sqrt(2 / 3), abs=1e-4)
    assert not scipy_root(residual, slope, [0.9], "hybr").success


def test_elimination_in_exact_numbers() -> None:
    matrix = [[Fraction(0), Fraction(2)], [Fraction(3), Fraction(4)]]
    assert eliminate(matrix, [Fraction(1), Fraction(5)]) == [Fraction(1), Fraction(1, 2)]
    assert eliminate([[1, 2], [2, 4]], [1, 2]) is None


@pytest.mark.parametrize("tolerance", [1e-2, 1e-6, 1e-12])
def test_plain_newton_ends_at_its_tolerance(tolerance: float) -> None:
    end = plain_newton(lambda x: [x[0] ** 2 - 2], lambda x: [[2 * x[0]]], [1.0], tolerance)
    assert end.success
    assert end.x[0] == pytest.approx(math.sqrt(2), rel=tolerance**2 + 1e-15)
    lost = plain_newton(lambda x: [x[0] ** 2 + 2], lambda x: [[2 * x[0]]], [1.0], tolerance)
    assert not lost.success


def test_pictures_hold_every_method(marks: tuple[Measurement, ...]) -> None:
    (axes,) = chart_picture(marks, "crank").axes
    labels = [text.get_text() for text in axes.get_legend().get_texts()]
    assert {"backsolve", "Newton", "scipy hybr"} <= set(labels)
    points = [
        Measurement("backsolve", None, 0.1, "solved", 1e-16, None, 1e-6),
        Measurement("backsolve", None, 0.01, "singular", math.nan, None, 1e-6),
        Measurement("scipy lm", None, 0.1, "false", 0.5, 7, 1e-4),
        Measurement("scipy lm", None, 0.01, "no convergence", math.nan, 70, 1e-4),
    ]
    errors, times = chart_picture(points, "crank", "x", towards=True).axes
    crosses = [line.get_xydata().tolist() for line in times.lines if line.get_marker() == "x"]
    assert crosses == [[[0.01, 1.0], [0.01, 100.0]]]
    rings = [line for line in errors.lines if line.get_markerfacecolor() == "none"]
    assert [line.get_xydata().tolist() for line in rings] == [[[0.1, 0.5]], []]
    told = [text.get_text() for text in errors.get_legend().get_texts()]
    false = "called an answer,\noff by more than 1e-6"
    assert told == ["backsolve", "scipy lm", "no answer", false]
    assert times.xaxis_inverted()
    assert times.lines[0].get_ydata().tolist() == [1.0, 1.0]
    rows = [line.split() for line in chart_table(points, "x").splitlines()[2:]]
    assert rows == [
        ["backsolve", "1", "of", "2", "0", "1", "1e-16", "0.1", "1.0"],
        ["scipy", "lm", "0", "of", "2", "1", "1", "5e-01", "0.1", "100.0"],
    ]
    assert chart_csv(points).splitlines()[4] == "scipy lm,,0.01,no convergence,,70,0.0001,"


def run(*words: str) -> int:
    return main(["chart", *words])


def test_the_command(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Any) -> None:
    monkeypatch.chdir(tmp_path)
    sheet = tmp_path / "kepler.tk"
    sheet.write_text("variables\n M = 1\n e = 0.5\n E\nrules\n M = E - e*sin(E)\n")
    assert run("kepler.tk", "-o", "chart.svg") == 0
    assert capsys.readouterr().out.startswith("Method")
    assert (tmp_path / "chart.svg").read_text().startswith("<?xml")
    assert run("kepler.tk", "--over", "M=0.5:1.5:0.5", "-o", "chart.csv") == 0
    assert "3 of 3  0      0" in capsys.readouterr().out
    head, *lines = (tmp_path / "chart.csv").read_text().splitlines()
    assert head == "method,tolerance,at,status,error,iterations,seconds,radius"
    assert [line.split(",")[2] for line in lines if line.startswith("backsolve,,")] == [
        "0.5",
        "1.0",
        "1.5",
    ]
    assert run("kepler.tk", "--approach", "e=1:1e-1..1e-3", "-o", "chart.png") == 0
    assert (tmp_path / "chart.png").read_bytes().startswith(b"\x89PNG")


def test_what_the_command_refuses(tmp_path: Path, capsys: Any) -> None:
    sheet = tmp_path / "root.tk"
    sheet.write_text("variables\n a = -4\n x\nrules\n x^2 = a\n")
    assert run(str(sheet)) == 1
    assert "infeasible" in capsys.readouterr().out
    for words, code in (
        (("-o", "chart.gif"), "E433"),
        (("--approach", "a=1"), "E424"),
        (("--approach", "a=1:1e-1..-1e-3"), "E424"),
        (("--over", "a=1:2"), "E424"),
        (("--over", "q=1:2:1"), "E407"),
    ):
        assert run(str(sheet), *words) == 2
        assert code in capsys.readouterr().err
