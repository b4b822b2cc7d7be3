"""Enclosures of random expressions contain their values at random points."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rulesheets.evaluate import Undefined, differentiate, enclose, extended
from rulesheets.nodes import Call, Expression, Name, Number, Power, Product, Quotient, Sum, Symbol
from tests.rulesheets.evaluate.random_expressions import expressions

X, Y = Name("x"), Name("y")
INF = np.inf


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
    boxes = {name: (np.array([low[k]]), np.array([middle[k] + width])) for k, name in enumerate(("x", "y"))}
    for tree in (expression, differentiate(expression, "x")):
        try:
            value = extended(tree, point, 60)
        except Undefined:
            continue
        below, above = enclose(tree, boxes)
        assert float(below[0]) <= value <= float(above[0])


def test_shapes_follow_the_boxes() -> None:
    boxes = {"x": (np.zeros((3, 1)), np.ones((3, 1))), "y": (np.zeros(4), np.ones(4))}
    for tree in (Sum((X, Y)), Number(2.0), X):
        low, high = enclose(tree, boxes)
        assert low.shape == high.shape == (3, 4)
    low, high = enclose(Product(X, Number(2.0)), {"x": (1.0, 3.0)})
    assert low.shape == () and low <= 2.0 and high >= 6.0


def test_empty_boxes_and_symbols() -> None:
    low, high = enclose(
        Sum((Call("sqrt", (X,)), Number(1.0))), {"x": (np.array([-2.0, -1.0]), np.array([-1.0, 4.0]))}
    )
    assert np.isnan(low[0]) and np.isnan(high[0])
    assert (low[1], high[1]) == pytest.approx((1.0, 3.0))
    with pytest.raises(Undefined):
        enclose(Symbol("open"), {})
    with pytest.raises(KeyError):
        enclose(X, {})


def test_squares_are_tight() -> None:
    box = {"x": (np.array([-1.0]), np.array([2.0]))}
    for square in (Product(X, X), Power(X, Number(2.0))):
        low, high = enclose(square, box)
        assert (low[0], high[0]) == pytest.approx((0.0, 4.0))


def test_poles_split() -> None:
    low, high = enclose(Quotient(Number(1.0), X), {"x": (np.array([0.0, -1.0]), np.array([1.0, 1.0]))})
    assert low.tolist() == pytest.approx([1.0, -INF]) and high.tolist() == [INF, INF]
