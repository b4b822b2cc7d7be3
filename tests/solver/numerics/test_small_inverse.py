"""Small inverses against numpy, and against the identity they must give."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from solver.numerics.small_inverse import LARGEST, inverse


@given(st.integers(1, LARGEST), st.integers(0, 2**32 - 1))
def test_the_inverse_is_that_of_numpy(n: int, seed: int) -> None:
    random = np.random.default_rng(seed)
    matrix = random.normal(size=(n, n)) * 10.0 ** random.integers(-3, 4, size=(n, 1))
    found = inverse(matrix.tolist())
    expected = np.linalg.inv(matrix)
    tolerance = 1e-13 * np.linalg.cond(matrix) * np.abs(expected).max()
    assert np.allclose(found, expected, rtol=0.0, atol=tolerance)


def test_rows_are_exchanged_where_a_pivot_is_zero() -> None:
    assert inverse([[0.0, 2.0], [4.0, 0.0]]) == [[0.0, 0.25], [0.5, 0.0]]


@pytest.mark.parametrize("matrix", [[[0.0]], [[1.0, 2.0], [2.0, 4.0]], [[0.0, 0.0], [1.0, 1.0]]])
def test_a_singular_matrix_has_none(matrix: list[list[float]]) -> None:
    assert inverse(matrix) is None
