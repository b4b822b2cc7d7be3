"""Large sheets in random order, solved right; ``benchmarks/scale.py`` tells how long that takes."""

from __future__ import annotations

import math

import mpmath
import pytest

import rulesheets
import solver
from benchmarks.sheets import Sheet, backward_chain, chain, cubic_blocks, linear_blocks
from solver.solution import explore


def check(sheet: Sheet) -> solver.Result:
    text, expected = sheet
    result = solver.solve(rulesheets.loads(text))
    assert str(result.status) == "solved"
    wrong = [
        n for n, v in expected.items() if not math.isclose(result[n], v, rel_tol=1e-9, abs_tol=1e-9)
    ]
    assert wrong == []
    assert result.complete
    return result


@pytest.mark.parametrize("direction", [chain, backward_chain])
def test_a_chain_of_2000_rules(direction: object) -> None:
    assert len(check(direction(2_000)).path.steps) == 2_000  # type: ignore[operator]


def test_formulas_of_numbers_are_right_to_the_last_digit() -> None:
    """A load of each of 1,100 hours, and their sum: too long a path to be followed in many
    digits."""
    rows = [f"g{i} = 10*sin(0.7*{i}) + 1\ns{i} = max(s{i - 1} + g{i}, 0)\n" for i in range(1, 1101)]
    result = solver.solve(rulesheets.loads("s0 = 25\n" + "".join(rows)))
    assert str(result.status) == "solved"
    with mpmath.workdps(40):
        exact = {f"g{i}": float(10 * mpmath.sin(mpmath.mpf(0.7) * i) + 1) for i in range(1, 1101)}
    assert {name: result[name] for name in exact} == exact


def test_400_linear_blocks_of_five() -> None:
    steps = check(linear_blocks(2_000)).path.steps
    assert [len(step.equations) for step in steps] == [5] * 400


def test_nonlinear_blocks_are_searched_however_many_there_are(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(explore, "MAX_SEARCHES", 2)
    check(cubic_blocks(30))
