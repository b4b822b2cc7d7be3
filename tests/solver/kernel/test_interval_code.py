"""Compiled enclosures contain what the expressions are at points of the boxes, as the interpreted
ones do."""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import reduce
from itertools import product

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rulesheets.evaluate import Undefined, value
from rulesheets.evaluate.number import Arithmetic
from rulesheets.functions import INTERVALS
from rulesheets.functions.intervals import (
    Interval,
    add,
    divide,
    multiply,
    power,
    scaled,
    square,
)
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
    call,
)
from solver.kernel.emitter import IntervalEmitter

X, Y, K = Name("x"), Name("y"), Name("k")
LEAVES = st.sampled_from([X, Y, K, Number(2.0), Number(-0.5), Number(0.0)])
FUNCTIONS = st.sampled_from(["sind", "cosd", "sqrt", "abs", "exp", "atand"])


def _grown(inner: st.SearchStrategy[Expression]) -> st.SearchStrategy[Expression]:
    return st.one_of(
        st.builds(lambda a, b: Sum((a, b)), inner, inner),
        st.builds(Product, inner, inner),
        st.builds(Quotient, inner, inner),
        st.builds(lambda x, a, b: Quotient(Product(a, x), Sum((b, x))), inner, inner, inner),
        st.builds(lambda x, y, a, b: a * call("exp", b * x) - call("exp", y * x), *[inner] * 4),
        st.builds(Negative, inner),
        st.builds(lambda a: Product(a, a), inner),
        st.builds(lambda a, n: Power(a, Number(n)), inner, st.sampled_from([2.0, 3.0, 0.5])),
        st.builds(call, FUNCTIONS, inner),
    )


TREES = st.recursive(LEAVES, _grown, max_leaves=8)
ENDS = st.floats(-20, 20).map(lambda x: round(x, 2))


Ends = tuple[float, float]


class Interpreted(Arithmetic[Interval]):
    """Operation by operation, without the forms that the code has for quotients."""

    def __init__(self, box: Mapping[str, Interval]) -> None:
        self.box = box

    def number(self, node: Number) -> Interval:
        return node.value, node.value

    def name(self, node: Name) -> Interval:
        return self.box[node.name]

    def negative(self, node: Negative) -> Interval:
        low, high = self.of(node.operand)
        return -high, -low

    def sum(self, node: Sum) -> Interval:
        return reduce(lambda total, part: add(*total, *part), map(self.of, node.terms))

    def product(self, node: Product) -> Interval:
        factor = self.of(node.left)
        if node.left == node.right:
            return square(*factor)
        return multiply(*factor, *self.of(node.right))

    def divided(self, node: Quotient, above: Interval, below: Interval) -> Interval:
        return divide(*above, *below)

    def raised(self, node: Power, base: Interval, exponent: Interval) -> Interval:
        return power(*base, *exponent)

    def applied(self, node: Call, arguments: list[Interval]) -> Interval:
        bounds: Interval = INTERVALS[node.function](*(end for pair in arguments for end in pair))
        return bounds


def compiled(tree: Expression, x: Ends, y: Ends, k: float) -> Ends:
    emitter = IntervalEmitter(["x", "y"], ["k"])
    ends: Ends = emitter.function(emitter.of(tree))(k)(*x, *y)
    assert all(type(end) is float for end in ends)
    return ends


@given(TREES, st.tuples(ENDS, ENDS), st.tuples(ENDS, ENDS), ENDS, st.floats(0, 1), st.floats(0, 1))
def test_values_lie_within(
    tree: Expression, x: Ends, y: Ends, k: float, s: float, t: float
) -> None:
    x, y = (min(x), max(x)), (min(y), max(y))
    low, high = compiled(tree, x, y, k)
    point = {
        "x": min(x[0] + s * (x[1] - x[0]), x[1]),
        "y": min(y[0] + t * (y[1] - y[0]), y[1]),
        "k": k,
    }
    try:
        number = value(tree, point)
    except Undefined:
        return
    if math.isfinite(number):
        slack = 1e-13 * abs(number)  # the number itself is rounded, at every operation
        assert low - slack <= number <= high + slack


@given(TREES, st.tuples(ENDS, ENDS), st.tuples(ENDS, ENDS), ENDS)
def test_as_tight_as_the_interpreted_ones(tree: Expression, x: Ends, y: Ends, k: float) -> None:
    x, y = (min(x), max(x)), (min(y), max(y))
    low, high = compiled(tree, x, y, k)
    below, above = Interpreted({"x": x, "y": y, "k": (k, k)}).of(tree)
    if math.isnan(
        low
    ):  # the interpreted ones do not see of every rule that it is undefined all over
        for at_x, at_y in product((x[0], sum(x) / 2, x[1]), (y[0], sum(y) / 2, y[1])):
            with pytest.raises(Undefined):
                value(tree, {"x": at_x, "y": at_y, "k": k})
        return
    assert not math.isnan(below)
    if math.isfinite(below) and math.isfinite(above):
        size = 1e-12 * max(abs(below), abs(above)) + 1e-300
        assert low >= below - size
        assert high <= above + size


@pytest.mark.parametrize("ends", [(1e3, 1e300), (-1e300, -1e3), (1e3, math.inf)])
def test_what_saturates_has_its_limit(ends: Ends) -> None:
    """x/(1 + 2x), a law of Monod or Langmuir, is next to 1/2 far out, however wide a box is."""
    low, high = compiled(
        Quotient(X, Sum((Number(1.0), Product(Number(2.0), X)))), ends, (0.0, 0.0), 0.0
    )
    assert 0.499 < low <= high < 0.501


@pytest.mark.parametrize("factor", [-3.0, 0.0, 0.1, 1e-320])
def test_a_known_factor_keeps_signs(factor: float) -> None:
    for low, high in ((-2.0, 3.0), (0.0, 5.0), (1e-320, 2.0), (-1e-320, 0.0)):
        below, above = scaled(factor, factor, low, high)
        assert below <= min(factor * low, factor * high)
        assert above >= max(factor * low, factor * high)
        if low >= 0.0:
            assert (below >= 0.0) if factor >= 0.0 else (above <= 0.0)
    assert all(map(math.isnan, scaled(factor, factor, math.nan, math.nan)))


def test_squares_are_not_negative() -> None:
    (crossed, above), (tiny, _), zero = (
        square(*ends) for ends in ((-2.0, 1.0), (1e-200, 2.0), (0.0, 0.0))
    )
    assert crossed == tiny == 0.0
    assert zero == (0.0, 0.0)
    assert above >= 4.0


def test_what_depends_on_points_alone_is_computed_once() -> None:
    emitter = IntervalEmitter(["x"], ["k"])
    calls: list[float] = []
    emitter.globals["noted"] = lambda low, high: (calls.append(low), high)
    on_box = emitter.function(emitter.apply("noted", emitter.of(K)))(2.0)
    assert [on_box(0.0, 1.0), on_box(1.0, 2.0)] == [(None, 2.0)] * 2
    assert calls == [2.0]


def test_code_of_one_shape_keeps_its_own_numbers() -> None:
    made = []
    for slope, offset in ((2.0, -0.5), (3.0, 7.0), (-4.0, 0.0)):
        emitter = IntervalEmitter(["x"], [])
        tree = Sum((Product(Number(slope), X), Number(offset)))
        made.append((slope, offset, emitter.function(emitter.of(tree))()))
    for slope, offset, on_box in made:
        low, high = on_box(1.0, 2.0)
        assert low <= min(slope, 2 * slope) + offset and max(slope, 2 * slope) + offset <= high
        assert high - low <= abs(slope) + 1e-14
