"""The standard nonlinear systems, from their standard starts and from ten and a hundred times
that."""

from __future__ import annotations

from functools import cache
from typing import Any

import mpmath
import pytest

import rulesheets
import solver
from benchmarks.standard import PROBLEMS, Problem
from rulesheets.model import Model
from solver import Result, Status
from solver.facts import Method
from solver.kernel.block import BlockKernel
from solver.kernel.candidates import Candidates
from solver.kernel.full_search import fall_back
from solver.kernel.problem import BlockProblem
from solver.path.planner import planner

MULTIPLE = (2, 18, 19)
"""Problems whose only roots are multiple ones, or not isolated."""
QUICK = (2, 5, 11, 15, 17, 20, 22)
FARTHER = [
    pytest.param(
        problem,
        factor,
        id=f"{problem.number} from {factor}",
        marks=() if quick else pytest.mark.slow,
    )
    for factor in (10.0, 100.0)
    for problem in PROBLEMS
    for quick in [problem.number in QUICK]
]


class Digits:
    """The functions that the problems are made of, at 50 digits."""

    exp, sin, cos, atan, sqrt = mpmath.exp, mpmath.sin, mpmath.cos, mpmath.atan, mpmath.sqrt
    pi = mpmath.pi

    @staticmethod
    def where(v: Any, positive: float, negative: float) -> float:
        return positive if v > 0 else negative

    @staticmethod
    def expm1_over(v: Any) -> Any:
        return -mpmath.expm1(-(v**2)) / v if v else mpmath.mpf(0)


@cache
def model(number: int) -> Model:
    return rulesheets.loads(PROBLEMS[number - 1].sheet)


@cache
def solved(problem: Problem, factor: float) -> Result:
    return solver.solve(model(problem.number), guesses=problem.guesses(factor))


def check(problem: Problem, result: Result) -> None:
    """Every answer is a root to rounding; a simple one is where 50 digits see it."""
    assert result.status in (Status.SOLVED, Status.SINGULAR)
    with mpmath.workdps(50):
        for solution in result.solutions:
            x = [mpmath.mpf(solution[name]) for name in problem.names]
            assert max(abs(v) for v in problem.residuals(x, Digits)) <= 1e-10
    if result.status is Status.SOLVED and problem.number not in MULTIPLE:
        values = [result.solutions[0][name] for name in problem.names]
        assert values == pytest.approx(refined(problem, values), rel=1e-9, abs=1e-13)


def refined(problem: Problem, values: list[Any]) -> list[float]:
    with mpmath.workdps(50):
        x = mpmath.matrix(values)
        for _ in range(8):
            jacobian = mpmath.matrix(len(values))
            here = problem.residuals(list(x), Digits)
            for j in range(len(values)):
                ahead = x.copy()
                ahead[j] += mpmath.mpf(10) ** -30
                for i, (b, a) in enumerate(
                    zip(problem.residuals(list(ahead), Digits), here, strict=True)
                ):
                    jacobian[i, j] = (b - a) * mpmath.mpf(10) ** 30
            x -= mpmath.lu_solve(jacobian, mpmath.matrix(here))
        return [float(v) for v in x]


@pytest.mark.parametrize("problem", PROBLEMS, ids=lambda problem: problem.title)
def test_from_the_standard_start(problem: Problem) -> None:
    check(problem, solved(problem, 1.0))


@pytest.mark.parametrize(("problem", "factor"), FARTHER)
def test_from_farther_starts(problem: Problem, factor: float) -> None:
    check(problem, solved(problem, factor))


@pytest.mark.parametrize("number", [2, 19])
def test_a_multiple_root_is_not_passed_off_as_a_simple_one(number: int) -> None:
    assert solved(PROBLEMS[number - 1], 1.0).status is Status.SINGULAR


def test_the_methods_tried_are_told() -> None:
    result = solved(PROBLEMS[10], 1.0)
    (attempts,) = result.attempts.values()
    assert attempts[0].method is Method.STARTS
    assert sum(attempt.found for attempt in attempts) == len(result.solutions)


def test_what_descent_does_not_find_trust_regions_do() -> None:
    """Descent from the standard start of the trigonometric function ends in a minimum that is no
    root."""
    problem = PROBLEMS[10]
    (block,) = solved(problem, 1.0).attempts
    kernel = BlockKernel(planner(model(problem.number)).graph, block)
    candidates = Candidates(BlockProblem(kernel, {}, problem.guesses()))
    fall_back(candidates.problem, candidates)
    (attempt,) = candidates.attempts
    assert (attempt.method, attempt.found) == (Method.TRUST_REGION, 1)
    (answer,) = candidates.answers
    values = list(answer.values.values())
    assert values == pytest.approx(refined(problem, values), rel=1e-12)


def test_no_finite_root_is_said() -> None:
    """x y = 1 and x y = 2 at infinity only; the second pair meets at no real point."""
    for sheet in ("x*y = 1\nx*y = 2", "x^2 + y^2 = 1\nx + y = 2"):
        result = solver.solve(rulesheets.loads(sheet))
        assert result.status in (Status.INFEASIBLE, Status.INCONSISTENT)
        assert not result.solutions


@pytest.mark.parametrize("number", [15, 16])
def test_a_limit_at_infinity_is_no_root(number: int) -> None:
    """Far out, square roots of a trace near 0 satisfy each rule to rounding; there are two that
    exist."""
    result = solved(PROBLEMS[number - 1], 1.0)
    assert all(abs(abs(float(str(solution["x1"]))) - 0.01) <= 1e-6 for solution in result.solutions)
