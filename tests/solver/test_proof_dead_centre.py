"""Towards dead centre every proved number is the float nearest to the closed form at 200 digits."""

from __future__ import annotations

import math
from pathlib import Path

import mpmath
import pytest

import rulesheets
import solver
from tests.oracles import slider_crank as oracle
from tests.oracles.slider_crank import Crank

pytest.importorskip("flint")

MODEL = rulesheets.load(Path(__file__).parent.parent.parent / "models/offset_slider_crank/model.tk")
AO, AB, OFFSET, OMEGA, ALPHA = 3.0, 8.0, 2.0, -15.0, -10.0
DISTANCES = tuple(10.0**-k for k in range(1, 16))
SOME = (DISTANCES[4], DISTANCES[9], DISTANCES[14])


@pytest.fixture(autouse=True)
def many_digits(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(oracle, "DIGITS", 200)


def assert_nearest(solution: solver.Solution, exact: dict[str, mpmath.mpf]) -> None:
    assert solution.proof is not None
    assert solution.proof.proved, solution.proof.obstacle
    assert solution.proof.nearest
    for name, number in exact.items():
        if name in solution:
            assert solution[name] == float(number), name


@pytest.mark.parametrize("distance", SOME)
@pytest.mark.parametrize("branch", ["open", "crossed"])
@pytest.mark.parametrize("reach", [AO + AB, AB - AO], ids=["outer", "inner"])
def test_driven_by_the_slider(reach: float, branch: str, distance: float) -> None:
    """The end of the stroke where crank and rod lie stretched, and that where they lie folded."""
    away = -distance if reach > AB else distance
    x = math.copysign(math.sqrt(reach**2 - OFFSET**2) * (1 + away), 1 if branch == "open" else -1)
    result = solver.solve(MODEL, {"branch": branch, "thetaAO": None, "xB": x}, prove=True)
    angles = oracle.crank_angles(AO, AB, OFFSET, x)
    assert str(result.status) == "solved"
    assert result.complete
    assert sorted(s["thetaAO"] for s in result.solutions) == sorted(map(float, angles))
    for angle in angles:
        exact = oracle.forward(Crank(AO, AB, OFFSET, OMEGA, ALPHA, angle, branch == "open"))
        (found,) = (s for s in result.solutions if s["thetaAO"] == float(angle))
        assert_nearest(found, exact)


@pytest.mark.parametrize("reach", [AO + AB, AB - AO], ids=["outer", "inner"])
def test_driven_by_the_crank(reach: float) -> None:
    """Where the slider nearly stands still, its velocity is all but cancelled."""
    stretched = math.degrees(math.asin(OFFSET / reach))
    at_rest = stretched if reach > AB else stretched - 180.0
    for distance in DISTANCES:
        angle = at_rest * (1 - distance)
        result = solver.solve(MODEL, {"thetaAO": angle}, prove=True)
        assert str(result.status) == "solved"
        (found,) = result.solutions
        assert_nearest(found, oracle.forward(Crank(AO, AB, OFFSET, OMEGA, ALPHA, angle)))


@pytest.mark.parametrize("distance", SOME)
def test_the_rates_of_the_crank_from_those_of_the_slider(distance: float) -> None:
    x = math.sqrt((AO + AB) ** 2 - OFFSET**2) * (1 - distance)
    inputs = {"xB": x, "vB": -0.5, "aB": -700.0, "thetaAO": None, "omegaAO": None, "alphaAO": None}
    result = solver.solve(MODEL, inputs, prove=True)
    angles = oracle.crank_angles(AO, AB, OFFSET, x)
    assert sorted(s["thetaAO"] for s in result.solutions) == sorted(map(float, angles))
    for angle in angles:
        omega, alpha = oracle.crank_rates(AO, OFFSET, x, angle, -0.5, -700.0)
        (found,) = (s for s in result.solutions if s["thetaAO"] == float(angle))
        assert_nearest(found, {"omegaAO": omega, "alphaAO": alpha})
