"""Linear systems in numbers of more digits: exact in fractions."""

from fractions import Fraction

import mpmath
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from solver.numerics.elimination import Singular, eliminate_rows

entries = st.integers(-5, 5)


@settings(max_examples=60, deadline=None)
@given(
    st.lists(st.lists(entries, min_size=4, max_size=4), min_size=4, max_size=4),
    st.lists(entries, min_size=4, max_size=4),
)
def test_elimination_in_fractions_is_exact_or_singular(
    rows: list[list[int]], right: list[int]
) -> None:
    matrix = [{j: Fraction(a) for j, a in enumerate(row) if a} for row in rows]
    column = [Fraction(b) for b in right]
    try:
        (x,) = eliminate_rows(matrix, [column])
    except Singular:
        import sympy

        assert sympy.Matrix(rows).det() == 0
    else:
        assert [sum(a * x[j] for j, a in row.items()) for row in matrix] == column


def test_large_systems_have_all_digits() -> None:
    """The second difference matrix of n points with u'' = -2 has the solution i (n + 1 - i)."""
    n = 80
    mp = mpmath.MPContext()
    mp.dps = 60
    rows = [
        {j: mp.mpf(2 if i == j else -1) for j in (i - 1, i, i + 1) if 0 <= j < n} for i in range(n)
    ]
    (x,) = eliminate_rows(rows, [[mp.mpf(2) / 3] * n])
    assert max(abs(x[i] - mp.mpf((i + 1) * (n - i)) / 3) for i in range(n)) < 1e-25


def test_singular_systems_are_named() -> None:
    with pytest.raises(Singular):
        eliminate_rows(
            [{0: Fraction(1), 1: Fraction(2)}, {0: Fraction(2), 1: Fraction(4)}],
            [[Fraction(1)] * 2],
        )
    n = 41
    with pytest.raises(Singular):
        eliminate_rows([{0: 1.0} for _ in range(n)], [[1.0] * n])
