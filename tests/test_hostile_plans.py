"""Hostile sheets through compiled plans: calls and sweeps say what a solve says.

``benchmarks/hostile.py --plans`` makes and judges as many as one has patience for.
"""

from __future__ import annotations

import warnings

import pytest

from benchmarks import hostile_inputs
from benchmarks.hostile_kinds import sheet
from benchmarks.hostile_plans import examine, parametrised
from benchmarks.hostile_sheets import Sheet

UNLIMITED = 0.0
QUICK = 10
"""Seeds from here on are tried with ``-m slow``."""


@pytest.mark.parametrize(
    "first",
    [pytest.param(k, marks=() if k < QUICK else pytest.mark.slow) for k in range(0, 200, 10)],
)
def test_hostile_plans(first: int) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        outcomes = [examine(seed, UNLIMITED, most=2) for seed in range(first, first + 10)]
    assert [outcome.finding for outcome in outcomes if outcome.finding] == []


@pytest.mark.parametrize("seed", [1035, 1067, 2, 3])
def test_small_sheets_at_special_numbers(seed: int) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        outcome = examine(
            seed, UNLIMITED, 3, make=hostile_inputs.sheet, asked=hostile_inputs.points
        )
    assert outcome.finding is None
    assert outcome.status not in ("refused", "slow", "hang", "crash")


def test_a_sheet_without_inputs_gets_one_in_place_of_a_number() -> None:
    made = Sheet("planted", (("", "x^2", "4.0"),), planted={"x": 2.0})
    found = parametrised(made, 1)
    assert found is not None
    ((name, value),) = found.inputs.items()
    assert value in (2.0, 4.0) and name != "x"
    assert name in " ".join(found.rules[0])
    given = Sheet("planted", (("", "x^2", "a"),), {"a": 4.0})
    assert parametrised(given, 1) is given
    assert parametrised(Sheet("broken text", (), raw="x ="), 1) is None


def test_most_sheets_have_something_to_ask_a_plan_for() -> None:
    made = [parametrised(sheet(seed, 2), seed) for seed in range(60)]
    assert sum(found is not None for found in made) > 40
