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
from collections.abc import Iterator, Mapping
from typing import NamedTuple

from rulesheets.diagnosis import Diagnosis, RuleSheetError, error, refuse, said, suggestion
from rulesheets.files import read_source
from rulesheets.inputs import (
    decimal_point,
    delimiter,
    guess_with_tolerance,
    is_symbol,
    parse_input,
    symbol_as_guess,
    unguarded,
    variable_named,
)
from rulesheets.model import Model, Tolerance, Value
from rulesheets.syntax import Source, Span

COLUMNS = ("St", "Input", "Name", "Output", "Unit", "Comment")
_STATUSES = {"", "I", "O", "G", "C"}
_NAMELESS = error(
    "E410",
    "a variable sheet needs a heading with the column Name",
    notes=(f"the first line is {','.join(COLUMNS)}",),
)
"""Without an excerpt: a file without this heading is no variable sheet, and is not shown."""


class VariableSheet(NamedTuple):
    """What a variable sheet overrides: inputs (None clears one), first guesses, and tolerances of inputs."""

    inputs: Mapping[str, Value | None]
    guesses: Mapping[str, float]
    tolerances: Mapping[str, Tolerance]


class Row(NamedTuple):
    """One row as texts, in the order of ``COLUMNS``."""

    status: str = ""
    input: str = ""
    name: str = ""
    output: str = ""
    unit: str = ""
    comment: str = ""


def read_variable_sheet(path: str | os.PathLike[str], model: Model) -> VariableSheet:
    """The inputs and guesses of a CSV variable sheet for a model.

    Raises RuleSheetError with every row that is wrong, each with its place.
    """
    source = read_source(os.fspath(path))
    inputs: dict[str, Value | None] = {}
    guesses: dict[str, float] = {}
    tolerances: dict[str, Tolerance] = {}
    complaints: list[Diagnosis] = []
    for row, line in _rows(source):
        try:
            value, tolerance = _input_of(row, line, model)
            if row.name in inputs:
                message, place = f"{row.name} has a row already", _cell(line, row.name)
                raise RuleSheetError(said("E414", message, place, "keep one of the rows", label="again"))
            inputs[row.name] = None if row.status == "G" else value
            if row.status == "G" and value is not None:
                if isinstance(value, str):
                    raise RuleSheetError(symbol_as_guess(value, _cell(line, row.input)))
                guesses[row.name] = value
            if tolerance is not None:
                tolerances[row.name] = tolerance
        except RuleSheetError as wrong:
            complaints.extend(wrong.diagnoses)
    refuse(complaints)
    return VariableSheet(inputs, guesses, tolerances)


def _input_of(row: Row, line: Span, model: Model) -> tuple[Value | None, Tolerance | None]:
    variable = variable_named(row.name, model, _cell(line, row.name))
    if not row.input:
        return None, None
    place = _cell(line, row.input)
    text = (
        f"{row.input} [{row.unit}]" if row.unit and variable.unit and not is_symbol(row.input) else row.input
    )
    value, tolerance = parse_input(text, place, variable)
    if tolerance is not None and row.status == "G":
        raise RuleSheetError(guess_with_tolerance(place))
    return value, tolerance


def _rows(source: Source) -> Iterator[tuple[Row, Span]]:
    """The rows that speak of a variable, each with the place of its lines."""
    import csv  # which a solve without a variable sheet need not wait for

    separator = delimiter(source.text.lstrip("\r\n").partition("\n")[0])
    reader = csv.reader(io.StringIO(source.text, newline=""), delimiter=separator)
    columns: list[str] | None = None
    before = 0
    for cells in reader:
        line = _lines(source, before, reader.line_num)
        before = reader.line_num
        cells = [unguarded(cell.strip()) for cell in cells]
        if not any(cells):
            continue
        if columns is None:
            columns = _heading(cells, line)
        elif (row := _row(columns, cells, line)) is not None:
            yield row if separator == "," else row._replace(input=decimal_point(row.input)), line
    if columns is None:
        raise RuleSheetError(_NAMELESS)


def _lines(source: Source, before: int, last: int) -> Span:
    starts = source.line_starts
    first = min(before, len(starts) - 1)
    end = starts[last] - 1 if last < len(starts) else len(source.text)
    return Span(source, starts[first], max(end, starts[first]))


def _cell(line: Span, text: str) -> Span:
    """The place of a cell in its line; the whole line where it is quoted beyond recognition."""
    at = line.text.find(text)
    return line.part(at, len(text)) if text and at >= 0 else line


def _heading(cells: list[str], line: Span) -> list[str]:
    columns = [cell.lower() for cell in cells]
    if "name" not in columns:
        raise RuleSheetError(_NAMELESS)
    known = {"", *map(str.lower, COLUMNS)}
    every = f"the columns are {', '.join(COLUMNS)}"
    strange = [cell for cell in cells if cell.lower() not in known]
    message = "a variable sheet has no column "
    refuse(said("E411", message + c, _cell(line, c), *suggestion(c, COLUMNS), every) for c in strange)
    return columns


def _row(columns: list[str], cells: list[str], line: Span) -> Row | None:
    if len(cells) > len(columns) and any(cells[len(columns) :]):
        message = f"this row has {len(cells)} cells, and the heading {len(columns)}"
        note = "put a cell that has a comma in it in double quotes"
        raise RuleSheetError(said("E415", message, line, note))
    by_column = dict(zip(columns, cells, strict=False))
    status, *others = (by_column.get(column.lower(), "") for column in COLUMNS)
    row = Row(status.upper(), *others)
    if row.status == "C" or not (row.name or row.input):
        return None
    if row.status not in _STATUSES:
        message = f"there is no status {row.status}"
        if row.status == "L":
            message = "a variable with the status L holds a list, and lists are not there yet"
        place = _cell(line, cells[columns.index("st")])
        note = "the column St is blank, or G for a guess, or C for a comment row"
        raise RuleSheetError(said("E412", message, place, note))
    if not row.name:
        note = "fill in the column Name, or mark a comment row by C in the column St"
        raise RuleSheetError(said("E413", f"the input {row.input} belongs to no variable", line, note))
    return row
