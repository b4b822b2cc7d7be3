"""How small the numbers of a program can be, and rows that a compiled way has to leave for that."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st

import rulesheets
import solver
from solver.compiled.array import ArrayKernel
from solver.compiled.flow import Flow, NotCompilable
from solver.compiled.magnitude import sizes, stands_out, whole
from solver.table import CODES
from tests.solver.compiled.test_rounding import NUMBERS, equation, expressions

FINITE = st.floats(allow_nan=False, allow_infinity=False, allow_subnormal=True)


@settings(max_examples=80, deadline=None)
@given(expressions(st.one_of(NUMBERS, st.sampled_from(["x", "y"]))), FINITE, FINITE)
@example("(0.1 / (x)^2)", 1.3407807929942597e154, 0.0)
def test_every_number_of_a_program_lies_within_its_size(text: str, x: float, y: float) -> None:
    flow = Flow()
    values = {"x": flow.input(0), "y": flow.input(1)}
    try:
        flow.expression(equation(f"z = {text}").right, values)
    except NotCompilable:
        return
    known = sizes(flow)
    nodes = [n for n, kind in enumerate(flow.nodes) if not isinstance(kind[1], bool) and kind[0] in COMPUTED]
    found = [np.empty(1) for _ in nodes]
    ArrayKernel(flow, nodes)([np.array([x]), np.array([y])], found)
    finite = {node for node, (number,) in zip(nodes, found, strict=True) if math.isfinite(number)}
    if any(node in nodes and node not in finite for node in flow.finite):
        return  # what is computed from a divisor that overflows does not count
    for node, (number,) in zip(nodes, found, strict=True):
        if node not in finite:
            continue
        assert number != 0.0 or known[node].zero, flow.nodes[node]
        if number:
            power = math.frexp(number)[1]
            assert known[node].low <= power and power - 1 <= known[node].high, flow.nodes[node]


COMPUTED = {"const", "input", "add", "sub", "mul", "div", "neg", "abs", "sqrt", "sin", "cos", "sind", "cosd"}


@given(st.floats(0.5, 1.0), st.floats(0.5, 1.0), st.integers(-1070, 1020), st.integers(-60, 60))
def test_a_difference_of_floats_is_0_or_no_less_than_their_last_places(
    a: float, b: float, power: int, apart: int
) -> None:
    x, y = math.ldexp(a, power), math.ldexp(b, max(-1074, min(1020, power + apart)))
    assume(x and y)
    for rest in (x - y, x + y):
        assert rest == 0.0 or abs(rest) >= 2.0**-54 * max(x, y)


def test_what_the_form_of_a_program_tells_needs_no_look_at_its_numbers() -> None:
    flow = Flow()
    x = flow.input(0)
    sine = flow.call("sind", x)
    assert whole(flow, flow.add("mul", flow.constant(3.0), flow.call("cosd", x))) == flow.true
    assert whole(flow, flow.add("div", flow.constant(3.0), flow.constant(7.0))) == flow.true
    assert whole(flow, flow.add("mul", sine, sine)) != flow.true  # of a tiny angle
    assert whole(flow, flow.add("div", flow.constant(3.0), x)) != flow.true
    assert whole(flow, flow.add("div", x, flow.constant(3.0))) == flow.true  # two digits at most
    root = flow.add("sqrt", flow.add("sub", flow.constant(64.0), flow.add("mul", sine, sine)))
    assert stands_out(flow, root, sine) == flow.true
    assert stands_out(flow, sine, root) != flow.true
    assert stands_out(flow, sine, x) != flow.true


LEFT_ALONE = {
    "a product whose factor is far below floats": ("b*x = 3e-30", (2.0, 1.0, 1e300), "failed"),
    "a quotient": ("x/1e-300 = b", (2.0, 3.0, 1e-300), "failed"),
    "a factor of a product": ("x*b*1e-20 = 3e-30", (2.0, 1.0, 1e305), "failed"),
    "a divisor that is 0": ("b/x = 3", (2.0, 1.0, 0.0), "singular"),
    "a divisor of a divisor": ("360/(b/x) = 0.25", (2.0, -3.0, 0.0), "singular"),
    "a divisor that its sum holds nothing of": ("y + b = 2.5\n(y + b)*x = 4", (2.0, 1.0, -1e300), "singular"),
    "a sum that holds nothing of a number": ("y + b = 2.5\n(y + b)/x^3 = 4", (2.0, 1.0, -1e300), "singular"),
    "the pole of a tangent": ("tan(pi/b) = x", (3.0, 2.5, 2.0), "failed"),
    "a tangent of an angle of any size": ("x - tan(b) = cos(b)", (2.0, 1.0, 1e16), "singular"),
    "a cosine of an angle of any size": ("x/cos(b) = 0.5", (2.0, 1.0, 1e300), "singular"),
    "a missing number": ("if b > 3 then x = b else x = 5", (2.0, 1.0, math.nan), "partial"),
}


@pytest.mark.parametrize(("rules", "points", "status"), LEFT_ALONE.values(), ids=LEFT_ALONE)
def test_rows_that_a_solve_refuses_are_no_answers_of_a_plan(
    rules: str, points: tuple[float, ...], status: str
) -> None:
    """``b``: two numbers to learn from, and one with which the rules have no answer in floats."""
    model = rulesheets.loads(rules + "\n")
    want = [name for name in model.variables if name != "b"]
    *fine, bad = points
    plan = solver.prepare(model, ["b"], want)
    for b in fine:
        expected = solver.solve(rulesheets.loads(rules + "\n"), {"b": b}, want)
        assert plan(b) == pytest.approx([expected[name] for name in want], rel=1e-14)
    assert plan.paths.programs, "nothing was learned, nothing is tried"
    for call in (plan, plan.all):
        with pytest.raises(solver.Unsolved) as refused:
            call(bad)
        assert str(refused.value.status) == status
    rows = np.array([*fine, bad] * 12)
    codes = {CODES[said]: str(said) for said in solver.Status}
    expected_codes = ["solved", "solved", status] * 12
    fresh = solver.prepare(model, ["b"], want)
    table = fresh.sweep(rows)
    assert [codes[int(code)] for code in table.status] == expected_codes
    assert np.isnan(table["x"]).tolist() == [False, False, True] * 12
    assert [codes[int(code)] for code in fresh.sweep_all(rows)[0]] == expected_codes


def test_answers_as_near_to_the_guesses_come_in_the_order_of_those_without_guesses() -> None:
    """Both lie 1e150 from the guesses, as far as floats tell."""
    rules = "variables\n  a\n  x ~ -0.288\n  y ~ -0.423\nrules\n  x + y = -1.29\n  x*y = a\n"
    plan = solver.prepare(rulesheets.loads(rules), ["a"])
    plan(-7.0)
    assert plan.paths.programs
    for answers in (plan.all(-1e300), plan.sweep_all(np.full(40, -1e300))[1].values[0][:2]):
        first = answers[0][0] if isinstance(answers, list) else answers[0]
        assert first == pytest.approx(1e150)
    result = solver.solve(rulesheets.loads(rules), {"a": -1e300})
    assert [solution["x"] for solution in result.solutions] == pytest.approx([1e150, -1e150])


def test_a_divisor_that_is_a_quotient_loses_no_digits() -> None:
    """a*x/(x/b) is computed as (a*x*b)/x, which is 0 where a*x*b is below floats."""
    rules = "x = b\n(x/b)*(b + y) = a*x\n"
    plan = solver.prepare(rulesheets.loads(rules), ["a", "b"], ["y"])
    assert plan(1.5, 2.0) == pytest.approx([1.0])
    assert plan(1e16, 1e-300) == pytest.approx([1e-284], rel=1e-14)
    table = plan.sweep(np.array([1.5, 1e16] * 12), np.array([2.0, 1e-300] * 12))
    assert table["y"] == pytest.approx([1.0, 1e-284] * 12, rel=1e-14)


@pytest.mark.parametrize(
    ("rules", "point", "right"),
    [
        ("x/a = b/a", (1e16, 1e-300), 1e-300),  # digits are lost in b/a
        ("x = sqrt(a*b)", (1e-300, 1e-300), 1e-300),
        ("2*x = sqrt(a*b)", (1e-300, 1e-300), 5e-301),
        ("x = sqrt(a^2 + b^2)", (1e-200, -1e-200), math.sqrt(2.0) * 1e-200),
        ("x = (a*b)^0.25", (1e-300, 1e-300), 1e-150),
    ],
)
def test_what_underflows_on_the_way_is_not_lost(rules: str, point: tuple[float, float], right: float) -> None:
    plan = solver.prepare(rulesheets.loads(rules + "\n"), ["a", "b"], ["x"])
    plan(1.5, 2.0)
    assert plan.paths.programs
    assert plan(*point) == pytest.approx([right], rel=1e-14, abs=0.0)
    table = plan.sweep(
        *(np.array([plain, number] * 12) for plain, number in zip((1.5, 2.0), point, strict=True))
    )
    assert table["x"][1::2] == pytest.approx([right] * 12, rel=1e-14, abs=0.0)


@pytest.mark.parametrize(
    ("rules", "point"),
    [
        ("x/(sqrt(b) - (90 - b)) = a^3", (1e-300, 0.14)),
        ("x*b = exp(a)", (-1e300, 2.0)),
        ("x = b*exp(a)", (-1e300, 2.0)),
        ("x/(cos(b)/b) = a - 0.5", (1.0, 1e16)),
        ("x/(tand(b) - a) = a - 4", (0.54, -1e300)),
        ("x/(a/b)^(-1) = b - b", (0.0, 45.0)),
        ("x/asind(b - 1.5) = a - a", (1.5, 5.67)),
    ],
)
def test_a_plan_calls_nothing_solved_that_a_solve_does_not(rules: str, point: tuple[float, float]) -> None:
    """Values below floats, divisors without a value or that an angle's last places decide, a power of 0."""
    model = rulesheets.loads(rules + "\n")
    status = solver.solve(rulesheets.loads(rules + "\n"), dict(zip("ab", point, strict=True)), ["x"]).status
    assert status is not solver.Status.SOLVED
    plan = solver.prepare(model, ["a", "b"], ["x"])
    plan(1.5, 2.0)
    assert plan.paths.programs
    with pytest.raises(solver.Unsolved) as refused:
        plan(*point)
    assert refused.value.status is status
    table = plan.sweep(
        *(np.array([plain, number] * 12) for plain, number in zip((1.5, 2.0), point, strict=True))
    )
    codes = {CODES[said]: said for said in solver.Status}
    assert [codes[int(code)] for code in table.status] == [solver.Status.SOLVED, status] * 12
