"""Floats, arrays and machine code compute the same, and the pieces they are made of are right."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

import mpmath
import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

import rulesheets
import solver
from rulesheets.functions import TABLE
from rulesheets.model import Model
from rulesheets.syntax import nodes
from solver.sweeps import Plan
from solver.trace.arrays import ArrayKernel
from solver.trace.flow import Flow
from solver.trace.llvm import NativeKernel, available
from solver.trace.python import NAMES, direction_lines, sine_and_cosine, sine_and_cosine_lines
from solver.trace.rows import AnswerKernel
from tests.sampling import sampled

atan2d, cosd, sind = (TABLE[name].value for name in ("atan2d", "cosd", "sind"))

ROOT = Path(__file__).parents[3] / "models"
MODELS = sorted(path.parent.name for path in ROOT.glob("*/model.tk"))
needs_llvm = pytest.mark.skipif(not available(), reason="needs the extra jit")
X, Y = nodes.Name("x"), nodes.Name("y")


def flow_of(expression: nodes.Expression) -> tuple[Flow, int]:
    flow = Flow()
    return flow, flow.expression(expression, {"x": flow.input(0), "y": flow.input(1)})


def ulps(found: np.ndarray, expected: np.ndarray) -> np.ndarray:
    return np.abs(found - expected) / np.spacing(np.maximum(np.abs(expected), 1e-300))


def sines(degrees: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    flow, found = Flow(), (np.empty_like(degrees), np.empty_like(degrees))
    angle = flow.input(0)
    ArrayKernel(flow, [flow.node("sind", angle), flow.node("cosd", angle)])([degrees], found)
    return found


def test_sine_and_cosine_of_blocks_are_within_two_ulp_of_the_exact_ones() -> None:
    degrees = np.random.default_rng(7).uniform(-720, 720, 500)
    with mpmath.workdps(40):
        for function, found in zip((mpmath.sin, mpmath.cos), sines(degrees), strict=True):
            exact = [function(mpmath.mpf(float(d)) * mpmath.pi / 180) for d in degrees]
            errors = [
                abs(float(mpmath.mpf(float(f)) - e)) for f, e in zip(found, exact, strict=True)
            ]
            assert max(e / math.ulp(float(abs(x))) for e, x in zip(errors, exact, strict=True)) < 2


def test_special_angles_are_exact() -> None:
    special = np.array(
        [0.0, 30.0, 60.0, 90.0, 120.0, 150.0, 180.0, 210.0, 270.0, -30.0, -90.0, 360e9 + 30.0]
    )
    sine, cosine = sines(special)
    for degrees, s, c in zip(special, sine, cosine, strict=True):
        assert (abs(s) == 0.5) == (abs(sind(degrees)) == 0.5)
        assert (s, c) == pytest.approx((sind(degrees), cosd(degrees)), abs=1e-15)
        if sind(degrees) in (0.0, 1.0, -1.0, 0.5, -0.5):
            assert s == sind(degrees)
        if cosd(degrees) in (0.0, 1.0, -1.0, 0.5, -0.5):
            assert c == cosd(degrees)


@given(st.floats(-1e15, 1e15))
@example(288075239501490.0)
def test_sine_and_cosine_of_straight_line_code_are_within_two_ulp(degrees: float) -> None:
    found = sine_and_cosine(degrees)
    scope: dict[str, float] = {"a": degrees}
    exec("\n".join(sine_and_cosine_lines("a", "s", "c")), dict(NAMES), scope)
    assert (scope["s"], scope["c"]) == found
    if abs(degrees) < 1e-300:
        return  # what is subnormal in radians has fewer digits
    with mpmath.workdps(60):
        # Whole turns off first, which is exact: 60 digits of pi times many turns have fewer beyond
        # the point.
        angle = mpmath.mpf(math.fmod(degrees, 360.0)) * mpmath.pi / 180
        for function, number in zip((mpmath.sin, mpmath.cos), found, strict=True):
            exact = function(angle)
            # 60 digits of pi leave a right angle a cosine of 1e-60.
            assert abs(mpmath.mpf(number) - exact) <= 2 * math.ulp(float(abs(exact))) + 1e-50


@given(st.integers(-400, 400))
def test_multiples_of_thirty_degrees_are_exact_in_straight_line_code(twelfths: int) -> None:
    degrees = 30.0 * twelfths
    exact = {0.0, 0.5, 1.0}
    for found, accurate in zip(
        sine_and_cosine(degrees), (sind(degrees), cosd(degrees)), strict=True
    ):
        assert (
            found == accurate
            if abs(accurate) in exact
            else found == pytest.approx(accurate, rel=4e-16)
        )


@pytest.mark.parametrize("eighths", range(-3, 5))
def test_directions_of_straight_line_code_are_exact_every_45_degrees(eighths: int) -> None:
    degrees = 45.0 * eighths
    y, x = (round(math.sqrt(2) * f(math.radians(degrees))) for f in (math.sin, math.cos))
    for size in (1.0, 3.7, 1e-200):
        scope = {"y": y * size, "x": x * size}
        exec("\n".join(direction_lines("t", "y", "x")), dict(NAMES), scope)
        assert scope["t"] == degrees == atan2d(y * size, x * size)


@pytest.mark.parametrize(
    ("y", "x", "degrees"), [(-0.0, -1.0, 180.0), (-1e-300, -1.0, 180.0), (-0.0, 2.0, 0.0)]
)
def test_no_direction_is_minus_180(y: float, x: float, degrees: float) -> None:
    scope = {"y": y, "x": x}
    exec("\n".join(direction_lines("t", "y", "x")), dict(NAMES), scope)
    assert scope["t"] == degrees == atan2d(y, x)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("tand(atan2d(y, x))", lambda x, y: y / x),
        ("cosd(x + 90)", lambda x, y: -sind(x)),
        ("sind(180 - x)", lambda x, y: sind(x)),
        ("cosd(x - 270)", lambda x, y: -sind(x)),
        ("(x + y) - y", lambda x, y: x),
        ("x/(1/y)", lambda x, y: x * y),
        ("-1/(-1/x)", lambda x, y: x),
        ("2*(3*x) - y*(-4)", lambda x, y: 6 * x + 4 * y),
        ("sqrt(x)*sqrt(x) + y", lambda x, y: x + y),
        ("(-sqrt(x)/4)^2", lambda x, y: x / 16),
        ("(x - y) + y", lambda x, y: x),
        ("x + (-3)", lambda x, y: x - 3),
        ("abs(x^2 + sqrt(y))", lambda x, y: x**2 + math.sqrt(y)),
        ("1 - (1 + x)^(-y)", lambda x, y: -math.expm1(-y * math.log1p(x))),
        ("(3 - y)^2 - (y - 3)^2 + x/8", lambda x, y: x / 8),
    ],
)
def test_simplified_expressions_keep_their_value(text: str, expected: object) -> None:
    model = rulesheets.loads(f"z = {text}")
    flow, node = flow_of(model.equations[0].right)
    rng = np.random.default_rng(3)
    x, y = rng.uniform(0.5, 80, 40), rng.uniform(0.5, 80, 40)
    found = np.empty(40)
    ArrayKernel(flow, [node])([x, y], [found])
    assert found == pytest.approx([expected(a, b) for a, b in zip(x, y, strict=True)], rel=1e-15)  # type: ignore[operator]


@needs_llvm
@given(st.floats(1e-12, 0.1), st.floats(-100, 100))
def test_growth_over_many_periods_keeps_its_digits(rate: float, periods: float) -> None:
    """(1 + r)^n - 1, where r is lost in the sum: by floats, arrays and machine code."""
    flow = Flow()
    one, x, y = flow.constant(1.0), flow.input(0), flow.input(1)
    node = flow.add("sub", flow.add("pow", flow.add("add", one, x), y), one)
    with mpmath.workdps(60):
        exact = mpmath.expm1(periods * mpmath.log1p(mpmath.mpf(rate)))
    for kernel in (ArrayKernel, NativeKernel):
        found = np.empty(1)
        kernel(flow, [node])([np.array([rate]), np.array([periods])], [found])
        assert found[0] == pytest.approx(
            float(exact), rel=2e-15 * (2 + abs(periods) * rate), abs=1e-300
        )


@needs_llvm
@given(st.floats(-1e3, 1e3), st.floats(-1e3, 1e3))
def test_directions_of_machine_code_are_within_four_ulp(x: float, y: float) -> None:
    if math.hypot(x, y) < 1e-290 or 0.0 < abs(y) < 1e-290 * abs(x) + 1e-290:
        return  # what is subnormal in radians has fewer digits
    found = np.empty(1)
    _direction()([np.array([x]), np.array([y])], [found])
    with mpmath.workdps(40):
        exact = mpmath.degrees(mpmath.atan2(mpmath.mpf(y + 0.0), mpmath.mpf(x)))
        apart = abs(float(mpmath.mpf(float(found[0])) - exact))
    assert apart <= 4 * math.ulp(float(abs(exact)))


_KERNELS: dict[str, NativeKernel] = {}


def _direction() -> NativeKernel:
    if "direction" not in _KERNELS:
        flow = Flow()
        node = flow.call("atan2d", flow.input(1), flow.input(0))
        _KERNELS["direction"] = NativeKernel(flow, [node])
    return _KERNELS["direction"]


def conditioning(model: Model, plan: Plan, driver: str, number: float) -> list[float]:
    """What a last digit of the inputs or of the result itself is worth: |y| + Σ|x dy/dx| over the
    inputs."""
    result = solver.solve(model, {driver: number}, plan.want)
    slopes = result.sensitivity(plan.want)
    inputs = {
        n: abs(v) for n, v in result.inputs.items() if isinstance(v, float) and n in slopes.inputs
    }
    return [
        abs(value) + sum(size * abs(slopes[name, x] or 0.0) for x, size in inputs.items())
        if isinstance(value := result[name], float)
        else 0.0
        for name in plan.want
    ]


def apart(one: Sequence[float | str], other: Sequence[float | str]) -> float:
    """How far two answers are apart; a symbol is near to itself alone."""
    return sum(
        abs(a - b) if isinstance(a, float) and isinstance(b, float) else float(a != b)
        for a, b in zip(one, other, strict=False)
    )


@needs_llvm
@pytest.mark.parametrize("name", sampled(MODELS, 2, 1))
def test_floats_arrays_machine_code_and_steps_agree_to_four_ulp_on_every_model(name: str) -> None:
    """Times conditioning: what as much in the inputs would do."""
    model = rulesheets.load(str(ROOT / name / "model.tk"))
    numbers = {n: v.value for n, v in model.variables.items() if isinstance(v.value, float)}
    want = [n for n, v in model.variables.items() if v.posted and v.value is None]
    driver = next((n for n in numbers if model.variables[n].unit == "deg"), None) or next(
        iter(numbers), None
    )
    if driver is None:
        return
    plan = solver.prepare(model, [driver], want)
    value = numbers[driver]
    plan(value)
    rng = np.random.default_rng(len(name))
    rows = value * (1.0 + np.concatenate([[0.0], rng.uniform(-0.02, 0.02, 2)]))
    if model.variables[driver].unit == "deg":
        rows = np.concatenate([rows, rng.uniform(-180.0, 180.0, 2)])
    assert plan.records.programs
    program, scalar = plan.records.programs[0], plan.records.every[0]
    (arrays, holds), (native, also) = (
        AnswerKernel(program, jit, np.array([np.inf]))([rows]) for jit in (False, True)
    )
    assert (holds == also).all() and holds[0]
    assert (arrays.counts == native.counts).all()
    for row in np.flatnonzero(holds):
        number = float(rows[row])
        steps = plan.judged((number,))[0].leaves[0].branch.values
        answers = scalar(number)
        place = min(
            range(len(answers)), key=lambda k: apart(answers[k], [steps[name] for name in want])
        )
        for at, scale in enumerate(conditioning(model, plan, driver, number)):
            several = [kind.planes[place][at][row] for kind in (arrays, native)]
            found = answers[place][at], *several, steps[want[at]]
            if isinstance(found[0], str):
                assert all(one == found[0] for one in found)
                continue
            one, *others = map(float, found)
            assert max([one, *others]) - min([one, *others]) <= 4 * 2.0**-52 * scale


def test_rows_beside_the_record_take_as_many_steps_as_they_need() -> None:
    """Two of the three answers are near a fold: two steps are not enough for them, one is for the
    third."""
    model = rulesheets.load("four_link_chain")
    speed = float(solver.solve(model)["omegaQR"])
    plan = solver.prepare(model, ["omegaQR"], ["PQ"], {"PQ": None})
    plan.all(speed)
    (program,) = plan.records.programs
    column = np.linspace(0.993 * speed, 1.007 * speed, 1000)
    planes, there, holds = AnswerKernel(program, False, np.array([np.inf])).quick([column])
    assert there.all() and holds.all()
    found = np.array(planes)[:, 0]
    for row in (0, 500, 999):
        answers = sorted(one for (one,) in plan.all(float(column[row])))
        assert sorted(found[:, row]) == pytest.approx(answers, rel=1e-12)


@needs_llvm
def test_roots_that_take_many_steps_are_found_together_beside_machine_code(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """What a loop of machine code holds are only a few steps of a block."""
    model = solver.loads("exp(-y)*x + y^3 + sin(x*y) = c\ny*x^2 + ln(1 + x^2) + y = d\n")
    plan = solver.prepare(model, ["c", "d"], ["x", "y"])
    rng = np.random.default_rng(1)
    columns = rng.uniform(3.0, 3.9, 3000), rng.uniform(2.0, 3.0, 3000)
    assert plan.sweep(*columns).solved.all()
    alone: list[object] = []
    monkeypatch.setattr(plan.records, "known", lambda numbers: alone.append(numbers))
    assert plan.sweep(*columns, jit=True).solved.all()
    assert len(alone) < 60


def test_a_missing_extra_is_told_at_every_sweep(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("solver.trace.llvm.available", lambda: False)
    plan = solver.prepare(solver.loads("variables\nx\nk\nrules\nx^2 + k*x = 3\n"), ["k"], ["x"])
    for _ in range(2):
        with pytest.raises(ImportError, match="llvmlite"):
            plan.sweep(np.linspace(1.0, 5.0, 40), jit=True)


@pytest.mark.parametrize("jit", [False, pytest.param(True, marks=needs_llvm)])
def test_a_condition_on_the_sine_of_a_huge_angle_is_left_to_a_solve(jit: bool) -> None:
    """Rows have no sines beyond 1e15 degrees: what is not known to be larger is not smaller for
    that."""
    plan = solver.prepare(solver.loads("if cosd(x) > 0.5 then y = 1 else y = 2"), ["x"], ["y"])
    plan(70.0)
    table = plan.sweep(np.array([70.0, 80.0, 100.0] * 8 + [3.6e15]), jit=jit)
    assert table["y"].tolist() == [2.0] * 24 + [1.0]
