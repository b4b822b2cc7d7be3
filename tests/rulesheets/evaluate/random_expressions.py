"""Random smooth expressions of two variables, as a hypothesis strategy."""

from __future__ import annotations

from hypothesis import strategies as st

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
)

SMOOTH = (
    "sqrt",
    "exp",
    "ln",
    "sin",
    "cos",
    "atan",
    "sind",
    "cosd",
    "tand",
    "asind",
    "atand",
    "tanh",
    "erf",
)

leaves = st.one_of(
    st.sampled_from([Name("x"), Name("y")]),
    st.integers(-5, 5).map(lambda whole: Number(float(whole))),
    st.floats(0.1, 3.0).map(Number),
)


def _grown(parts: st.SearchStrategy[Expression]) -> st.SearchStrategy[Expression]:
    return st.one_of(
        parts.map(Negative),
        st.lists(parts, min_size=2, max_size=4).map(lambda terms: Sum(tuple(terms))),
        st.builds(Product, parts, parts),
        st.builds(Quotient, parts, parts),
        st.builds(Power, parts, st.integers(-3, 3).map(lambda whole: Number(float(whole)))),
        st.builds(Power, parts, parts),
        st.builds(lambda name, part: Call(name, (part,)), st.sampled_from(SMOOTH), parts),
    )


def _with_directions(parts: st.SearchStrategy[Expression]) -> st.SearchStrategy[Expression]:
    return st.one_of(_grown(parts), st.builds(lambda y, x: Call("atan2d", (y, x)), parts, parts))


continuous = st.recursive(leaves, _grown, max_leaves=8)
expressions = st.recursive(leaves, _with_directions, max_leaves=8)

# Points with three decimals, so that none is as near to a kink as a difference is wide.
positive = st.integers(100, 3000).map(lambda thousandths: thousandths / 1000)
nonzero = st.integers(-3000, 3000).filter(bool).map(lambda thousandths: thousandths / 1000)
