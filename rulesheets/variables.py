"""Variable sheets as CSV: ``St,Input,Name,Output,Unit,Comment``, read and written.

Only the column Name is required, and capitals in the heading do not matter. A row says:

======  ==========  ==============================================================
St      Input       means
======  ==========  ==============================================================
        a value     an input: a number, an expression of numbers, or a symbol
        ``3 ± 0.1`` an input with a tolerance (``+-`` and ``± 1%`` are read too)
        blank       not an input, whatever the rule sheet says
G       a number    to be solved, with a first guess
C       anything    a comment row
======  ==========  ==============================================================
"""

from __future__ import annotations

import io
import os
from collections.abc import Iterator
from typing import NamedTuple

from rulesheets.diagnosis import (
    Diagnosis,
    RuleSheetError,
    error,
    error_at,
    refusal,
    refuse,
    suggestion,
)
from rulesheets.files import read_source
from rulesheets.inputs import (
    COLUMNS,
    decimal_point,
    delimiter,
    guess_with_tolerance,
    parse_input,
    symbol_as_guess,
    symbol_name,
    unguarded,
    variable_named,
)
from rulesheets.model import Model, Tolerance, Value
from rulesheets.syntax import Source, Span

_NAMED = "a variable sheet needs a heading with the column Name"
_NAMELESS = error("E410", _NAMED, notes=(f"the first line is {','.join(COLUMNS)}",))
"""Without an excerpt: a file without this heading is not a variable sheet, and is not quoted."""


class VariableSheet(NamedTuple):
    """Overrides by a variable sheet: inputs (None clears one), first guesses, tolerances."""

    inputs: dict[str, Value | None]
    guesses: dict[str, float]
    tolerances: dict[str, Tolerance]


def read_variable_sheet(path: str | os.PathLike[str], model: Model) -> VariableSheet:
    """The inputs and guesses of a CSV variable sheet for a model.

    Raises RuleSheetError with every wrong row and its place.
    """
    found = VariableSheet({}, {}, {})
    complaints: list[Diagnosis] = []
    for row, line in _rows(read_source(os.fspath(path))):
        try:
            if _speaks(row, line):
                _take(row, line, model, found)
        except RuleSheetError as wrong:
            complaints.extend(wrong.diagnoses)
    refuse(complaints)
    return found


def _take(row: dict[str, str], line: Span, model: Model, found: VariableSheet) -> None:
    """Add the content of a row for its variable."""
    name, given, guessed = row["name"], row["input"], row["st"].upper() == "G"
    variable, place = variable_named(name, model, _cell(line, name)), _cell(line, given)
    value, tolerance = None, None
    if given:
        if row["unit"] and variable.unit and symbol_name(given) is None:
            given += f" [{row['unit']}]"
        value, tolerance = parse_input(given, place, variable)
    if tolerance is not None and guessed:
        raise RuleSheetError(guess_with_tolerance(place))
    if name in found.inputs:
        message, again = f"{name} has a row already", _cell(line, name)
        raise refusal("E414", message, again, "keep one of the rows", label="again")
    found.inputs[name] = None if guessed else value
    if guessed and value is not None:
        if isinstance(value, str):
            raise RuleSheetError(symbol_as_guess(value, place))
        found.guesses[name] = value
    if tolerance is not None:
        found.tolerances[name] = tolerance


def _rows(source: Source) -> Iterator[tuple[dict[str, str], Span]]:
    """The rows below the heading, by its columns in lower case, with their places."""
    import csv  # which a solve without a variable sheet need not wait for

    separator = delimiter(source.text.lstrip("\r\n").partition("\n")[0])
    reader = csv.reader(io.StringIO(source.text, newline=""), delimiter=separator)
    columns: list[str] = []
    last, starts = 0, (*source.line_starts, len(source.text) + 1)
    for cells in reader:
        first, last = starts[min(last, len(starts) - 2)], reader.line_num
        line = Span(source, first, max(first, starts[min(last, len(starts) - 1)] - 1))
        cells = [unguarded(cell.strip()) for cell in cells]
        if not any(cells):
            continue
        if not columns:
            columns = _heading(cells, line)
            continue
        if any(cells[len(columns) :]):
            message = f"this row has {len(cells)} cells, and the heading {len(columns)}"
            note = "put a cell that has a comma in it in double quotes"
            raise refusal("E415", message, line, note)
        row = dict.fromkeys(map(str.lower, COLUMNS), "") | dict(zip(columns, cells, strict=False))
        if separator != ",":
            row["input"] = decimal_point(row["input"])
        yield row, line
    if not columns:
        raise RuleSheetError(_NAMELESS)


def _cell(line: Span, text: str) -> Span:
    """The place of a cell in its line; the whole line where it is quoted beyond recognition."""
    at = line.text.find(text)
    return line.part(at, len(text)) if text and at >= 0 else line


def _last(line: Span, text: str) -> Span:
    """The last place of a text in a line."""
    return line.part(line.text.rfind(text), len(text))


def _heading(cells: list[str], line: Span) -> list[str]:
    columns = [cell.lower() for cell in cells]
    if "name" not in columns:
        raise RuleSheetError(_NAMELESS)
    known = {"", *map(str.lower, COLUMNS)}
    every = f"the columns are {', '.join(COLUMNS)}"
    strange = [cell for cell in cells if cell.lower() not in known]
    complaints = []
    for cell in strange:
        message, notes = f"a variable sheet has no column {cell}", suggestion(cell, COLUMNS)
        complaints.append(error_at("E411", message, _cell(line, cell), *notes, every))
    for place, cell in enumerate(cells):
        if cell and cell.lower() in columns[:place]:
            message, note = f"the heading has the column {cell} twice", "keep one of them"
            complaints.append(error_at("E411", message, _last(line, cell), note))
    refuse(complaints)
    return columns


def _speaks(row: dict[str, str], line: Span) -> bool:
    """Whether a row is about a variable. Raises RuleSheetError (E412, E413) if that is unclear."""
    status = row["st"].upper()
    if status == "C" or not (row["name"] or row["input"]):
        return False
    if status not in ("", "I", "O", "G"):
        message = f"there is no status {status}"
        if status == "L":
            message = "a variable with the status L holds a list, and lists are not supported yet"
        note = "the column St is blank, or G for a guess, or C for a comment row"
        raise refusal("E412", message, _cell(line, row["st"]), note)
    if not row["name"]:
        note = "fill in the column Name, or mark a comment row by C in the column St"
        raise refusal("E413", f"the input {row['input']} belongs to no variable", line, note)
    return True
