"""Random sheets with a planted solution: found again, nothing false, whatever the order of the
rules."""

from __future__ import annotations

import math
import random
from collections.abc import Mapping
from typing import Any

import numpy as np
import pytest

import rulesheets
import solver
from tests.oracles import random_sheets as oracle
from tests.oracles.random_sheets import RandomSheet

SEEDS = 7
REGULAR = 1e-6
UNGUARDED = ("linear", "polynomial", "trigonometric", "rational", "transcendental", "called")


def solve(sheet: RandomSheet, **given: Any) -> Any:
    result = solver.solve(rulesheets.loads(sheet.text), **given)
    assert result.diagnoses or result.status is solver.Status.SOLVED
    return result


def sheets(families: tuple[str, ...], seeds: int = SEEDS, rules: int | None = None) -> list[Any]:
    return [
        pytest.param(family, seed, rules, id=f"{family}-{seed}")
        for family in families
        for seed in range(seeds)
    ]


def regularity(sheet: RandomSheet) -> float:
    """Smallest over largest singular value of the scaled Jacobian at the state; 0 where it is not
    square."""
    rows = np.array(oracle.jacobian(sheet, sheet.state))
    if rows.shape != (len(sheet.unknowns),) * 2:
        return 0.0
    sizes = np.maximum(np.abs(rows).max(axis=1, keepdims=True), 1e-300)
    values = np.linalg.svd(rows / sizes, compute_uv=False)
    return float(values[-1] / values[0]) if values[0] else 0.0


def is_state(solution: Mapping[str, Any], sheet: RandomSheet, tolerance: float) -> bool:
    """Whether a solution is the planted state; an angle may be a whole turn off."""
    for name, planted in sheet.state.items():
        apart = abs(solution.get(name, math.inf) - planted)
        if name.startswith("t"):
            apart = min(apart, abs(apart - 360.0))
        if not apart <= tolerance * max(1.0, abs(planted)):
            return False
    return True


def found(result: Any, sheet: RandomSheet) -> bool:
    tolerance = max(1e-9, 1e-12 / max(regularity(sheet), 1e-12))
    return any(is_state(solution, sheet, tolerance) for solution in result.solutions)


def assert_true_success(result: Any, sheet: RandomSheet) -> None:
    """Every rule holds at every answer that is called one, by the witness at 50 digits."""
    if str(result.status) != "solved":
        return
    for solution in result.solutions:
        values = {name: solution[name] for name in sheet.state}
        for rule in sheet.rules:
            for left, right in oracle.active(rule, oracle.exact(values)):
                assert oracle.backward_error(left, right, values) <= 80 * oracle.EPS, (
                    rule.text,
                    values,
                )


def answers(result: Any, sheet: RandomSheet) -> list[tuple[float, ...]]:
    """The answers as tuples in a fixed order, rounded so that they can be compared."""
    return sorted(tuple(float(f"{s[n]:.6g}") + 0.0 for n in sheet.state) for s in result.solutions)


def unknown(result: Any, sheet: RandomSheet) -> set[str]:
    """Names of the sheet itself that stay unknown (locals are numbered in the order of the
    calls)."""
    return set(result.undetermined) & set(sheet.state)


@pytest.mark.parametrize(("family", "seed", "rules"), sheets(tuple(oracle.FAMILIES)))
def test_planted_solution_is_found(family: str, seed: int, rules: int | None) -> None:
    sheet = oracle.random_sheet(random.Random(f"{family}{seed}"), family, rules)
    result = solve(sheet)
    assert_true_success(result, sheet)
    if regularity(sheet) > REGULAR:
        assert str(result.status) == "solved"
        assert found(result, sheet)


@pytest.mark.parametrize(("family", "seed", "rules"), sheets(UNGUARDED, 4, 4))
def test_order_of_rules_changes_nothing(family: str, seed: int, rules: int) -> None:
    draw = random.Random(f"shuffle {family}{seed}")
    sheet = oracle.random_sheet(draw, family, rules)
    result, shuffled = solve(sheet), solve(sheet.shuffled(draw))
    assert result.status is shuffled.status
    assert unknown(result, sheet) == unknown(shuffled, sheet)
    if result.complete and shuffled.complete:
        assert answers(result, sheet) == answers(shuffled, sheet)


@pytest.mark.parametrize(("family", "seed", "rules"), sheets(UNGUARDED, 4, 4))
def test_without_a_rule_the_right_names_stay_unknown(family: str, seed: int, rules: int) -> None:
    draw = random.Random(f"drop {family}{seed}")
    sheet = oracle.random_sheet(draw, family, rules)
    if regularity(sheet) <= REGULAR:
        return
    dropped = sheet.without(draw.randrange(rules))
    result = solve(dropped)
    assert str(result.status) == "partial"
    assert unknown(result, sheet) == oracle.undetermined(dropped.rows, dropped.unknowns)


@pytest.mark.parametrize(
    ("family", "seed", "rules"), sheets(("linear", "polynomial", "trigonometric"), 5)
)
def test_redundant_rule_is_a_check(family: str, seed: int, rules: int | None) -> None:
    draw = random.Random(f"redundant {family}{seed}")
    sheet = oracle.random_sheet(draw, family, rules)
    if regularity(sheet) <= 1e-3:
        return
    extra = oracle.linear(draw, list(sheet.state), sheet.state)
    agreeing = sheet.adding(extra)
    result = solve(agreeing)
    assert_true_success(result, agreeing)
    assert str(result.status) == "solved"
    assert found(result, sheet)


@pytest.mark.parametrize(
    ("family", "seed", "rules"), [*sheets(("linear",), 5), *sheets(("polynomial",), 4, 2)]
)
def test_rule_that_disagrees_is_an_inconsistency(family: str, seed: int, rules: int | None) -> None:
    draw = random.Random(f"redundant {family}{seed}")
    sheet = oracle.random_sheet(draw, family, rules)
    if regularity(sheet) <= 1e-3:
        return
    contrary = sheet.adding(oracle.off_by_one(oracle.linear(draw, list(sheet.state), sheet.state)))
    result = solve(contrary)
    assert_true_success(result, contrary)
    assert str(result.status) != "solved"
    if family == "linear":
        assert str(result.status) == "inconsistent"


@pytest.mark.parametrize(("family", "seed", "rules"), sheets(UNGUARDED, 4, 3))
def test_any_well_posed_inputs_lead_back_to_the_state(family: str, seed: int, rules: int) -> None:
    draw = random.Random(f"swap {family}{seed}")
    sheet = oracle.random_sheet(draw, family, rules)
    swapped = sheet.given(draw.sample(list(sheet.state), len(sheet.inputs)))
    result = solve(swapped)
    assert_true_success(result, swapped)
    if not oracle.is_square(swapped.rows, swapped.unknowns):
        assert str(result.status) != "solved" or found(result, swapped)
    elif regularity(swapped) > REGULAR:
        assert str(result.status) == "solved"
        assert found(result, swapped)
