"""All answers of a row on arrays: the same as the straight-line code lists, in its order, none
twice."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import brentq

import rulesheets
import solver
from solver.files.tables import CODES
from solver.sweeps import sweep_answers
from solver.trace.flow import Flow
from solver.trace.graph import NotCompilable
from solver.trace.order import Order
from solver.trace.program import Ending, Program
from solver.trace.python import compile_scalar
from solver.trace.rows import AnswerKernel

MODELS = Path(__file__).parents[3] / "models"
FEW = st.integers(-2, 2).map(float)


@st.composite
def programs(draw: st.DrawFn) -> Program:
    """Endings whose inputs say how they are ordered, what they give, and whether they count."""
    flow, endings, keys = Flow(), [], []
    count, known = draw(st.integers(1, 4)), draw(st.booleans())
    for place in range(count):
        order, check, one, other = (flow.input(4 * place + k) for k in range(4))
        zero = flow.constant(0.0)
        key = flow.constant(float(draw(st.integers(0, 3)))) if known else order
        results: tuple[int | str, ...] = (
            one,
            flow.add("mul", one, other),
            draw(st.sampled_from("ab")),
        )
        holds = (flow.add("le", zero, check),)
        endings.append(Ending(results, (*holds, flow.node("finite", one))))
        keys.append((key,))
    return Program(flow, 4 * count, tuple(endings), (), Order(tuple(keys) if count > 1 else ()))


@settings(max_examples=60, deadline=None)
@given(programs(), st.data())
def test_arrays_list_what_straight_line_code_lists(program: Program, data: st.DataObject) -> None:
    row = st.lists(FEW, min_size=program.inputs, max_size=program.inputs)
    rows = data.draw(st.lists(row, min_size=1, max_size=8))
    expected = [compile_scalar(program, all_answers=True)(*numbers) for numbers in rows]
    answers, settled = AnswerKernel(program, False, np.full(len(rows[0]), np.inf))(
        list(np.array(rows).T)
    )
    found = list(zip(*(column.tolist() for column in answers.listed()), strict=True))
    ends = np.cumsum(np.maximum(answers.counts, 1)).tolist()
    listed = [found[end - n : end] for end, n in zip(ends, answers.counts.tolist(), strict=True)]
    for row_, sure, here in zip(expected, settled.tolist(), listed, strict=True):
        assert sure == (row_ is not None)
        assert here == list(dict.fromkeys(row_ or ()))


def test_a_symbol_beside_a_number_is_left_to_straight_line_code() -> None:
    flow = Flow()
    number = flow.input(0)
    endings = tuple(
        Ending((result,), (flow.node("finite", number),)) for result in (number, "open")
    )
    assert compile_scalar(Program(flow, 1, endings), all_answers=True)(2.0) == [(2.0,), ("open",)]
    with pytest.raises(NotCompilable):
        AnswerKernel(Program(flow, 1, endings), False, np.array([np.inf]))


@cache
def crank(driver: str) -> tuple[solver.Plan, Callable[[tuple[float]], Any]]:
    """A plan from the driver, and its solves step by step, each of which is made once."""
    model = rulesheets.load(str(MODELS / "offset_slider_crank" / "model.tk"))
    want = [name for name in ("xB", "thetaAO", "vB", "alphaAB") if name != driver]
    plan = solver.prepare(model, [driver], want, {"thetaAO": None})
    return plan, cache(plan.judged)


@pytest.mark.parametrize("jit", [False, True])
@pytest.mark.parametrize(("driver", "reach"), [("xB", 12.0), ("thetaAO", 400.0)])
def test_rows_of_the_crank_have_the_answers_of_a_solve(
    driver: str, reach: float, jit: bool
) -> None:
    if jit:
        pytest.importorskip("llvmlite")
    alone, judged = crank(driver)
    plan, want = solver.prepare(alone.model, [driver], alone.want, {"thetaAO": None}), alone.want
    rows = np.random.default_rng(3).uniform(-reach, reach, 60)
    sweep_answers(plan, [rows], jit)  # learns
    codes, answers = sweep_answers(plan, [rows], jit)
    ends = np.cumsum(np.maximum(answers.counts, 1))
    for place, number in enumerate(rows.tolist()):
        verdict, _ = judged((number,))
        assert codes[place] == CODES[verdict.status]
        leaves = verdict.leaves if not codes[place] else ()
        expected = list(
            dict.fromkeys(tuple(leaf.branch.values[n] for n in want) for leaf in leaves)
        )
        here = slice(ends[place] - answers.counts[place], ends[place])
        found = list(zip(*(column[here].tolist() for column in answers.listed()), strict=True))
        assert len(found) == len(expected)
        for one, other in zip(found, expected, strict=True):
            assert one == pytest.approx(other, rel=1e-11, abs=1e-9)
    assert (codes == 0).any()


def test_symbols_that_are_wanted_come_with_their_answers() -> None:
    model = rulesheets.loads(
        "variables\n  x\n  y\n  side\nrules\n  y = x^2\n  if x < 0 then side = 'left else side = "
        "'right\n"
    )
    plan = solver.prepare(model, ["y"], ["x", "side"])
    for _ in range(2):
        codes, answers = sweep_answers(plan, [np.array([4.0, -1.0, 0.25] * 8)], jit=False)
    assert answers.counts.tolist() == [2, 0, 2] * 8
    assert answers.listed()[0].tolist() == pytest.approx(
        [2.0, -2.0, math.nan, 0.5, -0.5] * 8, nan_ok=True
    )
    assert answers.listed()[1].tolist() == ["right", "left", None, "right", "left"] * 8
    assert [str(solver.Table.STATUSES[code]) for code in codes[:3]] == [
        "solved",
        "infeasible",
        "solved",
    ]


CENTRES = "r^2 = (x + 38.28)^2 + (y - b)^2\ns^2 = x^2 + y^2\n"
"""Two circles, one through the other's centre line: each x of the second has two centres b, or
none."""


@cache
def centres(share: float) -> tuple[list[float], list[tuple[float, float]]]:
    """Numbers of y, r and s, and the answers of a solve."""
    numbers = [share * v for v in (3.4, 42.36688528792271, 5.17925177993887)]
    found = solver.solve(
        rulesheets.loads(CENTRES), dict(zip("yrs", numbers, strict=True))
    ).solutions
    return numbers, [(one["x"], one["b"]) for one in found]


@settings(max_examples=10)
@given(st.permutations((0.97, 1.0, 1.05, 1.2, 0.99, 1.1)))
def test_calls_have_the_answers_of_a_solve_whatever_was_asked_before(shares: list[float]) -> None:
    plan = solver.prepare(rulesheets.loads(CENTRES), ["y", "r", "s"], ["x", "b"])
    for numbers, found in map(centres, shares):
        expected = [pytest.approx(one, rel=1e-9) for one in found]
        assert plan.all(*numbers) == expected
        assert plan(*numbers) == expected[0]


def test_a_branch_may_end_in_a_block_out_of_range() -> None:
    model = rulesheets.load(
        str(MODELS / "slotted_link" / "model.tk")
    )  # its slot points one way: CS > 0
    plan = solver.prepare(model, ["xD"], ["thetaOB"], {"thetaOB": None})
    for number in (0.2618614682831908, 0.262, 0.26):
        inputs = {"thetaOB": None, "xD": number}
        found = solver.solve(model, inputs, want=["thetaOB"]).solutions
        assert plan.all(number) == [pytest.approx((one["thetaOB"],), rel=1e-9) for one in found]


def test_a_double_root_that_is_asked_again_has_the_same_answers() -> None:
    model = rulesheets.loads("x^3 - 3*x = y\nz = exp(x)\n")
    plan = solver.prepare(model, ["y"], ["x", "z"])
    first = plan.all(2.0)
    assert [row[0] for row in first] == pytest.approx([2.0, -1.0])
    for number in (1.0, 2.0, 1.5, 2.0, -2.0, 2.0):
        again = [row[0] for row in plan.all(number)]
        assert again == pytest.approx(
            [one["x"] for one in solver.solve(model, {"y": number}).solutions]
        )
        assert plan(number) == plan.all(number)[0]
    assert plan.all(2.0) == first
    assert plan.sweep(np.array([1.0, 2.0, 2.0]))["x"].tolist()[1:] == pytest.approx([2.0, 2.0])


SHAPER = """variables
  r = 100
  d = 250
  th = 40
  w = 6
  q
  beta
  al
rules
  q*cosd(beta) = d + r*cosd(th)
  q*sind(beta) = r*sind(th)
  al = w^2*r*d*sind(th)*(r^2 - d^2)/q^4
"""


@pytest.mark.parametrize("al", [-2.4738, -2.4565, -2.4368, -2.5])
def test_answers_that_differ_in_other_unknowns_alone_are_one(al: float) -> None:
    """The link of a shaper turns by beta with a length q, or by half a turn more with -q."""
    plan = solver.prepare(rulesheets.loads(SHAPER), ["al"], ["r"], {"r": None})
    cosine, sine = math.cos(math.radians(40.0)), math.sin(math.radians(40.0))
    square = np.poly1d([1.0, 500.0 * cosine, 62500.0])
    roots = (al * square**2 - 36.0 * 250.0 * sine * np.poly1d([1.0, 0.0, -62500.0, 0.0])).roots
    expected = sorted(roots[np.isreal(roots)].real)
    for _ in range(2):
        assert sorted(r for (r,) in plan.all(al)) == pytest.approx(expected, rel=1e-9)
    table: solver.Table = plan.sweep(np.linspace(al, 1.001 * al, 100))
    assert set(table.answers.tolist()) == {4}


def test_rows_across_two_folds_have_the_roots_of_each_side() -> None:
    """x exp(x) + x/10 has a minimum and a maximum, and between their heights three roots."""

    def height(x: float) -> float:
        return x * math.exp(x) + x / 10.0

    low, high = (
        brentq(lambda x: (1.0 + x) * math.exp(x) + 0.1, *ends)
        for ends in ((-2.0, -1.0), (-3.5, -2.5))
    )
    plan = solver.prepare(rulesheets.loads("y = x*exp(x) + x/10"), ["y"], ["x"])
    y = np.linspace(1.01 * height(low), 0.99 * height(high), 20_001)
    table = plan.sweep(y)
    inside = (height(low) < y) & (y < height(high))
    assert (table["answers"] == np.where(inside, 3, 1)).all()
    for row in range(0, len(y), 500):
        roots = sorted(x for (x,) in plan.all(y[row]))
        assert len(roots) == table["answers"][row]
        assert [height(x) for x in roots] == pytest.approx([y[row]] * len(roots), rel=1e-14)
    assert [height(x) for x in table["x"]] == pytest.approx(y.tolist(), rel=1e-14)


@pytest.mark.parametrize("height", ["x^2", "x^3", "sinh(x)"])
def test_rows_may_have_a_root_beside_zero(height: str) -> None:
    """A line through the origin meets the curve only there, unless it rises steeply enough."""
    sheet = f"variables\n  x in [0, 30]\nrules\n  y = {height}\n  y = a*x"
    plan = solver.prepare(rulesheets.loads(sheet), ["a"], ["x"])
    assert plan.all(-1.0) == [(0.0,)]
    for a in (2.0, -2.0, 3.0):
        roots = [x for (x,) in plan.all(a)]
        assert len(roots) == 1 + (a > 0.0)
        assert roots[-1] == 0.0
        assert all(math.isclose(_rise(height, x), a * x, rel_tol=1e-13) for x in roots)


def test_a_row_at_which_a_linear_block_is_singular_is_not_taken_for_zero() -> None:
    """a*x + y = x + b*y = 0 has other answers than 0 where a*b is 1."""
    plan = solver.prepare(rulesheets.loads("a*x + y = 0\nx + b*y = 0"), ["a", "b"], ["x", "y"])
    assert plan.all(1.0, 3.0) == [(0.0, 0.0)]
    assert plan.all(2.0, 5.0) == [(0.0, 0.0)]
    for b in (0.5, 0.25):
        with pytest.raises(solver.Unsolved):
            plan.all(1.0 / b, b)


def test_the_order_at_an_input_of_zero_is_not_that_of_other_rows() -> None:
    """An input of 0 suggests no size; any other does, and the nearest sizes come first."""
    sheet, want = "(x - 10)^2 = 4\n(y - 10)^2 = 9\nz = p/x", ["x", "y", "z"]
    plan, model = solver.prepare(rulesheets.loads(sheet), ["p"], want), rulesheets.loads(sheet)
    for p in (0.0, 3.0, -3.0, 0.0, 80.0):
        found = solver.solve(model, {"p": p}, want).solutions
        assert plan.all(p) == [tuple(map(one.get, want)) for one in found]


def test_a_row_beside_a_removable_hole_has_no_root_by_rounding() -> None:
    """Where n is all but 0, (C - S)/n is 0/0 to rounding, and any L satisfies the last rule."""
    sheet = "S = C*(1 - d)^n\nW = C*(1 - d)^2*d\nL = (C - S)/n\nC = 50000"
    plan = solver.prepare(rulesheets.loads(sheet), ["L", "W"], ["S", "n", "d"])
    for _ in range(2):
        for w in (5178.0, 7000.0):
            found = plan.all(7500.0, w)
            assert len(found) == 2
            for s, n, d in found:
                assert math.isclose(50000 * (1 - d) ** 2 * d, w, rel_tol=1e-12)
                assert math.isclose((50000 - s) / 7500, n, rel_tol=1e-9)
                assert math.isclose(-math.expm1(n * math.log1p(-d)), 0.15 * n, rel_tol=1e-9)


def _rise(height: str, x: float) -> float:
    return math.sinh(x) if height == "sinh(x)" else x ** float(height[2:])


def test_a_case_without_an_answer_at_the_first_row_is_watched() -> None:
    """Blasius' and Poiseuille's friction factors overlap: between 0.0278 and 0.0456 both have an
    answer."""
    model = rulesheets.loads("if Re < 2300 then f = 64/Re else f = 0.316/Re^0.25")
    plan, factors = solver.prepare(model, ["f"], ["Re"]), np.linspace(0.02, 0.06, 401).tolist()
    expected = [
        [64 / f] * (64 / f < 2300) + [(0.316 / f) ** 4] * ((0.316 / f) ** 4 >= 2300)
        for f in factors
    ]
    assert plan.sweep(factors)["answers"].tolist() == [len(numbers) for numbers in expected]
    for f, numbers in zip(factors, expected, strict=True):
        assert sorted(re for (re,) in plan.all(f)) == pytest.approx(sorted(numbers))
        assert plan(f) == plan.all(f)[0]
        assert plan(f)[0] == pytest.approx(solver.solve(model, {"f": f})["Re"])


def test_a_root_that_comes_from_a_pole_is_not_missed() -> None:
    """Below 60 a torque has one speed; above, a second one, from standstill on."""
    plan = solver.prepare(rulesheets.loads("T = min(120, 18000/w, 60 + w/2)"), ["T"], ["w"])
    for torque, count in ((6.0, 1), (45.0, 1), (63.0, 2), (75.0, 2), (50.0, 1)):
        assert len(plan.all(torque)) == count


def test_a_root_that_comes_from_infinity_is_not_missed() -> None:
    """No depth has a negative Froude number; a small one has a great depth."""
    sheet = "v = 2/y\nFr = v/sqrt(9.81*y)\nif Fr > 1 then z = Fr else z = y"
    plan = solver.prepare(rulesheets.loads(sheet), ["Fr"], ["y"])
    for froude, depth in ((10.0, 0.1597), (0.5, 1.1771)):
        with pytest.raises(solver.Unsolved):
            plan(-2.0)
        assert plan(froude)[0] == pytest.approx(depth, rel=1e-3)


def test_a_case_without_real_roots_at_the_first_row_is_watched() -> None:
    """Inhibition above 5 gives a second concentration for lower rates alone."""
    sheet = "if s <= 5 then v = 10*s/(2 + s) else v = 10*s/(2 + s + (s - 5)^2/8)"
    plan = solver.prepare(rulesheets.loads(sheet), ["v"], ["s"])
    assert len(plan.all(10.1)) == 1
    assert [s for (s,) in plan.all(2.0)] == [pytest.approx(41.0), pytest.approx(0.5)]
