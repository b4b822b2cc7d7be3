from __future__ import annotations

import pytest

from rulesheets.evaluate import Undefined, holds
from rulesheets.syntax.nodes import (
    And,
    Comparison,
    Condition,
    Expression,
    Given,
    Name,
    Not,
    Number,
    Or,
    Quotient,
    Sum,
    Symbol,
)

X = Name("x")
ONE = Number(1.0)


def compare(left: Expression, operator: str, right: Expression) -> Comparison:
    return Comparison(operator, left, right)


TRUE, FALSE = compare(ONE, "=", ONE), compare(ONE, "<>", ONE)
WAITING = compare(Name("unknown"), ">", ONE)
BROKEN = compare(Quotient(ONE, Number(0.0)), ">", ONE)


@pytest.mark.parametrize(
    ("operator", "below", "same", "above"),
    [
        ("=", False, True, False),
        ("<>", True, False, True),
        ("<", True, False, False),
        ("<=", True, True, False),
        (">", False, False, True),
        (">=", False, True, True),
    ],
)
def test_relations(operator: str, below: bool, same: bool, above: bool) -> None:
    outcomes = [holds(compare(X, operator, ONE), {"x": x}) for x in (0.5, 1.0, 1.5)]
    assert outcomes == [below, same, above]


def test_equality_has_a_tolerance_and_order_has_none() -> None:
    sum_of_tenths = Sum((Number(0.1),) * 10)
    assert holds(compare(sum_of_tenths, "=", ONE), {})
    assert not holds(compare(sum_of_tenths, "<>", ONE), {})
    assert holds(compare(sum_of_tenths, "<", ONE), {})
    assert not holds(compare(X, "=", Number(0.0)), {"x": 1e-300})
    assert not holds(compare(X, "=", ONE), {"x": 1.0 + 1e-14})


@pytest.mark.parametrize("value", ["crossed", 1.0])
@pytest.mark.parametrize("operator", ["=", "<>", "<", "<=", ">", ">="])
def test_a_symbol_equals_itself_alone(operator: str, value: str | float) -> None:
    assert holds(compare(X, operator, Symbol("open")), {"x": value}) is (operator == "<>")
    assert holds(compare(Symbol("open"), operator, X), {"x": value}) is (operator == "<>")


def test_equal_symbols() -> None:
    assert holds(compare(X, "=", Symbol("open")), {"x": "open"})
    assert holds(compare(X, "=", Name("y")), {"x": "open", "y": "open"})
    assert not holds(compare(X, "<>", Symbol("open")), {"x": "open"})
    assert not holds(compare(X, "<=", Symbol("open")), {"x": "open"})


def test_given() -> None:
    assert holds(Given("x"), {}, given={"x"})
    assert not holds(Given("x"), {"x": 1.0}, given=())


@pytest.mark.parametrize("first", [TRUE, FALSE])
@pytest.mark.parametrize("second", [TRUE, FALSE])
def test_connectives(first: Condition, second: Condition) -> None:
    left, right = first is TRUE, second is TRUE
    assert holds(And((first, second)), {}) is (left and right)
    assert holds(Or((first, second)), {}) is (left or right)
    assert holds(Not(first), {}) is not left


@pytest.mark.parametrize(("obstacle", "error"), [(WAITING, KeyError), (BROKEN, Undefined)])
def test_a_term_that_settles_the_outcome_is_enough_in_any_order(
    obstacle: Condition, error: type[Exception]
) -> None:
    for terms in ((obstacle, FALSE), (FALSE, obstacle)):
        assert not holds(And(terms), {})
        with pytest.raises(error):
            holds(Or(terms), {})
    for terms in ((obstacle, TRUE), (TRUE, obstacle)):
        assert holds(Or(terms), {})
        with pytest.raises(error):
            holds(And(terms), {})
