"""What is asked for the golden record, by source."""

from __future__ import annotations

import random
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cache
from pathlib import Path
from zlib import crc32

import rulesheets
import solver
from benchmarks import hostile_kinds, standard
from rulesheets.model import Model, Value
from tests.everyday.corpus import sheets
from tests.oracles import random_sheets, redistribution
from tests.oracles.differences import Differences

MODELS = Path(__file__).parent.parent.parent / "models"
CORPUS, CHOICES, HOSTILE = 7, 10, 300
"""Seeds of a family of the random corpus, of a pool of a redistribution, of hostile sheets."""
WANTED = {"models": 8, "corpus": 1, "redistributions": 4, "everyday": 4}
"""Every so many-th question of a source is asked for one name alone."""


@dataclass(frozen=True)
class Question:
    """A solve under a name that stays: ``read`` gives the model, which may be refused. ``want``:
    None for everything."""

    source: str
    name: str
    read: Callable[[], Model]
    inputs: Mapping[str, Value | None] = field(default_factory=dict)
    guesses: Mapping[str, float] = field(default_factory=dict)
    want: tuple[str, ...] | None = None

    @property
    def id(self) -> str:
        return f"{self.source}/{self.name}"

    def asked(self) -> solver.Result:
        return solver.solve(self.read(), dict(self.inputs), self.want, dict(self.guesses))


@cache
def _loaded(name: str) -> Model:
    return rulesheets.load(MODELS / name / "model.tk")


def _models() -> Iterator[Question]:
    """Every model as it stands, and every well-posed swap of a given number and a computed one."""
    for path in sorted(MODELS.glob("*/model.tk")):
        name = path.parent.name
        model, read = _loaded(name), lambda name=name: _loaded(name)
        yield Question("models", name, read)
        first = solver.solve(model).solutions[0]
        for out, into in _swaps(model, first):
            yield Question("models", f"{name}: {out} > {into}", read, {out: first[out], into: None})


def _swaps(model: Model, state: Mapping[str, Value]) -> Iterator[tuple[str, str]]:
    """The swaps after which the rules that are active at a state still reach every number."""
    known = {name for name, variable in model.variables.items() if variable.value is not None}
    rows = [set(equation.names) for equation in Differences(model, state, known).equations]
    numbers = [name for name, value in state.items() if not isinstance(value, str)]
    asked = [name for name in numbers if name not in known and model.variables[name].posted]
    for out in asked:
        for into in sorted(known.intersection(numbers)):
            unknown = set(numbers) - known - {out} | {into}
            if not random_sheets.undetermined([row & unknown for row in rows], unknown):
                yield out, into


def _corpus() -> Iterator[Question]:
    for family in random_sheets.FAMILIES:
        for seed in range(CORPUS):
            made = random_sheets.random_sheet(random.Random(f"{family}{seed}"), family)
            yield Question(
                "corpus", f"{family} {seed}", lambda text=made.text: rulesheets.loads(text)
            )


def _redistributions() -> Iterator[Question]:
    for name in redistribution.SHEETS:
        of = redistribution.sheet(name)
        for pool in ("posted", "numbers"):
            for seed in range(CHOICES):
                choice = redistribution.well_posed_choice(of, getattr(of, pool), seed)
                label = f"{name}: {pool} {seed}"
                yield Question(
                    "redistributions", label, lambda of=of: of.model, of.inputs_of(choice)
                )


def _standard() -> Iterator[Question]:
    for problem in standard.PROBLEMS:
        read = cache(lambda text=problem.sheet: rulesheets.loads(text))
        for factor in (1.0, 10.0):
            label = f"{problem.number} {problem.title} from {factor:g}"
            yield Question("standard", label, read, guesses=problem.guesses(factor))


def _everyday() -> Iterator[Question]:
    for sheet in sheets():
        for asked in sheet.questions():
            name = asked.id
            yield Question("everyday", name, lambda sheet=sheet: sheet.model, asked.changes)


def _hostile() -> Iterator[Question]:
    for seed in range(HOSTILE):
        made = hostile_kinds.sheet(seed)
        yield Question(
            "hostile", f"{made.kind} {seed}", lambda text=made.text: rulesheets.loads(text)
        )


def _want() -> Iterator[Question]:
    """One unknown of questions of the other sources, drawn from their names."""
    for source, every in WANTED.items():
        for asked in questions(source):
            if crc32(asked.id.encode()) % every:  # the same ones beside further questions
                continue
            model = asked.read()
            given = {name for name, value in asked.inputs.items() if value is not None}
            unknown = [
                name
                for name, variable in model.variables.items()
                if variable.posted and name not in given
                if variable.value is None or name in asked.inputs
            ]
            if unknown:
                name = random.Random(asked.id).choice(sorted(unknown))
                yield replace(asked, source="want", name=f"{asked.name} ? {name}", want=(name,))


SOURCES: dict[str, Callable[[], Iterator[Question]]] = {
    "models": _models,
    "corpus": _corpus,
    "redistributions": _redistributions,
    "standard": _standard,
    "everyday": _everyday,
    "hostile": _hostile,
    "want": _want,
}


@cache
def questions(source: str) -> tuple[Question, ...]:
    return tuple(SOURCES[source]())
