"""A number with a unit, for a variable: converted to the unit that its rules work in."""

from __future__ import annotations

import re
from collections.abc import Sequence

from rulesheets.diagnosis import Diagnosis, RuleSheetError, error, labels
from rulesheets.model import Variable
from rulesheets.source import Span
from rulesheets.spelling import suggestion
from rulesheets.units.library import library
from rulesheets.units.text import UnitError
from rulesheets.units.unit import Unit, convert

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
    if not variable.unit:
        raise RuleSheetError(_no_unit(variable, unit, place))
    source, target = unit_named(unit, place), unit_named(variable.unit, place)
    if source.bases != target.bases:
        raise RuleSheetError(_other_kind(variable, unit, source, target, place))
    return [convert(number, source, target, difference) for number in numbers]


def unit_named(text: str, place: Span | None = None) -> Unit:
    """The unit of a text. Raises RuleSheetError (E460) with what may be meant."""
    try:
        return library().unit(text)
    except UnitError as wrong:
        raise RuleSheetError(_unknown(wrong, text, place)) from None


def _unknown(wrong: UnitError, text: str, place: Span | None) -> Diagnosis:
    notes = suggestion(wrong.name, library().names()) if wrong.name else ()
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
    source, target = library().unit(variable.unit), library().unit(variable.display_unit)
    return convert(number, source, target, difference)
