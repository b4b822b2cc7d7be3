"""Solving with one matrix, small, large, sparse, deficient."""

from __future__ import annotations

import math

import numpy
import pytest
import scipy.sparse
from hypothesis import given, settings
from hypothesis import strategies as st

from solver.numerics.linear_algebra import (
    any_rank,
    factorise,
    null_direction,
    row_sizes,
)

ENTRIES = st.integers(-9, 9).map(float)
SQUARE = st.integers(1, 8).flatmap(
    lambda n: st.lists(st.lists(ENTRIES, min_size=n, max_size=n), min_size=n, max_size=n)
)


@settings(max_examples=60, deadline=None)
@given(SQUARE)
def test_small_and_large_paths_agree_with_numpy(rows: list[list[float]]) -> None:
    n = len(rows)
    factor = factorise(rows, [1.0] * n)
    rank = numpy.linalg.matrix_rank(numpy.array(rows))
    assert factor.rank == rank
    if rank == n:
        rhs = [float(i + 1) for i in range(n)]
        assert factor.solution(rhs) == pytest.approx(
            numpy.linalg.solve(rows, rhs).tolist(), rel=1e-7, abs=1e-9
        )


def test_a_tiny_matrix_that_overflows_moves_nothing() -> None:
    for rows in (
        [[1e300, 1.0], [math.nan, 1.0]],
        [[0.0, 0.0], [0.0, 0.0]],
        [[1e300, 1.0], [1e300, 1.0]],
    ):
        factor = any_rank(rows, [1e10, 1.0])
        assert (factor.rank, factor.solution([1.0, 1.0]).tolist()) == (0, [0.0, 0.0])


def test_condition_grows_where_the_matrix_nears_singularity() -> None:
    conditions = [
        factorise([[1.0, 1.0], [1.0, 1.0 + d]], [1.0, 1.0]).condition() for d in (1.0, 1e-4, 1e-8)
    ]
    assert conditions[0] < 10
    assert conditions[1] == pytest.approx(4e4, rel=0.1)
    assert conditions[2] == pytest.approx(4e8, rel=0.1)
    assert factorise([[1.0, 1.0], [1.0, 1.0]], [1.0, 1.0]).condition() == math.inf


def test_deficient_gives_the_shortest_of_the_best() -> None:
    factor = factorise([[1.0, 1.0], [2.0, 2.0]], [1.0, 1.0])
    assert factor.solution([2.0, 4.0]) == pytest.approx([1.0, 1.0])
    weighted = factorise([[1.0, 1.0]], [1.0, 2.0])
    assert weighted.solution([5.0]) == pytest.approx([1.0, 4.0])


def test_sparse_agrees_with_dense() -> None:
    dense = numpy.diag(numpy.arange(1.0, 41.0)) + numpy.diag(numpy.ones(39), 1)
    sparse = scipy.sparse.csr_array(dense)
    rhs = [1.0] * 40
    assert factorise(sparse, rhs).solution(rhs) == pytest.approx(
        numpy.linalg.solve(dense, rhs).tolist()
    )
    assert (row_sizes(sparse, [-1.0] * 40) == row_sizes(dense.tolist(), [-1.0] * 40)).all()


def test_a_singular_sparse_matrix_tells_its_rank() -> None:
    dense = numpy.eye(40)
    dense[3] = dense[4]
    factor = factorise(scipy.sparse.csr_array(dense), [1.0] * 40)
    assert (factor.rank, factor.columns) == (39, 40)


def test_a_solution_that_overflows_is_not_finite_and_no_warning() -> None:
    factor = factorise(numpy.diag([1e-200] * 12), [1.0] * 12)
    assert not any(map(math.isfinite, factor.solution([1e200] * 12)))


def test_a_direction_is_scaled_like_the_point() -> None:
    moving = null_direction([[1.0, -2.0], [2.0, -4.0]], [4.0, 2.0])
    assert [abs(part) for part in moving] == pytest.approx([1.0, 0.5])
    assert null_direction([[1.0, float("inf")], [0.0, 1.0]], [1.0, 1.0]) == (1.0, 1.0)
