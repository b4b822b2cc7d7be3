"""Random choices of the inputs of the slider crank, and what is true of each, judged from outside.

A linkage is drawn and put in motion by the closed form; six of its numbers are given back besides
the branch. Which choices are well-posed is decided on a hand-made transcription of the rules: by a
matching for the pattern, by the Jacobian at 50 digits for the values.
"""

from __future__ import annotations

import math
import random
import re
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from pathlib import Path
from typing import Any

import mpmath
import numpy as np

import rulesheets
from tests.oracles import random_sheets, slider_crank
from tests.oracles.random_sheets import evaluated
from tests.oracles.slider_crank import DIGITS, Crank
from tests.oracles.slider_crank_rules import AS_PRINTED, SLOPE_FREE

MODELS = Path(__file__).parents[2] / "models"
SHEETS = {"offset_slider_crank": AS_PRINTED, "offset_slider_crank_slope_free": SLOPE_FREE}
GIVEN = 6
SINGULAR = 1e-12
"""Least singular value of the scaled Jacobian over the largest, where a choice determines
nothing."""

State = Mapping[str, Any]
Row = tuple[str, str]


@dataclass(frozen=True)
class Choice:
    """A linkage at a state, and the numbers that are given back. ``condition``: of the scaled
    Jacobian."""

    crank: Crank
    state: State
    inputs: tuple[str, ...]
    condition: float

    @property
    def singular(self) -> bool:
        """Whether the values determine nothing, although the pattern would."""
        return self.condition > 1 / SINGULAR


@dataclass(frozen=True)
class Sheet:
    """One of the two sheets of the crank, with its rules by hand over bare names."""

    name: str

    @cached_property
    def model(self) -> Any:
        return rulesheets.load(MODELS / self.name / "model.tk")

    @cached_property
    def full(self) -> dict[str, str]:
        """Bare name of every quantity -> its name in the model."""
        return {name.split(".")[-1]: name for name in self.model.variables}

    @cached_property
    def numbers(self) -> list[str]:
        return [name for name in self.full if name != "branch"]

    @cached_property
    def posted(self) -> list[str]:
        return [name for name in self.numbers if self.model.variables[self.full[name]].posted]

    @cached_property
    def rules(self) -> tuple[tuple[str | None, str, str], ...]:
        return SHEETS[self.name]

    def quantities(self, *expressions: str) -> set[str]:
        return set(re.findall(r"[A-Za-z_]\w*", " ".join(expressions))).intersection(self.numbers)

    def active_rules(self, values: State) -> list[Row]:
        """The rules that ask something at these values; a guard or side that lacks a value asks
        nothing."""
        known = exact(values)
        found = []
        for guard, left, right in self.rules:
            needed = self.quantities(left, right, guard or "")
            if needed <= values.keys() and (not guard or evaluated(guard, known)):
                found.append((left, right))
        return found

    def is_well_posed(self, rows: Sequence[Row], inputs: Iterable[str]) -> bool:
        """Whether the pattern of the rules determines every other number."""
        unknowns = set(self.numbers) - set(inputs)
        return random_sheets.is_square([self.quantities(*row) & unknowns for row in rows], unknowns)

    def inputs_of(self, choice: Choice) -> dict[str, Any]:
        """What to hand to ``solve``: the sheet's own inputs cleared, the choice and the branch
        given."""
        cleared = {n: None for n, v in self.model.variables.items() if v.value is not None}
        given = {self.full[name]: choice.state[name] for name in choice.inputs}
        return {**cleared, **given, "branch": choice.state["branch"]}

    def is_state(self, solution: Mapping[str, Any], choice: Choice) -> bool:
        """Whether every number of the state is there, to what rounding of the inputs makes of
        it."""
        tolerance = max(1e-9, 1e-13 * choice.condition)
        for name in self.numbers:
            apart = abs(solution.get(self.full[name], math.inf) - choice.state[name])
            if name.startswith("theta"):
                apart = min(apart, abs(apart - 360.0))
            if not apart <= tolerance * max(1.0, abs(choice.state[name])):
                return False
        return True


@cache
def sheet(name: str) -> Sheet:
    return Sheet(name)


def exact(values: State) -> dict[str, Any]:
    return {name: v if isinstance(v, str) else mpmath.mpf(v) for name, v in values.items()}


def random_crank(draw: random.Random) -> Crank:
    """A linkage in general position."""
    while True:
        lengths = (
            round(draw.uniform(1, 4), 2),
            round(draw.uniform(5, 9), 2),
            round(draw.uniform(-2, 2), 2),
        )
        rates = round(draw.uniform(-20, 20), 1), round(draw.uniform(-20, 20), 1)
        crank = Crank(*lengths, *rates, float(draw.randint(-179, 179)), draw.random() < 0.5)
        upright = crank.thetaAO % 90 == 0 or abs(slider_crank.rise(crank)) > 0.98 * crank.AB
        if crank.offset and rates[0] and rates[1] and not upright:
            return crank


def state_of(crank: Crank) -> State:
    values = {name: float(v) for name, v in slider_crank.forward(crank).items()}
    return {**values, **crank.inputs, "branch": "open" if crank.open else 0.0}


def well_posed_choice(of: Sheet, pool: Collection[str], seed: int) -> Choice:
    """A random linkage, and six numbers that determine it by their pattern; the branch is given
    besides."""
    draw = random.Random(seed)
    while True:
        crank = random_crank(draw)
        inputs = tuple(draw.sample(list(pool), GIVEN))
        state = state_of(crank)
        rows = of.active_rules(state)
        if of.is_well_posed(rows, inputs):
            return Choice(crank, state, inputs, _condition(of, rows, state, inputs))


def _condition(of: Sheet, rows: Sequence[Row], state: State, inputs: Collection[str]) -> float:
    """Of the Jacobian by the unknowns times their values, rows equilibrated."""
    unknowns = [name for name in of.numbers if name not in inputs]
    matrix = np.zeros((len(rows), len(unknowns)))
    with mpmath.workdps(DIGITS):
        at = exact(state)
        for i, (left, right) in enumerate(rows):
            for name in of.quantities(left, right) & set(unknowns):
                size = abs(at[name]) or 1
                up, down = (
                    {**at, name: at[name] + sign * size * mpmath.mpf(10) ** -20} for sign in (1, -1)
                )
                change = evaluated(f"({left})-({right})", up) - evaluated(
                    f"({left})-({right})", down
                )
                matrix[i, unknowns.index(name)] = float(change / 2 * mpmath.mpf(10) ** 20)
    matrix /= np.abs(matrix).max(axis=1)[:, None]
    singular = np.linalg.svd(matrix, compute_uv=False)
    return float(singular[0] / singular[-1]) if singular[-1] else math.inf
