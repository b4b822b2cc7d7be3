"""The chain of methods: what the structure of a block admits, in order; blocks that ask for the
last."""

from __future__ import annotations

import pytest

import rulesheets
import solver
from benchmarks.hard_blocks import hard_block
from rulesheets.evaluate.digits import extended
from solver.facts import Method
from solver.kernel.block import BlockKernel
from solver.kernel.solve_block import first_methods
from solver.path import SolveBlock
from solver.path.planner import planner


def kernel(text: str) -> BlockKernel:
    model = rulesheets.loads(text)
    inputs = frozenset(
        name for name, variable in model.variables.items() if variable.value is not None
    )
    (block,) = (s for s in planner(model).path(inputs, {}).steps if isinstance(s, SolveBlock))
    return BlockKernel(planner(model).graph, block)


@pytest.mark.parametrize(
    ("text", "methods"),
    [
        (
            "x + y = 3\nx - 2*y = 1",
            [Method.LINEAR, Method.POLYNOMIAL, Method.FORMULA, Method.RANGE, Method.STARTS],
        ),
        ("x^2 + y^2 = 4\ny = x^3 + 1", [Method.POLYNOMIAL, Method.RANGE, Method.STARTS]),
        ("y = exp(x)\nx*y = 2", [Method.RANGE, Method.STARTS]),
        (
            "3*cosd(t) + 2*sind(t) = x\nx = 1 + sind(t)",
            [Method.FORMULA, Method.RANGE, Method.STARTS],
        ),
        (
            "variables\nx in [0, 1]\ny in [0, 1]\nz in [0, 1]\nrules\n"
            "x*exp(y) + y*z^3 + x^3 = 1\ny*exp(z) + z*x^3 + y^3 = 1\nz*exp(x) + x*y^3 + z^3 = 1",
            [Method.BOXES, Method.STARTS],
        ),
    ],
)
def test_the_structure_of_a_block_tells_its_chain(text: str, methods: list[Method]) -> None:
    assert list(first_methods(kernel(text))) == methods


@pytest.mark.parametrize("seed", [122, 119])
def test_a_hard_block_is_solved_by_whichever_method(seed: int) -> None:
    model = rulesheets.loads(hard_block(24, seed).sheet)
    result = solver.solve(model)
    assert result.status is solver.Status.SOLVED
    (attempts,) = result.attempts.values()
    assert attempts[-1].found
    values = result.solutions[0]
    for equation in model.equations:
        miss = extended(equation.left, values, 50) - extended(equation.right, values, 50)
        assert abs(miss) <= 1e-12 * (1 + abs(extended(equation.right, values, 50)))
