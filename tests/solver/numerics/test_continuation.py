"""Curves with closed forms, followed through folds, beside other branches, and to where they
end."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from solver.numerics.continuation import End, Problem, Trace, crossing, follow, point_at, start


def problem(
    residual: Callable[..., Sequence[float]],
    jacobian: Callable[..., Sequence[Sequence[float]]],
    **more: object,
) -> Problem:
    n = len(jacobian(*np.full(4, 0.5)[: _arity(jacobian)])[0])
    sizes = {"scale": 1.0, "turn": math.inf, "low": -math.inf, "high": math.inf, **more}
    arrays = {
        name: np.broadcast_to(np.asarray(value, dtype=float), n).copy()
        for name, value in sizes.items()
        if name not in ("regime", "these")
    }
    extra = {name: more[name] for name in ("regime", "these") if name in more}
    return Problem(
        lambda z: np.array(residual(*z), dtype=float),
        lambda z: np.array(jacobian(*z), dtype=float),
        **arrays,
        **extra,
    )


def _arity(function: Callable[..., object]) -> int:
    return function.__code__.co_argcount


def followed(curve: Problem, z: Sequence[float], way: int = 1) -> Trace:
    first = start(curve, np.array(z))
    assert first is not None
    if way < 0:
        first = point_at(curve, first.z, -first.tangent)
        assert first is not None
    return follow(curve, first)


def folds(trace: Trace) -> list[float]:
    return [float(point.z[-1]) for point in trace.points if point.fold]


@settings(max_examples=15, deadline=None)
@given(a=st.floats(0.05, 20.0), b=st.floats(0.05, 20.0), angle=st.floats(0.0, 6.28))
def test_an_ellipse_is_closed_and_its_ends_are_its_folds(a: float, b: float, angle: float) -> None:
    curve = problem(
        lambda y, x: [(y / a) ** 2 + (x / b) ** 2 - 1],
        lambda y, x: [[2 * y / a**2, 2 * x / b**2]],
        scale=[a, b],
    )
    trace = followed(curve, [a * math.sin(angle), b * math.cos(angle)])
    assert trace.end is End.CLOSED
    assert sorted(folds(trace)) == pytest.approx([-b, b], rel=1e-12)
    turned = np.unwrap([math.atan2(p.z[0] / a, p.z[1] / b) for p in trace.points])
    assert abs(turned[-1] - turned[0]) == pytest.approx(2 * math.pi, rel=1e-9)
    assert (np.diff(turned) * np.sign(turned[-1] - turned[0]) > 0).all()


def lemniscate(shift: float) -> Problem:
    """x² (1 − x²) − y² + shift = 0: a figure of eight; two lobes where the shift is below 0, else a
    loop."""
    return problem(
        lambda y, x: [x * x * (1 - x * x) - y * y + shift],
        lambda y, x: [[-2 * y, 2 * x - 4 * x**3]],
    )


@pytest.mark.parametrize("shift", [1e-2, 1e-4, 1e-6, 1e-8, 1e-10])
def test_branches_that_nearly_cross_are_kept_apart(shift: float) -> None:
    x = 0.5
    one_loop = followed(lemniscate(shift), [math.sqrt(x * x * (1 - x * x) + shift), x])
    assert one_loop.end is End.CLOSED
    assert {float(np.sign(p.z[1])) for p in one_loop.points} >= {-1.0, 1.0}
    lobe = followed(lemniscate(-shift), [math.sqrt(x * x * (1 - x * x) - shift), x])
    assert lobe.end is End.CLOSED
    assert min(p.z[1] for p in lobe.points) > 0
    roots = sorted(math.sqrt((1 + sign * math.sqrt(1 - 4 * shift)) / 2) for sign in (-1, 1))
    assert sorted(folds(lobe))[1] == pytest.approx(roots[1], rel=1e-12)
    assert sorted(folds(lobe))[0] == pytest.approx(
        math.sqrt(2 * shift / (1 + math.sqrt(1 - 4 * shift))), rel=1e-10
    )


def test_where_branches_cross_the_curve_ends_and_says_so() -> None:
    trace = followed(lemniscate(0.0), [0.5 * math.sqrt(0.75), 0.5])
    assert trace.end is End.SINGULAR
    assert np.abs(trace.points[-1].z).max() < 1e-6


def test_a_curve_ends_where_it_leaves_the_domain_or_a_range() -> None:
    curve = problem(
        lambda y, x: [y - math.sqrt(x)],
        lambda y, x: [[1, -0.5 / math.sqrt(x)]],
        high=[math.inf, 3.0],
    )
    up, down = followed(curve, [1.0, 1.0], 1), followed(curve, [1.0, 1.0], -1)
    assert (up.end, down.end) == (End.BOUNDARY, End.DOMAIN)
    assert up.points[-1].z == pytest.approx([math.sqrt(3.0), 3.0], rel=1e-15)
    assert down.points[-1].z[0] < 1e-7
    held = problem(lambda y, x: [y - x * x], lambda y, x: [[1, -2 * x]], high=[4.0, math.inf])
    assert followed(held, [1.0, 1.0]).points[-1].z == pytest.approx([4.0, 2.0], rel=1e-14)


def test_a_curve_ends_where_other_equations_hold() -> None:
    curve = problem(
        lambda y, x: [y - x], lambda y, x: [[1, -1]], regime=lambda z: z[1] > 0.7, these=False
    )
    trace = followed(curve, [0.0, 0.0])
    assert trace.end is End.CHANGED
    assert trace.points[-1].z[1] == pytest.approx(0.7, abs=1e-14)
    touching = problem(
        lambda y, x: [y - x],
        lambda y, x: [[1, -1]],
        regime=lambda z: z[1] == 0.02,
        these=False,
        high=[2.0, 1.0],
    )
    assert followed(touching, [0.0, 0.0]).end is End.BOUNDARY


def test_points_at_a_value_of_the_parameter() -> None:
    curve = problem(lambda y, x: [y * y + x * x - 1], lambda y, x: [[2 * y, 2 * x]])
    first = start(curve, np.array([1.0, 0.0]))
    assert first is not None
    found = crossing(curve, first, 0.1, 0.05)
    assert found is not None
    assert found.z.tolist() == [pytest.approx(math.sqrt(1 - 0.05**2), rel=1e-15), 0.05]


def test_a_curve_of_the_parameter_alone_runs_to_its_ends() -> None:
    alone = Problem(
        lambda z: np.zeros(0),
        lambda z: np.zeros((0, 1)),
        np.ones(1),
        np.full(1, np.inf),
        np.zeros(1),
        np.ones(1),
    )
    first = start(alone, np.array([0.5]))
    assert first is not None
    assert follow(alone, first).points[-1].z.tolist() == [1.0]
