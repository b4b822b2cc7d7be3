"""Blocks of the same formulas by other rules are searched once, and told by their own rules."""

from __future__ import annotations

from typing import Any

import pytest

import rulesheets
import solver
from solver.facts import DoubleRoot, NoRoot, OutOfRange
from solver.kernel.candidates import Answer, BlockOutcome
from solver.path.steps import SolveBlock
from solver.solution import explore
from solver.solution.leaves import Twins

SENSES = """
x^3 + y = w + 1
y - 0.2*x^2 = 0.3
w = v + 0.1*x
if and(x >= 0, y >= 0) then v = 0.9*y
if and(x <= 0, y <= 0) then v = 0.9*y
if and(x >= 0, y <= 0) then v = -0.9*y
if and(x <= 0, y >= 0) then v = -0.9*y
"""


def test_cases_of_the_same_formulas_share_a_search(monkeypatch: pytest.MonkeyPatch) -> None:
    """Four cases, of which two and two put the same formulas into the block."""
    searched: list[tuple[int, ...]] = []
    original = explore.solve_block

    def counted(kernel: Any, *rest: Any) -> BlockOutcome:
        searched.append(kernel.block.equations)
        return original(kernel, *rest)

    monkeypatch.setattr(explore, "solve_block", counted)
    model = rulesheets.loads(SENSES)
    result = solver.solve(model)
    rules = {model.equations[index] for equations in searched for index in equations}
    formulas = {(rule.left, rule.right) for rule in rules if rule.guard}
    assert len(formulas) == 2
    assert len(searched) == 2
    assert str(result.status) == "solved"
    for found in result.solutions:
        x, y, v = (found[name] for name in "xyv")
        assert v == pytest.approx(0.9 * abs(y) if x >= 0 else -0.9 * abs(y), rel=1e-12)


def test_outcome_is_told_by_the_rules_of_the_case() -> None:
    twins = Twins(rulesheets.loads(SENSES))
    met = SolveBlock((0, 1, 2, 3), ("x", "y", "v", "w"), ("x",))
    same, other = (SolveBlock((0, 1, 2, e), met.unknowns, ("x",)) for e in (4, 5))
    assert twins.sense(met) == twins.sense(same) != twins.sense(other)
    double = DoubleRoot((0, 1, 2, 3), ("x",), {"x": 1.0})
    facts = (NoRoot((0, 1, 2, 3), ("x",), True), OutOfRange(3, "v", 2.0))
    told = twins.told(BlockOutcome((Answer({"x": 1.0}, double),), facts=facts), met, same)
    assert told.answers[0].double == DoubleRoot((0, 1, 2, 4), ("x",), {"x": 1.0})
    assert told.facts == (NoRoot((0, 1, 2, 4), ("x",), True), OutOfRange(4, "v", 2.0))
