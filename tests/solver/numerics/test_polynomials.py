"""Exact roots of polynomials: against polynomials that are made from their roots, and numpy."""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from solver.numerics.one_unknown import real_roots


def polynomial(*roots: float, factor: float = 1.0, quadratics: int = 0) -> list[Fraction]:
    """With these roots, and so many factors x² + x + k that have none."""
    product = [Fraction(factor)]
    factors = [[-Fraction(root), Fraction(1)] for root in roots]
    factors += [[Fraction(k + 1), Fraction(1), Fraction(1)] for k in range(quadratics)]
    for other in factors:
        made = [Fraction(0)] * (len(product) + len(other) - 1)
        for i, a in enumerate(product):
            for j, b in enumerate(other):
                made[i + j] += a * b
        product = made
    return product


NUMBERS = st.floats(-1e6, 1e6, width=32).map(lambda x: x if abs(x) > 1e-6 else 0.0)
ROOTS = st.lists(NUMBERS, unique=True, max_size=5)


@given(ROOTS, st.integers(0, 2), st.floats(0.1, 100))
def test_planted_roots_are_found_to_the_last_bit(
    roots: list[float], quadratics: int, factor: float
) -> None:
    found = real_roots(polynomial(*roots, factor=factor, quadratics=quadratics))
    assert found == tuple(sorted(roots))


@given(ROOTS.filter(bool), st.floats(-1e6, 1e6), st.floats(-1e6, 1e6))
def test_ranges_are_closed(roots: list[float], a: float, b: float) -> None:
    low, high = sorted((a, b))
    found = real_roots(polynomial(*roots), low, high)
    assert found == tuple(sorted(root for root in roots if low <= root <= high))
    assert real_roots(polynomial(*roots), min(roots), max(roots)) == tuple(sorted(roots))


@given(st.lists(st.integers(-9, 9), min_size=2, max_size=7))
def test_counts_agree_with_numpy(coefficients: list[int]) -> None:
    assume(coefficients[-1])
    found = real_roots([Fraction(c) for c in coefficients])
    all_of_them = np.roots(coefficients[::-1])
    apart = min(
        (abs(a - b) for i, a in enumerate(all_of_them) for b in all_of_them[:i]), default=1.0
    )
    assume(apart > 1e-3)
    real = sorted(z.real for z in all_of_them if abs(z.imag) < 1e-7)
    assert found == pytest.approx(real, abs=1e-6)


@pytest.mark.parametrize("coefficients", [[], [0], [0, 0], [1, 2, 1], [1, 0, 2, 0, 1], [0, 0, 3]])
def test_no_list_for_nothing_and_for_multiple_roots(coefficients: list[int]) -> None:
    assert real_roots([Fraction(c) for c in coefficients]) is None


def test_a_constant_has_no_root() -> None:
    assert real_roots([Fraction(3)]) == ()


def test_neighbouring_floats_are_told_apart_and_nearer_roots_are_not_merged() -> None:
    one, next_one = 1.0, math.nextafter(1.0, 2.0)
    assert real_roots(polynomial(one, next_one)) == (one, next_one)
    between = [Fraction(one) + Fraction(k, 2**60) for k in (1, 2)]
    assert real_roots([between[0] * between[1], -(between[0] + between[1]), Fraction(1)]) is None


def test_wilkinson() -> None:
    """(x-1)(x-2)…(x-20), whose roots floats can't find from float coefficients."""
    assert real_roots(polynomial(*map(float, range(1, 21)))) == tuple(map(float, range(1, 21)))


@pytest.mark.parametrize("size", [1e-150, 1e-20, 1e20, 1e100])
def test_roots_of_any_size(size: float) -> None:
    assert real_roots(polynomial(-size, size / 3, 1.0)) == (-size, *sorted((size / 3, 1.0)))


@pytest.mark.parametrize("pairs", [1, 8, 11])
def test_a_root_between_ends_where_the_polynomial_is_next_to_nothing(pairs: int) -> None:
    """Inside it is larger than at the ends by more than floats hold: that is no reason to stop at
    an end."""
    near = [Fraction(k, 10**40) for k in range(1, pairs + 1)]
    coefficients = polynomial(*(-x for x in near), *(1 + x for x in near), Fraction(1, 3))  # type: ignore[arg-type]
    assert real_roots(coefficients, 0.0, 1.0) == (1 / 3,)


@pytest.mark.parametrize("exponent", [90, 99, 110, 300])
def test_the_nearest_float_where_the_polynomial_underflows_beside_its_size(exponent: int) -> None:
    """x³ = 10^-3k between 0 and 1: the root is 10^-k, a float of which is the one that is
    written."""
    coefficients = [Fraction(-1, 10 ** (3 * exponent)), Fraction(0), Fraction(0), Fraction(1)]
    assert real_roots(coefficients, 0.0, 1.0) == (float(f"1e-{exponent}"),)
