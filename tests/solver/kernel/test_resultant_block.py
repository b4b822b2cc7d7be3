"""Polynomial blocks with two tears, against the roots of one polynomial and against sympy."""

from __future__ import annotations

from itertools import permutations
from typing import Any

import pytest
import sympy
from hypothesis import given, settings
from hypothesis import strategies as st

import rulesheets
import solver

SYMMETRIC = rulesheets.loads("x + y + z = a\nx*y + y*z + z*x = b\nx*y*z = c")
ROOTS = st.integers(-40, 40).map(lambda n: n / 8)


def solve(a: float, b: float, c: float) -> Any:
    return solver.solve(SYMMETRIC, {"a": a, "b": b, "c": c})


def _rounded(point: tuple[float, ...]) -> tuple[float, ...]:
    return tuple(round(v, 6) for v in point)


@settings(max_examples=8, deadline=None)
@given(st.lists(ROOTS, min_size=3, max_size=3, unique=True))
def test_elementary_symmetric_functions_give_every_order_of_their_roots(roots: list[float]) -> None:
    p, q, r = roots
    result = solve(p + q + r, p * q + q * r + r * p, p * q * r)
    assert str(result.status) == "solved"
    assert result.complete
    found = sorted(((s["x"], s["y"], s["z"]) for s in result.solutions), key=_rounded)
    assert len(found) == 6
    for one, other in zip(found, sorted(permutations(roots)), strict=True):
        assert one == pytest.approx(other, rel=1e-9, abs=1e-9)


@pytest.mark.parametrize(("a", "b", "c"), [(1.0, 1.0, 1.0), (0.0, 2.5, 3.0)])
def test_three_numbers_of_which_two_are_complex_are_none(a: float, b: float, c: float) -> None:
    """t³ - a t² + b t - c has one real root."""
    result = solve(a, b, c)
    assert str(result.status) == "infeasible"


MIXED = "x + 2*y - z = {a}\nx*y + z^2 = {b}\nx^2 - y*z = {c}"


@pytest.mark.parametrize(("a", "b", "c"), [(4, 11, -5), (1, 3, 2), (-2, 5, 1)])
def test_quadrics_have_the_points_that_their_resultant_has(a: int, b: int, c: int) -> None:
    result = solver.solve(rulesheets.loads(MIXED.format(a=a, b=b, c=c)))
    assert result.complete
    x, y = sympy.symbols("x y")
    z = x + 2 * y - a
    p, q = sympy.expand(x * y + z**2 - b), sympy.expand(x**2 - y * z - c)
    meets = sympy.Poly(sympy.resultant(p, q, y), x)
    assert meets.is_sqf
    expected = sorted(float(root.evalf(30)) for root in meets.real_roots())
    assert sorted(s["x"] for s in result.solutions) == pytest.approx(expected, rel=1e-9)
