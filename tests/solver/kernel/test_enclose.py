"""Enclosures of random expressions contain their values at random points."""

from __future__ import annotations

import math
from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rulesheets.evaluate import Undefined, differentiate
from rulesheets.evaluate.digits import extended
from rulesheets.syntax.nodes import (
    Call,
    Expression,
    Name,
    Number,
    Power,
    Product,
    Quotient,
    Sum,
    Symbol,
)
from solver.kernel.emitter import enclose
from tests.rulesheets.evaluate.random_expressions import expressions

X, Y = Name("x"), Name("y")
INF = math.inf


@given(
    expression=expressions,
    middle=st.tuples(st.floats(-5.0, 5.0), st.floats(-5.0, 5.0)),
    width=st.floats(1e-6, 3.0),
    where=st.tuples(st.floats(0.0, 1.0), st.floats(0.0, 1.0)),
)
def test_contains_the_value_and_the_slope(
    expression: Expression, middle: tuple[float, float], width: float, where: tuple[float, float]
) -> None:
    low = [each - width for each in middle]
    point = {
        name: min(max(low[k] + 2.0 * width * where[k], low[k]), middle[k] + width)
        for k, name in enumerate(("x", "y"))
    }
    box = {name: (low[k], middle[k] + width) for k, name in enumerate(("x", "y"))}
    for tree in (expression, differentiate(expression, "x")):
        try:
            value = extended(tree, point, 60)
        except Undefined:
            continue
        below, above = enclose(tree, box)
        assert below <= value <= above


def test_ends_are_rounded_outward() -> None:
    low, high = enclose(Product(X, Y), {"x": (0.1, 0.3), "y": (0.7, 1.1)})
    assert Fraction(low) < Fraction(0.1) * Fraction(0.7) and Fraction(high) > Fraction(
        0.3
    ) * Fraction(1.1)
    assert (low, high) == pytest.approx((0.07, 0.33), rel=1e-15)


def test_empty_boxes_and_symbols() -> None:
    tree = Sum((Call("sqrt", (X,)), Number(1.0)))
    assert all(map(math.isnan, enclose(tree, {"x": (-2.0, -1.0)})))
    assert enclose(tree, {"x": (-1.0, 4.0)}) == pytest.approx((1.0, 3.0))
    assert all(map(math.isnan, enclose(Symbol("open"), {})))
    with pytest.raises(KeyError):
        enclose(X, {})


def test_squares_are_tight() -> None:
    for square in (Product(X, X), Power(X, Number(2.0))):
        assert enclose(square, {"x": (-1.0, 2.0)}) == pytest.approx((0.0, 4.0))


def test_poles_split() -> None:
    assert enclose(Quotient(Number(1.0), X), {"x": (0.0, 1.0)}) == pytest.approx((1.0, INF))
    assert enclose(Quotient(Number(1.0), X), {"x": (-1.0, 1.0)}) == (-INF, INF)
