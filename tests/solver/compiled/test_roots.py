"""Iterated blocks in compiled ways: a root only where it is proven to be the only one."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import rulesheets
import solver
from solver.compiled.roots import RootFinder

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
