"""Compiled enclosures contain what the expressions are at points of the boxes, as the interpreted ones do."""

from __future__ import annotations

import math
from collections.abc import Callable
from itertools import product

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rulesheets.evaluate import Undefined, enclose, value
from rulesheets.functions import intervals as arithmetic
from rulesheets.functions.arrays import scaled, square
from rulesheets.syntax.nodes import Expression, Name, Negative, Number, Power, Product, Quotient, Sum, call
from solver.kernel.emitter import IntervalEmitter
from solver.kernel.enclosure import ARRAYS, FLOATS

X, Y, K = Name("x"), Name("y"), Name("k")
LEAVES = st.sampled_from([X, Y, K, Number(2.0), Number(-0.5), Number(0.0)])
FUNCTIONS = st.sampled_from(["sind", "cosd", "sqrt", "abs", "exp", "atand"])


def _grown(inner: st.SearchStrategy[Expression]) -> st.SearchStrategy[Expression]:
    return st.one_of(
        st.builds(lambda a, b: Sum((a, b)), inner, inner),
        st.builds(Product, inner, inner),
        st.builds(Quotient, inner, inner),
        st.builds(Negative, inner),
        st.builds(lambda a: Product(a, a), inner),
        st.builds(lambda a, n: Power(a, Number(n)), inner, st.sampled_from([2.0, 3.0, 0.5])),
        st.builds(call, FUNCTIONS, inner),
    )


TREES = st.recursive(LEAVES, _grown, max_leaves=8)
ENDS = st.floats(-20, 20).map(lambda x: round(x, 2))


Ends = tuple[float, float]


def on_arrays(tree: Expression, x: Ends, y: Ends, k: float) -> Ends:
    emitter = IntervalEmitter(["x", "y"], ["k"], ARRAYS)
    low, high = emitter.of(tree)
    function = emitter.function([low, high])
    with np.errstate(all="ignore"):
        ends = function(*(np.array([end]) for end in (*x, *y)), np.float64(k))
    return tuple(float(np.broadcast_to(end, (1,))[0]) for end in ends)  # type: ignore[return-value]


def on_floats(tree: Expression, x: Ends, y: Ends, k: float) -> Ends:
    emitter = IntervalEmitter(["x", "y"], ["k"], FLOATS)
    low, high = emitter.of(tree)
    ends: Ends = emitter.function([low, high])(*x, *y, k)
    assert all(type(end) is float for end in ends)
    return ends


BOTH = pytest.mark.parametrize("compiled", [on_arrays, on_floats])
Compiled = Callable[[Expression, Ends, Ends, float], Ends]


@BOTH
@given(TREES, st.tuples(ENDS, ENDS), st.tuples(ENDS, ENDS), ENDS, st.floats(0, 1), st.floats(0, 1))
def test_values_lie_within(
    compiled: Compiled, tree: Expression, x: Ends, y: Ends, k: float, s: float, t: float
) -> None:
    x, y = (min(x), max(x)), (min(y), max(y))
    low, high = compiled(tree, x, y, k)
    point = {"x": min(x[0] + s * (x[1] - x[0]), x[1]), "y": min(y[0] + t * (y[1] - y[0]), y[1]), "k": k}
    try:
        number = value(tree, point)
    except Undefined:
        return
    if math.isfinite(number):
        slack = 1e-13 * abs(number)  # the number itself is rounded, at every operation
        assert low - slack <= number <= high + slack


@BOTH
@given(TREES, st.tuples(ENDS, ENDS), st.tuples(ENDS, ENDS), ENDS)
def test_as_tight_as_the_interpreted_ones(
    compiled: Compiled, tree: Expression, x: Ends, y: Ends, k: float
) -> None:
    x, y = (min(x), max(x)), (min(y), max(y))
    low, high = compiled(tree, x, y, k)
    below, above = enclose(tree, {"x": x, "y": y, "k": (k, k)})
    if math.isnan(low):  # the interpreted ones do not see of every rule that it is undefined all over
        for at_x, at_y in product((x[0], sum(x) / 2, x[1]), (y[0], sum(y) / 2, y[1])):
            with pytest.raises(Undefined):
                value(tree, {"x": at_x, "y": at_y, "k": k})
        return
    assert not math.isnan(below)
    if math.isfinite(below) and math.isfinite(above):
        size = 1e-12 * max(abs(below), abs(above)) + 1e-300
        assert low >= below - size
        assert high <= above + size


@pytest.mark.parametrize("factor", [-3.0, 0.0, 0.1, 1e-320])
def test_a_known_factor_keeps_signs(factor: float) -> None:
    low, high = np.array([-2.0, 0.0, 1e-320, -1e-320, np.nan]), np.array([3.0, 5.0, 2.0, 0.0, np.nan])
    with np.errstate(all="ignore"):
        below, above = scaled(np.float64(factor), np.float64(factor), low, high)
    for a, b, c, d in zip(below[:4], above[:4], low[:4], high[:4], strict=True):
        assert a <= min(factor * c, factor * d)
        assert b >= max(factor * c, factor * d)
        if c >= 0.0:
            assert (a >= 0.0) if factor >= 0.0 else (b <= 0.0)
    assert np.isnan(below[4])
    with_floats = [
        arithmetic.scaled(factor, factor, *ends) for ends in zip(low.tolist(), high.tolist(), strict=True)
    ]
    assert np.array_equal(np.array(with_floats).T, [below, above], equal_nan=True)


def test_squares_are_not_negative() -> None:
    below, above = square(np.array([-2.0, 1e-200, 0.0]), np.array([1.0, 2.0, 0.0]))
    assert below.tolist()[:2] == [0.0, 0.0]
    assert below[2] == above[2] == 0.0
    assert above[0] >= 4.0
    with_floats = [arithmetic.square(*ends) for ends in ((-2.0, 1.0), (1e-200, 2.0), (0.0, 0.0))]
    assert with_floats == list(zip(below.tolist(), above.tolist(), strict=True))
