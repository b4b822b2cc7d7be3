"""Exact small linear systems, refined large ones."""

from __future__ import annotations

from fractions import Fraction

import numpy
import pytest
import sympy
from hypothesis import given, settings
from hypothesis import strategies as st

from solver.numerics.elimination import solve_linear

ENTRIES = st.integers(-6, 6)


System = tuple[list[list[int]], list[int]]


def integers(length: int) -> st.SearchStrategy[list[int]]:
    return st.lists(ENTRIES, min_size=length, max_size=length)


def systems(size: int = 5) -> st.SearchStrategy[System]:
    return st.tuples(st.integers(1, size), st.integers(1, size)).flatmap(
        lambda shape: st.tuples(
            st.lists(integers(shape[1]), min_size=shape[0], max_size=shape[0]), integers(shape[0])
        )
    )


@settings(max_examples=80, deadline=None)
@given(systems())
def test_rank_and_consistency_agree_with_sympy(system: System) -> None:
    rows, rhs = system
    outcome = solve_linear(rows, rhs)
    matrix = sympy.Matrix(rows)
    assert (not outcome.conflict) == (matrix.row_join(sympy.Matrix(rhs)).rank() == matrix.rank())
    assert len(outcome.nullspace) == matrix.shape[1] - matrix.rank()


@settings(max_examples=80, deadline=None)
@given(systems())
def test_conflict_is_a_minimal_dependent_set_and_combines_to_the_miss(
    system: System,
) -> None:
    rows, rhs = system
    outcome = solve_linear(rows, rhs)
    if not outcome.conflict:
        return
    chosen = sympy.Matrix([rows[i] for i in outcome.conflict])
    assert chosen.rank() == len(outcome.conflict) - 1
    for left_out in range(len(outcome.conflict)):
        rest = chosen.copy()
        rest.row_del(left_out)
        assert rest.rank() == rest.shape[0]
    combined = sum(m * rhs[i] for m, i in zip(outcome.multipliers, outcome.conflict, strict=True))
    assert outcome.miss != 0
    assert combined == pytest.approx(outcome.miss)


@settings(max_examples=50, deadline=None)
@given(systems(4))
def test_determined_unknowns_are_the_same_in_every_solution(system: System) -> None:
    rows, rhs = system
    outcome = solve_linear(rows, rhs)
    if outcome.solution is None:
        return
    symbols = sympy.symbols(f"x:{len(rows[0])}")
    (general,) = sympy.linsolve((sympy.Matrix(rows), sympy.Matrix(rhs)), *symbols)
    for value, expression in zip(outcome.solution, general, strict=True):
        assert (value is None) == bool(expression.free_symbols)
        if value is not None:
            assert value == float(expression)


def test_solution_is_correctly_rounded_where_floats_lose_everything() -> None:
    n = 12
    hilbert = [[1.0 / (i + j + 1) for j in range(n)] for i in range(n)]
    outcome = solve_linear(hilbert, [1.0] * n)
    exact = sympy.Matrix(n, n, lambda i, j: sympy.Rational(Fraction(hilbert[i][j]))).LUsolve(
        sympy.ones(n, 1)
    )
    assert outcome.solution == tuple(float(Fraction(int(v.p), int(v.q))) for v in exact)


def test_the_contradicting_pair_is_named_with_its_miss() -> None:
    outcome = solve_linear([[1, 0, 1], [1, 1, 0], [1, 1, 0]], [5, 26, 27])
    assert outcome.solution is None
    assert outcome.conflict == (1, 2)
    assert abs(outcome.miss) == 1


def test_redundant_rows_leave_what_they_leave_free() -> None:
    outcome = solve_linear([[1, 1, 0], [2, 2, 0], [0, 0, 3]], [26, 52, 6])
    assert len(outcome.nullspace) == 1
    assert outcome.solution == (None, None, 2.0)
    assert outcome.free == (0, 1)


@pytest.mark.parametrize("filled", [1.0, 0.03])
def test_large_system_is_refined_to_working_precision(filled: float) -> None:
    random = numpy.random.default_rng(7)
    n = 120
    matrix = random.integers(-9, 10, (n, n)) * (random.random((n, n)) < filled) + 40 * numpy.eye(n)
    x = random.integers(1, 100, n)
    outcome = solve_linear(matrix.tolist(), (matrix @ x).tolist())
    assert outcome.solution == tuple(map(float, x))


def test_large_singular_system_keeps_what_is_determined() -> None:
    n = 40
    rows = numpy.eye(n)
    rows[5] = 0
    rows[5, 4], rows[4, 5] = 2, 0.5
    rows[4, 4], rows[5, 5] = 1, 1
    outcome = solve_linear(rows.tolist(), [1.0] * 4 + [3.0, 6.0] + [1.0] * (n - 6))
    assert outcome.free == (4, 5)
    assert outcome.solution is not None
    assert outcome.solution[0] == pytest.approx(1.0)


def test_large_contradiction_names_its_rows() -> None:
    n = 40
    rows = numpy.eye(n)
    rows[7] = rows[3]
    rhs = [1.0] * n
    rhs[7] = 2.0
    outcome = solve_linear(rows.tolist(), rhs)
    assert outcome.solution is None
    assert outcome.conflict == (3, 7)


@pytest.mark.parametrize("seed", range(4))
def test_independent_rows_of_a_wide_system_never_contradict_each_other(seed: int) -> None:
    """Most of them homogeneous, so that a residual is large beside what it is made of."""
    random = numpy.random.default_rng(seed)
    m, n = 35, 48
    sizes = random.choice([1.0, -1.0, 2.0, -0.3], (m, n)) * 10.0 ** random.integers(-3, 4, (m, n))
    matrix = numpy.where(random.random((m, n)) < 0.06, sizes, 0.0)
    numpy.fill_diagonal(matrix, 1.0)
    rhs = numpy.where(random.random(m) < 0.1, random.normal(size=m), 0.0)
    outcome = solve_linear(matrix.tolist(), rhs.tolist())
    assert len(outcome.nullspace) == n - m
    assert not outcome.conflict


def test_large_contradiction_is_found_in_rows_of_any_size() -> None:
    n = 40
    rows = numpy.diag(10.0 ** numpy.linspace(-150, 150, n))
    rows[7] = 0
    rows[7, 3] = 3 * rows[3, 3]
    rhs = rows.sum(axis=1)
    assert not solve_linear(rows.tolist(), rhs.tolist()).conflict
    rhs[7] *= 1.0 + 1e-9
    outcome = solve_linear(rows.tolist(), rhs.tolist())
    assert outcome.conflict == (3, 7)
    assert outcome.miss == pytest.approx(rhs[7] * 1e-9 * outcome.multipliers[1])
