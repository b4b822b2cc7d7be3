"""Rows of the variables section as variables with their values."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace

from rulesheets.checks.names import check_constant
from rulesheets.circular import with_round_values
from rulesheets.diagnosis import Diagnosis, RuleSheetError
from rulesheets.evaluate import Undefined, value
from rulesheets.input_messages import names_variable, no_tolerance, not_finite, outside_range, symbol_as_guess
from rulesheets.model import Tolerance, Value, Variable
from rulesheets.parse.ranges import empty_range
from rulesheets.syntax import nodes
from rulesheets.syntax.nodes import Expression, Range, Symbol, VariableRow, measured, names, units_of
from rulesheets.syntax.source import Span
from rulesheets.units.library import Library
from rulesheets.units.quantity import cannot_show, converted, part_with_unit, unit_named


def constant(expression: Expression) -> Value:
    """The value of an input as written: a symbol, or an expression of numbers evaluated once.

    Raises RuleSheetError where it names a variable (E401), has no finite value (E402) or
    breaks the rules of calls and symbols.
    """
    if isinstance(expression, Symbol):
        return expression.name
    name = next(names(expression), None)
    if name is not None:
        raise RuleSheetError(names_variable(name, expression.span))
    unit = next(units_of(expression), None)
    if unit is not None:
        raise RuleSheetError(part_with_unit(unit, expression.span))
    complaints = tuple(check_constant(expression))
    if complaints:
        raise RuleSheetError(*complaints)
    try:
        number = float(value(with_round_values(expression), {}))
    except Undefined as undefined:
        raise RuleSheetError(not_finite(str(undefined), expression.span)) from None
    if not math.isfinite(number):
        raise RuleSheetError(not_finite(f"it is {number}", expression.span))
    return number


def declared(rows: tuple[VariableRow, ...], units: Library) -> Mapping[str, Variable]:
    """The variables of the rows, in their order, with the ``units`` of their sheet.

    Raises RuleSheetError with everything that is wrong with units, values, guesses and ranges.
    """
    variables: dict[str, Variable] = {}
    complaints: list[Diagnosis] = []
    for row in rows:
        try:
            variables[row.name] = _variable(row, units)
        except RuleSheetError as wrong:
            complaints.extend(wrong.diagnoses)
    if complaints:
        raise RuleSheetError(*complaints)
    return variables


def _variable(row: VariableRow, library: Library) -> Variable:
    units = [unit_named(text, _place_of(text, row), library) for text in (row.unit, row.display_unit) if text]
    if len(units) == 2 and units[0].bases != units[1].bases:
        raise RuleSheetError(
            cannot_show(row.name, row.unit, row.display_unit, _place_of(row.display_unit, row))
        )
    bare = Variable(
        name=row.name,
        unit=row.unit,
        display_unit=row.display_unit,
        comment=row.comment,
        posted=True,
        span=row.span,
        units=library,
    )
    return valued(bare, row)


def valued(bare: Variable, row: VariableRow) -> Variable:
    """A variable with the value, guess, tolerance and range of its row, converted to its unit."""
    bounds = row.range or Range()
    low, high = _end(bounds.low, bounds.lower, bare), _end(bounds.high, bounds.upper, bare)
    if low > high:
        raise RuleSheetError(empty_range(bounds.span))
    variable = replace(
        bare,
        value=None if row.value is None else _given(row.value, bare),
        guess=None if row.guess is None else _guess(row.guess, bare),
        low=low,
        high=high,
        low_open=bounds.low_open,
        high_open=bounds.high_open,
        tolerance=None if row.tolerance is None else _tolerance(row.tolerance, row, bare),
    )
    if row.value is not None and isinstance(variable.value, float) and not variable.admits(variable.value):
        raise RuleSheetError(outside_range(variable.value, variable, row.value.span))
    return variable


def _given(expression: Expression, variable: Variable, difference: bool = False) -> Value:
    """The value of an input; ``3[in]`` in the unit of its variable."""
    found = measured(expression)
    if found is None:
        return constant(expression)
    return converted([found[0]], found[1], variable, expression.span, difference)[0]


def _end(number: float, written: Expression | None, variable: Variable) -> float:
    """An end of a range; one that names variables is a requirement, and none here."""
    if written is None or (found := measured(written)) is None:
        return number
    return converted([found[0]], found[1], variable, written.span)[0]


def _place_of(unit: str | None, row: VariableRow) -> Span | None:
    """Where the unit of a row stands in its text."""
    if row.span is None or unit is None:
        return row.span
    text = row.span.source.text
    start = text.find(unit, text.find("[", row.span.end))
    return Span(row.span.source, start, start + len(unit)) if start >= 0 else row.span


def _tolerance(written: nodes.Tolerance, row: VariableRow, variable: Variable) -> Tolerance:
    size = _given(written.size, variable, difference=not written.percent)
    if isinstance(row.value, Symbol) or isinstance(size, str) or size < 0.0:
        raise RuleSheetError(no_tolerance(isinstance(row.value, Symbol), written.span))
    return Tolerance(size, written.percent)


def _guess(expression: Expression, variable: Variable) -> float:
    guess = _given(expression, variable)
    if isinstance(guess, str):
        raise RuleSheetError(symbol_as_guess(guess, expression.span))
    return guess
