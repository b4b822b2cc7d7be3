"""Several roots of a system from several starts."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from solver.numerics.multistart import multistart, place
from solver.numerics.termination import Outcome

Vector = list[float]


def circle_and_hyperbola(x: Vector) -> Vector:
    return [x[0] ** 2 + x[1] ** 2 - 25, x[0] * x[1] - 12]


def slopes(x: Vector) -> list[Vector]:
    return [[2 * x[0], 2 * x[1]], [x[1], x[0]]]


def test_all_four_intersections() -> None:
    found = multistart(circle_and_hyperbola, slopes, [1.0, 1.0])
    expected = [(-4, -3), (-3, -4), (3, 4), (4, 3)]
    assert sorted(root.x for root in found.roots) == [pytest.approx(p, rel=1e-14) for p in expected]


def test_ranges_keep_their_own() -> None:
    found = multistart(circle_and_hyperbola, slopes, [1.0, 1.0], [(0, math.inf), (3.5, 10)])
    assert [root.x for root in found.roots] == [pytest.approx((3, 4), rel=1e-14)]


def test_the_root_nearest_the_guess_comes_first() -> None:
    found = multistart(circle_and_hyperbola, slopes, [-2.9, -4.1])
    assert found.roots[0].x == pytest.approx((-3, -4), rel=1e-14)


def test_the_same_question_has_the_same_answer() -> None:
    first = multistart(circle_and_hyperbola, slopes, [1.0, 1.0])
    assert first == multistart(circle_and_hyperbola, slopes, [1.0, 1.0])


def test_without_a_root_the_best_end_is_told() -> None:
    found = multistart(lambda x: [x[0] ** 2 + 1], lambda x: [[2 * x[0]]], [3.0])
    assert found.roots == ()
    assert found.best is not None
    assert found.best.residual == pytest.approx((1.0,))


def test_a_line_of_solutions_does_not_fill_the_list() -> None:
    found = multistart(lambda x: [x[0] + x[1] - 26], lambda x: [[1, 1]], [1.0, 1.0])
    assert 1 < len(found.roots) <= 4
    assert {root.outcome for root in found.roots} == {Outcome.SINGULAR_JACOBIAN}


BOUNDS = st.sampled_from([-math.inf, -1e9, -5.0, 0.0, 1e-6, 3.0, 1e9, math.inf])


@given(st.floats(0, 1, exclude_max=True), BOUNDS, BOUNDS, st.floats(1e-9, 1e9))
def test_starts_lie_in_their_range(share: float, low: float, high: float, scale: float) -> None:
    if low < high:
        x = place(share, low, high, scale)
        assert math.isfinite(x)
        assert low <= x <= high
