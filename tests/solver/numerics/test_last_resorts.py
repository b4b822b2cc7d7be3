"""Trust regions, and unknowns that are fixed and released: roots that descent does not reach."""

from __future__ import annotations

import math
import random
from collections.abc import Callable, Sequence

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from solver.numerics.dogleg import TrustLimits, dogleg
from solver.numerics.newton import NewtonResult, newton
from solver.numerics.outcome import Outcome
from solver.numerics.release import fix_and_release
from tests.solver.numerics.test_homotopy import freudenstein_roth, slopes

Search = Callable[..., NewtonResult]


def releasing_the_last(
    residual: Search, jacobian: Search, start: list[float], scale: list[float]
) -> NewtonResult:
    return fix_and_release(residual, jacobian, start, scale, len(start) - 1)


SEARCHES = [dogleg, releasing_the_last]


@pytest.mark.parametrize("held", [0, 1])
def test_a_release_leads_through_a_local_minimum(held: int) -> None:
    """The standard start of Freudenstein and Roth lies in the valley of a minimum that is no root."""
    start = [0.5, -2.0]
    assert not newton(freudenstein_roth, slopes, start).outcome.found
    assert not dogleg(freudenstein_roth, slopes, start, [1.0, 1.0]).outcome.found
    found = fix_and_release(freudenstein_roth, slopes, start, [1.0, 1.0], held)
    assert found.outcome is Outcome.CONVERGED
    assert found.x == pytest.approx((5.0, 4.0), rel=1e-14)


def test_a_trust_region_gets_round_a_singular_jacobian() -> None:
    """M. J. D. Powell (1970): steps along Newton's direction end at (1.8016, 0), which is no root."""

    def residual(x: Sequence[float]) -> list[float]:
        return [x[0], 10 * x[0] / (x[0] + 0.1) + 2 * x[1] ** 2]

    def slope(x: Sequence[float]) -> list[list[float]]:
        return [[1.0, 0.0], [1.0 / (x[0] + 0.1) ** 2, 4 * x[1]]]

    found = dogleg(residual, slope, [3.0, 1.0], [1.0, 1.0])
    assert found.outcome.found
    assert max(map(abs, found.x)) <= 1e-6


@pytest.mark.parametrize("search", SEARCHES)
@settings(max_examples=15, deadline=None)
@given(st.integers(2, 9), st.randoms(use_true_random=False))
def test_a_linear_system_from_anywhere(search: Search, n: int, draw: random.Random) -> None:
    """Unknowns that are 0 among them: their rows have no size of their own, and nothing but rounding."""
    uniform = draw.uniform
    matrix = [[uniform(-1, 1) + (2 * n if i == j else 0) for j in range(n)] for i in range(n)]
    root = [draw.choice((0.0, 1.0, uniform(-5, 5))) for _ in range(n)]
    right = [math.fsum(a * x for a, x in zip(row, root, strict=True)) for row in matrix]

    def residual(x: Sequence[float]) -> list[float]:
        return [
            math.fsum([*(a * v for a, v in zip(row, x, strict=True)), -b])
            for row, b in zip(matrix, right, strict=True)
        ]

    found = search(residual, lambda _: matrix, [uniform(-100, 100) for _ in range(n)], [1.0] * n)
    assert found.outcome is Outcome.CONVERGED
    assert found.x == pytest.approx(root, rel=1e-12, abs=1e-12)


@pytest.mark.parametrize("search", SEARCHES)
@settings(max_examples=20, deadline=None)
@given(st.floats(-4, 4), st.floats(-4, 4), st.floats(-4, 4), st.floats(-4, 4))
def test_what_is_called_a_root_is_one(search: Search, p: float, q: float, x: float, y: float) -> None:
    """Two conics that may or may not meet."""

    def residual(v: Sequence[float]) -> list[float]:
        return [v[0] ** 2 + v[1] ** 2 - 4, v[0] * v[1] - p * v[0] - q]

    def slope(v: Sequence[float]) -> list[list[float]]:
        return [[2 * v[0], 2 * v[1]], [v[1] - p, v[0]]]

    found = search(residual, slope, [x, y], [1.0, 1.0])
    if found.outcome.found:
        assert max(map(abs, residual(found.x))) <= 1e-12 * (10 + abs(p) + abs(q))


@pytest.mark.parametrize("search", SEARCHES)
@pytest.mark.parametrize("apart", [1e-8, 1e-10, 0.5])
def test_conics_that_all_but_touch_have_no_root(search: Search, apart: float) -> None:
    """A circle of radius 2, and a line ``apart`` from it: |F| has a minimum, and no root."""

    def residual(v: Sequence[float]) -> list[float]:
        return [v[0] ** 2 + v[1] ** 2 - 4, v[0] + v[1] - (2 + apart) * math.sqrt(2)]

    for start in ([1.0, 2.0], [-2.0, -2.0], [1.5, 1.4]):
        found = search(residual, lambda v: [[2 * v[0], 2 * v[1]], [1.0, 1.0]], start, [1.0, 1.0])
        assert not found.outcome.found


@pytest.mark.parametrize("search", [dogleg, newton])
def test_conics_that_touch_have_a_double_root(search: Search) -> None:
    def residual(v: Sequence[float]) -> list[float]:
        return [v[0] ** 2 + v[1] ** 2 - 25, 3 * v[0] + 4 * v[1] - 25]

    found = search(residual, lambda v: [[2 * v[0], 2 * v[1]], [3.0, 4.0]], [2.0, 5.0], [1.0, 1.0])
    assert found.outcome is Outcome.SINGULAR_JACOBIAN
    assert found.x == pytest.approx((3.0, 4.0), abs=1e-6)


@pytest.mark.parametrize("search", SEARCHES)
def test_a_start_outside_the_domain_is_told(search: Search) -> None:
    def residual(x: Sequence[float]) -> list[float]:
        return [math.sqrt(x[0]) - 2, x[1] - x[0]]

    found = search(residual, lambda x: [[0.5 / math.sqrt(x[0]), 0.0], [-1.0, 1.0]], [-1.0, 1.0], [1.0, 1.0])
    assert found.outcome is Outcome.DOMAIN


def test_a_step_back_from_the_edge_of_a_domain() -> None:
    """ln x = -5 from 3: the full Newton step leaves the domain."""
    found = dogleg(lambda x: [math.log(x[0]) + 5], lambda x: [[1 / x[0]]], [3.0], [1.0])
    assert found.outcome is Outcome.CONVERGED
    assert found.x[0] == pytest.approx(math.exp(-5), rel=1e-14)


def test_the_iterations_are_limited() -> None:
    found = dogleg(freudenstein_roth, slopes, [0.5, -2.0], [1.0, 1.0], TrustLimits(iterations=3))
    assert (found.outcome, found.iterations) == (Outcome.LIMIT, 3)
