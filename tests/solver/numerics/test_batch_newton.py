"""Newton on many starts at once, on systems whose roots are known."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from solver.numerics.box_search import arrivals


def himmelblau(x: Any) -> Any:
    """Where the gradient of Himmelblau's function vanishes: nine points, four of them its
    minima."""
    a, b = x[:, 0], x[:, 1]
    p, q = a**2 + b - 11, a + b**2 - 7
    return np.stack([4 * a * p + 2 * q, 2 * p + 4 * b * q], 1)


def himmelblau_slopes(x: Any) -> Any:
    a, b = x[:, 0], x[:, 1]
    mixed = 4 * (a + b)
    one, two = 12 * a**2 + 4 * b - 42, 12 * b**2 + 4 * a - 26
    return np.stack([np.stack([one, mixed], 1), np.stack([mixed, two], 1)], 1)


GRID = np.array([[a, b] for a in np.linspace(-5, 5, 8) for b in np.linspace(-5, 5, 8)])


def test_every_stationary_point_of_himmelblau() -> None:
    ends = arrivals(himmelblau, himmelblau_slopes, GRID, np.ones(2))
    assert len(ends) > 40
    assert np.abs(himmelblau(ends)).max() < 1e-5
    distinct = {tuple(np.round(end, 6) + 0.0) for end in ends}
    assert len(distinct) == 9
    assert any(math.dist(end, (3.0, 2.0)) < 1e-8 for end in ends)


def test_the_ends_are_in_the_order_of_their_starts() -> None:
    starts = np.array([[3.1, 2.1], [100.0, np.nan], [-2.8, 3.1]])
    ends = arrivals(himmelblau, himmelblau_slopes, starts, np.ones(2))
    assert ends == pytest.approx(np.array([[3.0, 2.0], [-2.805118, 3.131312]]), abs=1e-6)


def test_no_root_no_end() -> None:
    starts = np.linspace(-9, 9, 20)[:, None]
    found = arrivals(lambda x: x**2 + 1, lambda x: 2 * x[:, :, None], starts, np.ones(1))
    assert found.shape == (0, 1)


def test_steps_stay_in_the_domain() -> None:
    """sqrt(x) + x = 6 has the root 4; a full step from 90 would leave for negative numbers."""
    starts = np.array([[90.0], [0.01], [-1.0]])
    ends = arrivals(
        lambda x: np.sqrt(x) + x - 6,
        lambda x: (0.5 / np.sqrt(x) + 1)[:, :, None],
        starts,
        np.ones(1),
    )
    assert ends.ravel().tolist() == pytest.approx([4.0, 4.0])


def test_a_singular_start_spoils_no_other() -> None:
    starts = np.array([[0.0, 0.0], [2.0, 1.0]])

    def residual(x: Any) -> Any:
        return np.stack([x[:, 0] ** 2 - 4, x[:, 0] * x[:, 1] - 2], 1)

    def jacobian(x: Any) -> Any:
        zero = np.zeros(len(x))
        return np.stack([np.stack([2 * x[:, 0], zero], 1), np.stack([x[:, 1], x[:, 0]], 1)], 1)

    ends = arrivals(residual, jacobian, starts, np.ones(2))
    assert ends.tolist() == [pytest.approx([2.0, 1.0])]
