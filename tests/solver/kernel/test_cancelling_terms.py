"""Terms that cancel between the rules of a block, beside a minimum, a maximum or a power: the
statuses and the lists are those of a scan."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeAlias

import numpy as np
import pytest

import rulesheets
import solver
from solver import Status

Array: TypeAlias = np.ndarray[Any, np.dtype[np.float64]]

SHEET = "w - ({}) = x\nw = x + y"
"""The rules say that y is the expression, of an x that cancels otherwise."""
SHARES: dict[str, Callable[[Array], Array]] = {
    "min(x/2, 3)": lambda x: np.minimum(x / 2, 3),
    "min(x^2, 4)": lambda x: np.minimum(x**2, 4),
    "max(x - 1, 0)^2": lambda x: np.maximum(x - 1, 0) ** 2,
    "abs(x) + x": lambda x: np.abs(x) + x,
    "abs(x) + 2*abs(x - 3)": lambda x: np.abs(x) + 2 * np.abs(x - 3),
    "min(max(x, 1), 4)": lambda x: np.minimum(np.maximum(x, 1), 4),
    "min(x^2, 2*x, 3)": lambda x: np.minimum(np.minimum(x**2, 2 * x), 3),
    "sqrt(max(x, 0)) + min(x, 1)": lambda x: np.sqrt(np.maximum(x, 0)) + np.minimum(x, 1),
    "x*step(x, 2)": lambda x: x * (x >= 2),
    "x*exp(-x)": lambda x: x * np.exp(-x),
}
POINTS = np.concatenate([-np.logspace(4, -4, 50_000), np.logspace(-4, 4, 50_000)])


@pytest.mark.parametrize("y", [-7.0, 0.3, 2.5, 50.0])
@pytest.mark.parametrize("share", SHARES)
def test_a_scan_finds_the_same(share: str, y: float) -> None:
    with np.errstate(over="ignore"):
        misses = SHARES[share](POINTS) - y
    before = np.flatnonzero(np.diff(np.sign(misses)))
    crossings = [POINTS[k] for k in before if abs(misses[k + 1] - misses[k]) < 1]
    result = solver.solve(rulesheets.loads(SHEET.format(share)), {"y": y})
    found = sorted(float(solution["x"]) for solution in result.solutions)
    assert result.status is (Status.SOLVED if crossings else Status.INFEASIBLE)
    assert found == pytest.approx(crossings, rel=1e-3)
    assert result.complete


REAGENTS = "xi = min(nA/a, nB)\nleftA = nA - a*xi\nleftB = nB - xi"


@pytest.mark.parametrize("a", [2.0, 3.0, 1.1])
@pytest.mark.parametrize("left", [-1.0, 0.0, 0.7])
def test_the_reagent_that_is_left(left: float, a: float) -> None:
    """The one that limits is used up, and none is left owing."""
    model = rulesheets.loads(REAGENTS)
    result = solver.solve(model, {"a": a, "leftA": left, "nB": 5.0})
    statuses = {-1.0: Status.INFEASIBLE, 0.0: Status.PARTIAL, 0.7: Status.SOLVED}
    assert result.status is statuses[left]
    if left > 0.0:
        assert result.complete
        assert result["nA"] == pytest.approx(left + 5.0 * a, rel=1e-14)


@pytest.mark.parametrize("left", [(1.0, 2.0), (0.7, 0.1), (-1.0, 0.0), (0.0, -2.0)])
def test_reagents_that_are_both_left_contradict(left: tuple[float, float]) -> None:
    inputs = dict(zip(("leftA", "leftB"), left, strict=True))
    result = solver.solve(rulesheets.loads(REAGENTS), {"a": 2.0, **inputs})
    assert result.status is Status.INFEASIBLE


def test_reagents_of_which_one_is_left_may_be_any() -> None:
    inputs = {"a": 2.0, "leftA": 0.0, "leftB": 1.5}
    assert solver.solve(rulesheets.loads(REAGENTS), inputs).status is Status.PARTIAL
