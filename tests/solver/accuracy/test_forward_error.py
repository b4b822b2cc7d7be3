"""Error bars against answers at 50 digits: never too short, and not much too long."""

from __future__ import annotations

import random
from fractions import Fraction
from pathlib import Path

import mpmath
import pytest

import rulesheets
import solver
from tests.oracles import slider_crank as oracle
from tests.oracles.slider_crank import Crank

MODELS = Path(__file__).parents[3] / "models"
SHEETS = ("offset_slider_crank", "offset_slider_crank_slope_free")
QUANTITIES = ("xB", "vB", "omegaAB", "aB", "alphaAB")


@pytest.mark.parametrize("name", SHEETS)
def test_bars_of_the_crank_reach_the_exact_answer(name: str) -> None:
    model = rulesheets.load(MODELS / name / "model.tk")
    draw = random.Random(3)
    for _ in range(25):
        crank = Crank(3.0, 8.0, draw.uniform(-2, 2), -15.0, -10.0, draw.uniform(-180, 180))
        solution = solver.solve(model, crank.inputs).solutions[0]
        exact = oracle.forward(crank)
        for quantity in QUANTITIES:
            assert abs(solution[quantity] - exact[quantity]) <= solution.error[quantity], quantity
            assert solution.error[quantity] <= 1e-13 * abs(solution[quantity]) + 1e-12, quantity


def test_bars_of_a_block_reach_the_exact_answer() -> None:
    """Crank angles for slider positions ever nearer to dead centre."""
    model = rulesheets.load(MODELS / SHEETS[1] / "model.tk")
    for exponent in range(1, 4):
        xB = 10.816653826391967 * (1 - 10.0**-exponent)
        result = solver.solve(model, {"xB": xB, "thetaAO": None})
        exact = oracle.crank_angles(3.0, 8.0, 2.0, xB)
        for solution in result.solutions:
            nearest = min(abs(solution["thetaAO"] - angle) for angle in exact)
            assert nearest <= solution.error["thetaAO"] <= 1e-11


def hilbert(size: int) -> tuple[str, list[Fraction]]:
    """A sheet H x = b with b the float row sums, and its exact solution."""
    matrix = [[Fraction(1.0 / (i + j + 1)) for j in range(size)] for i in range(size)]
    rhs = [Fraction(float(sum(row))) for row in matrix]
    lines = [
        " + ".join(f"{float(c)!r}*x{j}" for j, c in enumerate(row)) + f" = {float(b)!r}"
        for row, b in zip(matrix, rhs, strict=True)
    ]
    return "\n".join(lines), solved(matrix, rhs)


def solved(matrix: list[list[Fraction]], rhs: list[Fraction]) -> list[Fraction]:
    rows = [[*row, b] for row, b in zip(matrix, rhs, strict=True)]
    for k, pivot in enumerate(rows):
        for i, row in enumerate(rows):
            if i != k:
                factor = row[k] / pivot[k]
                rows[i] = [a - factor * p for a, p in zip(row, pivot, strict=True)]
    return [row[-1] / row[k] for k, row in enumerate(rows)]


@pytest.mark.parametrize("size", [2, 4, 7])
def test_bars_of_a_linear_block_grow_with_its_condition(size: int) -> None:
    text, exact = hilbert(size)
    solution = solver.solve(rulesheets.loads(text)).solutions[0]
    for k, x in enumerate(exact):
        assert abs(Fraction(solution[f"x{k}"]) - x) <= Fraction(solution.error[f"x{k}"])
    (block,) = solution.accuracy.blocks.values()
    assert block.rank == size
    known = float(mpmath.cond(mpmath.hilbert(size), lambda a: mpmath.mnorm(a, mpmath.inf)))
    assert known / 100 <= block.condition <= known * 100


def test_cancellation_shows() -> None:
    solution = solver.solve(rulesheets.loads("a = 1/3\nb = a + 1e10\nc = b - 1e10")).solutions[0]
    with mpmath.workdps(50):
        true = float(abs(mpmath.mpf(solution["c"]) - mpmath.mpf(1) / 3))
    assert true <= solution.error["c"] <= 1e-5


def test_an_input_is_exact() -> None:
    solution = solver.solve(
        rulesheets.loads("variables\n x = 0.1\n y\n z\nrules\n y = x\n z = 2*y")
    ).solutions[0]
    assert (solution.error["x"], solution.error["y"]) == (0.0, 0.0)
    assert 0.0 < solution.error["z"] <= 1e-16


def test_a_large_block_has_bars() -> None:
    """A tridiagonal system of more unknowns than are kept as a dense matrix, all of them 1."""
    size = 450
    lines = [
        " + ".join([f"4*x{i}", *(f"x{j}" for j in (i - 1, i + 1) if 0 <= j < size)])
        + f" = {4 + (i > 0) + (i < size - 1)}"
        for i in range(size)
    ]
    solution = solver.solve(rulesheets.loads("\n".join(lines))).solutions[0]
    for i in range(size):
        assert abs(solution[f"x{i}"] - 1.0) <= solution.error[f"x{i}"] <= 1e-14


def test_bars_of_roots_of_higher_multiplicity_hold_them() -> None:
    """At (1, -1) three answers coincide: floats know a third of their digits."""
    result = solver.solve(rulesheets.loads("y = x^3 - 2*x\nx = y^3 - 2*y"))
    exact = [(0.0, 0.0), (3**0.5, 3**0.5), (-(3**0.5), -(3**0.5)), (1.0, -1.0), (-1.0, 1.0)]
    assert len(result.solutions) == len(exact)
    for solution in result.solutions:
        assert any(
            abs(solution["x"] - x) <= solution.error["x"] + 1e-15
            and abs(solution["y"] - y) <= solution.error["y"] + 1e-15
            for x, y in exact
        )


@pytest.mark.parametrize(
    ("rule", "root"),
    [("x^3 - 3*x^2 + 3*x = 1", 1.0), ("x^4 - 8*x^3 + 24*x^2 - 32*x + 16 = 0", 2.0)],
)
def test_a_multiple_root_of_a_polynomial_is_what_it_is_in_exact_numbers(
    rule: str, root: float
) -> None:
    result = solver.solve(rulesheets.loads(rule))
    assert str(result.status) == "singular"
    assert result["x"] == root
