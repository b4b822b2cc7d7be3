"""Iterated blocks in compiled ways: a root only where it is proven to be the only one."""

from __future__ import annotations

import math
from pathlib import Path

import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import rulesheets
import solver
from solver.compiled.roots import RootFinder

MODELS = Path(__file__).parents[3] / "models"
KEPLER = solver.prepare(
    rulesheets.loads("variables\n  e = 0.3\n  M = 1\n  E in [-4, 4]\nrules\n  M = E - e*sin(E)\n"),
    ["e", "M"],
    ["E"],
)
CUBIC = solver.prepare(rulesheets.loads("x^3 - a*x + sin(x)/10 = b"), ["a", "b"], ["x"])


@settings(max_examples=60)
@given(st.floats(0.0, 0.95), st.floats(-3.0, 3.0))
def test_a_monotonic_residual_has_its_root(e: float, M: float) -> None:
    KEPLER(0.3, 1.0)
    (E,) = KEPLER(e, M)
    assert abs(E - e * math.sin(E) - M) <= 8e-16 * (abs(E) + abs(M)) + 1e-300
    assert KEPLER.sweep([e], [M])["E"][0] == pytest.approx(E, rel=1e-15)


def test_rows_are_iterated_together() -> None:
    KEPLER(0.3, 1.0)
    e, M = (axis.ravel() for axis in np.meshgrid(np.linspace(0, 0.9, 40), np.linspace(-3, 3, 50)))
    E = KEPLER.sweep(e, M)["E"]
    assert np.abs(E - e * np.sin(E) - M).max() < 1e-14
    assert KEPLER.paths.programs


@settings(max_examples=40)
@given(st.floats(-3.0, 3.0), st.floats(-2.0, 2.0))
def test_no_root_of_several_is_passed_off_as_the_only_one(a: float, b: float) -> None:
    """Three roots where a is large and b small: all of them, or the step-by-step way's word."""
    CUBIC(-1.0, 1.0)
    grid = np.linspace(-4, 4, 4001)
    values = grid**3 - a * grid + np.sin(grid) / 10 - b
    crossings = int((np.sign(values[1:]) != np.sign(values[:-1])).sum())
    if np.abs(values).min() > 1e-3:
        assert len(CUBIC.all(a, b)) >= crossings


def test_what_is_not_proven_is_no_number() -> None:
    model = rulesheets.loads("x^3 - a*x + sin(x)/10 = b")
    plan = solver.prepare(model, ["a", "b"], ["x"])
    plan(-1.0, 1.0)
    finders = [finder for program in plan.paths.programs for finder in program.flow.finders]
    assert finders and all(isinstance(finder, RootFinder) for finder in finders)
    (finder,) = finders[:1]
    known = {"a": 2.0, "b": 0.1}
    with pytest.raises(ValueError):
        finder.scalar(*(known[name] for name in finder.known))
    roots = finder.array(*(np.full(5, known[name]) for name in finder.known))
    assert np.isnan(roots).all()


def test_every_root_of_a_gas_below_its_critical_temperature_is_followed() -> None:
    """The molar volume is a root of a cubic: three of them, proven and in order."""
    model = rulesheets.load(str(MODELS / "van_der_waals" / "model.tk"))
    plan = solver.prepare(model, ["P"], ["Vm"], {"T": 280.0})
    a, b, RT = 3.592, 0.04267, 0.0820573661 * 280.0
    plan.all(50.0)
    (way,) = plan.paths.every
    for P in (48.0, 49.3, 50.0, 51.7):
        found = way(P)
        assert found is not None and len(found) == 3
        exact = np.sort(np.roots([P, -(P * b + RT), a, -a * b]).real)
        assert sorted(row[0] for row in found) == pytest.approx(exact, rel=1e-12)
    rows = np.linspace(48.0, 52.0, 500)
    volumes = plan.sweep(rows)["Vm"]
    assert np.abs((rows + a / volumes**2) * (volumes - b) / RT - 1).max() < 1e-13
    assert volumes[::50] == pytest.approx([plan(P)[0] for P in rows[::50]], rel=1e-14)


@settings(max_examples=30)
@given(st.floats(75.0, 130.0))
def test_both_elevations_of_a_projectile_come_from_one_way(v0: float) -> None:
    plan = PROJECTILE
    plan.all(82.0)
    (way,) = plan.paths.every
    found = way(v0)
    assert found is not None
    twice = math.degrees(math.asin(9.8 * 560.0 / v0**2))
    assert sorted(row[0] for row in found) == pytest.approx([twice / 2, 90.0 - twice / 2], rel=1e-12)


PROJECTILE = solver.prepare(
    rulesheets.load(str(MODELS / "projectile" / "model.tk")), ["v0"], ["theta", "t", "H"]
)


@settings(max_examples=30)
@given(st.floats(-0.3, 0.3))
def test_a_root_on_either_side_of_a_gap_is_counted(a: float) -> None:
    """The residual rises on both sides of the stretch from -1 to 1, where it is not defined."""
    plan = GAP
    plan.all(0.01)
    found = plan.all(a)
    exact = sorted(
        (float(mpmath.findroot(lambda x: x * mpmath.log(x * x - 1) - a, side)) for side in (1.4, -1.4)),
        key=lambda x: (x < 0, abs(x)),
    )
    assert [row[0] for row in found] == pytest.approx(exact, rel=1e-13)


GAP = solver.prepare(
    rulesheets.loads("variables\n  a = 0.01\n  x\nrules\n  x*ln(x^2 - 1) = a\n"), ["a"], ["x"]
)


@settings(max_examples=40)
@given(st.floats(-1.0, 1.0), st.floats(0.0, 0.6))
def test_as_many_roots_as_a_wave_has_crossings(b: float, a: float) -> None:
    WAVE.all(0.1, 0.1)
    grid = np.linspace(-10.0, 10.0, 8001)
    values = np.sin(grid) - a * grid - b
    crossings = int(((values[1:] > 0) != (values[:-1] > 0)).sum())
    turning = np.sign(np.diff(values))
    flat = np.flatnonzero(turning[1:] != turning[:-1]) + 1
    if np.abs(values[[0, *flat, -1]]).min() < 1e-3:
        return  # a double root, or one at the end of the range
    assert WAVE.paths.every
    for way in WAVE.paths.every:
        found = way(a, b)
        assert found is None or len(found) == crossings


WAVE = solver.prepare(
    rulesheets.loads("variables\n  a = 0.1\n  b = 0.1\n  x in [-10, 10]\nrules\n  sin(x) - a*x = b\n"),
    ["a", "b"],
    ["x"],
)
