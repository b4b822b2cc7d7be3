"""A number with a unit, for a variable: converted to the unit that its rules work in."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence

from rulesheets.diagnosis import Diagnosis, RuleSheetError, error, labels
from rulesheets.model import Model, Variable
from rulesheets.spelling import suggestion
from rulesheets.syntax.nodes import UnitRow
from rulesheets.syntax.source import Span
from rulesheets.units.library import MONEY, Library, library
from rulesheets.units.text import UnitError
from rulesheets.units.unit import Unit, affine, convert

_BRACKETED = re.compile(r"(.*\S)\s*\[([^\[\]]*)\]\s*", re.DOTALL)
_PLAIN = re.compile(
    r"\s*((?>[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?))\s*((?!.*[*/]\s*\d)(?:[^\W\d_]|[°%‰$€£¥'℃℉]).*?)\s*",
    re.DOTALL,
)


def parted(text: str) -> tuple[str, str] | None:
    """``50 [mm]``, ``50mm`` or ``50 mm`` as the value and the unit; None for a value without one."""
    found = _BRACKETED.fullmatch(text) or _PLAIN.fullmatch(text)
    return (found[1], found[2].strip()) if found else None


def converted(
    numbers: Sequence[float],
    unit: str,
    variable: Variable,
    place: Span | None = None,
    difference: bool = False,
) -> list[float]:
    """Numbers in ``unit`` as numbers in the unit of the variable; a ``difference`` has no zero point.

    Raises RuleSheetError for an unknown unit, one of another kind, and for a variable without a unit.
    """
    if unit == variable.unit:
        return list(numbers)
    source, target = _units(unit, variable, place)
    return [convert(number, source, target, difference or variable.difference) for number in numbers]


def scaling(unit: str, variable: Variable) -> tuple[float, float]:
    """Factor and shift from ``unit`` to that of the variable. Raises RuleSheetError as ``converted`` does."""
    return affine(*_units(unit, variable, None), variable.difference)


def _units(unit: str, variable: Variable, place: Span | None) -> tuple[Unit, Unit]:
    """A unit, and that of a variable, which is of its kind."""
    if not variable.unit:
        raise RuleSheetError(_no_unit(variable, unit, place))
    source, target = (unit_named(text, place, variable.units) for text in (unit, variable.unit))
    if source.bases != target.bases:
        raise RuleSheetError(_other_kind(variable, unit, source, target, place))
    return source, target


def unit_named(text: str, place: Span | None, units: Library) -> Unit:
    """The unit of a text. Raises RuleSheetError (E460) with what may be meant."""
    try:
        return units.unit(text)
    except UnitError as wrong:
        raise RuleSheetError(_unknown(wrong, text, place, units)) from None


def library_of(rows: tuple[UnitRow, ...]) -> Library:
    """The units of a sheet with such a section. Raises RuleSheetError (E460, E462)."""
    units = library(tuple(row.definition for row in rows))
    complaints: list[Diagnosis] = []
    first: dict[str, UnitRow] = {}
    for row in rows:
        for name in row.names:
            earlier = first.setdefault(name, row)
            shipped = library().named(name)
            if earlier is not row:
                complaints.append(error("E462", f"the unit {name} is defined twice", *labels((row.span, ""))))
            elif shipped is not None and shipped.bases == {name: 1} and name not in MONEY:
                complaints.append(error("E462", f"{name} is a base unit", *labels((row.span, ""))))
    for row in () if complaints else rows:
        try:
            units.meant(row.meaning)
        except UnitError as wrong:
            complaints.append(_unknown(wrong, row.meaning, row.span, units))
    if complaints:
        raise RuleSheetError(*complaints)
    return units


def _unknown(wrong: UnitError, text: str, place: Span | None, units: Library) -> Diagnosis:
    if wrong.name in units.names():
        return error("E462", f"{wrong.name} is defined by itself", *labels((place, "")))
    notes = suggestion(wrong.name, units.names()) if wrong.name else ()
    message = f"{wrong}" if wrong.name in ("", text) else f"{wrong} (in {text})"
    return error("E460", message, *labels((place, "")), notes=notes)


def _no_unit(variable: Variable, unit: str, place: Span | None) -> Diagnosis:
    return error(
        "E461",
        f"{variable.name} has no unit, so a value in {unit} cannot be converted",
        *labels((place, "")),
        notes=(f"leave the unit out, or write {variable.name} [{unit}] in the variables section",),
    )


def _other_kind(variable: Variable, unit: str, source: Unit, target: Unit, place: Span | None) -> Diagnosis:
    if source.dimension == target.dimension:
        message = f"{unit} and {variable.unit}, the unit of {variable.name}, differ by an angle"
        notes = ("write rev/s or rad/s for a rotation, Hz or 1/s for events",)
    else:
        message = f"{variable.name} is in {variable.unit}, and {unit} measures something else"
        notes = (f"give {variable.name} in {variable.unit} or a unit of its kind",)
    return error("E461", message, *labels((place, "")), notes=notes)


def part_with_unit(unit: str, place: Span | None) -> Diagnosis:
    notes = ("write one number with its unit, as in x = 3[in] [mm]",)
    return error("E461", f"{unit} stands inside an expression of numbers", *labels((place, "")), notes=notes)


def cannot_show(name: str, unit: str | None, display: str | None, place: Span | None) -> Diagnosis:
    own = f"is in {unit}" if unit else "has no unit"
    message = f"{name} {own}, and cannot be shown in {display}"
    return error(
        "E461",
        message,
        *labels((place, "")),
        notes=("show it in a unit of its kind" if unit else f"write {name} [{display}] in its row",),
    )


def shown(number: float, variable: Variable, difference: bool = False) -> float:
    """A number of a variable in its display unit, where it has one."""
    if not (variable.unit and variable.display_unit):
        return number
    source, target = map(variable.units.unit, (variable.unit, variable.display_unit))
    return convert(number, source, target, difference or variable.difference)


def displaying(variable: Variable) -> tuple[float, float]:
    """Factor and shift from the unit of a variable to its display unit, where it has one."""
    if not (variable.unit and variable.display_unit):
        return 1.0, 0.0
    source, target = map(variable.units.unit, (variable.unit, variable.display_unit))
    return affine(source, target, variable.difference)


def displays(model: Model, names: Iterable[str]) -> dict[str, tuple[float, float]]:
    """Factor and shift to the display unit, for the variables that have one."""
    variables = (model.variables[name] for name in names if name in model.variables)
    return {v.name: displaying(v) for v in variables if v.unit and v.display_unit}
