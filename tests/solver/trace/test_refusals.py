"""Rows without an answer: told by a record that refuses them, and only those that a solve
refuses."""

from __future__ import annotations

import math
from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import rulesheets
import solver

TANK = """
variables
  p  = 101400 > 0    [Pa]
  p0 = 101325        [Pa]
  h  >= 0            [m]
rules
  p = p0 + 998*9.81*h
"""
ARM = """
variables
  a  = 35
  b  = 50
  t1 = 100           [deg]
  t2 in [0, 180]     [deg]
  x
rules
  a*sind(t1) = b*cosd(t2)
  x = a*cosd(t1) + b*sind(t2)
"""
ACID = """
variables
  I  = 0.06
  Cs = 0.05
  Kw = 1e-14
  H  > 0
  OH > 0
  A  > 0
rules
  H*OH = Kw
  H + Cs = OH + A
  I = (H + Cs + OH + A)/2
"""


def statuses(plan: solver.Plan, *columns: object) -> list[str]:
    return [str(solver.Table.STATUSES[code]) for code in plan.sweep(*columns).status]


@pytest.mark.parametrize(
    ("sheet", "name", "low", "high", "edge"),
    [
        (TANK, "p", 101250.0, 101400.0, 101325.0),
        (ARM, "a", 50.1, 52.0, 50.0 / np.sin(np.radians(100.0))),
    ],
)
def test_rows_beside_large_numbers_are_refused_together(
    sheet: str, name: str, low: float, high: float, edge: float
) -> None:
    """The rows past the edge of a range, and of the image of a function."""
    plan = solver.prepare(rulesheets.loads(sheet), [name], None)
    column = np.linspace(low, high, 400)
    solved = column >= edge if sheet is TANK else column <= edge
    assert statuses(plan, column) == ["solved" if one else "infeasible" for one in solved]
    assert plan.records.refusals
    assert plan.records.vain <= 1


def test_rows_next_to_an_edge_are_refused_as_by_a_solve() -> None:
    model = rulesheets.loads(TANK)
    plan = solver.prepare(model, ["p"], ["h"])
    draw = np.random.default_rng(3)
    column = 101325.0 * (
        1.0 + 10.0 ** draw.uniform(-16.0, -4.0, 120) * draw.choice([-1.0, 1.0], 120)
    )
    single = [str(solver.solve(model, {"p": p}, want=["h"]).status) for p in column.tolist()]
    assert {*single} == {"solved", "infeasible"}
    assert statuses(plan, column) == single


def test_terms_that_cancel_refuse_no_row() -> None:
    """What rounding leaves of a sum says nothing about its sign, nor does a multiple of it."""
    text = "variables\n  a = 1\n  b = 0.2\n  y >= 0\nrules\n  x = a - 0.3 - b\n  y = x*5000\n"
    model = rulesheets.loads(text)
    plan = solver.prepare(model, ["a", "b"], ["y"])
    with pytest.raises(solver.Unsolved):
        plan(0.4, 0.2)
    draw = np.random.default_rng(4)
    b = draw.uniform(0.1, 0.9, 120)
    a = (b + 0.3) * (1.0 + draw.integers(-3, 4, 120) * 2.0**-53) - 0.01 * (
        draw.uniform(0, 1, 120) < 0.2
    )
    refused = [one == "infeasible" for one in statuses(plan, a, b)]
    assert plan.records.refusals
    for one, other in zip(a[refused].tolist(), b[refused].tolist(), strict=True):
        assert str(solver.solve(model, {"a": one, "b": other}, want=["y"]).status) == "infeasible"


def test_a_block_out_of_its_ranges_is_refused_without_an_error() -> None:
    plan = solver.prepare(rulesheets.loads(ACID), ["I"], ["A"])
    assert plan(0.06)[0] == pytest.approx(0.06, rel=1e-9)
    for _ in range(2):
        with pytest.raises(solver.Unsolved) as refused:
            plan(0.04)
        assert str(refused.value.status) == "infeasible"


BEYOND_FOLDS = (
    ("x = r*cosd(t) + sqrt(l^2 - r^2*sind(t)^2)\n", {"r": 1.0, "l": 2.0}, "x", (1.5, 6.0), ["t"]),
    ("y = x*exp(-x/a)\n", {"a": 2.0}, "y", (0.1, 3.0), ["x"]),
    ("y = x - a*sin(x)\nz = ln(x)*y\n", {"a": 1.5}, "z", (-1.0, 1.0), ["x", "y"]),
    (
        "p = u*v*sind(t)/x\nq = u*v*cosd(t)/x - v^2/x\n",
        {"q": 0.1, "u": 1.0, "x": 0.4},
        "p",
        (0.1, 3.0),
        ["v", "t"],
    ),
    ("variables\n y > 0\nrules\n e = y + q^2/(19.62*y^2)\n", {"e": 2.0}, "q", (1.0, 30.0), ["y"]),
    (
        "variables\n  z in [0, 1]\nrules\n  x^2 = p\n  exp(z) + x*z = q\n",
        {"p": 1.0},
        "q",
        (0.5, 4.0),
        ["x", "z"],
    ),
)
"""Sheets, what is given, and an input with a range beyond the fold of a block that no formula
solves."""


@pytest.mark.parametrize(("sheet", "given_", "name", "ends", "want"), BEYOND_FOLDS)
def test_rows_beyond_a_fold_are_refused_where_a_solve_refuses_them(
    sheet: str, given_: dict[str, float], name: str, ends: tuple[float, float], want: list[str]
) -> None:
    model = rulesheets.loads(sheet)
    plan = solver.prepare(model, [name], want, given_)
    column = np.random.default_rng(1).uniform(*ends, 60)
    expected = [str(plan.judged((number,))[0].status) for number in column.tolist()]
    for _ in range(2):
        assert statuses(plan, column) == expected


@settings(max_examples=6)
@given(st.floats(0.3, 2.0), st.floats(0.3, 2.0), st.floats(0.3, 2.0))
def test_what_one_box_of_inputs_refuses_has_no_answer(u: float, v: float, w: float) -> None:
    """z - a sin z = b + c is clear of 0 for z in [1, 2] where b + c is small, or large."""
    model = rulesheets.loads("variables\n  z in [1, 2]\nrules\n  z - a*sin(z) = b + c\n")
    plan = solver.prepare(model, ["a", "b", "c"], ["z"])
    for row in ((u, v, w), (u, w, v), (v, u, w), (1.1 * u, v, w), (u, 0.9 * v, w), (u, v, 1.5 * w)):
        expected = solver.solve(model, dict(zip("abc", row, strict=True)))
        if expected.status is solver.Status.SOLVED:
            assert plan(*row) == pytest.approx((expected["z"],), rel=1e-9)
        else:
            with pytest.raises(solver.Unsolved) as refused:
                plan(*row)
            assert refused.value.status is expected.status


def test_a_branch_whose_power_gets_a_value_is_not_missed() -> None:
    """From p = 9 down x = -sqrt(p) gives z, too."""
    model = solver.loads("variables\n p = 9.5\n w = 4\n z\nrules\n x^2 = p\n w = z + (3 + x)^1.5\n")
    plan = solver.prepare(model, ["p"], ["z"])
    for p in (9.5, 9.2, 8.9, 8.5):
        roots = [x for x in (math.sqrt(p), -math.sqrt(p)) if x >= -3.0]
        wanted = sorted(4.0 - (3.0 + x) ** 1.5 for x in roots)
        assert sorted(row[0] for row in plan.all(p)) == pytest.approx(wanted, rel=1e-12)


@pytest.mark.parametrize(
    ("rules", "shear"),
    [
        ("R = sqrt((a + 40)^2 + t^2)", lambda R, a: R**2 - (a + 40) ** 2),
        ("ln(R) = ln((a + 40)^2 + t^2)/2", lambda R, a: R**2 - (a + 40) ** 2),
        ("R = sqrt(1 + exp(t)) - a", lambda R, a: (R + a) ** 2 - 1 if R + a > 0 else -1),
    ],
)
def test_a_record_knows_of_the_answer_that_its_row_has_not(rules: str, shear) -> None:
    """Of the two centres of a circle of stresses one is too far out at first, by a step behind
    another."""
    model = rulesheets.loads(f"v^2 = a^2 + 3*R^2\n{rules}")
    plan = solver.prepare(model, ["R", "v"], want=["a", "t"])
    rows = [(63.8, 114.2), (66.2, 115.0), (65.3, 115.5), (66.0, 112.6)]
    for R, v in [*rows, *rows]:
        centres = [sign * math.sqrt(v**2 - 3 * R**2) for sign in (1, -1) if v**2 > 3 * R**2]
        expected = sorted(a for a in centres if shear(R, a) > 0)
        try:
            found = sorted({round(a, 9) for a, _ in plan.all(R, v)})
        except solver.Unsolved:
            found = []
        assert found == pytest.approx(expected, rel=1e-9)


def test_a_row_after_a_refused_one_is_not_refused_by_the_rounding_of_floats() -> None:
    """R/(R + 1.7) is 1 to six digits: the distance of the horizon takes more than floats have."""
    plan = solver.prepare(rulesheets.loads("dip = acosd(R/(R + 1.7))"), ["dip"], ["R"])
    for dip in (-0.04, 0.04, -0.05, 0.05):
        if dip < 0.0:
            with pytest.raises(solver.Unsolved, match="infeasible"):
                plan(dip)
        else:
            versed = 2.0 * math.sin(math.radians(dip) / 2.0) ** 2
            assert math.isclose(plan(dip)[0], 1.7 / versed - 1.7, rel_tol=1e-12)


def test_a_row_of_zero_is_contradicted_as_a_solve_says_after_a_refused_one() -> None:
    """Without friction P*cosd(a) is W*sind(a) and N is 0 only if P is."""
    sheet = "N = m*9.81*cosd(a) + P*sind(a)\nP*cosd(a) - m*9.81*sind(a) = 0.3*N"
    model = rulesheets.loads(f"variables\n  a in [0, 360]\n  m\n  N\n  P\nrules\n{sheet}")
    plan = solver.prepare(model, ["N", "P"], ["m", "a"])
    for n in (20.0, 0.0, -20.0, 0.0):
        verdict = solver.solve(model, {"N": n, "P": 105.0}).status
        with pytest.raises(solver.Unsolved, match=str(verdict)):
            plan(n, 105.0)


def test_a_row_that_several_rules_refuse_is_refused_by_all_of_them() -> None:
    """No side leads to such an angle: neither by the law of sines nor by that of cosines."""
    text = "a*sind(C) = c*sind(A)\na^2 = b^2 + c^2 - 2*b*c*cosd(A)\nA + B + C = 180"
    sheet = f"variables\n  a = 13 > 0\n  b > 0\n  c = 15 > 0\n  A > 0 < 180\nrules\n{text}"
    plan = solver.prepare(rulesheets.loads(sheet), ["A"], ["b"])
    column = np.linspace(50.0, 120.0, 600)
    fits = 15.0 * np.sin(np.radians(column)) < 13.0
    found = statuses(plan, column)
    assert [one == "solved" for one in found] == [
        bool(one) and x < 90 for one, x in zip(fits, column, strict=True)
    ]
    assert {*found} == {"solved", "infeasible"}
    assert plan.records.refusals


@pytest.mark.parametrize(
    "rule",
    [
        "acos(x/5) + x/10 = level",
        "asin(x/5) + exp(x)/10 = level",
        "acosh(x) + x = level",
        "acos(abs(x)) + x/10 = level",
        "acosd((x^2 + 40)/(14*x)) = level",
        "sqrt(x - 3) + sqrt(9 - x)/5 = level",
        "(x - 3)^1.5 + x/2 = level",
        "x^1.5 + x = level",
        "(55 - x)/ln(55/x) = level",
        "variables\ny <= 4\nrules\ny = 2*x\ny + exp(x) = level",
    ],
)
def test_a_row_with_an_answer_is_not_refused_after_refused_ones(rule: str) -> None:
    """Roots also come and go where a rule ends to be defined: in an arc cosine, a root, a pole."""
    model = rulesheets.loads(rule)

    @cache
    def fresh(level: float) -> list[float]:
        return _answers(solver.prepare(model, ["level"], ["x"]), level)

    for refused in (-100.0, -5.0, -1.0, -0.01, 1000.0):
        plan = solver.prepare(model, ["level"], ["x"])
        for level in (refused, 1.3 * refused, 0.5, 1.0, 2.0, 3.0, 20.0, -0.02):
            assert _answers(plan, level) == pytest.approx(fresh(level)), (refused, level)


def test_a_row_with_a_root_where_a_rule_is_undefined_teaches_nothing() -> None:
    """A turbine without work: at the pressure ratio 1 its efficiency is 0/0."""
    sheet = "T = r^0.28\n0.8 = (T - 1)/(D - 1)\nw = 4*(1 - 1/T) - (D - 1)"
    plan = solver.prepare(rulesheets.loads(sheet), ["w"], ["r"])
    assert len(_answers(plan, 0.0)) == 1
    for r in (1.5, 2.5, 1.2):
        t = r**0.28
        w = 4 * (1 - 1 / t) - (t - 1) / 0.8
        found = _answers(plan, w)
        assert len(found) == 2
        assert min(abs(one - r) for one in found) < 1e-9


def test_what_is_undefined_for_fixed_numbers_alone_keeps_no_row_from_a_record() -> None:
    """A throw from the ground, h = 0, is 0/0 without a speed, at any speed of the launch."""
    sheet = (
        "vx = v0*cosd(theta)\nvy = v0*sind(theta)\nR = vx*t\nh + vy*t - g*t^2/2 = 0\n"
        "H = h + vy^2/(2*g)"
    )
    model = rulesheets.loads(f"variables\n  R = 560\n  h = 0\n  H = 72\nrules\n{sheet}\n")
    plan = solver.prepare(model, ["v0"], ["theta", "g"])
    assert len(plan.all(82.0)) == 2
    assert plan.records.programs
    for v0 in (60.0, 75.0, 110.0):
        told = [(one["theta"], one["g"]) for one in solver.solve(model, {"v0": v0}).solutions]
        assert plan.all(v0) == [pytest.approx(one) for one in told]


def _answers(plan: solver.Plan, number: float) -> list[float]:
    """The answers at a number; none where it is refused as infeasible."""
    try:
        return [row[0] for row in plan.all(number)]
    except solver.Unsolved as reason:
        assert str(reason.status) == "infeasible"
        return []


def test_a_root_that_gets_a_value_later_is_not_missed() -> None:
    """The middle one of three roots has no square root at first."""
    model = rulesheets.loads("s^3 - 2*s = L\nI^2 = s + 0.1")
    plan = solver.prepare(model, ["L"], ["I"])
    for level, count in ((0.5, 2), (0.45, 2), (0.1, 4), (0.12, 4), (0.5, 2), (-0.3, 4)):
        found = sorted(_answers(plan, level))
        roots = np.roots([1.0, 0.0, -2.0, -level]).real + 0.1
        expected = sorted(sign * math.sqrt(r) for r in roots if r > 0 for sign in (1, -1))
        assert len(found) == count
        assert found == pytest.approx(expected)


@pytest.mark.parametrize("rule", ["q = 50*tan(acos(x))", "q = 2*tan(pi/2 - x)"])
def test_a_result_that_rests_on_rounding_is_refused_by_a_record_too(rule: str) -> None:
    plan = solver.prepare(rulesheets.loads(rule), ["x"], ["q"])
    assert plan(0.3)
    assert plan(0.25)
    with pytest.raises(solver.Unsolved):
        plan(0.0)


def test_a_row_in_which_an_unknown_stays_blank() -> None:
    """A pulley without a radius does not turn, and its angular acceleration is anything."""
    sheet = "5*9.8 - T1 = 5*a\nT2 - 3*9.8 = 3*a\nI = R^2\n(T1 - T2)*R = I*alpha\na = alpha*R"
    plan = solver.prepare(rulesheets.loads(sheet), ["R"], ["a"])
    for radius in (0.1, 0.102, 0.0):
        found = _answers(plan, radius)
        fresh = solver.prepare(rulesheets.loads(sheet), ["R"], ["a"])
        assert found == pytest.approx(_answers(fresh, radius))


TWO_ROOTS = [
    ("x*y = p\nx + y = q", {"p": 9.0, "q": 7.0}),
    ("y^2 + x = p\nx + 1.6*y = q", {"p": 30.0, "q": 9.0}),
    ("abs(x - 3) = p", {"p": 4.0}),
    ("if y > 2 then x = 3.2*y else x = 5 - y\ny^2 = p", {"p": 4.5}),
]
NOT_EVERYWHERE = [
    ("u = asind(T/x)", ""),
    ("u = acosd(x/T)", ""),
    ("u = ln(x - T)", ""),
    ("u = log10(T - x)", ""),
    ("u = acosh(x/T)", ""),
    ("u = atanh(x/T)", ""),
    ("sind(u) = x/T", "x > -2 < 6"),
    ("sind(u) = x/T", "u in [0, 90]"),
    ("u*v = x\nu - v = T\nw = ln(u)", ""),
    ("u^(1/3) = x - T", ""),
    ("u = mod(x, T) + ln(x + 1)", "u in [-3, 30]"),
]


@pytest.mark.parametrize(("rule", "declared"), NOT_EVERYWHERE)
@given(block=st.sampled_from(TWO_ROOTS), data=st.data())
@settings(max_examples=4)
def test_an_answer_where_a_branch_gets_a_value_is_not_missed(
    block: tuple[str, dict[str, float]], rule: str, declared: str, data: st.DataObject
) -> None:
    rules, inputs = block
    given_numbers = {**inputs, "T": data.draw(st.floats(0.5, 5.0))}
    numbers = "".join(f" {name} = {number!r}\n" for name, number in given_numbers.items())
    model = rulesheets.loads(f"variables\n{numbers} {declared}\nrules\n{rules}\n{rule}\n")
    driver = data.draw(st.sampled_from(sorted(given_numbers)))
    want = [name for name in model.variables if name not in given_numbers]
    plan = solver.prepare(model, [driver], want)
    for share in data.draw(st.lists(st.floats(0.5, 1.6), min_size=4, max_size=4)):
        number = share * given_numbers[driver]
        result = solver.solve(model, {driver: number}, want=want)
        told = [tuple(one[name] for name in want) for one in result.solutions]
        try:
            rows = plan.all(number)
        except solver.Unsolved:
            rows = []
        assert len(rows) == len(told)
        for row in rows:
            assert any(np.allclose(row, one, rtol=1e-6, atol=1e-6) for one in told)
