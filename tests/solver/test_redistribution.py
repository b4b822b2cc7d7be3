"""The slider crank from any choice of its inputs: numbers of the sheet and of the subsheets alike.

A state is drawn, some of its quantities are given, and the sheet must come back to it.
"""

from __future__ import annotations

from typing import Any

import pytest

import solver
from tests.oracles.random_sheets import EPS, backward_error
from tests.oracles.redistribution import Choice, Sheet, sheet, well_posed_choice
from tests.sampling import sampled

AS_PRINTED, SLOPE_FREE = "offset_slider_crank", "offset_slider_crank_slope_free"


def assert_true_success(of: Sheet, result: Any) -> None:
    """Every active rule holds at every answer, by the witness at 50 digits."""
    for solution in result.solutions:
        values = {name: solution[full] for name, full in of.full.items() if full in solution}
        for left, right in of.active_rules(values):
            of_rule = {name: values[name] for name in of.quantities(left, right)}
            assert backward_error(left, right, of_rule) <= 80 * EPS, (left, right, of_rule)


def assert_comes_back(of: Sheet, choice: Choice) -> None:
    result = solver.solve(of.model, of.inputs_of(choice))
    assert str(result.status) == "solved", choice
    assert any(of.is_state(solution, choice) for solution in result.solutions), choice
    assert_true_success(of, result)


@pytest.mark.parametrize("seed", sampled([2, 6, 15, 23, 30, 34], 2))
def test_any_inputs_of_the_sheet_as_printed(seed: int) -> None:
    of = sheet(AS_PRINTED)
    assert_comes_back(of, well_posed_choice(of, of.posted, seed))


@pytest.mark.parametrize("seed", sampled([0, 8, 11, 18, 25], 2))
def test_any_inputs_of_the_sheet_without_slopes(seed: int) -> None:
    of = sheet(SLOPE_FREE)
    assert_comes_back(of, well_posed_choice(of, of.posted, seed))


@pytest.mark.parametrize("seed", sampled([4, 11, 22, 30, 36], 2))
def test_any_inputs_locals_included_as_printed(seed: int) -> None:
    of = sheet(AS_PRINTED)
    assert_comes_back(of, well_posed_choice(of, of.numbers, seed))


@pytest.mark.parametrize("seed", sampled([5, 15, 20, 24, 38], 2))
def test_any_inputs_locals_included_without_slopes(seed: int) -> None:
    of = sheet(SLOPE_FREE)
    assert_comes_back(of, well_posed_choice(of, of.numbers, seed))


@pytest.mark.parametrize(
    ("name", "seed"), [(SLOPE_FREE, 7), (SLOPE_FREE, 30), (AS_PRINTED, 18), (AS_PRINTED, 32)]
)
def test_values_that_leave_something_free_are_never_solved(name: str, seed: int) -> None:
    """By their pattern they determine all, by their values they don't: no length is given."""
    of = sheet(name)
    choice = well_posed_choice(of, of.numbers, seed)
    assert choice.singular
    assert str(solver.solve(of.model, of.inputs_of(choice)).status) in {"partial", "singular"}
