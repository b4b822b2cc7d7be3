"""Damped Newton on problems with known answers, and its honesty where there is none."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy
import pytest
import scipy.sparse
from hypothesis import given, settings
from hypothesis import strategies as st

from solver.numerics.newton import NewtonLimits, Outcome, newton

Vector = list[float]


Function = Callable[[float], float]


def scalar(f: Function, slope: Function, start: float) -> tuple[float, Outcome]:
    result = newton(lambda x: [f(x[0])], lambda x: [[slope(x[0])]], [start])
    return result.x[0], result.outcome


@settings(max_examples=60, deadline=None)
@given(st.floats(1e-6, 1e6), st.floats(1e-3, 1e3))
def test_square_root_to_the_last_bit(square: float, start: float) -> None:
    x, outcome = scalar(lambda x: x * x - square, lambda x: 2 * x, start)
    assert outcome is Outcome.CONVERGED
    assert abs(x) == pytest.approx(math.sqrt(square), rel=4.5e-16)


@pytest.mark.parametrize(
    ("f", "slope", "start", "root"),
    [
        (math.atan, lambda x: 1 / (1 + x * x), 10.0, 0.0),
        (math.log, lambda x: 1 / x, 100.0, 1.0),
        (lambda x: math.sqrt(x) - 1e-3, lambda x: 0.5 / math.sqrt(x), 100.0, 1e-6),
        (lambda x: math.exp(x) - 1, math.exp, 20.0, 0.0),
        (lambda x: x * x - 1e-30, lambda x: 2 * x, 1.0, 1e-15),
        (lambda x: 1 / x - 4e5, lambda x: -1 / x**2, 1e-9, 2.5e-6),
    ],
)
def test_damping_and_domain(f: Function, slope: Function, start: float, root: float) -> None:
    x, outcome = scalar(f, slope, start)
    assert outcome is Outcome.CONVERGED
    assert x == pytest.approx(root, rel=1e-15, abs=1e-16)


@pytest.mark.parametrize(
    ("f", "slope", "start"),
    [
        (lambda x: x * x + 1, lambda x: 2 * x, 3.0),
        (lambda x: 3 * x**3 - 200 * x**2 - x - 1, lambda x: 9 * x**2 - 400 * x - 1, 1.0),
        (lambda x: math.exp(-x), lambda x: -math.exp(-x), 1.0),
        (lambda x: 1 / x, lambda x: -1 / x**2, 1.0),
    ],
)
def test_no_root_is_claimed_at_a_minimum_or_at_infinity(
    f: Function, slope: Function, start: float
) -> None:
    _, outcome = scalar(f, slope, start)
    assert outcome in (Outcome.STALLED, Outcome.LIMIT)


def test_a_start_outside_the_domain_is_told() -> None:
    assert scalar(math.log, lambda x: 1 / x, -1.0)[1] is Outcome.DOMAIN


@pytest.mark.parametrize("start", [3.0, -7.0, 1.5])
def test_double_root_is_singular_and_found_to_half_the_digits(start: float) -> None:
    x, outcome = scalar(lambda x: x * x - 2 * x + 1, lambda x: 2 * x - 2, start)
    assert outcome is Outcome.SINGULAR_JACOBIAN
    assert x == pytest.approx(1.0, abs=1e-6)


def test_redundant_equations_are_not_an_isolated_answer() -> None:
    result = newton(lambda x: [sum(x) - 26, 2 * sum(x) - 52], lambda x: [[1, 1], [2, 2]], [1, 1])
    assert result.outcome is Outcome.SINGULAR_JACOBIAN
    assert sum(result.x) == pytest.approx(26)


def test_contradicting_equations_are_not_solved() -> None:
    result = newton(lambda x: [sum(x) - 26, sum(x) - 27], lambda x: [[1, 1], [1, 1]], [1, 1])
    assert result.outcome is Outcome.STALLED


def test_overdetermined_but_consistent() -> None:
    result = newton(
        lambda x: [x[0] ** 2 + x[1] ** 2 - 25, x[0] * x[1] - 12, x[0] - x[1] - 1],
        lambda x: [[2 * x[0], 2 * x[1]], [x[1], x[0]], [1, -1]],
        [5.0, 1.0],
    )
    assert result.outcome is Outcome.CONVERGED
    assert result.x == pytest.approx((4, 3), rel=1e-15)


# --- classical problems (Moré, Garbow, Hillstrom 1981), from their standard starts ---


def rosenbrock(x: Vector) -> Vector:
    return [10 * (x[1] - x[0] ** 2), 1 - x[0]]


def rosenbrock_slopes(x: Vector) -> list[Vector]:
    return [[-20 * x[0], 10], [-1, 0]]


def powell_badly_scaled(x: Vector) -> Vector:
    return [1e4 * x[0] * x[1] - 1, math.exp(-x[0]) + math.exp(-x[1]) - 1.0001]


def powell_badly_scaled_slopes(x: Vector) -> list[Vector]:
    return [[1e4 * x[1], 1e4 * x[0]], [-math.exp(-x[0]), -math.exp(-x[1])]]


def helical_valley(x: Vector) -> Vector:
    turn = math.atan2(x[1], x[0]) / (2 * math.pi)
    return [10 * (x[2] - 10 * turn), 10 * (math.hypot(x[0], x[1]) - 1), x[2]]


def helical_valley_slopes(x: Vector) -> list[Vector]:
    r = math.hypot(x[0], x[1])
    k = 100 / (2 * math.pi * r * r)
    return [[k * x[1], -k * x[0], 10], [10 * x[0] / r, 10 * x[1] / r, 0], [0, 0, 1]]


def brown_almost_linear(x: Vector) -> Vector:
    return [v + sum(x) - len(x) - 1 for v in x[:-1]] + [math.prod(x) - 1]


def brown_almost_linear_slopes(x: Vector) -> list[Vector]:
    n = len(x)
    rows = [[1.0 + (i == j) for j in range(n)] for i in range(n - 1)]
    return [*rows, [math.prod(x[:j] + x[j + 1 :]) for j in range(n)]]


@pytest.mark.parametrize(
    ("residual", "jacobian", "start"),
    [
        (rosenbrock, rosenbrock_slopes, [-1.2, 1.0]),
        (powell_badly_scaled, powell_badly_scaled_slopes, [0.0, 1.0]),
        (helical_valley, helical_valley_slopes, [-1.0, 0.0, 0.0]),
        (brown_almost_linear, brown_almost_linear_slopes, [0.5] * 5),
        (brown_almost_linear, brown_almost_linear_slopes, [0.5] * 10),
    ],
)
def test_classical_problems(
    residual: Callable[[Vector], Vector], jacobian: Callable[[Vector], list[Vector]], start: Vector
) -> None:
    result = newton(residual, jacobian, start)
    assert result.outcome is Outcome.CONVERGED
    assert max(map(abs, residual(list(result.x)))) < 1e-13


def test_powell_singular_has_its_root_at_the_origin() -> None:
    result = newton(
        lambda x: [
            x[0] + 10 * x[1],
            5**0.5 * (x[2] - x[3]),
            (x[1] - 2 * x[2]) ** 2,
            10**0.5 * (x[0] - x[3]) ** 2,
        ],
        lambda x: [
            [1, 10, 0, 0],
            [0, 0, 5**0.5, -(5**0.5)],
            [0, 2 * (x[1] - 2 * x[2]), -4 * (x[1] - 2 * x[2]), 0],
            [2 * 10**0.5 * (x[0] - x[3]), 0, 0, -2 * 10**0.5 * (x[0] - x[3])],
        ],
        [3.0, -1.0, 0.0, 1.0],
    )
    assert result.outcome is Outcome.SINGULAR_JACOBIAN
    assert max(map(abs, result.x)) < 1e-4


# --- invariance and size ---


@settings(max_examples=30, deadline=None)
@given(st.integers(-30, 30), st.integers(-30, 30), st.integers(-20, 20))
def test_units_of_rules_and_unknowns_do_not_change_the_answer(
    row: int, other: int, column: int
) -> None:
    """Powers of two are exact factors, so the iterates must agree bit for bit."""
    a, b, c = 2.0**row, 2.0**other, 2.0**column
    plain = newton(rosenbrock, rosenbrock_slopes, [-1.2, 1.0], [1.0, 1.0])
    scaled = newton(
        lambda x: [a * rosenbrock([x[0] * c, x[1]])[0], b * rosenbrock([x[0] * c, x[1]])[1]],
        lambda x: [
            [a * rosenbrock_slopes([x[0] * c, x[1]])[0][0] * c, a * 10],
            [-b * c, 0],
        ],
        [-1.2 / c, 1.0],
        [1.0 / c, 1.0],
    )
    assert (scaled.x[0] * c, scaled.x[1]) == plain.x
    assert scaled.iterations == plain.iterations


@pytest.mark.parametrize("sparse", [False, True])
def test_broyden_tridiagonal_of_200_unknowns(sparse: bool) -> None:
    n = 200

    def residual(x: Vector) -> Vector:
        v = numpy.array([0.0, *x, 0.0])
        values: Vector = ((3 - 2 * v[1:-1]) * v[1:-1] - v[:-2] - 2 * v[2:] + 1).tolist()
        return values

    def jacobian(x: Vector) -> object:
        diagonal = 3 - 4 * numpy.array(x)
        bands = scipy.sparse.diags_array(
            [numpy.full(n - 1, -1.0), diagonal, numpy.full(n - 1, -2.0)], offsets=[-1, 0, 1]
        )
        return bands.tocsr() if sparse else bands.toarray()

    result = newton(residual, jacobian, [-1.0] * n)
    assert result.outcome is Outcome.CONVERGED
    assert max(map(abs, residual(list(result.x)))) < 1e-14


def test_the_limit_on_iterations_is_kept() -> None:
    result = newton(rosenbrock, rosenbrock_slopes, [-1.2, 1.0], limits=NewtonLimits(iterations=1))
    assert result.outcome is Outcome.LIMIT
    assert result.iterations == 1
