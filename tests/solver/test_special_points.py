"""Small sheets at special points, which a search of ``benchmarks/hostile.py --small`` has found
wanting."""

from __future__ import annotations

import mpmath
import pytest

import rulesheets
import solver
from solver import Result


def solved(*rules: str) -> Result:
    return solver.solve(rulesheets.loads("\n".join(rules)))


@pytest.mark.parametrize("size", [1e16, 1e60])
def test_an_answer_beside_a_number_that_hides_it(size: float) -> None:
    """(x - s)² - s² = -360 s has the roots s ± s√(1 - 360/s)."""
    with mpmath.workdps(200):
        root = mpmath.sqrt(1 - mpmath.mpf(360) / mpmath.mpf(size))
        roots = [float(size * (1 + root)), float(size * (1 - root))]
    result = solved(f"(x - {size!r})^2 - {size!r}^2 = -360*{size!r}")
    assert result.complete
    assert sorted(solution["x"] for solution in result.solutions) == pytest.approx(
        sorted(roots), rel=1e-15
    )


def test_a_number_that_is_lost_beside_a_larger_one_is_not_out_of_its_range() -> None:
    """(z - 1e16) + 1e16 is z; floats make 0 of -0.5, which the range does not admit."""
    rules = "variables\nz in [-0.5, -0.25]\nrules\n(z + (-1e16)) - (-1e16) = -0.5"
    result = solver.solve(rulesheets.loads(rules))
    assert result.status is solver.Status.SOLVED
    assert result["z"] == -0.5


def test_a_number_that_is_out_of_its_range_to_all_digits_is_refused() -> None:
    rules = "variables\nz in [-0.5, -0.25]\nrules\n(z + (-1e16)) - (-1e16) = -0.75"
    assert solver.solve(rulesheets.loads(rules)).status is solver.Status.INFEASIBLE
