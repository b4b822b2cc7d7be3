"""Sheets that write factors of 1000, 60 or 180/pi by hand, rewritten with units: the answers stay.

``units/NAME.tk`` computes in SI units, takes its inputs and shows its outputs in those of the sheet
NAME, and has no factor between units. It is asked the questions of that sheet in the same units.
"""

from __future__ import annotations

import math
import random

import pytest

import rulesheets
import solver
from rulesheets.library import convert, library
from rulesheets.model import Variable
from rulesheets.units import SYSTEMS, shown
from rulesheets.units.check import check_units

from .corpus import HERE, Question, Sheet, is_state, sheets
from .test_everyday import OPEN

REWRITTEN = {path.stem: rulesheets.load(path) for path in sorted((HERE / "units").glob("*.tk"))}
WITH_CONSTANTS = ("electrolysis", "sphere_tank")
"""A number of a rule is used as written: these rules hold in SI units alone."""
UNITS = sorted(
    {name for names in SYSTEMS.values() for name in names.split()}
    | {"gon", "rpm", "h", "mil", "kA"}
)


def pairs() -> list[Sheet]:
    return [sheet for sheet in sheets() if sheet.name in REWRITTEN]


def answer_of(model: rulesheets.Model, found: solver.Solution) -> dict[str, float | str]:
    """An answer in the units in which it is shown."""
    values = {name: found[name] for name in model.variables}
    return {
        n: shown(v, model.variables[n]) if isinstance(v, float) else v for n, v in values.items()
    }


def asked(question: Question, model: rulesheets.Model) -> dict[str, object]:
    """The changes of a question, in the units of its own sheet."""
    units = {name: model.variables[name].shown_unit for name in question.changes}
    return {
        n: value if value is None or not units[n] else (value, units[n])
        for n, value in question.changes.items()
    }


def questions() -> list[object]:
    found = (question for sheet in pairs() for question in sheet.questions())
    return [pytest.param(question, id=question.id) for question in found if question.id not in OPEN]


@pytest.mark.parametrize("question", questions())
def test_the_answer_is_that_of_the_factors(question: Question) -> None:
    model = REWRITTEN[question.sheet.name]
    result = solver.solve(model, asked(question, model))
    assert str(result.status) == "solved"
    found = answer_of(model, result.solutions[0])
    assert any(is_state(found, state, question.sheet.tolerance) for state in question.expected), (
        found
    )


@pytest.mark.quick
@pytest.mark.parametrize("sheet", pairs(), ids=lambda sheet: sheet.name)
def test_a_rewritten_sheet_has_the_units_of_the_first(sheet: Sheet) -> None:
    model = REWRITTEN[sheet.name]
    assert check_units(model) == ()
    units = {name: variable.shown_unit for name, variable in model.variables.items()}
    assert units == {name: variable.unit or "" for name, variable in sheet.model.variables.items()}


@pytest.mark.quick
def test_there_are_twenty_rewritten_sheets() -> None:
    assert len(pairs()) == len(REWRITTEN) >= 20


# --- what is the same in any units ------------------------------------------------------


def scaled(name: str, seed: int) -> rulesheets.Model:
    """A rewritten sheet in base units of random sizes: other readings of the same quantities."""
    chance = random.Random(seed)
    model = REWRITTEN[name]
    measures = [variable.measure for variable in model.variables.values()]
    bases = sorted({base for unit in measures if unit is not None for base in unit.bases} - {"rad"})
    sizes = "".join(f"  own_{base} = {10 ** chance.uniform(-2, 2):.17g} {base}\n" for base in bases)
    rows = "".join(map(row, model.variables.values()))
    rules = (HERE / "units" / f"{name}.tk").read_text().partition("rules\n")[2]
    return rulesheets.loads(f"units\n{sizes}\nvariables\n{rows}\nrules\n{rules}")


def row(variable: Variable) -> str:
    """The row of a variable in the scaled units, with what is given in those of the sheet."""
    unit = variable.measure
    own = (
        "".join(f"{'' if b == 'rad' else 'own_'}{b}^{e} " for b, e in unit.bases.items())
        if unit
        else ""
    )
    of = f"[{variable.unit}]" if own else ""
    value = "" if variable.value is None else f" = {variable.value!r}{of}"
    ranged = (
        f" in [{variable.low!r}{of}, {variable.high!r}{of}]" if math.isfinite(variable.high) else ""
    )
    return (
        f"  {variable.name}{value}{ranged}{f' [{own} -> {variable.shown_unit}]' if own else ''}\n"
    )


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("name", [name for name in REWRITTEN if name not in WITH_CONSTANTS])
def test_random_units_leave_what_an_answer_means(name: str, seed: int) -> None:
    found, other = solver.solve(REWRITTEN[name]), solver.solve(scaled(name, seed))
    assert other.status is found.status is solver.Status.SOLVED
    first, second = (
        answer_of(found.model, found.solutions[0]),
        answer_of(other.model, other.solutions[0]),
    )
    assert second == pytest.approx(first, rel=1e-12)


@pytest.mark.parametrize("name", REWRITTEN)
def test_inputs_in_random_units_of_their_kind_leave_the_answer(name: str) -> None:
    model, chance = REWRITTEN[name], random.Random(name)
    given = {}
    for variable in model.variables.values():
        unit = variable.measure
        if isinstance(variable.value, float) and unit is not None:
            alike = [other for other in UNITS if library().unit(other).bases == unit.bases]
            other = chance.choice([*alike, variable.unit])
            given[variable.name] = (convert(variable.value, unit, library().unit(other)), other)
    first, second = solver.solve(model).solutions[0], solver.solve(model, given).solutions[0]
    assert dict(second) == pytest.approx(dict(first), rel=1e-12)
