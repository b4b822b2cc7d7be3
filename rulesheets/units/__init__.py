"""Values with units, converted to the units of their variables and to display units.

Differences of temperatures are distinguished from points of a scale. A solve never sees a unit.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace

from rulesheets.diagnosis import Diagnosis, RuleSheetError, error_at, refusal, refuse, suggestion
from rulesheets.library import MONEY, Library, Unit, UnitError, affine, convert, library
from rulesheets.model import Model, Variable
from rulesheets.syntax import Span
from rulesheets.syntax.nodes import UnitRow

_BRACKETED = re.compile(r"(.*\S)\s*\[([^\[\]]*)\]\s*", re.DOTALL)
_PLAIN = re.compile(
    r"\s*((?>[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?))"
    r"(?:\s*(?=[^\W\d_]|[°%‰$€£¥'℃℉])|\s+(?=1\s*/\s*[^\W\d_]))((?!.*[*/]\s*\d).*?)\s*",
    re.DOTALL,
)

ENDS = "degC", "degF", "°C", "°F", "K", "C", "R", "F", "mm", "cm", "s"
"""Ends of joined units: ``kgK``, ``Nmm``, ``Pas``."""
_BARE = re.compile(r"[\d./]+(?:[eE][-+]?\d+)?")


def value_and_unit(text: str) -> tuple[str, str] | None:
    """Value and unit of ``50 [mm]``, ``50mm``, ``50 mm`` or ``5 1/s``; None without a unit."""
    found = _BRACKETED.fullmatch(text) or _PLAIN.fullmatch(text)
    return (found[1], found[2].strip()) if found else None


def converted(
    numbers: Sequence[float],
    unit: str,
    variable: Variable,
    place: Span | None = None,
    difference: bool = False,
) -> list[float]:
    """Numbers in ``unit`` in that of the variable; a ``difference`` has no zero point.

    Raises RuleSheetError for an unknown unit, another kind, and a variable without one.
    """
    if unit == variable.unit:
        return list(numbers)
    source, target = _units(unit, variable, place)
    difference = difference or variable.difference
    return [convert(number, source, target, difference) for number in numbers]


def scaling(unit: str, variable: Variable) -> tuple[float, float]:
    """Factor and shift from ``unit`` to that of the variable. Raises as ``converted`` does."""
    return affine(*_units(unit, variable, None), variable.difference)


def _units(unit: str, variable: Variable, place: Span | None) -> tuple[Unit, Unit]:
    """A unit, and that of a variable, which is of its kind."""
    name, own = variable.name, variable.unit
    if not own:
        message = f"{name} has no unit, so a value in {unit} cannot be converted"
        note = f"leave the unit out, or write {name} [{unit}] in the variables section"
        raise refusal("E461", message, place, note)
    source, target = (unit_named(text, place, variable.units) for text in (unit, own))
    if source.bases == target.bases:
        return source, target
    message = f"{name} is in {own}, and {unit} measures something else"
    note = f"give {name} in {own} or a unit of its kind"
    if source.dimension == target.dimension:
        message = f"{unit} and {own}, the unit of {name}, differ by an angle"
        note = "write rev/s or rad/s for a rotation, Hz or 1/s for events"
    raise refusal("E461", message, place, note)


def unit_named(text: str, place: Span | None, units: Library) -> Unit:
    """The unit of a text. Raises RuleSheetError (E460) with a suggestion."""
    try:
        return units.unit(text)
    except UnitError as wrong:
        raise RuleSheetError(_unknown(wrong, text, place, units)) from None


def library_of(rows: Sequence[UnitRow]) -> Library:
    """The units of a sheet with such a section. Raises RuleSheetError (E460, E462)."""
    units = library(*(row.definition for row in rows))
    complaints: list[Diagnosis] = []
    first: dict[str, UnitRow] = {}
    for row in rows:
        known = [name for name in row.names if name in library().names()]
        if len(row.names) > 1 and known and _BARE.fullmatch(row.meaning):
            # ct, EUR = 0.01 in the order of TK, from, to = factor, which would call both of them
            # 0.01
            names = f"{', '.join(row.names[:-1])} and {row.names[-1]}"
            message = f"this line calls {names} {row.meaning}, a number without a unit"
            cure = f"write {row.names[0]} = {row.meaning} {row.names[1]}"
            why = "names before the equals sign are names of one unit"
            note = f"{why}, and {known[-1]} is one already"
            complaints.append(error_at("E462", message, row.span, cure, note))
            continue
        for name in row.names:
            earlier = first.setdefault(name, row)
            shipped = library().named(name)
            if earlier is not row:
                complaints.append(error_at("E462", f"the unit {name} is defined twice", row.span))
            elif shipped is not None and shipped.bases == {name: 1} and name not in MONEY:
                complaints.append(error_at("E462", f"{name} is a base unit", row.span))
    for row in () if complaints else rows:
        try:
            units.meant(row.meaning)
        except UnitError as wrong:
            complaints.append(_unknown(wrong, row.meaning, row.span, units))
    refuse(complaints)
    return units


def _unknown(wrong: UnitError, text: str, place: Span | None, units: Library) -> Diagnosis:
    if wrong.name in units.names():
        return error_at("E462", f"{wrong.name} is defined by itself", place)
    every = (*units.names(), *units.prefixed())
    alike = [one for one in every if one.lower() == wrong.name.lower()]
    notes = _apart(wrong.name, units) or suggestion(wrong.name, alike or units.names())
    message = f"{wrong}" if wrong.name in ("", text) else f"{wrong} (in {text})"
    return error_at("E460", message, place, *notes)


def _apart(name: str, units: Library) -> tuple[str, ...]:
    """The cure for two units without a sign between them: ``kgK``; a plural has no such."""
    loud = name.isupper() and name.lower() in units.names()
    for end in () if loud else ENDS:
        first = name.removesuffix(end)
        if first not in ("", name):
            with suppress(UnitError):
                if len(units.unit(first).bases) > (end == "s"):
                    return (f"write {first}-{end} for a product of units",)
    return ()


def cannot_show(name: str, unit: str | None, display: str | None, place: Span | None) -> Diagnosis:
    own = f"is in {unit}" if unit else "has no unit"
    note = "show it in a unit of its kind" if unit else f"write {name} [{display}] in its row"
    return error_at("E461", f"{name} {own}, and cannot be shown in {display}", place, note)


def shown(number: float, variable: Variable, difference: bool = False) -> float:
    """A number of a variable in its display unit, if it has one."""
    units = _shown_in(variable)
    return convert(number, *units, difference or variable.difference) if units else number


def displaying(variable: Variable) -> tuple[float, float]:
    """Factor and shift from the unit of a variable to its display unit, if it has one."""
    units = _shown_in(variable)
    return affine(*units, variable.difference) if units else (1.0, 0.0)


def _shown_in(variable: Variable) -> tuple[Unit, Unit] | None:
    """The unit of a variable and its display unit."""
    if not (variable.unit and variable.display_unit):
        return None
    return variable.units.unit(variable.unit), variable.units.unit(variable.display_unit)


def displays(model: Model, names: Iterable[str]) -> dict[str, tuple[float, float]]:
    """Factor and shift to the display unit, for the variables that have one."""
    variables = (model.variables[name] for name in names if name in model.variables)
    return {v.name: displaying(v) for v in variables if v.unit and v.display_unit}


def differences(model: Model) -> frozenset[str]:
    """The variables of a model that are differences of temperatures."""
    measures = (v.measure for v in model.variables.values() if v.unit)
    if not any(measure and measure.bases == {"K": 1} for measure in measures):
        return frozenset()
    from rulesheets.units.check import Weights

    return frozenset(Weights(model).differences)


SYSTEMS = {
    "si": "mm cm m km mm^2 cm^2 m^2 mm^3 cm^3 L m^3 g kg t N kN MN Pa kPa MPa GPa degC K m/s km/h "
    "J kJ MJ GJ kWh N-m kN-m W kW MW kg/m^3 kg/s m^3/s L/s m/s^2 kJ/kg kJ/kg-K W/m-K W/m^2-K Pa-s "
    "N/m N/mm",
    "us": "in ft mi in^2 ft^2 in^3 gal ft^3 oz lb lbf kip psi ksi degF degR ft/s mph Btu lbf-ft hp "
    "lb/ft^3 lb/s ft^3/s gpm ft/s^2 Btu/lb Btu/lb-R Btu/h-ft-R Btu/h-ft^2-R lbf-s/ft^2 lbf/ft "
    "lbf/in",
}
"""Units to choose from, by system; of several of one kind, the one nearest in size is taken."""

_COMPOUND = re.compile(r"[^\W\d_][\W\d]+[^\W\d_]")


def with_display_unit(variable: Variable, unit: str, place: Span | None = None) -> Variable:
    """The variable shown in ``unit``. Raises RuleSheetError (E460, E461) if that does not fit."""
    target = unit_named(unit, place, variable.units)
    own = variable.measure
    if own is None or own.bases != target.bases:
        raise RuleSheetError(cannot_show(variable.name, variable.unit, unit, place))
    return replace(variable, display_unit=None if unit == variable.unit else unit)


def with_display_units(model: Model, system: str | None, chosen: Mapping[str, str]) -> Model:
    """The model shown in units of a system, and some variables in those ``chosen`` for them."""
    if system is None and not chosen:
        return model
    units = {name: library().unit(name) for name in SYSTEMS.get(system or "", "").split()}
    variables = {name: _in_system(variable, units) for name, variable in model.variables.items()}
    for name, unit in chosen.items():
        variables[name] = with_display_unit(model.variables[name], unit)
    return replace(model, variables=variables)


def _in_system(variable: Variable, units: Mapping[str, Unit]) -> Variable:
    """The variable in a unit of the system; unchanged if the system has none of its kind."""
    own = variable.measure
    if variable.unit in units:
        return replace(variable, display_unit=None)
    alike = [name for name, unit in units.items() if own is not None and unit.bases == own.bases]
    if own is None or not variable.unit or not alike:
        return variable
    compound = bool(_COMPOUND.search(variable.unit))

    def distance(name: str) -> tuple[bool, bool, float]:
        unit = units[name]
        return (
            bool(_COMPOUND.search(name)) != compound,
            bool(unit.offset) != bool(own.offset),
            abs(math.log(unit.scale / own.scale)),
        )

    return with_display_unit(variable, min(alike, key=distance))
