"""Elimination in any arithmetic: exact in fractions, and no answer where there is no number."""

from __future__ import annotations

import math
from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from solver.numerics.elimination import Singular, eliminate, eliminate_rows

fractions = st.fractions(-9, 9, max_denominator=9)
systems = st.integers(1, 4).flatmap(
    lambda n: st.tuples(
        st.lists(st.lists(fractions, min_size=n, max_size=n), min_size=n, max_size=n),
        st.lists(fractions, min_size=n, max_size=n),
    )
)


@given(systems)
def test_what_comes_out_satisfies_every_row_exactly(
    system: tuple[list[list[Fraction]], list[Fraction]],
) -> None:
    matrix, rhs = system
    found = eliminate(matrix, rhs)
    if found is not None:
        assert [sum(a * x for a, x in zip(row, found, strict=True)) for row in matrix] == rhs
    else:
        assert determinant(matrix) == 0


def determinant(matrix: list[list[Fraction]]) -> Fraction:
    """By the first row, without a pivot."""
    if not matrix:
        return Fraction(1)
    minors = [[row[:j] + row[j + 1 :] for row in matrix[1:]] for j in range(len(matrix))]
    return sum(
        ((-1) ** j * entry * determinant(minors[j]) for j, entry in enumerate(matrix[0])),
        Fraction(0),
    )


@pytest.mark.parametrize("bad", [math.nan, math.inf])
def test_a_matrix_with_what_is_no_number_is_refused(bad: float) -> None:
    for place in range(4):
        matrix = [[2.0, 1.0], [1.0, 3.0]]
        matrix[place // 2][place % 2] = bad
        assert eliminate(matrix, [1.0, 1.0], 1e-12) is None
        with pytest.raises(Singular):
            eliminate_rows([dict(enumerate(row)) for row in matrix], [[1.0, 1.0]], 1e-12)
