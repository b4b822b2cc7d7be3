"""What is said about values, inputs and variable sheets: the wording of their diagnoses, side by side."""

from __future__ import annotations

import math
import os
from collections.abc import Sequence

from rulesheets.diagnosis import Diagnosis, RuleSheetError, error, meant, said, suggestion
from rulesheets.model import Model, Variable
from rulesheets.syntax import Span


def names_variable(name: str, place: Span | None) -> Diagnosis:
    return said(
        "E401",
        f"an input is a number or a symbol, and {name} is a variable",
        place,
        f"for the symbol write '{name}",
        "to tie two variables together write a rule",
        label="evaluated once, before anything is solved",
    )


def not_finite(reason: str, place: Span | None) -> Diagnosis:
    return said(
        "E402",
        f"this input has no finite value: {reason}",
        place,
        "give a finite number, or leave the value out to have it solved",
    )


def outside_range(number: float, variable: Variable, place: Span | None) -> Diagnosis:
    return said(
        "E403",
        f"{variable.name} = {number:.10g} lies outside its range {range_text(variable)}",
        place,
        "change the value, or the range in the variables section",
    )


def symbol_for_number(symbol: str, variable: Variable, model: Model, place: Span | None = None) -> Diagnosis:
    ranged = math.isfinite(variable.low) or math.isfinite(variable.high)
    kind = f"in [{variable.unit}]" if variable.unit else "that rules compute with"
    kind = f"that is {range_text(variable)}" if ranged and not variable.unit else kind
    tied = ("to tie two variables together write a rule",) if symbol in model.variables else ()
    return said(
        "E406",
        f"{variable.name} is a number {kind}, and '{symbol} is a symbol",
        place,
        "give a number, or clear the input to have it solved",
        *tied,
    )


def symbol_as_guess(symbol: str, place: Span | None) -> Diagnosis:
    return said(
        "E404",
        f"a guess is a number, and '{symbol} is a symbol",
        place,
        f"to give the symbol as an input write = '{symbol}",
    )


def no_tolerance(symbol: bool, place: Span | None) -> Diagnosis:
    """A tolerance of a symbol, or one that is not a number from 0 on."""
    return said(
        "E405",
        "a symbol has no tolerance" if symbol else "a tolerance is a number that is not negative",
        place,
        "write it as in = 3 ± 0.01, or = 3 ± 1%",
    )


def guess_with_tolerance(place: Span | None) -> Diagnosis:
    return said(
        "E405", "a guess has no tolerance", place, "write the guess alone, or clear the G to make it an input"
    )


def range_text(variable: Variable) -> str:
    """``> 0``, ``<= 5`` or ``[0, 5]``, with round brackets at open ends."""
    low, high = f"{variable.low:.10g}", f"{variable.high:.10g}"
    if math.isinf(variable.low):
        return f"{'<' if variable.high_open else '<='} {high}"
    if math.isinf(variable.high):
        return f"{'>' if variable.low_open else '>='} {low}"
    return f"{'(' if variable.low_open else '['}{low}, {high}{')' if variable.high_open else ']'}"


def not_a_value(text: str, place: Span, reason: str = "") -> Diagnosis:
    help_ = "a value is a number (3, 1e-3), an expression of numbers (2*3), or a symbol ('open)"
    return said(
        "E406", f"{text or 'nothing'} is not a value" + (f": {reason}" if reason else ""), place, help_
    )


def not_a_symbol(text: str, variable: Variable) -> Diagnosis:
    return error(
        "E406",
        f"{text!r} is no value for {variable.name}: a text is read as a symbol, and this is none",
        notes=("give numbers as numbers, and symbols by their names ('open')",),
    )


def not_a_number(given: object, variable: Variable) -> Diagnosis:
    """For what is given by a program: neither a number nor a text."""
    return error(
        "E406",
        f"{given!r} is no value for {variable.name}: neither a number nor a symbol",
        notes=("a sweep takes lists and arrays; a solve takes one value of each input",),
    )


def unknown_variable(name: str, model: Model, place: Span | None = None) -> Diagnosis:
    """The complaint about a name that the model does not have, with the name that may be meant."""
    notes = meant(name, model.variables)
    return said("E407", f"{model.name} has no variable {name}", place, *notes)


def no_name_column(columns: Sequence[str]) -> Diagnosis:
    """Without an excerpt: a file without this heading is no variable sheet, and is not shown."""
    return error(
        "E410",
        "a variable sheet needs a heading with the column Name",
        notes=(f"the first line is {','.join(columns)}",),
    )


def unknown_column(name: str, columns: Sequence[str], place: Span) -> Diagnosis:
    return said(
        "E411",
        f"a variable sheet has no column {name}",
        place,
        *suggestion(name, columns),
        f"the columns are {', '.join(columns)}",
    )


def unknown_status(status: str, place: Span) -> Diagnosis:
    if status == "L":
        message = "a variable with the status L holds a list, and lists are not there yet"
    else:
        message = f"there is no status {status}"
    return said("E412", message, place, "the column St is blank, or G for a guess, or C for a comment row")


def nameless_input(text: str, place: Span) -> Diagnosis:
    return said(
        "E413",
        f"the input {text} belongs to no variable",
        place,
        "fill in the column Name, or mark a comment row by C in the column St",
    )


def repeated_row(name: str, place: Span) -> Diagnosis:
    return said("E414", f"{name} has a row already", place, "keep one of the rows", label="again")


def too_many_cells(cells: int, columns: int, place: Span) -> Diagnosis:
    return said(
        "E415",
        f"this row has {cells} cells, and the heading {columns}",
        place,
        "put a cell that has a comma in it in double quotes",
    )


def not_finite_number(number: float, variable: Variable) -> Diagnosis:
    return error("E402", f"{variable.name} = {number} is not finite", notes=("give a finite number",))


def unwritable(path: str, failure: OSError) -> Diagnosis:
    return error("E416", f"{path} cannot be written: {failure.strerror}", notes=("choose another place",))


def expect_regular(name: str) -> None:
    """Raise RuleSheetError (E304) for a pipe or a device: reading it may never end."""
    if os.path.exists(name) and not (os.path.isfile(name) or os.path.isdir(name)):
        notes = ("a dash in place of the sheet reads it from standard input",)
        raise RuleSheetError(
            error("E304", f"{name} cannot be read: it is a pipe or a device, not a file", notes=notes)
        )
