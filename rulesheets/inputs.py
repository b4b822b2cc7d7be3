"""Values that a variable can have, and the inputs that the sheet and the caller give."""

from __future__ import annotations

import math
import re
from collections.abc import Collection, Iterable, Mapping
from dataclasses import replace
from typing import Any, NamedTuple, SupportsFloat

from rulesheets.diagnosis import (
    Diagnosis,
    Label,
    RuleSheetError,
    empty_range,
    error_at,
    few,
    meant,
    refusal,
    refuse,
    wrong_range,
)
from rulesheets.evaluate import Undefined, value
from rulesheets.library import Library
from rulesheets.model import Model, Tolerance, Value, Values, Variable, expect, once, reached
from rulesheets.syntax import Source, Span, nodes
from rulesheets.syntax.nodes import measured, names, units_of, walk
from rulesheets.units import (
    cannot_show,
    converted,
    displaying,
    unit_named,
    value_and_unit,
    with_display_unit,
)


def constant(expression: nodes.Expression) -> Value:
    """The value of an input as written: a symbol, or an expression of numbers evaluated once.

    Raises RuleSheetError if it names a variable (E401), has no finite value (E402) or breaks the
    rules of calls and symbols.
    """
    if isinstance(expression, nodes.Symbol):
        return expression.name
    if read := names(expression):
        message = f"an input is a number or a symbol, and {read[0]} is a variable"
        notes = f"for the symbol write '{read[0]}", "to tie two variables together write a rule"
        label = "evaluated once, before anything is solved"
        raise refusal("E401", message, expression.span, *notes, label=label)
    if units := units_of(expression):
        message = f"{units[0]} stands inside an expression of numbers"
        note = "write one number with its unit, as in x = 3[in] [mm]"
        raise refusal("E461", message, expression.span, note)
    from rulesheets.checks import check_constant  # a command with mere numbers starts without it

    refuse(check_constant(expression))
    if any(nodes.calls(expression)):
        from rulesheets.evaluate.exact import with_round_values

        expression = with_round_values(expression)
    try:
        number = float(value(expression, {}))
    except Undefined as undefined:
        raise RuleSheetError(not_finite(str(undefined), expression.span)) from None
    return _finite(number, expression.span)


DIGITS = 10
"""Significant digits that a person reads: all that matter, and no rounding noise."""


def readable(value: float | str | None) -> str:
    """A value for the variable sheet: ``'open``, ``-41.46077186``, blank if there is none."""
    if value is None:
        return ""
    if isinstance(value, str):
        return f"'{value}"
    return f"{value + 0.0:.{DIGITS}g}"


def exact(value: float | str | None) -> str:
    """A value for a file, blank for None and NaN: reading it back gives the same float."""
    if value is None or value != value:
        return ""
    return f"'{value}" if isinstance(value, str) else repr(float(value) + 0.0).removesuffix(".0")


def declared(rows: tuple[nodes.VariableRow, ...], units: Library) -> dict[str, Variable]:
    """The variables of the rows, in their order, with the ``units`` of their sheet.

    Raises RuleSheetError with all mistakes in units, values, guesses and ranges.
    """
    variables: dict[str, Variable] = {}
    complaints: list[Diagnosis] = []
    for row in rows:
        try:
            texts = [text for text in (row.unit, row.display_unit) if text]
            meant = [unit_named(text, _place_of(text, row), units) for text in texts]
            if len(meant) == 2 and meant[0].bases != meant[1].bases:
                place = _place_of(row.display_unit, row)
                raise RuleSheetError(cannot_show(row.name, row.unit, row.display_unit, place))
            bare = Variable(
                row.name,
                unit=row.unit,
                display_unit=row.display_unit,
                comment=row.comment,
                posted=True,
                span=row.span,
                units=units,
            )
            variables[row.name] = valued(bare, row)
        except RuleSheetError as wrong:
            complaints.extend(wrong.diagnoses)
    refuse(complaints)
    return variables


def _place_of(unit: str | None, row: nodes.VariableRow) -> Span | None:
    """The place of the unit in the text of a row."""
    if row.span is None or unit is None:
        return row.span
    text = row.span.source.text
    start = text.find(unit, text.find("[", row.span.end))
    return row.span if start < 0 else Span(row.span.source, start, start + len(unit))


def valued(bare: Variable, row: nodes.VariableRow) -> Variable:
    """A variable with the value, guess, tolerance and range of its row, converted to its unit."""
    ends: dict[str, Any] = {}
    for bound in row.range:
        if not any(names(bound.right)):  # else it is a requirement
            end = "low" if bound.operator.startswith(">") else "high"
            ends |= {end: _end(bound.right, bare), f"{end}_open": len(bound.operator) == 1}
    variable = replace(bare, **ends) if ends else bare
    if variable.low >= variable.high and not variable.admits(variable.low):
        raise RuleSheetError(empty_range(row.range[-1].span))
    value = None if row.value is None else _given(row.value, bare)
    guess = None if row.guess is None else _given(row.guess, bare)
    if isinstance(guess, str):
        raise RuleSheetError(symbol_as_guess(guess, row.guess.span if row.guess else None))
    tolerance = None
    if (written := row.tolerance) is not None:
        size = _given(written.size, bare, difference=not written.percent)
        if isinstance(row.value, nodes.Symbol) or isinstance(size, str) or size < 0.0:
            raise RuleSheetError(no_tolerance(isinstance(row.value, nodes.Symbol), written.span))
        tolerance = Tolerance(size, written.percent)
    variable = replace(variable, value=value, guess=guess, tolerance=tolerance)
    if row.value is not None and isinstance(value, float) and not variable.admits(value):
        raise RuleSheetError(outside_range(value, variable, row.value.span))
    return variable


def _end(written: nodes.Expression, variable: Variable) -> float:
    """An end of a range."""
    if measured(written) is not None:
        return float(_given(written, variable))
    try:
        found = constant(written)
    except RuleSheetError as wrong:
        reason = wrong.diagnoses[0].message.replace("this input", "this bound")
        raise RuleSheetError(wrong_range(reason, written.span)) from None
    if isinstance(found, str):
        reason = f"a bound is a number, and '{found} is a symbol"
        raise RuleSheetError(wrong_range(reason, written.span))
    return found


def _given(expression: nodes.Expression, variable: Variable, difference: bool = False) -> Value:
    """The value of an input; ``3[in]`` in the unit of its variable."""
    found = measured(expression)
    if found is None:
        return constant(expression)
    return converted([found[0]], found[1], variable, expression.span, difference)[0]


def symbolic(model: Model) -> frozenset[str]:
    """Variables that are given a symbol, compared with one, or set equal to such a variable."""
    found = {name for name, variable in model.variables.items() if isinstance(variable.value, str)}
    nodes_ = (node for condition in model.conditions for node in walk(condition))
    pairs = [equation.sides for equation in model.equations]
    pairs += ((node.left, node.right) for node in nodes_ if isinstance(node, nodes.Comparison))
    for pair in pairs:
        if any(isinstance(side, nodes.Symbol) for side in pair):
            found.update(side.name for side in pair if isinstance(side, nodes.Name))
    return _tied(found, pairs)


@once
def quantities(model: Model) -> frozenset[str]:
    """Variables that can only be numbers.

    They have a unit or a range, or a rule computes with them or with variables set equal to them,
    and nothing shows that they may be symbols.
    """
    variables = model.variables.values()
    given = (v.name for v in variables if v.unit or v.ranged)
    pairs = [equation.sides for equation in model.equations]
    sides = (side for pair in pairs for side in pair if not isinstance(side, nodes.Name))
    computed = _tied({*names(*sides)}, pairs)
    return frozenset(given) | (computed - symbolic(model))


def _tied(
    found: Collection[str], pairs: Collection[tuple[nodes.Expression, nodes.Expression]]
) -> frozenset[str]:
    """These variables, and those that rules set equal to one of them, directly or not."""
    neighbours: dict[str, list[str]] = {}
    for left, right in pairs:
        if isinstance(left, nodes.Name) and isinstance(right, nodes.Name):
            neighbours.setdefault(left.name, []).append(right.name)
            neighbours.setdefault(right.name, []).append(left.name)
    return frozenset(reached(found, lambda name: neighbours.get(name, ())))


_DIGITS = frozenset("0123456789+-.eE")
_PLUS_MINUS = ("±", "+/-", "+-")
FEW = 12
"""Names that are listed where one is unknown and like none of them."""
_NOT_SYMBOLS = frozenset({"pi", "nan", "inf", "infinity"})


class Inputs(NamedTuple):
    """The starting data of a solve: values of the inputs and first guesses, by full names."""

    values: Values
    guesses: Mapping[str, float]


def parse_value(text: str, place: Span | None = None) -> Value:
    """A number, an expression of numbers, or a symbol (``open`` or ``'open``).

    ``place`` is the place of the text, for messages. Raises RuleSheetError for anything else, for a
    text that names a variable and for one without a finite value.
    """
    text = text.strip()
    place = place or Span(Source("<value>", text), 0, len(text))
    number = _plain_number(text)
    if number is not None:
        return _finite(number, place)
    symbol = symbol_name(text)
    if symbol and (text.startswith("'") or text.lower() not in _NOT_SYMBOLS):
        return symbol
    if text.lower().lstrip("+-") in _NOT_SYMBOLS - {"pi"}:
        raise RuleSheetError(not_finite(f"it is {text}", place))
    if not text or any(mark in text for mark in '"=;\n'):
        raise RuleSheetError(not_a_value(text, place))
    from rulesheets.parse.sections import parse  # with it comes lark
    from rulesheets.syntax.program import rules_of

    try:  # an expression of numbers, read as the right side of a rule
        sheet = parse(Source("<value>", f"value = {text}"))
    except RuleSheetError as wrong:
        first = wrong.diagnoses[0]
        raise RuleSheetError(not_a_value(text, place, first.message, *first.notes)) from None
    rule = next(rules_of(sheet)).body
    if not isinstance(rule, nodes.Equality) or len(rule.right) != 1:
        raise RuleSheetError(not_a_value(text, place))
    try:
        return constant(rule.right[0])
    except RuleSheetError as wrong:
        told = (one._replace(labels=(Label(place),)) for one in wrong.diagnoses)
        raise RuleSheetError(*told) from None


def _plain_number(text: str) -> float | None:
    """The number that a text of digits stands for."""
    if not _DIGITS.issuperset(text):
        return None
    try:
        return float(text)
    except ValueError:
        return None


def symbol_name(text: str) -> str | None:
    """The name of the symbol that a text stands for, without its apostrophe."""
    name = text.removeprefix("'")
    return name if name.isidentifier() and name.isascii() else None


def parse_input(
    text: str, place: Span | None = None, variable: Variable | None = None
) -> tuple[Value, Tolerance | None]:
    """A value, with a tolerance if one follows it: ``3 ± 0.01``, ``3 +- 1%``.

    A unit after it (``3 in``, ``3 ± 0.1 [mm]``) is converted to that of the ``variable``. Raises
    RuleSheetError as :func:`parse_value` does, for an invalid tolerance (E405) and for units (E460,
    E461).
    """
    sign = next((sign for sign in _PLUS_MINUS if sign in text), "")
    written, _, size = text.rpartition(sign) if sign else (text, "", "")
    percent, unit = size.rstrip().endswith("%"), ""
    measured = None if variable is None or percent else value_and_unit(size if sign else written)
    if measured is not None:
        last, unit = measured
        written, size = (written, last) if sign else (last, "")
    value = parse_value(written, place)
    width = parse_value(size.strip().removesuffix("%"), place) if sign else 0.0
    if sign and (isinstance(value, str) or isinstance(width, str) or width < 0.0):
        raise RuleSheetError(no_tolerance(isinstance(value, str), place))
    if variable is not None and unit:
        if isinstance(value, str):
            text = f"'{value} [{unit}]"
            where = place or Span(Source("<value>", text), 0, len(text))
            raise RuleSheetError(not_a_value(text, where, "a symbol has no unit"))
        (value,) = converted([value], unit, variable, place)
        if not percent:
            (width,) = converted([float(width)], unit, variable, place, difference=True)
    return value, Tolerance(float(width), percent) if sign else None


def with_tolerances(model: Model, tolerances: Mapping[str, Tolerance]) -> Model:
    """The model with other tolerances of its variables (by full names)."""
    if not tolerances:
        return model
    variables = dict(model.variables)
    for name, tolerance in tolerances.items():
        variables[name] = replace(variables[name], tolerance=tolerance)
    return replace(model, variables=variables)


def _finite(number: float, place: Span | None) -> float:
    if not math.isfinite(number):
        raise RuleSheetError(not_finite(f"it is {number}", place))
    return number


def override(
    model: Model,
    inputs: Mapping[str, Value | SupportsFloat | None] | None = None,
    guesses: Mapping[str, SupportsFloat] | None = None,
) -> Inputs:
    """The sheet's inputs and guesses, overridden by the caller's; None clears an input.

    Raises RuleSheetError with every name that the model does not have and every value that is not
    finite or lies outside the range of its variable; TypeError for an argument that is not a model
    or a mapping.
    """
    expect(Model, model)
    for mapping, word in ((inputs, "inputs"), (guesses, "guesses")):
        if mapping is not None and not isinstance(mapping, Mapping):
            kind = type(mapping).__name__
            raise TypeError(f"{word} are a mapping of names to values, not of the type {kind}")
    complaints: list[Diagnosis] = []
    values = {name: item.value for name, item in model.variables.items() if item.value is not None}
    first = {name: item.guess for name, item in model.variables.items() if item.guess is not None}
    for name, given in (inputs or {}).items():
        try:
            variable = variable_named(name, model)
            value = None if given is None else _checked(given, variable, model)
            values.pop(name, None)
            if value is not None:
                values[name] = value
        except RuleSheetError as wrong:
            complaints.extend(wrong.diagnoses)
    for name, guess in (guesses or {}).items():
        try:
            start = _in_its_unit(guess, variable := variable_named(name, model))
            if isinstance(start, str):
                raise RuleSheetError(symbol_as_guess(start, None))
            first[name] = _number(start, variable)
        except RuleSheetError as wrong:
            complaints.extend(wrong.diagnoses)
    refuse(complaints)
    return Inputs(values, first)


def variable_named(name: str, model: Model, place: Span | None = None) -> Variable:
    """The variable of that full name. Raises RuleSheetError (E407) with a suggestion."""
    if not isinstance(name, str):
        raise TypeError(f"a variable is named by a text, and {name!r} is none")
    variable = model.variables.get(name)
    if variable is None:
        raise RuleSheetError(unknown_variable(name, model, place))
    return variable


def variables_named(names: Iterable[str], model: Model) -> tuple[str, ...]:
    """Full names of variables; a text alone is one name. Raises RuleSheetError (E407)."""
    names = (names,) if isinstance(names, str) else names
    return tuple(variable_named(name, model).name for name in names)


def in_unit(model: Model, name: str, values: Any, unit: str) -> Any:
    """Numbers or arrays of a variable, given in its own unit, converted to another one.

    Raises RuleSheetError (E407, E460, E461).
    """
    factor, shift = displaying(with_display_unit(variable_named(name, model), unit))
    return values * factor + shift


def _checked(given: Value | SupportsFloat, variable: Variable, model: Model) -> Value:
    given = _in_its_unit(given, variable)
    if isinstance(given, str):
        symbol = symbol_name(given)
        if symbol is None:
            why = "a text is read as a symbol, and this is not one"
            note = "give numbers as numbers, and symbols by their names ('open')"
            message = f"{given!r} is not a valid value for {variable.name}: {why}"
            raise refusal("E406", message, None, note)
        if variable.name in quantities(model):
            raise RuleSheetError(symbol_for_number(symbol, variable, model))
        return symbol
    number = _number(given, variable)
    if not variable.admits(number):
        raise RuleSheetError(outside_range(number, variable, None))
    return number


def _in_its_unit(given: Any, variable: Variable) -> Any:
    """``"3 in"``, ``(3, "in")`` and pint quantities in the variable's unit; others as given."""
    if isinstance(given, str) and (measured := value_and_unit(given)):
        plain = _plain_number(measured[0]) is not None
        return parse_input(given, None, variable)[0] if plain else given
    if (pair := with_unit(given)) is None:
        return given
    return converted([_number(pair[0], variable)], pair[1], variable)[0]


def with_unit(given: Any) -> tuple[Any, str] | None:
    """``(3, "in")`` and quantities of pint, numbers or arrays, with the unit; None for others."""
    if isinstance(given, tuple) and len(given) == 2 and isinstance(given[1], str):
        return given
    if hasattr(given, "to_base_units"):
        base = given.to_base_units()
        return base.magnitude, f"{base.units:C}"
    return None


def _number(given: SupportsFloat, variable: Variable) -> float:
    try:
        number = float(given)
    except (TypeError, ValueError):
        why = "neither a number nor a symbol"
        message = f"{given!r} is not a valid value for {variable.name}: {why}"
        note = "a sweep takes lists and arrays; a solve takes one value of each input"
        raise refusal("E406", message, None, note) from None
    except OverflowError:
        number = math.inf
    if not math.isfinite(number):
        raise RuleSheetError(not_finite_number(number, variable))
    return number


COLUMNS = ("St", "Input", "Name", "Output", "Unit", "Comment")
"""Of a variable sheet."""

_FORMULA = re.compile(r"'*[=+\-@\t\r]")
_NUMBER = r"(?:\d+(?:[.,]\d*)?|[.,]\d+)(?:[eE][-+]?\d+)?"
_PLAIN = re.compile(rf"[-+]?{_NUMBER}")
_TOLERATED = re.compile(rf"[-+]?{_NUMBER}(?:\s*(?:±|\+-)\s*{_NUMBER}\s*%?)?")


def guarded(text: str) -> str:
    """A cell that no spreadsheet takes for a formula: an apostrophe is put before one.

    Numbers are unchanged; :func:`unguarded` reads the text again.
    """
    return f"'{text}" if _FORMULA.match(text) and not _PLAIN.fullmatch(text) else text


def unguarded(text: str) -> str:
    return text[1:] if text.startswith("'") and _FORMULA.match(text) else text


def delimiter(heading: str) -> str:
    """A comma, or the delimiter of spreadsheets with decimal commas: a semicolon or a tab."""
    return max(",;\t", key=heading.count)


def decimal_point(text: str) -> str:
    """A number with a decimal comma (``3,5``, ``3,5 ± 0,1``) with a point; other cells as given."""
    if "," not in text or "." in text or not _TOLERATED.fullmatch(text.strip()):
        return text
    return text.replace(",", ".")


# --- what is said about values and inputs ---------------------------------------


def not_finite(reason: str, place: Span | None) -> Diagnosis:
    note = "give a finite number, or leave the value out to have it solved"
    return error_at("E402", f"this input has no finite value: {reason}", place, note)


def not_finite_number(number: float, variable: Variable) -> Diagnosis:
    message = f"{variable.name} = {number} is not finite"
    return error_at("E402", message, None, "give a finite number")


def outside_range(number: float, variable: Variable, place: Span | None) -> Diagnosis:
    message = f"{variable.name} = {number:.10g} lies outside its range {range_text(variable)}"
    note = "change the value, or the range in the variables section"
    return error_at("E403", message, place, note)


def symbol_for_number(
    symbol: str, variable: Variable, model: Model, place: Span | None = None
) -> Diagnosis:
    kind = f"that is {range_text(variable)}" if variable.ranged else "that rules compute with"
    kind = f"in [{variable.unit}]" if variable.unit else kind
    message = f"{variable.name} is a number {kind}, and '{symbol} is a symbol"
    tied = ("to tie two variables together write a rule",) if symbol in model.variables else ()
    note = "give a number, or clear the input to have it solved"
    return error_at("E406", message, place, note, *tied)


def symbol_as_guess(symbol: str, place: Span | None) -> Diagnosis:
    message = f"a guess is a number, and '{symbol} is a symbol"
    return error_at("E404", message, place, f"to give the symbol as an input write = '{symbol}")


def no_tolerance(symbol: bool, place: Span | None) -> Diagnosis:
    """A tolerance of a symbol, or one that is not a number from 0 on."""
    message = "a symbol has no tolerance"
    if not symbol:
        message = "a tolerance is a number that is not negative"
    return error_at("E405", message, place, "write it as in = 3 ± 0.01, or = 3 ± 1%")


def guess_with_tolerance(place: Span | None) -> Diagnosis:
    note = "write the guess alone, or clear the G to make it an input"
    return error_at("E405", "a guess has no tolerance", place, note)


def range_text(variable: Variable) -> str:
    """``> 0``, ``<= 5`` or ``[0, 5]``, with round brackets at open ends."""
    low, high = f"{variable.low:.10g}", f"{variable.high:.10g}"
    if math.isinf(variable.low):
        return f"{'<' if variable.high_open else '<='} {high}"
    if math.isinf(variable.high):
        return f"{'>' if variable.low_open else '>='} {low}"
    return f"{'(' if variable.low_open else '['}{low}, {high}{')' if variable.high_open else ']'}"


def not_a_value(text: str, place: Span, reason: str = "", *cures: str) -> Diagnosis:
    message = f"{text or 'nothing'} is not a value" + (f": {reason}" if reason else "")
    note = "a value is a number (3, 1e-3), an expression of numbers (2*3), or a symbol ('open)"
    return error_at("E406", message, place, *(cures or (note,)))


def unknown_variable(name: str, model: Model, place: Span | None) -> Diagnosis:
    """The complaint about a name that the model does not have, with a suggestion."""
    notes = meant(name, model.variables)
    names = [one for one, variable in model.variables.items() if variable.posted]
    if names and not notes:
        notes = (f"its variables are {few(names, FEW)}",)
    return error_at("E407", f"{model.name} has no variable {name}", place, *notes)
