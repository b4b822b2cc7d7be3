"""Which answer the rows of a sweep show: a branch kept along a line, the rule for unrelated
rows."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import rulesheets
import solver

LINE = "variables\n  s\n  x\n  y\nrules\n  x^2 - 3*x = s\n  y = 2*x\n"
"""x = 1.5 ± sqrt(2.25 + s): both are positive below 0, and the lower one is negative above."""
PLAN = solver.prepare(rulesheets.loads(LINE), ["s"], ["x"])


def lower(s: np.ndarray) -> np.ndarray:
    return 1.5 - np.sqrt(2.25 + s)


def upper(s: np.ndarray) -> np.ndarray:
    return 1.5 + np.sqrt(2.25 + s)


@pytest.mark.parametrize("rows", [9, 700, 2000])
@pytest.mark.parametrize("jobs", [1, 2])
def test_a_branch_does_not_jump_while_it_exists(rows: int, jobs: int) -> None:
    """Through pieces of a sweep, in one process or in several, in the direction in which it is
    asked."""
    model = rulesheets.loads(LINE)
    for s in (np.linspace(-2, 2, rows), np.linspace(2, -2, rows)):
        table = solver.sweep(model, {"s": s}, ["x"], jobs=jobs)
        first = float(solver.solve(model, {"s": float(s[0])})["x"])
        branch = min((lower, upper), key=lambda curve: abs(curve(s)[0] - first))
        assert table["x"] == pytest.approx(branch(s), rel=1e-12, abs=1e-12)
        assert (table.answers == 2).all()
        plan = solver.prepare(model, ["s"], ["x"])
        assert plan.sweep(s)["x"] == pytest.approx(branch(s), rel=1e-12, abs=1e-12)


@settings(max_examples=25, deadline=None)
@given(st.lists(st.integers(3, 40), min_size=2, max_size=5), st.booleans(), st.booleans())
def test_a_branch_is_kept_where_the_inputs_turn_back(
    lengths: list[int], twice: bool, down: bool
) -> None:
    """Up and down by equal steps, with each turning point once or twice, as often as you like."""
    steps, sign = [0.0], -1.0 if down else 1.0
    for length in lengths:
        steps += [0.0] * twice * (len(steps) > 1) + [sign * 0.125] * length
        sign = -sign
    s = np.cumsum(steps)
    s -= 2.0 + s.min()
    table = PLAN.sweep(s)
    branch = min((lower, upper), key=lambda curve: abs(curve(s)[0] - table["x"][0]))
    assert table["x"] == pytest.approx(branch(s), rel=1e-12, abs=1e-12)


def test_a_number_that_all_answers_share_does_not_move_the_branch() -> None:
    """The depth to which a sphere sinks, and the volume of water, equal for the three roots of the
    cubic."""
    text = "variables\n R = 10\n s\nrules\n x^3 - 3*R*x^2 + 4*R^3*s = 0\n V = pi*(3*R*x^2 - x^3)/3"
    s = np.linspace(0.6, 0.67, 60)
    roots = np.array([np.sort(np.roots([1.0, -30.0, 0.0, 4000.0 * share]))[1] for share in s])
    table = solver.prepare(rulesheets.loads(text), ["s"], ["x", "V"]).sweep(s)
    assert table["x"] == pytest.approx(roots, rel=1e-9)


def test_rows_without_an_answer_have_no_value_whichever_root_the_others_show() -> None:
    """Most rows show the lower root, which comes second there."""
    model, s = (
        rulesheets.loads(LINE.replace("  s\n", "  s in [-3, 1]\n")),
        np.linspace(-0.3, 1.5, 60),
    )
    table = solver.prepare(model, ["s"], ["x", "y"]).sweep(s)
    curve = min((lower, upper), key=lambda branch: abs(branch(s[:1]) - table["x"][:1])[0])
    assert table["x"] == pytest.approx(np.where(s <= 1.0, curve(s), np.nan), rel=1e-9, nan_ok=True)
    assert table["y"] == pytest.approx(2.0 * table["x"], nan_ok=True)


def test_unrelated_rows_have_each_their_own_first_answer() -> None:
    model = rulesheets.loads(LINE)
    plan = solver.prepare(model, ["s"], ["x", "y"])
    s = np.random.default_rng(3).permutation(np.linspace(-2, 40, 41) ** 2 * 0.1 - 1)
    table = plan.sweep(s)
    alone = np.array([plan(value) for value in s.tolist()])
    assert (abs(table["x"] - alone[:, 0]) <= 1e-12 * abs(alone[:, 0])).mean() > 0.9
    assert table.answers.tolist() == [len(plan.all(value)) for value in s.tolist()]


def test_three_rows_that_are_even_by_chance_are_no_sweep() -> None:
    """One row in five was next to such a step, and went on with an answer that is not the first."""
    plan = solver.prepare(rulesheets.loads(LINE), ["s"], ["x"])
    s = np.random.default_rng(3).uniform(-2, 2, 400)
    alone = np.array([plan(value)[0] for value in s.tolist()])
    assert (abs(plan.sweep(s)["x"] - alone) <= 1e-12 * abs(alone)).mean() > 0.97


def test_a_branch_ends_where_its_answers_do() -> None:
    """Below s = -2.25 there is none: the rule decides again where there is one."""
    model = rulesheets.loads(LINE)
    s = np.array([-1.0, -1.5, -2.0, -2.5, -3.0, -2.5, -2.0, -1.5, -1.0, -0.5, 0.5])
    table = solver.sweep(model, {"s": s}, ["x"])
    assert table.answers.tolist() == [2, 2, 2, 0, 0, 0, 2, 2, 2, 2, 2]
    assert np.isnan(table["x"][3:6]).all()
    assert table["x"][6] == pytest.approx(float(solver.solve(model, {"s": -2.0})["x"]), rel=1e-12)


def test_lines_of_a_grid_begin_anew() -> None:
    model = rulesheets.loads("variables\n  s\n  k\n  x\nrules\n  k*x^2 - 3*x = s\n")
    s, k = np.linspace(-0.5, 2, 26), np.array([1.0, 1.5])
    table = solver.sweep(model, {"k": k, "s": s}, ["x"], grid=True)
    for place, factor in enumerate(k.tolist()):
        line = solver.sweep(model, {"s": s}, ["x"], given={"k": factor})
        assert table["x"][26 * place : 26 * place + 26] == pytest.approx(line["x"], rel=1e-12)


@pytest.mark.parametrize("jit", [False, True])
def test_a_long_sweep_shows_what_it_shows_in_one_piece(
    jit: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Pieces in which the answers go on steadily are not ordered anew, and others are."""
    if jit:
        pytest.importorskip("llvmlite")
    model = rulesheets.load("offset_slider_crank")
    out, back = np.linspace(4.6, 10.8, 6_000), np.linspace(10.3, 4.5, 3_000)
    column = np.concatenate([out, [20.0], back, np.random.default_rng(6).uniform(5.0, 10.0, 800)])
    tables = []
    for piece in (2**20, 2**11, 1250):
        monkeypatch.setattr("solver.sweeps.PIECE", piece)
        plan = solver.prepare(model, ["xB"], ["thetaAO", "vB", "alphaAB"], {"thetaAO": None})
        plan(7.0)
        tables.append(plan.sweep(column, jit=jit))
    for table in tables[1:]:
        assert (table.status == tables[0].status).all()
        assert (table.answers == tables[0].answers).all()
        for name in plan.want:
            here, there = table[name], tables[0][name]
            near = np.abs(here - there) <= 1e-9 * np.maximum(1.0, np.abs(there))
            assert (near | (np.isnan(here) & np.isnan(there))).all()
    assert set(tables[0].answers.tolist()) == {0, 2}


def test_a_row_in_which_only_another_branch_has_an_answer_does_not_end_the_branch() -> None:
    """Degree of consolidation: the rule for more than 0.6 begins a little above the end of the
    other."""
    rules = "if U <= 0.6 then T = pi/4*U^2 else T = 1.781 - 0.933*log10(100*(1 - U))"
    times = np.linspace(0.4345, 0.1345, 11)
    table = solver.sweep(rulesheets.loads(rules), {"T": times})
    alone = table.answers == 1
    assert alone.sum() == 1
    assert (table["U"][~alone] > 0.0).all()
