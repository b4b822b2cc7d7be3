"""The slider crank from any choice of its inputs: numbers of the sheet and of the subsheets alike.

A state is drawn, some of its quantities are given, and the sheet must come back to it. Which choices
are well-posed is decided on the hand-made transcription of the rules by a matching.
"""

from __future__ import annotations

import math
import random
import re
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import mpmath
import pytest

import rulesheets
import solver
from tests.oracles import random_sheets, slider_crank
from tests.oracles.random_sheets import backward_error, evaluated
from tests.oracles.slider_crank import Crank
from tests.oracles.slider_crank_rules import RULES

MODEL = rulesheets.load(Path(__file__).parents[2] / "models" / "offset_slider_crank" / "model.tk")
FULL = {name.split(".")[-1]: name for name in MODEL.variables}
NUMBERS = [name for name in FULL if name != "branch"]
PROVEN_WRONG = {"inconsistent", "infeasible", "singular"}
State = Mapping[str, Any]


def exact(values: State) -> dict[str, Any]:
    return {name: v if isinstance(v, str) else mpmath.mpf(v) for name, v in values.items()}


def random_crank(draw: random.Random) -> Crank:
    """A linkage in general position."""
    while True:
        lengths = round(draw.uniform(1, 4), 2), round(draw.uniform(5, 9), 2), round(draw.uniform(-2, 2), 2)
        rates = round(draw.uniform(-20, 20), 1), round(draw.uniform(-20, 20), 1)
        crank = Crank(*lengths, *rates, float(draw.randint(-179, 179)), draw.random() < 0.5)
        upright = crank.thetaAO % 90 == 0 or abs(slider_crank.rise(crank)) > 0.98 * crank.AB
        if crank.offset and not upright:
            return crank


def state_of(crank: Crank) -> State:
    values = {name: float(v) for name, v in slider_crank.forward(crank).items()}
    return {**values, **crank.inputs, "branch": "open" if crank.open else 0.0}


def quantities(*expressions: str) -> set[str]:
    return set(re.findall(r"[A-Za-z_]\w*", " ".join(expressions))).intersection(NUMBERS)


def active_rules(values: State) -> list[tuple[str, str]]:
    """The rules that ask something at these values; a guard or side that lacks a value asks nothing."""
    known = exact(values)
    found = []
    for guard, left, right in RULES:
        if quantities(left, right, guard or "") <= values.keys() and (not guard or evaluated(guard, known)):
            found.append((left, right))
    return found


def is_well_posed(state: State, inputs: Iterable[str]) -> bool:
    unknowns = set(NUMBERS) - set(inputs)
    rows = [quantities(left, right) & unknowns for left, right in active_rules(state)]
    return random_sheets.is_square(rows, unknowns)


def well_posed_choice(pool: list[str], seed: int) -> tuple[Crank, tuple[str, ...]]:
    """A random crank, and six numbers that determine it; the branch is given besides."""
    draw = random.Random(seed)
    while True:
        crank = random_crank(draw)
        inputs = tuple(draw.sample(pool, 6))
        if is_well_posed(state_of(crank), inputs):
            return crank, inputs


def solve_from(state: State, inputs: Iterable[str], **other: Any) -> Any:
    cleared = dict.fromkeys(name for name, v in MODEL.variables.items() if v.value is not None)
    given = {FULL[name]: state[name] for name in inputs}
    return solver.solve(MODEL, {**cleared, **given, "branch": state["branch"], **other})


def is_state(solution: Mapping[str, Any], state: State) -> bool:
    """Whether every number of the state is there, to what rounding of the inputs makes of it."""
    for name in NUMBERS:
        apart = abs(solution.get(FULL[name], math.inf) - state[name])
        if name.startswith("theta"):
            apart = min(apart, abs(apart - 360.0))
        if not apart <= 1e-5 * max(1.0, abs(state[name])):
            return False
    return True


def assert_true_success(result: Any) -> None:
    """Every active rule holds at every answer that is called one, by the witness at 50 digits."""
    if str(result.status) != "solved":
        return
    for solution in result.solutions:
        values = {name: solution[full] for name, full in FULL.items() if full in solution}
        for left, right in active_rules(values):
            of_rule = {name: values[name] for name in quantities(left, right)}
            assert backward_error(left, right, of_rule) <= 80 * random_sheets.EPS, (left, right, of_rule)


POSTED = [name for name in NUMBERS if MODEL.variables[FULL[name]].posted]


@pytest.mark.parametrize("seed", [2, 3, 4, 9, 17, 22, 23, 24, 28, 30, 31])
def test_any_inputs_of_the_sheet(seed: int) -> None:
    crank, inputs = well_posed_choice(POSTED, seed)
    state = state_of(crank)
    result = solve_from(state, inputs)
    assert_true_success(result)
    assert str(result.status) == "solved", (inputs, crank)
    assert any(is_state(solution, state) for solution in result.solutions), (inputs, crank)


@pytest.mark.parametrize("seed", [6, 9, 10, 12, 22, 24, 27, 30])
def test_any_inputs_locals_included(seed: int) -> None:
    """The state comes back, or nothing is said that it refutes."""
    crank, inputs = well_posed_choice(NUMBERS, seed)
    state = state_of(crank)
    result = solve_from(state, inputs)
    assert_true_success(result)
    assert str(result.status) not in PROVEN_WRONG, (inputs, crank)
    if not any(is_state(solution, state) for solution in result.solutions):
        assert not result.complete, (inputs, crank)
