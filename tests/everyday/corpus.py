"""Ordinary sheets, each with an independent computation of its state, and the questions asked of
them.

A sheet is a file ``AREA/NAME.tk``; the function NAME of ``AREA.py`` computes everything else from
its inputs. Forward, the sheet is solved as it stands. Backward, ``"h > v0"`` gives h its forward
value and asks for v0; the first answer expected is the forward state, or what ``either`` allows
beside it.
"""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from importlib import import_module
from itertools import combinations
from pathlib import Path
from typing import Any

import rulesheets
import solver

from . import judge

HERE = Path(__file__).parent
AREAS = (
    "thermal",
    "fluids",
    "machines",
    "structures",
    "electricity",
    "chemistry",
    "finance",
    "surveying",
    "optics",
    "life",
)
OWN = "own problem"
TOLERANCE = 1e-8
NEAR = 1e-4
"""How far from an answer its root may be: a double root is known to half of the digits."""

Value = float | str
State = dict[str, Any]


@dataclass(frozen=True)
class Sheet:
    """``published``: what the source prints for its inputs, within the relative error beside it."""

    area: str
    name: str
    source: str
    oracle: Callable[..., dict[str, float]]
    back: tuple[str, ...]
    either: Mapping[str, tuple[State, ...]]
    published: Mapping[str, tuple[float, float]]
    tolerance: float = TOLERANCE

    @cached_property
    def text(self) -> str:
        return (HERE / self.area / f"{self.name}.tk").read_text()

    @cached_property
    def model(self) -> rulesheets.Model:
        return rulesheets.loads(self.text)

    @cached_property
    def inputs(self) -> State:
        return {name: v.value for name, v in self.model.variables.items() if v.value is not None}

    @cached_property
    def state(self) -> State:
        asked = inspect.signature(self.oracle).parameters
        return {**self.inputs, **self.oracle(**{name: self.inputs[name] for name in asked})}

    def questions(self) -> Iterator[Question]:
        return (Question(self, label) for label in ("forward", *self.back))


@dataclass(frozen=True)
class Question:
    """What is asked is computed when it is asked: to list questions reads no sheet."""

    sheet: Sheet
    label: str

    @property
    def changes(self) -> dict[str, Value | None]:
        if self.label == "forward":
            return {}
        given, asked = (side.split() for side in self.label.split(">"))
        return {name: self.sheet.state[name] for name in given} | dict.fromkeys(asked)

    @property
    def expected(self) -> tuple[Mapping[str, Value], ...]:
        """The states any of which may come first; a value that is not named is not judged."""
        return self.sheet.state, *self.sheet.either.get(self.label, ())

    @property
    def id(self) -> str:
        return f"{self.sheet.area}/{self.sheet.name}: {self.label}"

    def is_expected(self, answer: Mapping[str, Value]) -> bool:
        return any(is_state(answer, state, self.sheet.tolerance) for state in self.expected)

    def judged(self) -> Verdict:
        return verdict(
            self.sheet.text,
            solver.solve(self.sheet.model, self.changes),
            self.is_expected,
            self.sheet.state,
        )


@dataclass(frozen=True)
class Verdict:
    """``false``: what the result claims and is not true."""

    first: bool
    listed: bool
    false: tuple[str, ...]
    result: solver.Result

    def __str__(self) -> str:
        if self.false:
            return "; ".join(self.false)
        count, status = len(self.result.solutions), self.result.status
        return (
            "right"
            if self.first
            else f"{status}, {count} answers, " + ("listed" if self.listed else "missed")
        )


def is_state(answer: Mapping[str, Value], state: Mapping[str, Value], tolerance: float) -> bool:
    return all(
        name in answer and _is_close(answer[name], value, tolerance)
        for name, value in state.items()
    )


def _is_close(one: Value, other: Value, tolerance: float) -> bool:
    if isinstance(one, str) or isinstance(other, str):
        return one == other
    return math.isclose(one, other, rel_tol=tolerance, abs_tol=1e-12)


def verdict(
    text: str,
    result: solver.Result,
    is_expected: Callable[[Mapping[str, Value]], bool],
    planted: State,
) -> Verdict:
    """Judges a result whose answers include the planted state."""
    right = [is_expected(answer) for answer in result.solutions]
    solved = str(result.status) == "solved"
    false = [
        f"{answer}: breaks {rule}"
        for answer in result.solutions
        for rule in judge.broken(text, answer)
    ]
    if solved:
        unknown = [name for name in planted if name not in result.inputs]
        far = (
            (answer, judge.distance_to_root(text, answer, unknown)) for answer in result.solutions
        )
        false += [
            f"{dict(answer)}: the root is {part:.0e} away" for answer, part in far if part > NEAR
        ]
    pairs = combinations(result.solutions, 2)
    false += [f"{dict(one)} is listed twice" for one, two in pairs if is_state(one, two, 1e-12)]
    if str(result.status) in ("infeasible", "inconsistent"):
        false.append(f"called {result.status}")
    if solved and result.complete and not any(is_state(a, planted, 1e-6) for a in result.solutions):
        false.append(f"{len(result.solutions)} answers called complete, the state not among them")
    return Verdict(solved and right[:1] == [True], solved and any(right), tuple(false), result)


def sheet(
    source: str, back: str, either: Any = None, tolerance: float = TOLERANCE, **published: Any
) -> Any:
    """Registers the oracle of the sheet of its name; ``back``: swaps, separated by commas."""

    def register(oracle: Callable[..., dict[str, float]]) -> Callable[..., dict[str, float]]:
        swaps = tuple(
            " > ".join(part.strip() for part in swap.split(">")) for swap in back.split(",")
        )
        area = oracle.__module__.rpartition(".")[2]
        known = {n: (v if isinstance(v, tuple) else (v, 0.01)) for n, v in published.items()}
        SHEETS.append(
            Sheet(area, oracle.__name__, source, oracle, swaps, either or {}, known, tolerance)
        )
        return oracle

    return register


SHEETS: list[Sheet] = []


def sheets() -> list[Sheet]:
    """Every sheet of the corpus, by area."""
    for area in AREAS:
        if (HERE / f"{area}.py").exists():
            import_module(f"tests.everyday.{area}")
    return SHEETS
