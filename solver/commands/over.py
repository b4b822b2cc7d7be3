"""Values of inputs on the command line (``--over``, ``--approach``), and the states of a drawing."""

from __future__ import annotations

import math
import re
import sys
from argparse import Namespace
from collections.abc import Iterable, Iterator, Sequence
from fractions import Fraction
from itertools import chain
from typing import NamedTuple

from rulesheets.diagnosis import Diagnosis, Label, RuleSheetError, error, refuse, suggestion
from rulesheets.input_messages import not_finite, symbol_for_number
from rulesheets.inputs import parse_input, parse_value, quantities, variable_named
from rulesheets.model import Model, Value, Variable
from rulesheets.units import converted, parted, scaling
from solver.commands.inputs import Option, Request
from solver.files.tables import Chunk, column_of, heading, pieces
from solver.sweeps.sweep import (
    Axis,
    Grid,
    Stretch,
    file_chunks,
    grid_chunks,
    grid_lessons,
)

LIMIT = 10**12
"""Rows that a sweep may have: beyond that nobody waits for the end."""

_DECIMAL = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d{1,3})?", re.ASCII)


def read_over(
    texts: Sequence[str], model: Model, *, side_by_side: bool = False
) -> tuple[tuple[str, ...], Grid]:
    """The swept inputs in the order given, and their rows.

    Raises RuleSheetError for what is no range of a variable, and for ranges that cannot be combined.
    """
    axes = read_axes(texts, model)
    lengths = {name: len(axis) for name, axis in axes.items()}
    first, length = next(iter(lengths.items()))
    if not side_by_side and math.prod(lengths.values()) > LIMIT:
        raise RuleSheetError(_too_many(Option("over", texts[-1])))
    for (name, other), text in zip(lengths.items(), texts, strict=True):
        if side_by_side and other != length:
            said = f"with --zip all have one length: {first} has {length:,}, {name} has {other:,}"
            note = "leave --zip out to sweep every combination"
            raise RuleSheetError(Option("over", text).wrong("E424", said, note))
    return tuple(axes), Grid(tuple(axes.values()), zipped=side_by_side)


def read_axes(texts: Iterable[str], model: Model) -> dict[str, Axis]:
    """The values by name, in the order given. Raises RuleSheetError for what gives no variable its values."""
    axes: dict[str, Axis] = {}
    for text in texts:
        option = Option("over", text)
        name, equals, stretch = (part.strip() for part in text.partition("="))
        if not name or not equals or not stretch:
            raise RuleSheetError(_no_range(option))
        variable = variable_named(name, model, option.place(name))
        if name in axes:
            raise RuleSheetError(option.repeated(name))
        axes[name] = _axis(option, variable, stretch, model)
    return axes


def _axis(option: Option, variable: Variable, stretch: str, model: Model) -> Axis:
    """A range, or a list; one value is a list of one."""
    if ":" not in stretch:
        parts = [part.strip() for part in stretch.split(",")]
        last = parted(parts[-1])
        if last is not None and not any(map(parted, parts[:-1])):  # 1,2,5 in: the unit of all
            parts = [*(f"{part} [{last[1]}]" for part in parts[:-1]), parts[-1]]
        values = [_listed(option, variable, part, model) for part in parts]
        return column_of(values, variable.name)
    head, _, end = stretch.rpartition(":")
    if (measured := parted(end)) is not None:  # 0:90:5deg: a range in a unit, in that of the variable
        number, unit = measured
        numbers = _axis(option, variable, f"{head}:{number}", model)[:].tolist()
        return column_of(converted(numbers, unit, variable, option.place(unit)), variable.name)
    parts = stretch.split(":")
    if len(parts) != 3:
        raise RuleSheetError(_no_range(option))
    start, stop, step = (_number(option, part.strip()) for part in parts)
    if step == 0 or (stop - start) / step < 0:
        said = "this step never leads from the start to the stop"
        note = "the step is not 0, and negative where the stop is below the start"
        raise RuleSheetError(option.wrong("E424", said, note, option.text.rpartition(":")[2]))
    count = int((stop - start) / step) + 1
    if count > LIMIT:
        raise RuleSheetError(_too_many(option))
    if max(abs(start), abs(start + step * (count - 1))) > Fraction(sys.float_info.max):
        raise RuleSheetError(not_finite("it is too large for a float", option.place(stretch)))
    return Stretch(start, step, count)


def _listed(option: Option, variable: Variable, text: str, model: Model) -> float | str:
    """A value of a list. Raises RuleSheetError for a symbol where only a number can be."""
    value, _ = parse_input(text, option.place(text), variable)
    if isinstance(value, str) and variable.name in quantities(model):
        raise RuleSheetError(symbol_for_number(value, variable, model, option.place(text)))
    return value


def _number(option: Option, text: str) -> Fraction:
    """The exact decimal, or the float that an expression of numbers comes to."""
    if _DECIMAL.fullmatch(text):
        return Fraction(text)
    value = parse_value(text, option.place(text))
    if isinstance(value, str):
        raise RuleSheetError(_no_range(option))
    return Fraction(value)


def _no_range(option: Option) -> Diagnosis:
    note = "write --over NAME=START:STOP:STEP, such as NAME=0:360:5, or --over NAME=1,2,5"
    return option.wrong("E424", "--over needs a name and a range or a list", note)


def _too_many(option: Option) -> Diagnosis:
    return option.wrong("E424", f"this sweep has more than {LIMIT:,} rows", "take a larger step")


A_DECADE = 2
"""Points a decade."""

_NUMBER = r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?"
_FORM = re.compile(rf"\s*([^=]+?)\s*=\s*(.+?)\s*:\s*({_NUMBER})\s*\.\.\s*({_NUMBER})\s*")


def read_approach(text: str, model: Model) -> tuple[str, dict[float, float]]:
    """The input, and its values with their distances from the limit, the farthest first.

    Distances are relative to the limit (absolute where that is 0), and counted towards 0; negative ones
    lie beyond. Raises RuleSheetError for what is none of this.
    """
    option, form = Option("approach", text), _FORM.fullmatch(text)
    said = "--approach needs a name, a limit, and the relative distances of the first and the last value"
    unread = option.wrong("E424", said, "write --approach NAME=LIMIT:1e-1..1e-15, with the limit as a number")
    if form is None:
        raise RuleSheetError(unread)
    name, limit_text, first, last = form[1], form[2], float(form[3]), float(form[4])
    variable_named(name, model, option.place(name))
    limit = parse_value(limit_text, option.place(limit_text))
    if isinstance(limit, str) or not first * last > 0 or not math.isfinite(first * last):
        raise RuleSheetError(unread)
    decades = math.log10(last / first)
    count = round(abs(decades) * A_DECADE) + 1
    if count > 100 * A_DECADE:
        raise RuleSheetError(unread)
    distances = [first * 10.0 ** (decades * k / max(count - 1, 1)) for k in range(count)]
    numbers = [limit * (1.0 - d) if limit else d for d in distances]
    return name, {number: abs(d) for number, d in zip(numbers, distances, strict=True) if number != limit}


FRAMES = 100_000
"""Values that a range may have: a film of an hour and a half."""


def read_states(
    texts: Iterable[str], request: Request
) -> tuple[dict[str, list[Value]], dict[str, list[float]]]:
    """What ``--over`` says of a drawing: lists of values (``branch=open,crossed``), and one range at most.

    Raises RuleSheetError for what is neither, for names that are given twice, and for a second range.
    """
    texts = tuple(texts)
    ranges = [text for text in texts if ":" in text]
    if len(ranges) > 1:
        note = "list the values of the other variable: they stand side by side"
        raise RuleSheetError(Option("over", ranges[1]).wrong("E424", "a film runs over one range", note))
    axes = read_axes(texts, request.model)
    request.swept(axes)
    moving = ranges[0].partition("=")[0].strip() if ranges else None
    if moving is not None and len(axes[moving]) > FRAMES:
        said = f"a film has at most {FRAMES:,} frames"
        raise RuleSheetError(Option("over", ranges[0]).wrong("E424", said, "take a larger step"))
    values = {name: axis[:].tolist() for name, axis in axes.items()}
    lists = {name: column for name, column in values.items() if name != moving}
    return lists, {name: column for name, column in values.items() if name == moving}


class Swept(NamedTuple):
    """What a sweep goes over: the inputs by name, and their rows in pieces.

    ``total`` is the number of rows where it is known, ``shape`` that of the grid, where it is one.
    """

    names: tuple[str, ...]
    total: int | None
    shape: tuple[int, ...] | None
    chunks: Iterator[Chunk]
    lessons: Chunk

    @property
    def line(self) -> int:
        """Rows in which only the last input changes."""
        return self.shape[-1] if self.shape else sys.maxsize


def read_swept(arguments: Namespace, model: Model) -> Swept:
    """The rows of ``--over`` or ``--rows``. Raises RuleSheetError where these make no sense."""
    if bool(arguments.over) == bool(arguments.rows):
        note = "give --over NAME=START:STOP:STEP, or --rows FILE"
        raise RuleSheetError(error("E443", "a sweep needs either ranges or a file of rows", notes=(note,)))
    if arguments.rows:
        return _file_rows(arguments.rows, arguments.columns, model)
    names, rows = read_over(arguments.over, model, side_by_side=arguments.zip)
    return Swept(names, len(rows), rows.shape, grid_chunks(rows), grid_lessons(rows))


def _file_rows(path: str, columns: Iterable[str], model: Model) -> Swept:
    """``columns`` are those to take; none means all."""
    written, total = heading(path)
    there = [_parted(head)[0] for head in written]
    wanted = [name.strip() for text in columns for name in text.split(",") if name.strip()]
    if not any(name in model.variables for name in there):
        said = f"{path} has no column that is a variable of {model.name}"  # of another file show no word
        raise RuleSheetError(error("E440", said, notes=("the first line of the file names variables",)))
    names = tuple(dict.fromkeys(wanted or there))
    refuse(
        [
            *(_no_column(path, name, there) for name in wanted if name not in there),
            *(_no_variable(path, name, model) for name in names if name not in model.variables),
            *(_two_columns(path, name) for name in names if there.count(name) > 1),
        ]
    )
    heads = [written[there.index(name)] for name in names]
    numbers = [head for head, name in zip(heads, names, strict=True) if name in quantities(model)]
    scales: list[tuple[float, float]] = []
    for name, head in zip(names, heads, strict=True):
        variable, unit = model.variables[name], _parted(head)[1]
        scales.append(scaling(unit, variable) if unit and unit != variable.unit else (1.0, 0.0))

    def scaled(piece: Chunk) -> Chunk:
        pairs = zip(piece, scales, strict=True)
        return tuple(
            column if scale == (1.0, 0.0) else column * scale[0] + scale[1] for column, scale in pairs
        )

    chunks = file_chunks(map(scaled, pieces(path, heads, numbers)), total)
    first = next(chunks, ())
    lessons = grid_lessons(Grid(first, zipped=True), 16 * len(first[0])) if first else ()
    return Swept(names, total, None, chain([first] if first else [], chunks), lessons)


def _parted(head: str) -> tuple[str, str]:
    """``v [km/h]`` as the name of a column and its unit, which may be empty."""
    name, bracket, unit = head.removesuffix("]").partition("[")
    return (name.strip(), unit.strip()) if bracket and head.endswith("]") else (head, "")


def _no_column(path: str, name: str, there: Sequence[str]) -> Diagnosis:
    notes = (*suggestion(name, there), f"its columns are {', '.join(there)}")
    return error(
        "E440", f"{path} has no column {name}", Label(Option("columns", name).place(name)), notes=notes
    )


def _no_variable(path: str, name: str, model: Model) -> Diagnosis:
    """Such a column is a mistake more often than not: nothing is left out in silence."""
    notes = (*suggestion(name, model.variables), "--columns NAME,… takes some of the columns alone")
    return error("E440", f"{path} has a column {name}, and {model.name} no such variable", notes=notes)


def _two_columns(path: str, name: str) -> Diagnosis:
    return error("E440", f"{path} has two columns {name}", notes=("rename one of them",))
