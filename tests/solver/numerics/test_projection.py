"""Gauss–Newton of least norm, against solution sets in closed form."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from solver.numerics.box_search import GAUSS_NEWTON, arrivals

ENDLESS = np.array([np.inf, np.inf])
coordinates = st.floats(0.2, 5.0).map(lambda x: round(x, 3))


def circle(points: Any) -> Any:
    """x² + y² = 4, and the same rule once more."""
    miss = (points**2).sum(axis=1) - 4.0
    return np.stack([miss, miss * (miss + 8.0)], axis=1)


def slopes(points: Any) -> Any:
    miss = (points**2).sum(axis=1)[:, None] - 4.0
    return np.stack([2.0 * points, (2.0 * miss + 8.0) * 2.0 * points], axis=1)


def ends(starts: Any, low: Any = -ENDLESS, high: Any = ENDLESS) -> Any:
    at = np.array(starts, dtype=float)
    return arrivals(circle, slopes, at, np.full(2, 10.0), GAUSS_NEWTON, (low, high))


@settings(max_examples=60, deadline=None)
@given(coordinates, coordinates)
def test_a_repeated_rule_is_met_straight_ahead(x: float, y: float) -> None:
    """Steps of least norm keep to the ray from the centre."""
    (end,) = ends([[x, y]])
    assert end == pytest.approx(2.0 * np.array([x, y]) / np.hypot(x, y), rel=1e-6)


def test_an_end_stays_in_its_range() -> None:
    found = ends([[1.5, 1.0], [4.0, 0.1]], low=np.array([1.0, 0.0]), high=np.array([np.inf, 1.5]))
    assert len(found) > 0
    assert all(x >= 1.0 and 0.0 <= y <= 1.5 for x, y in found)
    assert np.hypot(*found.T) == pytest.approx(2.0)


def test_what_has_no_solution_arrives_nowhere_that_is_one() -> None:
    def apart(points: Any) -> Any:
        return circle(points) + np.array([0.0, 1.0])

    starts = np.array([[1.0, 2.0], [3.0, -1.0]])
    found = arrivals(apart, slopes, starts, np.ones(2), GAUSS_NEWTON)
    assert all(abs(apart(end[None, :])).max() > 1e-3 for end in found)
