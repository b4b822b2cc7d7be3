"""Boxes narrowed by rules: no point that satisfies them is lost, and what can be said at once is said."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rulesheets.evaluate import Undefined, enclose
from rulesheets.syntax.nodes import Expression, Name, Negative, Number, Power, Product, Quotient, Sum, call
from solver.kernel.box_search import Hull
from tests.solver.kernel.test_interval_code import ENDS

X, Y, C = Name("x"), Name("y"), Name("c")
LEAVES = st.sampled_from([X, Y, Number(2.0), Number(-0.5), Number(3.0)])
FUNCTIONS = [
    "sind",
    "cosd",
    "sin",
    "cos",
    "sqrt",
    "abs",
    "exp",
    "ln",
    "atand",
    "asin",
    "tanh",
    "sinh",
    "acosd",
]


def _grown(inner: st.SearchStrategy[Expression]) -> st.SearchStrategy[Expression]:
    return st.one_of(
        st.builds(lambda a, b, c: Sum((a, b, c)), inner, inner, inner),
        st.builds(lambda a, b: Sum((a, Negative(b))), inner, inner),
        st.builds(Product, inner, inner),
        st.builds(Quotient, inner, inner),
        st.builds(lambda a: Product(a, a), inner),
        st.builds(lambda a, n: Power(a, Number(n)), inner, st.sampled_from([2.0, 3.0, 4.0, -1.0, 0.5, 1.5])),
        st.builds(call, st.sampled_from(FUNCTIONS), inner),
    )


TREES = st.recursive(LEAVES, _grown, max_leaves=10)
SPANS = st.floats(0, 30).map(lambda x: round(x, 2))


def contract(hull: Hull, *box: tuple[float, float]) -> tuple[list[tuple[float, float]], bool]:
    low, high = (np.array([[side[end] for side in box]]) for end in (0, 1))
    with np.errstate(all="ignore"):
        low, high, empty = hull.contract(low, high)
    return list(zip(low[0].tolist(), high[0].tolist(), strict=True)), bool(empty[0])


@given(TREES, ENDS, ENDS, *[SPANS] * 4, st.floats(0, 4), st.floats(0, 4))
def test_no_root_is_lost(
    tree: Expression,
    x: float,
    y: float,
    left: float,
    right: float,
    below: float,
    above: float,
    less: float,
    more: float,
) -> None:
    """``c`` may be what the tree is at a point, enclosed there, and more: then the point stays."""
    try:
        low, high = enclose(tree, {"x": (x, x), "y": (y, y)})
    except Undefined:
        return
    if not (math.isfinite(low) and math.isfinite(high)):
        return
    box = ((x - left, x + right), (y - below, y + above), (float(low) - less, float(high) + more))
    narrowed, empty = contract(Hull([Sum((tree, Negative(C)))], ("x", "y", "c"), {}), *box)
    assert not empty
    for (first, last), number in zip(narrowed, (x, y), strict=False):
        assert first <= number <= last
    assert narrowed[2][0] <= high
    assert narrowed[2][1] >= low
    for (first, last), (low_end, high_end) in zip(narrowed, box, strict=True):
        assert low_end <= first <= last <= high_end


@pytest.mark.parametrize(
    ("form", "box", "expected"),
    [
        (Sum((Power(X, Number(2.0)), Number(-4.0))), (1.0, 9.0), (2.0, 2.0)),
        (Sum((Power(X, Number(2.0)), Number(-4.0))), (-9.0, 1.0), (-2.0, -2.0)),
        (Sum((Power(X, Number(3.0)), Number(8.0))), (-9.0, 9.0), (-2.0, -2.0)),
        (Sum((call("exp", X), Number(-1.0))), (-9.0, 9.0), (0.0, 0.0)),
        (Sum((call("cosd", X), Number(-0.5))), (100.0, 400.0), (300.0, 300.0)),
        (Sum((call("sind", X), Number(-0.5))), (-100.0, 100.0), (30.0, 30.0)),
        (Sum((call("sind", X), Number(-0.5))), (-400.0, 200.0), (-330.0, 150.0)),
        (Sum((Quotient(Number(6.0), X), Number(-2.0))), (-100.0, 100.0), (3.0, 3.0)),
        (Sum((Product(X, X), Number(-9.0))), (0.0, 100.0), (3.0, 3.0)),
        (Sum((call("abs", X), Number(-5.0))), (-4.0, 100.0), (5.0, 5.0)),
        (Sum((call("sqrt", X), Number(-5.0))), (0.0, 100.0), (25.0, 25.0)),
    ],
)
def test_one_operation_is_inverted(
    form: Expression, box: tuple[float, float], expected: tuple[float, float]
) -> None:
    (narrowed,), empty = contract(Hull([form], ("x",), {}), box)
    assert not empty
    assert narrowed == pytest.approx(expected, rel=1e-11, abs=1e-12)


@pytest.mark.parametrize(
    ("form", "box"),
    [
        (Sum((Power(X, Number(2.0)), Number(4.0))), (-9.0, 9.0)),
        (Sum((call("cosd", X), Number(-0.5))), (70.0, 290.0)),
        (Sum((call("sqrt", X), Number(1.0))), (-9.0, 9.0)),
        (call("ln", X), (-9.0, -1.0)),
        (Sum((Product(X, X), Number(-4.0))), (-1.9, 1.9)),
    ],
)
def test_what_holds_no_root_is_empty(form: Expression, box: tuple[float, float]) -> None:
    assert contract(Hull([form], ("x",), {}), box)[1]


def test_rules_share_their_common_parts() -> None:
    """x + y is 3 by one rule, and so √(x + y + 1) of the other is 2."""
    total = Sum((X, Y))
    rules = [Sum((total, Number(-3.0))), Sum((call("sqrt", Sum((total, Number(1.0)))), Negative(C)))]
    (_, _, c), _ = contract(Hull(rules, ("x", "y", "c"), {}), (-9.0, 9.0), (-9.0, 9.0), (-9.0, 9.0))
    assert c == pytest.approx((2.0, 2.0))
