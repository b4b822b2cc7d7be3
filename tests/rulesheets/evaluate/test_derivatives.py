"""Symbolic and accumulated derivatives against differences at 60 digits."""

from __future__ import annotations

import math

import pytest
from hypothesis import assume, given

from rulesheets.evaluate import (
    Undefined,
    derivatives,
    differentiate,
    slopes_by_name,
    value,
)
from rulesheets.evaluate.digits import context, extended
from rulesheets.syntax.nodes import (
    Call,
    Expression,
    Name,
    Negative,
    Number,
    Power,
    Product,
    Quotient,
    Sum,
    names,
)
from tests.rulesheets.evaluate.random_expressions import expressions, nonzero, positive

X, Y = Name("x"), Name("y")
MP = context(60)


def slope(expression: Expression, point: dict[str, float], name: str) -> float:
    """Central difference to about 20 digits."""
    step = MP.mpf(10) ** -20
    at = [
        extended(expression, {**point, name: MP.mpf(point[name]) + s * step}, 60) for s in (1, -1)
    ]
    return float((at[0] - at[1]) / (2 * step))


@given(expression=expressions, x=positive, y=nonzero)
def test_both_agree_with_differences(expression: Expression, x: float, y: float) -> None:
    point = {"x": x, "y": y}
    try:
        expected = {name: slope(expression, point, name) for name in set(names(expression))}
        exact = {name: extended(differentiate(expression, name), point, 60) for name in expected}
        result, gradient = derivatives(expression, point)
    except Undefined:
        return
    assume(all(abs(each) < 1e6 for each in expected.values()))
    assume(not any(math.isnan(each) for each in gradient.values()))  # sqrt at 0
    assert result == value(expression, point)
    assert set(gradient) == set(expected)
    for name, each in expected.items():
        assert float(exact[name]) == pytest.approx(each, rel=1e-12, abs=1e-12)
        if well_conditioned(expression, name, point):
            assert gradient[name] == pytest.approx(each, rel=1e-6, abs=1e-6)


def well_conditioned(expression: Expression, name: str, point: dict[str, float]) -> bool:
    """Whether the derivative hardly moves between neighbouring floats."""
    tree = differentiate(expression, name)
    try:
        here = float(extended(tree, point))
        near = [
            float(extended(tree, {k: v * (1.0 + s) for k, v in point.items()}))
            for s in (1e-12, -1e-12)
        ]
    except Undefined:
        return False
    return max(abs(each - here) for each in near) < 1e-8 and math.isfinite(here)


def test_folding_of_zeros_and_ones() -> None:
    assert differentiate(X, "x") == Number(1.0)
    assert differentiate(Y, "x") == Number(0.0)
    assert differentiate(Sum((X, Y, Negative(X))), "y") == Number(1.0)
    assert differentiate(Product(Y, X), "x") == Y
    assert differentiate(Quotient(X, Y), "x") == Quotient(Number(1.0), Y)
    assert differentiate(Power(X, Number(2.0)), "x") == Product(Number(2.0), X)
    assert differentiate(Call("exp", (X,)), "x") == Call("exp", (X,))
    assert differentiate(Call("int", (X,)), "x") == Number(0.0)


def test_bessel_functions_by_their_order() -> None:
    expression = Call("jn", (X, Y))
    with pytest.raises(Undefined):
        value(differentiate(expression, "x"), {"x": 1.0, "y": 0.5})
    assert value(differentiate(expression, "y"), {"x": 1.0, "y": 0.0}) == 0.5
    gradient = derivatives(expression, {"x": 1.0, "y": 0.0})[1]
    assert math.isnan(gradient["x"]) and gradient["y"] == 0.5


def test_where_a_derivative_does_not_exist_it_is_nan() -> None:
    result, gradient = derivatives(Sum((Call("sqrt", (X,)), Y)), {"x": 0.0, "y": 3.0})
    assert result == 3.0
    assert math.isnan(gradient["x"]) and gradient["y"] == 1.0


def test_powers_of_zero_and_of_negative_bases() -> None:
    square = Power(X, Number(2.0))
    assert derivatives(square, {"x": 0.0}) == (0.0, {"x": 0.0})
    assert derivatives(square, {"x": -3.0}) == (9.0, {"x": -6.0})
    assert derivatives(Power(X, Number(1.0)), {"x": 0.0}) == (0.0, {"x": 1.0})
    assert derivatives(Power(X, Number(0.0)), {"x": 0.0}) == (1.0, {"x": 0.0})


def test_kinks_take_one_side() -> None:
    both = Call("max", (X, Y, X))
    assert derivatives(both, {"x": 2.0, "y": 1.0})[1] == {"x": 1.0, "y": 0.0}
    tie = derivatives(both, {"x": 1.0, "y": 1.0})[1]
    assert sorted(tie.values()) == [0.0, 1.0]
    assert derivatives(Call("abs", (X,)), {"x": -2.0}) == (2.0, {"x": -1.0})


def test_undefined_blames_the_users_operation() -> None:
    root = Call("sqrt", (X,))
    with pytest.raises(Undefined) as caught:
        derivatives(Product(Y, root), {"x": -1.0, "y": 1.0})
    assert caught.value.expression is root
    with pytest.raises(Undefined, match="too large"):
        derivatives(Product(X, X), {"x": 1e200})


def test_slopes_of_a_sum_are_those_of_its_terms_by_each_name() -> None:
    """Only terms that hold a name are differentiated by it: a sum of n names takes n derivatives,
    not n²."""
    terms = (
        Product(X, Y),
        Negative(Sum((Power(X, Number(3.0)), Name("z")))),
        Call("sin", (Y,)),
        X,
        Number(2.0),
    )
    found = slopes_by_name(Sum(terms), {"x", "y", "w"})
    assert found == {name: differentiate(Sum(terms), name) for name in ("x", "y")}


def test_terms_without_a_name_are_not_differentiated_by_it() -> None:
    by_order = Call("jn", (X, Number(1.0)))
    assert slopes_by_name(Sum((by_order, Y)), {"y"}) == {"y": Number(1.0)}
