"""Compiled ways and the step-by-step way say the same, row by row, on every shipped model."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import rulesheets
import solver
from rulesheets.model import Model
from solver.files.tables import CODES
from solver.sweeps import Plan, sweep_answers
from tests.sampling import sampled

ROOT = Path(__file__).parents[3] / "models"
MODELS = sorted(path.parent.name for path in ROOT.glob("*/model.tk"))
SLOW = {"loan", "rachford_rice"}
"""Sheets of one iterated block, of which a row takes the step-by-step way long: fewer rows."""


def numbers_of(model: Model) -> dict[str, float]:
    return {n: v.value for n, v in model.variables.items() if isinstance(v.value, float)}


def rows_for(model: Model, name: str, count: int) -> np.ndarray:
    rng = np.random.default_rng(len(name))
    value = numbers_of(model)[name]
    if model.variables[name].unit == "deg":
        return np.concatenate([rng.uniform(-180, 180, count - 3), [0.0, 90.0, value]])
    around = value * rng.uniform(0.6, 1.4, count - 1) if value else rng.uniform(-1, 1, count - 1)
    return np.concatenate([around, [value]])


@pytest.mark.parametrize("name", sampled(MODELS, 2))
def test_every_row_of_a_sweep_is_what_a_solve_says(name: str) -> None:
    model = rulesheets.load(str(ROOT / name / "model.tk"))
    given_numbers = numbers_of(model)
    want = [n for n, v in model.variables.items() if v.posted and v.value is None]
    for driver in [*given_numbers][-2:][: 1 if name in SLOW else 2]:
        plan = solver.prepare(model, [driver], want)
        rows = rows_for(model, driver, 4 if name in SLOW else 7)
        plan.sweep(rows)  # learns the ways
        table = plan.sweep(np.tile(rows, 3))
        codes, answers = sweep_answers(plan, [np.tile(rows, 3)], jit=False)
        ends = np.cumsum(np.maximum(answers.counts, 1))
        for place, number in enumerate(rows):
            verdict, _ = plan.judged((float(number),))
            assert set(table.status[place :: len(rows)]) == {CODES[verdict.status]}
            assert set(codes[place :: len(rows)]) == {CODES[verdict.status]}
            if table.status[place]:
                continue
            for wanted in want:
                expected = verdict.leaves[0].branch.values[wanted]
                if isinstance(expected, float):
                    assert table[wanted][place] == pytest.approx(
                        expected, rel=1e-12, abs=1e-12 * 100
                    )
            expected_rows = verdict_rows(plan, float(number), want)
            assert_same_answers(plan, float(number), expected_rows)
            for turn in range(place, len(ends), len(rows)):
                here = slice(ends[turn] - answers.counts[turn], ends[turn])
                found = list(
                    zip(*(column[here].tolist() for column in answers.listed()), strict=True)
                )
                assert_alike(found, expected_rows)


def verdict_rows(plan: Plan, number: float, want: list[str]) -> list[tuple[float | str, ...]]:
    verdict, _ = plan.judged((number,))
    return list(
        dict.fromkeys(tuple(leaf.branch.values[n] for n in want) for leaf in verdict.leaves)
    )


def assert_same_answers(plan: Plan, number: float, expected: list[tuple[float | str, ...]]) -> None:
    found = plan.all(number)
    assert_alike(found, expected)
    numbers = [v for v in found[0] if isinstance(v, float)]
    assert [v for v in plan(number) if isinstance(v, float)] == pytest.approx(
        numbers, rel=1e-13, abs=1e-12
    )


def assert_alike(
    found: list[tuple[float | str, ...]], expected: list[tuple[float | str, ...]]
) -> None:
    assert len(found) == len(expected)
    for one, other in zip(found, expected, strict=True):
        for a, b in zip(one, other, strict=True):
            assert a == b if isinstance(b, str) else a == pytest.approx(b, rel=1e-12, abs=1e-10)


CRANK = rulesheets.load(str(ROOT / "offset_slider_crank" / "model.tk"))
FORWARD = solver.prepare(CRANK, ["thetaAO"], ["xB", "vB", "omegaAB", "aB", "alphaAB"])
BACKWARD = solver.prepare(CRANK, ["xB"], ["thetaAO", "vB", "omegaAB"], {"thetaAO": None})


@settings(max_examples=40, deadline=None)
@given(st.floats(-400, 400).filter(lambda theta: theta == 0.0 or abs(theta) > 1e-60))
def test_the_crank_turns_as_step_by_step(theta: float) -> None:
    FORWARD(-30.0)
    verdict, _ = FORWARD.judged((theta,))
    assert FORWARD.sweep([theta]).status[0] == CODES[verdict.status]
    if str(verdict.status) != "solved":
        return
    values = verdict.leaves[0].branch.values
    for name, number in zip(FORWARD.want, FORWARD(theta), strict=True):
        # The step-by-step way adds 90 degrees to the angle, which costs it 1e-16 of a right angle.
        assert number == pytest.approx(values[name], rel=1e-11, abs=1e-9)


@settings(max_examples=40, deadline=None)
@given(st.floats(-12, 12))
def test_the_slider_drives_as_step_by_step(xB: float) -> None:
    BACKWARD(9.0)
    verdict, _ = BACKWARD.judged((xB,))
    assert BACKWARD.sweep([xB]).status[0] == CODES[verdict.status]
    if str(verdict.status) == "solved":
        assert_same_answers(BACKWARD, xB, verdict_rows(BACKWARD, xB, list(BACKWARD.want)))


@pytest.mark.parametrize("theta", [0.0, 90.0, -90.0, 180.0, 270.0, 450.0, 30.0, -150.0])
def test_where_the_rules_compare_equal_numbers_calls_and_steps_agree(theta: float) -> None:
    """At right angles the velocity of A is level or upright, so that rules of both senses are
    active."""
    FORWARD(-30.0)
    verdict, _ = FORWARD.judged((theta,))
    assert str(verdict.status) == "solved"
    values = verdict.leaves[0].branch.values
    for name, number in zip(FORWARD.want, FORWARD(theta), strict=True):
        assert number == pytest.approx(values[name], rel=1e-13, abs=1e-12)


def test_a_call_goes_on_from_way_to_way_and_then_step_by_step() -> None:
    model = rulesheets.loads("if x > 0 then y = 2*x else y = x^2\nz = sqrt(x + 5)\n")
    plan = solver.prepare(model, ["x"], ["y", "z"])
    for x in (4.0, -1.0, 11.0, -4.0):
        assert plan(x) == (2 * x if x > 0 else x * x, math.sqrt(x + 5))
        assert plan.all(x) == [plan(x)]
    assert len(plan.records.programs) == 2
    with pytest.raises(solver.Unsolved) as refused:
        plan(-6.0)
    assert str(refused.value.status) == "infeasible"
    with pytest.raises(TypeError):
        plan(1.0, 2.0)


def test_bad_rows_do_not_spoil_their_neighbours() -> None:
    table = BACKWARD.sweep([9.0, 20.0, 9.5, np.nan, 1e300, 9.7])
    solved = [0, 2, 5]
    assert [str(table.STATUSES[code]) for code in table.status[[0, 1, 2, 5]]] == [
        "solved",
        "infeasible",
        "solved",
        "solved",
    ]
    assert np.isfinite(table["vB"][solved]).all()
    assert np.isnan(table["vB"][[1, 3, 4]]).all()


@pytest.mark.parametrize("number", [math.nan, math.inf])
def test_a_number_that_is_not_finite_is_an_input_that_is_lacking(number: float) -> None:
    assert str(BACKWARD.sweep([number]).STATUSES[BACKWARD.sweep([number]).status[0]]) == "partial"
    for ask in (BACKWARD, BACKWARD.all):
        with pytest.raises(solver.Unsolved) as refused:
            ask(number)
        assert str(refused.value.status) == "partial"


def test_symbols_select_the_rules() -> None:
    plan = solver.prepare(CRANK, ["branch", "thetaAO"], ["xB"])
    table = plan.sweep(["open", "crossed", "open"], [-30.0, -30.0, 10.0])
    xA, reach = 3.0 * math.sqrt(0.75), math.sqrt(64.0 - 3.5**2)
    assert table["xB"][0] == plan("open", -30.0)[0] == pytest.approx(xA + reach, rel=1e-14)
    assert table["xB"][1] == plan("crossed", -30.0)[0] == pytest.approx(xA - reach, rel=1e-14)


def test_a_direction_on_the_axis_is_left_to_the_step_by_step_way() -> None:
    """The rod along the slider's line: the slopes of the printed rules end there, the answers do
    not."""
    level = solver.prepare(CRANK, ["thetaAO"], ["xB"], {"offset": 0.0})
    assert level(0.0) == pytest.approx((11.0,), rel=1e-15)
    assert level.sweep(np.zeros(40))["xB"] == pytest.approx(np.full(40, 11.0), rel=1e-15)


def test_rows_out_of_reach_are_told_together_and_truly() -> None:
    model = rulesheets.load(str(ROOT / "four_link_chain" / "model.tk"))
    plan = solver.prepare(model, ["PQ", "thetaPQ"], ["thetaQR", "omegaQR", "xM"])
    rng = np.random.default_rng(5)
    cranks, angles = rng.uniform(0.05, 1.5, 3000), rng.uniform(-180, 180, 3000)
    table = plan.sweep(cranks, angles)
    assert plan.records.refusals
    Q = cranks * np.exp(1j * np.radians(angles))
    reach = np.abs(Q - 0.5)
    possible = (reach <= 0.5 + 0.4) & (reach >= abs(0.5 - 0.4))
    assert ((table.status == 0) == possible).all()


def test_a_slider_that_only_the_other_configuration_reaches() -> None:
    table = BACKWARD.sweep(np.linspace(-10.0, -6.0, 400))
    assert {str(table.STATUSES[code]) for code in table.status} == {"infeasible"}
    assert not BACKWARD.sweep(np.linspace(6.0, 10.0, 400)).status.any()


def test_an_input_outside_its_range_is_refused() -> None:
    model = rulesheets.loads("variables\n  c = 5 > 0\n  x\nrules\n  x = 2*c\n")
    plan = solver.prepare(model, ["c"], ["x"])
    assert plan(3.0) == (6.0,)
    with pytest.raises(solver.Unsolved, match="outside its range") as refused:
        plan(-5.0)
    assert str(refused.value.status) == "infeasible"
    table = plan.sweep([3.0, -5.0, 4.0] * 20)
    assert [str(table.STATUSES[code]) for code in table.status[:3]] == [
        "solved",
        "infeasible",
        "solved",
    ]
    assert np.isnan(table["x"][1::3]).all()


CUBICS = (
    ("x^3 - 3*x = y\n", "y", 1.0, lambda y: (1.0, 0.0, -3.0, -y)),
    ("e = x + 4/(19.62*x^2)\n", "e", 1.0, lambda e: (-1.0, e, 0.0, -4.0 / 19.62)),
    ("v = x*(12 - 2*x)*(9 - 2*x)\n", "v", 40.0, lambda v: (4.0, -42.0, 108.0, -v)),
)
"""Rules, an input and its scale, and the coefficients of the cubic that its number leads to."""


@pytest.mark.parametrize(("rule", "name", "scale", "cubic"), CUBICS)
@pytest.mark.parametrize("seed", range(3))
def test_a_plan_has_the_answers_that_are_born_away_from_where_it_was_made(
    rule: str, name: str, scale: float, cubic: Any, seed: int
) -> None:
    """On both sides of a fold, in any order; the roots of a cubic by its companion matrix."""
    plan: Any = solver.prepare(solver.loads(rule), [name], ["x"])
    numbers = scale * np.random.default_rng(seed).uniform(0.3, 6.0, 12)
    expected = []
    for number in numbers.tolist():
        roots = np.roots(cubic(number))
        expected.append(sorted(roots[np.abs(roots.imag) < 1e-9].real))
        found = [x for (x,) in plan.all(number)]
        assert sorted(found) == pytest.approx(expected[-1], rel=1e-9)
        assert plan(number) == pytest.approx((found[0],), rel=1e-14)
    assert {len(roots) for roots in expected} == {1, 3}
    assert plan.sweep(numbers)["answers"].tolist() == [len(roots) for roots in expected]


@pytest.mark.parametrize("count", [3, 64])
def test_a_sweep_of_symbols_and_numbers_says_row_by_row_what_calls_say(count: int) -> None:
    """Rows of different symbols in turn, one of them in a column of its own, one among numbers."""
    model = rulesheets.loads(
        "if k = 'up then y = x + z\nif k = 'down then y = x - z\nif k = 2 then y = x*z\n"
    )
    plan: Any = solver.prepare(model, ["k", "x"], ["y"], {"z": 0.25})
    kinds = np.resize(np.array(["up", "down", 2.0, "down"], dtype=object), count)
    numbers = np.linspace(-1.0, 1.0, count)
    form = {"up": lambda x: x + 0.25, "down": lambda x: x - 0.25, 2.0: lambda x: 0.25 * x}
    expected = [form[k](x) for k, x in zip(kinds, numbers, strict=True)]
    for table in (
        plan.sweep(kinds, numbers),
        solver.sweep(model, {"k": kinds, "x": numbers}, ["y"], given={"z": 0.25}),
    ):
        assert table["y"].tolist() == pytest.approx(expected, rel=1e-15)
        assert not table.status.any()
    alone: Any = solver.prepare(model, ["k"], ["y"], {"x": 3.0, "z": 0.25})
    assert alone.sweep(kinds)["y"].tolist() == [form[k](3.0) for k in kinds]
    kinds[1] = "neither"
    assert plan.sweep(kinds, numbers).status.nonzero()[0].tolist() == [1]


def test_a_plan_made_next_to_a_fold_has_the_answers_beyond_it() -> None:
    """x^3 - 3 x has a single root above 2, be it by 1e-12, and three below."""
    plan: Any = solver.prepare(solver.loads("x^3 - 3*x = y\n"), ["y"], ["x"])
    assert len(plan.all(2.0 + 1e-12)) == 1
    for y, count in ((2.0 - 1e-10, 3), (1.5, 3), (2.5, 1), (2.0, 2), (-2.5, 1)):
        assert len(plan.all(y)) == count


@pytest.mark.parametrize("start", [-2.46, -2.92])
def test_a_block_without_a_proof_has_the_answers_that_are_born_next_to_where_the_plan_was_made(
    start: float,
) -> None:
    """A force between molecules (Lennard-Jones): F r^13 + 24 r^6 = 48, with a pole that hides the
    proof."""
    model: Any = solver.loads("variables\nr = 1.3\nrules\nF = 24/r*(2*(1/r)^12 - (1/r)^6)\n")
    plan: Any = solver.prepare(model, ["F"], ["r"], {"r": None})
    assert len(plan.all(start)) == 1
    for force in (-2.3, 0.3, -0.8):
        roots = np.roots([force, *[0.0] * 6, 24.0, *[0.0] * 5, -48.0])
        expected = sorted(roots.real[abs(roots.imag) < 1e-9])
        assert len(expected) == 3
        assert plan(force)[0] > 0.0
        assert sorted(row[0] for row in plan.all(force)) == pytest.approx(expected, rel=1e-9)
