"""All roots of one equation: known answers, proofs of absence, and honesty about what was not
settled."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import mpmath
import numpy
import pytest
import scipy.optimize
from hypothesis import given, settings
from hypothesis import strategies as st

from solver.numerics.isolation import IsolationLimits, RootSearch, isolate_roots
from tests.solver.numerics.interval_arithmetic import (
    Interval,
    box_by_box,
    cos,
    enclosure,
    exp,
    log,
    log_slope,
    magnitude,
    sin,
    sqrt,
    sqrt_slope,
)

INF = math.inf
Expression = Callable[[Any], Any]


def search(
    box: Expression,
    slope: Expression | None,
    value: Callable[[float], float],
    low: float = -INF,
    high: float = INF,
    limits: IsolationLimits | None = None,
) -> RootSearch:
    slopes = enclosure(slope) if slope else None
    return isolate_roots(enclosure(box), slopes, value, low, high, limits or IsolationLimits())


def proven_empty(found: RootSearch) -> bool:
    return found.complete and not found.roots


def polynomial(roots: list[float]) -> tuple[Expression, Expression]:
    """Product of (x - root) and its slope, over floats or intervals."""

    def value(x: Any) -> Any:
        product = x - roots[0]
        for root in roots[1:]:
            product = product * (x - root)
        return product

    def slope(x: Any) -> Any:
        total = 0.0 * x
        for left_out in range(len(roots)):
            term = 1.0 + 0.0 * x
            for root in roots[:left_out] + roots[left_out + 1 :]:
                term = term * (x - root)
            total = total + term
        return total

    return value, slope


def test_the_cubic_that_simpler_methods_miss() -> None:
    found = search(
        lambda x: x * (x * (3 * x - 200) - 1) - 1,
        lambda x: x * (9 * x - 400) - 1,
        lambda x: x * (x * (3 * x - 200) - 1) - 1,
    )
    with mpmath.workdps(50):
        real = [float(r.real) for r in mpmath.polyroots([3, -200, -1, -1]) if abs(r.imag) < 1e-30]
    assert found.complete
    assert found.roots == pytest.approx(real, rel=2e-16)


@settings(max_examples=60, deadline=None)
@given(st.lists(st.integers(-400, 400), min_size=1, max_size=6, unique=True))
def test_every_root_of_a_product_on_the_whole_line(numerators: list[int]) -> None:
    roots = sorted(n / 8 for n in numerators)
    value, slope = polynomial(roots)
    found = search(value, slope, value, -1e6, 1e6)
    assert found.complete
    assert list(found.roots) == roots


@settings(max_examples=40, deadline=None)
@given(st.floats(1e-12, 1e12))
def test_scales_from_tiny_to_huge(root: float) -> None:
    by_log = search(
        lambda x: log(x) - math.log(root), log_slope, lambda x: math.log(x) - math.log(root)
    )
    assert by_log.complete
    assert by_log.roots == pytest.approx([root], rel=1e-14)
    straight = search(lambda x: x - root, lambda x: 1.0 + 0 * x, lambda x: x - root)
    assert straight.complete
    assert straight.roots == (root,)


@pytest.mark.parametrize("target", [-0.75, 0.0, 0.5, 0.999])
def test_a_turn_of_sine_in_degrees(target: float) -> None:
    k = math.pi / 180
    found = search(
        lambda x: sin(x * k) - target,
        lambda x: k * cos(x * k),
        lambda x: math.sin(x * k) - target,
        -180,
        180,
    )
    principal = math.degrees(math.asin(target))
    expected = {principal, 180 - principal if target > 0 else -180 - principal} - {-180.0}
    assert [x for x in found.roots if abs(x) < 180] == pytest.approx(
        sorted(expected), rel=1e-13, abs=1e-13
    )
    if target:
        assert found.complete
        assert len(found.roots) == 2


@settings(max_examples=40, deadline=None)
@given(st.floats(0.0, 0.999), st.floats(0.01, 6.2))
def test_kepler_has_one_answer(eccentricity: float, anomaly: float) -> None:
    found = search(
        lambda x: x - eccentricity * sin(x) - anomaly,
        lambda x: 1 - eccentricity * cos(x),
        lambda x: x - eccentricity * math.sin(x) - anomaly,
    )
    expected = scipy.optimize.brentq(
        lambda x: x - eccentricity * math.sin(x) - anomaly, -1, 8, xtol=1e-15
    )
    assert found.complete
    assert found.roots == pytest.approx([expected], rel=1e-9)


def test_colebrook() -> None:
    """1/√f = −2 log10(k + 2.51/(Re √f)), written in u = 1/√f > 0."""
    k, a, c = 1e-4 / 3.7, 2.51 / 1e5, 2 / math.log(10)
    found = search(
        lambda u: u + c * log(k + a * u),
        lambda u: 1 + c * a * log_slope(k + a * u),
        lambda u: u + c * math.log(k + a * u),
        0.0,
        INF,
    )
    with mpmath.workdps(50):
        exact = float(mpmath.findroot(lambda u: u + c * mpmath.log(k + a * u), 7))
    assert found.complete
    assert found.roots == pytest.approx([exact], rel=4e-16)


@pytest.mark.parametrize(
    ("box", "slope", "roots"),
    [
        (lambda x: 1 / x - 3, lambda x: -1 / x**2, [1 / 3]),
        (lambda x: 1 / (x - 0.3), lambda x: -1 / (x - 0.3) ** 2, []),
        (
            lambda x: 1 / (x**2 - 2) - 3,
            lambda x: -2 * x / (x**2 - 2) ** 2,
            [-math.sqrt(7 / 3), math.sqrt(7 / 3)],
        ),
        (lambda x: 1 / x**2 - 4, lambda x: -2 / (x**2 * x), [-0.5, 0.5]),
    ],
)
def test_poles_are_no_roots(box: Expression, slope: Expression, roots: list[float]) -> None:
    found = search(box, slope, box, -10, 10)
    assert found.complete
    assert found.roots == pytest.approx(roots, rel=4e-16)


@pytest.mark.parametrize(
    ("box", "slope"),
    [
        (lambda x: x**2 + 1, lambda x: 2 * x),
        (lambda x: exp(x) + 1, exp),
        (lambda x: sqrt(x) + 0.5, sqrt_slope),
        (lambda x: x * x - 2 * x + 1 + 1e-12, lambda x: 2 * x - 2),
    ],
)
def test_absence_is_proven(box: Expression, slope: Expression) -> None:
    found = search(box, slope, lambda x: math.nan, -100, 100)
    assert proven_empty(found)


def test_ends_of_the_range_count() -> None:
    value, slope = polynomial([1.0, 3.0])
    found = search(value, slope, value, 1, 3)
    assert found.complete
    assert found.roots == (1.0, 3.0)
    assert proven_empty(search(value, slope, value, 1.5, 2.5))


def test_a_range_of_one_point() -> None:
    assert search(lambda x: x - 2, lambda x: 1 + 0 * x, lambda x: x - 2, 2, 2).roots == (2.0,)
    assert proven_empty(search(lambda x: x - 2, lambda x: 1 + 0 * x, lambda x: x - 2, 3, 3))
    assert proven_empty(search(lambda x: x - 2, lambda x: 1 + 0 * x, lambda x: x - 2, 3, 1))


@pytest.mark.parametrize("root", [0.0, 1.0, -8.0, 0.3])
def test_double_roots_are_touching_and_not_called_complete(root: float) -> None:
    found = search(lambda x: (x - root) ** 2, lambda x: 2 * (x - root), lambda x: (x - root) ** 2)
    assert not found.complete
    assert found.roots == ()
    assert found.touching == (root,)


def test_an_expanded_double_root_is_found_through_its_slope() -> None:
    found = search(
        lambda x: x * x - 2 * x + 1, lambda x: 2 * x - 2, lambda x: x * x - 2 * x + 1, -10, 10
    )
    assert found.touching == pytest.approx([1.0], rel=1e-15)
    assert not found.complete


def test_a_kink_touches() -> None:
    def kink(x: Any) -> Any:
        return sqrt((x - 2) ** 2)

    found = search(kink, None, lambda x: abs(x - 2), -10, 10)
    assert 2.0 in found.touching


def test_the_edge_of_the_domain() -> None:
    found = search(
        lambda x: sqrt(x - 0.3), lambda x: sqrt_slope(x - 0.3), lambda x: math.sqrt(x - 0.3), -5, 5
    )
    assert found.touching == (0.3,)
    beyond = search(
        lambda x: sqrt(x - 1) - 2, lambda x: sqrt_slope(x - 1), lambda x: math.sqrt(x - 1) - 2
    )
    assert beyond.complete
    assert beyond.roots == (5.0,)


def test_an_essential_singularity_on_one_side() -> None:
    """x exp(1/x) = 3 has two roots, beside the minimum e at x = 1."""
    found = search(
        lambda x: x * exp(1 / x) - 3,
        lambda x: exp(1 / x) * (1 - 1 / x),
        lambda x: x * math.exp(1 / x) - 3,
        1e-3,
        1e9,
    )
    expected = [
        scipy.optimize.brentq(lambda x: x * math.exp(1 / x) - 3, *ends, xtol=1e-15)
        for ends in ((0.3, 1), (1, 9))
    ]
    assert found.complete
    assert found.roots == pytest.approx(expected, rel=1e-13)


def test_without_slopes_roots_are_found_but_not_proven() -> None:
    value, _ = polynomial([float(k) for k in range(1, 11)])
    found = search(value, None, value)
    assert found.roots == tuple(map(float, range(1, 11)))
    assert not found.complete


def test_a_function_that_vanishes_everywhere_is_flat() -> None:
    found = search(lambda x: x - x, lambda x: 0 * x, lambda x: 0.0, -1, 10)
    assert found.flat == ((-1.0, 10.0),)
    assert not found.complete


def test_infinitely_many_roots_end_at_the_budget() -> None:
    limits = IsolationLimits(boxes=20_000)
    found = search(
        lambda x: sin(1 / x),
        lambda x: -1 * cos(1 / x) / x**2,
        lambda x: math.sin(1 / x),
        0,
        1,
        limits,
    )
    assert not found.complete
    assert found.evaluations < 60_000
    assert found.roots[-1] == pytest.approx(1 / math.pi, rel=1e-15)
    assert all(abs(math.sin(1 / x)) * x < 1e-11 for x in found.roots)


@pytest.mark.parametrize("x", [64.0, 75.0, 100.0, 110.0, 120.0, 256.0])
def test_endlessly_many_roots_near_zero_do_not_hide_the_largest(x: float) -> None:
    """The width of a cam that gives an acceleration: sin(c/x)/x^2 turns ever faster towards 0, and
    has its largest roots where it is calm, on both sides of its last top."""
    target = math.sin(250.0 / x) / x**2

    def slope(box: Any) -> Any:
        return (0.0 - 250.0 * cos(250.0 / box) / box - 2.0 * sin(250.0 / box)) / (box * box * box)

    found = search(
        lambda box: sin(250.0 / box) / (box * box) - target,
        slope,
        lambda at: math.sin(250.0 / at) / at**2 - target,
        limits=IsolationLimits(12_000, 2_000),
    )
    assert not found.complete
    assert any(abs(root - x) <= 1e-9 * x for root in found.roots)


def test_a_search_ends_next_to_its_limit_with_some_roots() -> None:
    """A hundred roots of a sine, of which few boxes settle some."""
    limits = IsolationLimits(boxes=1_000)
    found = search(lambda x: sin(x), lambda x: cos(x), math.sin, -300, 300, limits)
    assert not found.complete
    assert found.roots
    assert found.evaluations <= 2 * limits.boxes


def test_a_jump_is_no_root() -> None:
    def box(lo: Any, hi: Any) -> tuple[Any, Any]:
        return numpy.where(hi < 0.7, 1.0, -1.0), numpy.where(lo < 0.7, 1.0, -1.0)

    def slope(lo: Any, hi: Any) -> tuple[Any, Any]:
        crossing = (lo < 0.7) & (hi >= 0.7)
        return numpy.where(crossing, -INF, 0.0), numpy.where(crossing, INF, 0.0)

    value, limits = lambda x: 1.0 if x < 0.7 else -1.0, IsolationLimits()
    found = isolate_roots(box_by_box(box), box_by_box(slope), value, -5, 5, limits)
    assert found.roots == ()


def test_a_jump_that_the_slope_hides_loses_no_root() -> None:
    """Slope 1 everywhere and a fall by 3 at 0.7, close beside the root 0.65: the other root is
    3.65."""

    def box(lo: Any, hi: Any) -> tuple[Any, Any]:
        before, after = lo < 0.7, hi >= 0.7
        least = numpy.where(after, numpy.maximum(lo, 0.7) - 3, lo)
        most = numpy.where(before, numpy.minimum(hi, 0.7), hi - 3)
        return least - 0.65, most - 0.65

    def slope(lo: Any, hi: Any) -> tuple[Any, Any]:
        return numpy.ones_like(lo), numpy.ones_like(lo)

    value, limits = lambda x: x - 0.65 if x < 0.7 else x - 3.65, IsolationLimits()
    found = isolate_roots(box_by_box(box), box_by_box(slope), value, -5, 5, limits)
    assert found.roots == (0.65, 3.65)


def test_cancellation_far_out_does_not_hide_that_there_is_no_root() -> None:
    """|x - 2| + x = 5: beyond 1e16 no float can tell; the slope, exactly 0 there, can."""

    def slope(x: Any) -> Any:
        lo = numpy.where(x.lo > 2, 1.0, -1.0)
        return Interval(lo, numpy.where(x.hi < 2, -1.0, 1.0)) + 1

    found = search(
        lambda x: magnitude(x - 2) + x - 5,
        slope,
        lambda x: abs(x - 2) + x - 5,
    )
    assert found.complete
    assert found.roots == (3.5,)


def test_overflow_beyond_the_horizon_spoils_nothing() -> None:
    found = search(
        lambda x: x**3 - 200 * x**2 + 1,
        lambda x: 3 * x**2 - 400 * x,
        lambda x: x**3 - 200 * x**2 + 1,
    )
    with mpmath.workdps(50):
        real = sorted(float(r.real) for r in mpmath.polyroots([1, -200, 0, 1]))
    assert found.complete
    assert found.roots == pytest.approx(real, rel=1e-15)
