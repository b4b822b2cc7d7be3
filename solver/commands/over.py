"""Values of inputs on the command line (``--over``, ``--approach``); states of a drawing."""

from __future__ import annotations

import math
import re
import sys
from argparse import Namespace
from collections.abc import Iterable, Iterator, Sequence
from fractions import Fraction
from itertools import chain
from typing import NamedTuple

import numpy as np

from rulesheets.diagnosis import Diagnosis, RuleSheetError, error_at, refusal, refuse, suggestion
from rulesheets.inputs import (
    not_finite,
    parse_input,
    parse_value,
    quantities,
    symbol_for_number,
    variable_named,
)
from rulesheets.model import Model, Value, Variable
from rulesheets.units import converted, scaling, value_and_unit
from solver.commands import Option, Request
from solver.files.tables import Chunk, column_of, heading, pieces
from solver.sweeps.sweep import Axis, Grid, Stretch, file_chunks, grid_chunks, grid_warmup

LIMIT = 10**12
"""The most rows of a sweep."""

_DECIMAL = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d{1,3})?", re.ASCII)


def read_axes(texts: Iterable[str], request: Request) -> dict[str, Axis]:
    """The values by name, in the given order.

    Raises RuleSheetError for invalid values, and for names that other options give.
    """
    axes: dict[str, Axis] = {}
    model = request.model
    for text in texts:
        option = Option("over", text)
        name, _, stretch = (part.strip() for part in text.partition("="))
        if not name or not stretch:
            raise RuleSheetError(_no_range(option))
        variable = variable_named(name, model, option.place(name))
        if name in axes:
            raise RuleSheetError(option.repeated(name))
        axes[name] = _axis(option, variable, stretch, model)
    request.swept(axes)
    return axes


def _axis(option: Option, variable: Variable, stretch: str, model: Model) -> Axis:
    """A range, or a list; one value is a list of one."""
    if ":" not in stretch:
        return column_of(_listed(option, variable, stretch, model), variable.name)
    head, _, end = stretch.rpartition(":")
    if measured := value_and_unit(end):  # 0:90:5deg: a range in a unit, in that of the variable
        number, unit = measured
        numbers = _axis(option, variable, f"{head}:{number}", model)[:].tolist()
        return column_of(converted(numbers, unit, variable, option.place(unit)), variable.name)
    if stretch.count(":") != 2:
        raise RuleSheetError(_no_range(option))
    exact = []
    for part in map(str.strip, stretch.split(":")):  # decimals as they are written, else as floats
        decimal = _DECIMAL.fullmatch(part)
        value = part if decimal else parse_value(part, option.place(part))
        if isinstance(value, str) and not decimal:
            raise RuleSheetError(_no_range(option))
        exact.append(Fraction(value))
    start, stop, step = exact
    if step == 0 or (stop - start) / step < 0:
        message = "this step never leads from the start to the stop"
        note = "the step is not 0, and negative where the stop is below the start"
        raise RuleSheetError(option.wrong("E424", message, note, option.text.rpartition(":")[2]))
    count = int((stop - start) / step) + 1
    if count > LIMIT:
        raise RuleSheetError(_too_many(option))
    if max(abs(start), abs(start + step * (count - 1))) > Fraction(sys.float_info.max):
        raise RuleSheetError(not_finite("it is too large for a float", option.place(stretch)))
    return Stretch(start, step, count)


def _listed(option: Option, variable: Variable, text: str, model: Model) -> list[float | str]:
    """The values of a list. Raises RuleSheetError for a symbol if only numbers are allowed."""
    *parts, end = (part.strip() for part in text.split(","))
    last = value_and_unit(end)
    if last is not None and not any(map(value_and_unit, parts)):  # 1,2,5 in: the unit of all
        parts = [f"{part} [{last[1]}]" for part in parts]
    values: list[float | str] = []
    for part in (*parts, end):
        value, _ = parse_input(part, option.place(part), variable)
        if isinstance(value, str) and variable.name in quantities(model):
            raise RuleSheetError(symbol_for_number(value, variable, model, option.place(part)))
        values.append(value)
    return values


def _no_range(option: Option) -> Diagnosis:
    note = "write --over NAME=START:STOP:STEP, such as NAME=0:360:5, or --over NAME=1,2,5"
    return option.wrong("E424", "--over needs a name and a range or a list", note)


def _too_many(option: Option) -> Diagnosis:
    return option.wrong("E424", f"this sweep has more than {LIMIT:,} rows", "take a larger step")


A_DECADE, MOST = 2, 200
"""Points a decade, and at all."""


def read_approach(text: str, model: Model) -> tuple[str, dict[float, float]]:
    """The input, and its values with their distances from the limit, the farthest first.

    Distances are relative to the limit (absolute if that is 0), and counted towards 0; negative
    ones lie beyond. Raises RuleSheetError for invalid text.
    """
    option, (head, _, ends) = Option("approach", text), text.rpartition(":")
    name, _, written = (part.strip() for part in head.partition("="))
    needed = "a name, a limit, and the relative distances of the first and the last value"
    message = f"--approach needs {needed}"
    note = "write --approach NAME=LIMIT:1e-1..1e-15, with the limit as a number"
    unread = RuleSheetError(option.wrong("E424", message, note))
    try:
        first, last = map(float, ends.split(".."))
        count = round(abs(math.log10(last / first)) * A_DECADE) + 1
    except (ValueError, ArithmeticError):
        raise unread from None
    if not name or not written or count > MOST:
        raise unread
    variable_named(name, model, option.place(name))
    limit = parse_value(written, option.place(written))
    if isinstance(limit, str):
        raise unread
    distances = np.geomspace(first, last, count).tolist()
    numbers = [limit * (1.0 - d) if limit else d for d in distances]
    pairs = zip(numbers, map(abs, distances), strict=True)
    return name, {number: distance for number, distance in pairs if number != limit}


FRAMES = 100_000
"""Values that a range may have: a film of an hour and a half."""


def read_states(
    texts: Sequence[str], request: Request
) -> tuple[dict[str, list[Value]], dict[str, list[float]]]:
    """The states of a drawing: lists of values (``branch=open,crossed``), and at most one range.

    Raises RuleSheetError for other texts, for names that are given twice, and for a second range.
    """
    ranges = [text for text in texts if ":" in text]
    if len(ranges) > 1:
        note = "list the values of the other variable: they stand side by side"
        wrong = Option("over", ranges[1]).wrong("E424", "a film runs over one range", note)
        raise RuleSheetError(wrong)
    axes = read_axes(texts, request)
    moving = ranges[0].partition("=")[0].strip() if ranges else None
    if moving is not None and len(axes[moving]) > FRAMES:
        message = f"a film has at most {FRAMES:,} frames"
        raise RuleSheetError(Option("over", ranges[0]).wrong("E424", message, "take a larger step"))
    values = {name: axis[:].tolist() for name, axis in axes.items()}
    motion = {} if moving is None else {moving: values.pop(moving)}
    return values, motion


class Swept(NamedTuple):
    """The rows of a sweep: the inputs by name, and their rows in pieces.

    ``total`` is the number of rows if known, ``shape`` that of the grid, if there is one.
    """

    names: tuple[str, ...]
    total: int | None
    shape: tuple[int, ...] | None
    chunks: Iterator[Chunk]
    warmup: Chunk

    @property
    def line(self) -> int:
        """Rows in which only the last input changes."""
        return self.shape[-1] if self.shape else sys.maxsize


def read_swept(arguments: Namespace, request: Request) -> Swept:
    """The rows of ``--over`` or ``--rows``.

    Raises RuleSheetError for invalid texts, and for ranges that cannot be combined.
    """
    if bool(arguments.over) == bool(arguments.rows):
        note = "give --over NAME=START:STOP:STEP, or --rows FILE"
        raise refusal("E443", "a sweep needs either ranges or a file of rows", None, note)
    if arguments.rows:
        return _file_rows(arguments.rows, arguments.columns, request)
    axes = read_axes(arguments.over, request)
    lengths = {name: len(axis) for name, axis in axes.items()}
    first, length = next(iter(lengths.items()))
    if not arguments.zip and math.prod(lengths.values()) > LIMIT:
        raise RuleSheetError(_too_many(Option("over", arguments.over[-1])))
    for (name, other), text in zip(lengths.items(), arguments.over, strict=True):
        if arguments.zip and other != length:
            each = f"{first} has {length:,}, {name} has {other:,}"
            message = f"with --zip all have one length: {each}"
            note = "leave --zip out to sweep every combination"
            raise RuleSheetError(Option("over", text).wrong("E424", message, note))
    rows = Grid(tuple(axes.values()), zipped=arguments.zip)
    return Swept(tuple(axes), len(rows), rows.shape, grid_chunks(rows), grid_warmup(rows))


def _file_rows(path: str, columns: Iterable[str], request: Request) -> Swept:
    """The rows of a file; ``columns`` selects columns, all if empty."""
    model, (written, total) = request.model, heading(path)
    there, units = zip(*map(_name_and_unit, written), strict=True) if written else ((), ())
    wanted = [name.strip() for text in columns for name in text.split(",") if name.strip()]
    names = tuple(dict.fromkeys(wanted or there))
    _expect_columns(path, there, wanted, model)
    request.swept(names)
    places = [there.index(name) for name in names]
    heads = [written[place] for place in places]
    numbers = [head for head, name in zip(heads, names, strict=True) if name in quantities(model)]
    scales: list[tuple[float, float]] = []
    for name, place in zip(names, places, strict=True):
        variable, unit = model.variables[name], units[place]
        scales.append(scaling(unit, variable) if unit and unit != variable.unit else (1.0, 0.0))

    def scaled(piece: Chunk) -> Chunk:
        pairs = zip(piece, scales, strict=True)
        return tuple(x if by == (1.0, 0.0) else x * by[0] + by[1] for x, by in pairs)

    chunks = file_chunks(map(scaled, pieces(path, heads, numbers)), total)
    first = next(chunks, ())
    warmup = grid_warmup(Grid(first, zipped=True), 16 * len(first[0])) if first else ()
    return Swept(names, total, None, chain([first] if first else [], chunks), warmup)


def _name_and_unit(head: str) -> tuple[str, str]:
    """``v [km/h]`` as the name of a column and its unit, which may be empty."""
    name, bracket, unit = head.removesuffix("]").partition("[")
    return (name.strip(), unit.strip()) if bracket and head.endswith("]") else (head, "")


def _expect_columns(path: str, there: Sequence[str], wanted: Sequence[str], model: Model) -> None:
    """Raise RuleSheetError (E440) unless the wanted columns (all if none is given) are variables.

    A column that is not is usually a mistake: nothing is left out silently.
    """
    if not any(name in model.variables for name in there):
        # of another file show no word
        message = f"{path} has no column that is a variable of {model.name}"
        raise refusal("E440", message, None, "the first line of the file names variables")
    complaints = []
    for name in wanted:
        if name not in there:
            place, near = Option("columns", name).place(name), suggestion(name, there)
            message, named = f"{path} has no column {name}", f"its columns are {', '.join(there)}"
            complaints.append(error_at("E440", message, place, *near, named))
    for name in dict.fromkeys(wanted or there):
        if name not in model.variables:
            near, some = suggestion(name, model.variables), "takes some of the columns alone"
            message = f"{path} has a column {name}, and {model.name} no such variable"
            complaints.append(error_at("E440", message, None, *near, f"--columns NAME,… {some}"))
        if there.count(name) > 1:
            message = f"{path} has two columns {name}"
            complaints.append(error_at("E440", message, None, "rename one of them"))
    refuse(complaints)
