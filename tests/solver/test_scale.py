"""Large sheets in random order, solved right; ``benchmarks/scale.py`` tells how long that takes."""

from __future__ import annotations

import math

import pytest

import rulesheets
import solver
from benchmarks.sheets import Sheet, backward_chain, chain, cubic_blocks, linear_blocks
from solver.solution import explore


def check(sheet: Sheet) -> solver.Result:
    text, expected = sheet
    result = solver.solve(rulesheets.loads(text))
    assert str(result.status) == "solved"
    wrong = [n for n, v in expected.items() if not math.isclose(result[n], v, rel_tol=1e-9, abs_tol=1e-9)]
    assert wrong == []
    assert result.complete
    return result


@pytest.mark.parametrize("direction", [chain, backward_chain])
def test_a_chain_of_2000_rules(direction: object) -> None:
    assert len(check(direction(2_000)).path.steps) == 2_000  # type: ignore[operator]


def test_400_linear_blocks_of_five() -> None:
    steps = check(linear_blocks(2_000)).path.steps
    assert [len(step.equations) for step in steps] == [5] * 400


def test_nonlinear_blocks_are_searched_however_many_there_are(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(explore, "MAX_SEARCHES", 2)
    check(cubic_blocks(30))
