"""Blocks of several tears with one unknown from which the others follow by formulas: all their
answers."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import brentq

import rulesheets
import solver

MODELS = Path(__file__).parents[3] / "models"
FLASH = rulesheets.load(MODELS / "rachford_rice" / "model.tk")
ANY_FEED = solver.prepare(FLASH, ["z1", "z2", "z3"], ["V", "x1", "y4"])
K = np.array([4.2, 1.75, 0.74, 0.34])


def rachford_rice(V: float, z: np.ndarray) -> float:
    """Falls over the whole range of V, whatever the feed is."""
    return float((z * (K - 1.0) / (1.0 + V * (K - 1.0))).sum())


@settings(max_examples=12, deadline=None)
@given(st.floats(0.02, 0.5), st.floats(0.02, 0.25), st.floats(0.02, 0.2))
def test_the_vapour_of_a_flash_is_proven_to_be_the_only_one(
    z1: float, z2: float, z3: float
) -> None:
    z = np.array([z1, z2, z3, 1.0 - z1 - z2 - z3])
    verdict, found = ANY_FEED.judged((z1, z2, z3))
    assert found.complete
    if rachford_rice(0.0, z) * rachford_rice(1.0, z) > 0.0:
        assert str(verdict.status) == "infeasible"
        return
    V = brentq(rachford_rice, 0.0, 1.0, args=(z,), xtol=1e-15)
    (leaf,) = verdict.leaves
    values = leaf.branch.values
    assert str(verdict.status) == "solved"
    assert values["V"] == pytest.approx(V, abs=1e-13)
    assert values["x1"] == pytest.approx(z1 / (1 + V * 3.2), rel=1e-12)
    assert values["y4"] == pytest.approx(0.34 * z[3] / (1 - V * 0.66), rel=1e-12)


def test_a_flash_is_compiled_and_its_rows_are_those_of_the_closed_balances() -> None:
    plan = solver.prepare(FLASH, ["z1"], ["V", "x1"])
    plan(0.1)
    assert plan.records.programs
    rows = np.linspace(0.07, 0.14, 60)
    table = plan.sweep(rows)
    assert not table.status.any()
    for z1, V, x1 in zip(rows[::7], table["V"][::7], table["x1"][::7], strict=True):
        z = np.array([z1, 0.2, 0.3, 1.0 - z1 - 0.2 - 0.3])
        assert brentq(rachford_rice, 0.0, 1.0, args=(z,), xtol=1e-15) == pytest.approx(V, abs=1e-13)
        assert x1 == pytest.approx(z1 / (1 + V * 3.2), rel=1e-13)


def test_definitions_that_lead_to_one_another_are_put_in_one_after_the_other() -> None:
    """p is twice q and q is one more than r: two rules remain; every answer within the ranges is
    found."""
    model = rulesheets.loads(
        "variables\n  c = 1\n  p in [-20, 20]\n  q in [-20, 20]\n  r in [-20, 20]\n  s in [-20, "
        "20]\nrules\n"
        "  p = 2*q\n  q = r + 1\n  s = exp(r/10)*p - 6*sin(r)\n  s*q - p*sin(q) = c\n"
    )
    result = solver.solve(model)

    def miss(r: np.ndarray) -> np.ndarray:
        q, p = r + 1.0, 2.0 * (r + 1.0)
        return (np.exp(r / 10) * p - 6 * np.sin(r)) * q - p * np.sin(q) - 1.0

    grid = np.linspace(-11.0, 9.0, 400_001)
    s = np.exp(grid / 10) * 2 * (grid + 1) - 6 * np.sin(grid)
    values = miss(grid)
    changes = np.flatnonzero((values[1:] > 0) != (values[:-1] > 0))
    expected = [grid[i] for i in changes if abs(s[i]) < 20]
    found = sorted(solution["r"] for solution in result.solutions)
    assert found == pytest.approx(expected, abs=1e-4)
    assert result.complete


@pytest.mark.parametrize(
    ("name", "given", "unknown", "beside"),
    [
        ("whitworth_quick_return", "xe", "phi", "xE"),
        ("piston_engine", "vP", "phi", "thetaBP"),
        ("four_link_chain", "yr", "thetaPQ", "thetaQR"),
        ("four_link_chain", "ym1", "thetaPQ", "thetaQR"),
        ("two_cylinder_engine", "ye1", "thetaOB", "thetaEF"),
        ("two_cylinder_engine", "omegaEF", "thetaOB", "thetaEF"),
    ],
)
def test_a_speed_is_met_at_every_angle_at_which_a_turn_passes_it(
    name: str, given: str, unknown: str, beside: str
) -> None:
    """It is turned forward by quarters of a degree; its assemblies are told by ``beside``."""
    model = rulesheets.load(MODELS / name / "model.tk")
    target = solver.solve(model).solutions[0][given]
    assert isinstance(target, float)
    forward = solver.prepare(model, [unknown], [beside, given])
    turn = np.linspace(-180.05, 179.95, 1441)
    states = [sorted(forward.all(float(angle))) for angle in turn]
    passed = [
        angle
        for angle, here, there in zip(turn, states, states[1:], strict=False)
        for (_, one), (_, other) in zip(here, there, strict=True)
        if (one - target) * (other - target) < 0.0
        and abs(one - other) < 0.2 * max(1.0, abs(target))
    ]
    result = solver.solve(model, {given: target, unknown: None})
    found = sorted(float(solution[unknown]) for solution in result.solutions)
    assert found == pytest.approx(sorted(passed), abs=0.26)
    assert result.complete or given == "ye1"
