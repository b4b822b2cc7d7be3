"""Singular values in plain Python against those of numpy, and against what a decomposition must satisfy."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from solver.numerics.nullspace import decompose, last_singular, null_direction
from solver.numerics.small_svd import LARGEST, decomposed

ORDERS = st.integers(1, LARGEST)


@settings(max_examples=40)
@given(ORDERS, ORDERS, st.integers(0, 2**32 - 1), st.sampled_from(["full", "deficient", "scaled", "near"]))
def test_it_is_a_decomposition(m: int, n: int, seed: int, kind: str) -> None:
    random = np.random.default_rng(seed)
    matrix = random.normal(size=(m, n))
    if kind == "scaled":
        matrix *= 10.0 ** random.integers(-12, 1, size=(m, 1))
    elif kind != "full":
        matrix[:, -1] = 2 * matrix[:, 0] + (1e-12 if kind == "near" else 0.0) * matrix[:, -1]
    found = decomposed(matrix.tolist())
    expected = np.zeros(n)
    expected[: min(m, n)] = np.linalg.svd(matrix, compute_uv=False)
    right, images = np.array(found.right), np.array(found.images)
    close = 1e-14 * n * expected[0]
    assert np.allclose(found.values, expected, rtol=0.0, atol=close)
    assert np.allclose(right @ right.T, np.eye(n), rtol=0.0, atol=1e-14 * n)
    assert np.allclose(right @ matrix.T, images, rtol=0.0, atol=close)
    assert np.allclose(images @ images.T, np.diag(expected**2), rtol=0.0, atol=close * expected[0])


@pytest.mark.parametrize("n", [2, 5, LARGEST, LARGEST + 3])
def test_the_last_vector_is_the_one_that_hardly_moves(n: int) -> None:
    random = np.random.default_rng(n)
    left, _ = np.linalg.qr(random.normal(size=(n, n)))
    right, _ = np.linalg.qr(random.normal(size=(n, n)))
    values = np.append(np.linspace(2.0, 1.0, n - 1), 1e-9)
    found, vector = last_singular((left @ np.diag(values) @ right).tolist())
    assert found == pytest.approx(values.tolist(), rel=1e-6)
    assert abs(right[-1] @ vector) == pytest.approx(1.0, rel=1e-14)


def test_a_direction_is_scaled_like_the_point() -> None:
    moving = null_direction([[1.0, -2.0], [2.0, -4.0]], [4.0, 2.0])
    assert np.abs(moving).tolist() == pytest.approx([1.0, 0.5])
    assert null_direction([[1.0, float("inf")], [0.0, 1.0]], [1.0, 1.0]) == (1.0, 1.0)


@settings(max_examples=40)
@given(
    st.integers(1, LARGEST + 3),
    st.integers(1, LARGEST + 3),
    st.integers(0, 2**32 - 1),
    st.sampled_from([1.0, 1e-120, 1e120]),
)
def test_least_squares_of_least_norm(m: int, n: int, seed: int, size: float) -> None:
    """Of any rank, also where the matrix is too large for plain Python, or its squares are no floats."""
    random = np.random.default_rng(seed)
    rank = int(random.integers(1, min(m, n) + 1))
    matrix = size * random.normal(size=(m, rank)) @ random.normal(size=(rank, n))
    rhs = random.normal(size=m)
    found = decompose(matrix.tolist())
    assert found.rank(1e-10) == rank
    condition = found.values[0] / found.values[rank - 1]
    expected = np.linalg.pinv(matrix / size, rcond=1e-10) @ rhs
    least = np.array(found.least(rhs.tolist(), rank)) * size
    assert np.allclose(least, expected, rtol=0.0, atol=1e-14 * condition**2 * np.abs(expected).max())
    null = np.array(found.right[rank:]).reshape(-1, n)
    assert np.allclose(null @ matrix.T / size, 0.0, rtol=0.0, atol=1e-12 * found.values[0] / size)


def test_nothing_is_all_null() -> None:
    found = decompose([[0.0, 0.0], [0.0, 0.0]])
    assert (found.rank(1e-6), found.least([1.0, 2.0], 0)) == (0, [0.0, 0.0])
