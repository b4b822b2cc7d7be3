"""Values of expressions in floats and to many digits, and what is said where there is none."""

from __future__ import annotations

import math

import pytest
from hypothesis import given

from rulesheets.evaluate import Undefined, value
from rulesheets.evaluate.digits import extended
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
    Symbol,
)
from tests.rulesheets.evaluate.random_expressions import continuous, nonzero, positive

X = Name("x")


def number(x: float) -> Number:
    return Number(x)


def test_arithmetic() -> None:
    expression = Sum((Product(X, X), Negative(Quotient(X, number(4.0))), Power(number(2.0), X)))
    assert value(expression, {"x": 3.0}) == 9.0 - 0.75 + 8.0
    assert value(Power(number(0.0), number(0.0)), {}) == 1.0
    assert value(Power(number(-8.0), number(3.0)), {}) == -512.0
    assert value(Call("max", (X, number(2.0), Call("pi", ()))), {"x": 1.0}) == math.pi


def test_terms_are_added_left_to_right() -> None:
    terms = tuple(map(number, (1e16, 1.0, -1e16, 1.0)))
    assert value(Sum(terms), {}) == 1.0
    assert float(extended(Sum(terms), {})) == 2.0


@pytest.mark.parametrize(
    ("expression", "x", "text"),
    [
        (Call("sqrt", (X,)), -3.2, "sqrt of -3.2"),
        (Call("ln", (X,)), -1.0, "ln of -1"),
        (Call("acosd", (X,)), 1.08, "acosd of 1.08"),
        (Call("acosd", (X,)), 1.0000000000000002, "acosd of 1.0000000000000002"),
        (Call("atan2d", (X, X)), 0.0, "atan2d of (0, 0)"),
        (Call("tand", (X,)), 90.0, "tand of 90"),
        (Call("exp", (X,)), 1000.0, "exp of 1000"),
        (Quotient(number(1.0), X), 0.0, "division by 0"),
        (Power(X, number(-1.0)), 0.0, "0^-1"),
        (Power(X, number(1.0 / 3.0)), -8.0, "(-8)^0.333333"),
        (Power(X, X), 1000.0, "1000^1000"),
        (Product(X, X), 1e200, "a number too large to hold"),
        (Sum((X, Symbol("open"))), 1.0, "arithmetic with a symbol"),
    ],
)
def test_undefined_reads_like_a_sentence(expression: Expression, x: float, text: str) -> None:
    with pytest.raises(Undefined) as caught:
        value(expression, {"x": x})
    assert str(caught.value) == text


def test_undefined_names_the_part() -> None:
    root = Call("sqrt", (Sum((X, number(-5.0))),))
    with pytest.raises(Undefined) as caught:
        value(Product(number(2.0), root), {"x": 1.0})
    assert caught.value.expression is root
    assert (caught.value.operation, caught.value.arguments) == ("sqrt", (-4.0,))


def test_missing_and_symbolic_variables() -> None:
    with pytest.raises(KeyError):
        value(X, {"y": 1.0})
    with pytest.raises(Undefined):
        value(X, {"x": "open"})
    with pytest.raises(Undefined):
        extended(X, {"x": "open"})


def test_extended_takes_floats_as_they_are() -> None:
    third = extended(Quotient(number(1.0), number(3.0)), {}, digits=40)
    assert str(third)[:40] == "0." + "3" * 38
    assert extended(Sum((number(0.1), X)), {"x": -0.1}) == 0
    assert (
        extended(Call("sind", (X,)), {"x": 1e15 + 180.0})
        + extended(Call("sind", (X,)), {"x": 1e15})
        == 0
    )


def test_a_long_sum_and_a_deep_tree() -> None:
    assert value(Sum((number(1.0),) * 50_000), {}) == 50_000.0
    deep: Expression = X
    for _ in range(400):
        deep = Negative(deep)
    assert value(deep, {"x": 2.0}) == 2.0 == extended(deep, {"x": 2.0})


@given(expression=continuous, x=positive, y=nonzero)
def test_floats_and_digits_agree(expression: Expression, x: float, y: float) -> None:
    """The float value is one that some point near by has: compared by a bound on the
    conditioning."""
    point = {"x": x, "y": y}
    try:
        exact = extended(expression, point, 60)
        around = [float(extended(expression, {"x": x * s, "y": y * t}, 60)) for s, t in NEARBY]
        result = value(expression, point)
    except Undefined:
        return
    spread = max(around) - min(around) + 1e-13 * (1.0 + abs(float(exact)))
    if spread < 1e-6:
        assert abs(result - float(exact)) <= 1e3 * spread + 1e-9 * abs(float(exact))


NEARBY = [(1.0 + 1e-13 * a, 1.0 + 1e-13 * b) for a in (-1, 1) for b in (-1, 1)]
