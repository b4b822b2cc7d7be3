"""The units in which values are shown: one chosen for a variable, or a whole system."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from rulesheets.diagnosis import RuleSheetError
from rulesheets.inputs import variable_named
from rulesheets.library import library
from rulesheets.model import Model, Variable
from rulesheets.syntax.source import Span
from rulesheets.units.quantity import cannot_show, displaying, unit_named

SYSTEMS = {
    "si": "mm cm m km mm^2 cm^2 m^2 mm^3 cm^3 L m^3 g kg t N kN MN Pa kPa MPa GPa degC K m/s km/h "
    "J kJ MJ GJ kWh N-m kN-m W kW MW kg/m^3 kg/s m^3/s L/s m/s^2 kJ/kg kJ/kg-K W/m-K W/m^2-K Pa-s "
    "N/m N/mm",
    "us": "in ft mi in^2 ft^2 in^3 gal ft^3 oz lb lbf kip psi ksi degF degR ft/s mph Btu lbf-ft hp "
    "lb/ft^3 lb/s ft^3/s gpm ft/s^2 Btu/lb Btu/lb-R Btu/h-ft-R Btu/h-ft^2-R lbf-s/ft^2 lbf/ft lbf/in",
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


def in_unit(model: Model, name: str, values: Any, unit: str) -> Any:
    """Numbers or arrays of a variable, which are in its own unit, in another.

    Raises RuleSheetError (E407, E460, E461).
    """
    factor, shift = displaying(with_display_unit(variable_named(name, model), unit))
    return values * factor + shift


def with_display_units(model: Model, system: str | None, chosen: Mapping[str, str]) -> Model:
    """The model shown in the units of a system, and some variables in those that are chosen for them."""
    if system is None and not chosen:
        return model
    variables = {
        name: with_display_unit(variable, chosen[name])
        if name in chosen
        else _in_system(variable, system or "")
        for name, variable in model.variables.items()
    }
    return replace(model, variables=variables)


def _in_system(variable: Variable, system: str) -> Variable:
    """The variable in a unit of the system; as it is where the system has none of its kind."""
    own = variable.measure
    if own is None or not variable.unit or system not in SYSTEMS:
        return variable
    names = SYSTEMS[system].split()
    if variable.unit in names:
        return replace(variable, display_unit=None)
    units = {name: library().unit(name) for name in names}
    alike = [name for name, unit in units.items() if unit.bases == own.bases]
    if not alike:
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
