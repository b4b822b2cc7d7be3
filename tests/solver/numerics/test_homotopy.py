"""Homotopies and full steps: roots that descent does not reach, against closed forms."""

from __future__ import annotations

import math
from collections.abc import Sequence

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from solver.numerics.full_newton import full_newton
from solver.numerics.homotopy import HomotopyLimits, follow_homotopy
from solver.numerics.newton import newton
from solver.numerics.outcome import Outcome


def freudenstein_roth(x: Sequence[float]) -> list[float]:
    """One root, (5, 4); the standard start lies in the valley of a local minimum at (11.41, -0.8968)."""
    return [
        x[0] - x[1] ** 3 + 5 * x[1] ** 2 - 2 * x[1] - 13,
        x[0] + x[1] ** 3 + x[1] ** 2 - 14 * x[1] - 29,
    ]


def slopes(x: Sequence[float]) -> list[list[float]]:
    return [
        [1.0, -3 * x[1] ** 2 + 10 * x[1] - 2],
        [1.0, 3 * x[1] ** 2 + 2 * x[1] - 14],
    ]


def test_a_curve_leads_through_a_local_minimum() -> None:
    start = [0.5, -2.0]
    assert not newton(freudenstein_roth, slopes, start).outcome.found
    found = follow_homotopy(freudenstein_roth, slopes, start, [1.0, 1.0])
    assert found.outcome is Outcome.CONVERGED
    assert found.x == pytest.approx((5.0, 4.0), rel=1e-14)


TENTHS = st.integers(-30, 30).map(lambda tenths: tenths / 10)


@settings(max_examples=60, deadline=None)
@given(TENTHS, TENTHS, TENTHS, st.floats(-9, 9))
def test_a_cubic_from_anywhere(a: float, b: float, c: float, start: float) -> None:
    """What is called a root is one; and a steep cubic, whose curve can't but pass its root, always has it."""

    def residual(x: Sequence[float]) -> list[float]:
        return [((x[0] + a) * x[0] + b) * x[0] + c]

    def slope(x: Sequence[float]) -> list[list[float]]:
        return [[(3 * x[0] + 2 * a) * x[0] + b]]

    found = follow_homotopy(residual, slope, [start], [1.0])
    (x,) = found.x
    size = abs(x) ** 3 + abs(a * x * x) + abs(b * x) + abs(c)
    assert not found.outcome.found or abs(residual([x])[0]) <= 1e-12 * size + 1e-40
    assert found.outcome.found or a * a >= 3 * b - 0.1


def test_a_curve_that_never_arrives_ends_within_its_limit() -> None:
    limits = HomotopyLimits(steps=50)
    found = follow_homotopy(lambda x: [x[0] ** 2 + 1], lambda x: [[2 * x[0]]], [3.0], [1.0], limits)
    assert not found.outcome.found
    assert found.iterations <= 50


def test_full_steps_go_uphill() -> None:
    """The trigonometric function of Moré, Garbow and Hillstrom: descent ends in a minimum that is no root."""
    n = 10

    def residual(x: Sequence[float]) -> list[float]:
        total = sum(map(math.cos, x))
        return [n - total + k * (1 - math.cos(v)) - math.sin(v) for k, v in enumerate(x, 1)]

    def jacobian(x: Sequence[float]) -> list[list[float]]:
        return [
            [math.sin(u) + (i == j) * ((i + 1) * math.sin(u) - math.cos(u)) for j, u in enumerate(x)]
            for i in range(n)
        ]

    start = [1 / n] * n
    assert not newton(residual, jacobian, start, [1.0] * n).outcome.found
    found = full_newton(residual, jacobian, start, [1.0] * n)
    assert found.outcome is Outcome.CONVERGED
    assert max(map(abs, residual(found.x))) <= 1e-14


def test_outside_the_domain_it_says_so() -> None:
    for search in (full_newton, follow_homotopy):
        found = search(lambda x: [math.sqrt(x[0]) - 2], lambda x: [[0.5 / math.sqrt(x[0])]], [-1.0], [1.0])
        assert found.outcome is Outcome.DOMAIN


def test_full_steps_stay_in_the_domain() -> None:
    found = full_newton(lambda x: [math.log(x[0])], lambda x: [[1 / x[0]]], [50.0], [1.0])
    assert found.outcome is Outcome.CONVERGED
    assert found.x == pytest.approx((1.0,), rel=1e-15)
