"""Every root of a system in a box, with proof."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from solver.numerics.box_search import Subdivision, branch_and_prune
from tests.solver.numerics.interval_arithmetic import Interval, cos, sin

System = Callable[..., Sequence[Any]]


def bounds(expressions: Sequence[Any], count: int) -> tuple[Any, Any]:
    """Lower and upper bounds (count, m) of m intervals or numbers."""
    boxes = [
        e if isinstance(e, Interval) else Interval(numpy.float64(e), numpy.float64(e))
        for e in expressions
    ]
    lo, hi = (
        [numpy.broadcast_to(b, count) for b in column]
        for column in zip(*((b.lo, b.hi) for b in boxes), strict=True)
    )
    return numpy.stack(lo, 1), numpy.stack(hi, 1)


def search(
    system: System, jacobian: System, box: Sequence[tuple[float, float]], boxes: int = 100_000
) -> Subdivision:
    n = len(box)

    def unknowns(lo: Any, hi: Any) -> list[Interval]:
        return [Interval(lo[:, j], hi[:, j]) for j in range(n)]

    def enclose(lo: Any, hi: Any) -> tuple[Any, Any]:
        return bounds(system(*unknowns(lo, hi)), len(lo))

    def enclose_jacobian(lo: Any, hi: Any) -> tuple[Any, Any]:
        flat = [entry for row in jacobian(*unknowns(lo, hi)) for entry in row]
        below, above = bounds(flat, len(lo))
        return below.reshape(-1, n, n), above.reshape(-1, n, n)

    return branch_and_prune(enclose, enclose_jacobian, box, boxes, 8_000)


def circle_and_hyperbola(x: Any, y: Any) -> Sequence[Any]:
    return x**2 + y**2 - 25, x * y - 12


def their_slopes(x: Any, y: Any) -> Sequence[Any]:
    return (2 * x, 2 * y), (y, x)


@pytest.mark.parametrize(
    ("box", "roots"),
    [
        ([(-10, 10), (-10, 10)], [(-4, -3), (-3, -4), (3, 4), (4, 3)]),
        ([(3, 10), (0, 3)], [(4, 3)]),
        ([(3.5, 10), (0, 10)], [(4, 3)]),
        ([(0, 1), (0, 1)], []),
    ],
)
def test_four_intersections_each_in_its_box(
    box: list[tuple[float, float]], roots: list[Any]
) -> None:
    found = search(circle_and_hyperbola, their_slopes, box)
    assert found.complete
    assert list(found.roots) == [pytest.approx(root, rel=1e-14) for root in roots]


def test_proved_boxes_are_narrow_and_hold_the_root() -> None:
    found = search(circle_and_hyperbola, their_slopes, [(-10, 10), (-10, 10)])
    for box, root in zip(found.proved, [(-4, -3), (-3, -4), (3, 4), (4, 3)], strict=True):
        for (low, high), value in zip(box, root, strict=True):
            assert low <= value <= high
            assert high - low < 1e-13


def test_nine_stationary_points_of_himmelblau() -> None:
    def gradient(x: Any, y: Any) -> Sequence[Any]:
        return (
            4 * x**3 + 4 * x * y - 42 * x + 2 * y**2 - 14,
            4 * y**3 + 4 * x * y - 26 * y + 2 * x**2 - 22,
        )

    def hessian(x: Any, y: Any) -> Sequence[Any]:
        return (12 * x**2 + 4 * y - 42, 4 * x + 4 * y), (4 * x + 4 * y, 12 * y**2 + 4 * x - 26)

    found = search(gradient, hessian, [(-5, 5), (-5, 5)])
    assert found.complete
    assert len(found.roots) == 9
    assert any(root == pytest.approx((3, 2), rel=1e-14) for root in found.roots)
    assert all(max(map(abs, gradient(*root))) < 1e-12 for root in found.roots)


@settings(max_examples=25, deadline=None)
@given(
    st.lists(st.lists(st.integers(-5, 5), min_size=3, max_size=3), min_size=3, max_size=3),
    st.lists(st.integers(-9, 9), min_size=3, max_size=3),
)
def test_linear_systems_against_elimination(rows: list[list[int]], x: list[int]) -> None:
    matrix = numpy.array(rows, dtype=float)
    if abs(numpy.linalg.det(matrix)) < 0.5:
        return
    rhs = matrix @ numpy.array(x)

    def system(*unknowns: Any) -> Sequence[Any]:
        return [
            sum((a * u for a, u in zip(row, unknowns, strict=True)), -b)
            for row, b in zip(matrix, rhs, strict=True)
        ]

    found = search(system, lambda *unknowns: rows, [(-10, 10)] * 3)
    assert found.complete
    assert found.roots == (pytest.approx(x, abs=1e-11),)


def test_absence_is_proven() -> None:
    found = search(
        lambda x, y: (x**2 + y**2 - 1, x + y - 2),
        lambda x, y: ((2 * x, 2 * y), (1, 1)),
        [(-9, 9)] * 2,
    )
    assert found.complete
    assert found.proved == ()


def test_a_tangency_is_not_called_a_root() -> None:
    found = search(
        lambda x, y: (x**2 + y**2 - 2, x + y - 2),
        lambda x, y: ((2 * x, 2 * y), (1, 1)),
        [(-9, 9)] * 2,
    )
    assert not found.complete
    assert found.proved == ()


def test_a_line_of_roots_ends_at_the_budget() -> None:
    found = search(
        lambda x, y: (x + y - 1, 2 * x + 2 * y - 2),
        lambda x, y: ((1, 1), (2, 2)),
        [(-9, 9)] * 2,
        boxes=5000,
    )
    assert not found.complete
    assert found.proved == ()
    assert found.boxes < 20_000


def test_two_link_arm_has_elbow_up_and_elbow_down() -> None:
    def reach(p: Any, q: Any) -> Sequence[Any]:
        return 3 * cos(p) + 2 * cos(q) - 2.5, 3 * sin(p) + 2 * sin(q) - 3.0

    def slopes(p: Any, q: Any) -> Sequence[Any]:
        return (-3 * sin(p), -2 * sin(q)), (3 * cos(p), 2 * cos(q))

    found = search(reach, slopes, [(-math.pi, math.pi), (-math.pi, math.pi)])
    distance, direction = math.hypot(2.5, 3.0), math.atan2(3.0, 2.5)
    bend = math.acos((9 + distance**2 - 4) / (6 * distance))
    assert found.complete
    assert [p for p, _ in found.roots] == pytest.approx(
        [direction - bend, direction + bend], rel=1e-13
    )


@settings(deadline=None)
@given(st.tuples(*[st.floats(-3, 3)] * 2), st.tuples(*[st.floats(0.01, 4)] * 4))
def test_no_root_is_lost(
    root: tuple[float, float], reach: tuple[float, float, float, float]
) -> None:
    y, box = (
        root[1],
        [(r - low, r + high) for r, low, high in zip(root, reach[:2], reach[2:], strict=True)],
    )
    at = [Interval(numpy.float64(number), numpy.float64(number)) for number in root]

    def system(a: Any, b: Any) -> Sequence[Any]:
        return a * b - at[0] * y, a**2 + b - (at[0] ** 2 + at[1])

    found = search(system, lambda a, b: ((b, a), (2 * a, 1.0)), box, boxes=2_000)
    held = (
        all(low <= r <= high for (low, high), r in zip(one, root, strict=True))
        for one in found.proved
    )
    assert any(held) or not found.complete


def test_a_root_at_a_corner_of_the_box_is_found() -> None:
    found = search(
        lambda x, y: (x + x**2 + y, y + x * y + 3 * x),
        lambda x, y: ((1 + 2 * x, 1), (y + 3, 1 + x)),
        [(0, 1)] * 2,
    )
    assert found.complete
    assert found.roots == (pytest.approx((0.0, 0.0), abs=1e-15),)
    assert min(found.roots[0]) >= 0.0
