"""What a sweep goes over: ranges (``--over``), or the columns of a file (``--rows``)."""

from __future__ import annotations

import sys
from argparse import Namespace
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import chain

from rulesheets.diagnosis import Diagnosis, Label, RuleSheetError, error, suggestion
from rulesheets.inputs import quantities
from rulesheets.model import Model, Variable
from rulesheets.units.quantity import scaling
from solver.commands.inputs import Option
from solver.commands.over import read_over
from solver.files.columns import Array
from solver.files.tables import heading, pieces
from solver.sweeps.chunks import Chunk, file_chunks, first_lessons, grid_chunks, grid_lessons


@dataclass(frozen=True)
class Swept:
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
        raise RuleSheetError(_either())
    if arguments.rows:
        return _file_rows(arguments.rows, arguments.columns, model)
    names, rows = read_over(arguments.over, model, side_by_side=arguments.zip)
    return Swept(names, len(rows), rows.shape, grid_chunks(rows), grid_lessons(rows))


def _file_rows(path: str, columns: Iterable[str], model: Model) -> Swept:
    """``columns`` are those to take; none means all."""
    written, total = heading(path)
    there = tuple(_parted(head)[0] for head in written)
    wanted = [name.strip() for text in columns for name in text.split(",") if name.strip()]
    if not any(name in model.variables for name in there):
        raise RuleSheetError(_no_rows(path, model))
    complaints = [_no_column(name, there, path) for name in wanted if name not in there]
    names = tuple(dict.fromkeys(wanted or there))
    complaints.extend(_unknown(name, model, path) for name in names if name not in model.variables)
    complaints.extend(_twice(name, path) for name in names if there.count(name) > 1)
    if complaints:
        raise RuleSheetError(*complaints)
    heads = [written[there.index(name)] for name in names]
    numbers = [head for head, name in zip(heads, names, strict=True) if name in quantities(model)]
    scales = [
        _scale(model.variables[name], _parted(head)[1]) for name, head in zip(names, heads, strict=True)
    ]
    read = (tuple(map(_scaled, piece, scales)) for piece in pieces(path, heads, numbers))
    chunks = file_chunks(read, total)
    first = next(chunks, ())
    return Swept(names, total, None, chain([first] if first else [], chunks), first_lessons(first))


def _parted(head: str) -> tuple[str, str]:
    """``v [km/h]`` as the name of a column and its unit, which may be empty."""
    name, bracket, unit = head.removesuffix("]").partition("[")
    return (name.strip(), unit.strip()) if bracket and head.endswith("]") else (head, "")


def _scale(variable: Variable, unit: str) -> tuple[float, float] | None:
    """Factor and shift from the unit of a column to that of its variable. Raises RuleSheetError."""
    return scaling(unit, variable) if unit and unit != variable.unit else None


def _scaled(column: Array, scale: tuple[float, float] | None) -> Array:
    return column if scale is None else column * scale[0] + scale[1]


def _either() -> Diagnosis:
    return error(
        "E443",
        "a sweep needs either ranges or a file of rows",
        notes=("give --over NAME=START:STOP:STEP, or --rows FILE",),
    )


def _no_column(name: str, there: tuple[str, ...], path: str) -> Diagnosis:
    return error(
        "E440",
        f"{path} has no column {name}",
        Label(Option("columns", name).place(name)),
        notes=(*suggestion(name, there), f"its columns are {', '.join(there)}"),
    )


def _unknown(name: str, model: Model, path: str) -> Diagnosis:
    """A column that is no variable is a mistake more often than not: nothing is left out in silence."""
    return error(
        "E440",
        f"{path} has a column {name}, and {model.name} no such variable",
        notes=(*suggestion(name, model.variables), "--columns NAME,… takes some of the columns alone"),
    )


def _no_rows(path: str, model: Model) -> Diagnosis:
    """Of a file that is nothing of the kind no word is shown."""
    notes = ("the first line of the file names variables",)
    return error("E440", f"{path} has no column that is a variable of {model.name}", notes=notes)


def _twice(name: str, path: str) -> Diagnosis:
    return error("E440", f"{path} has two columns {name}", notes=("rename one of them",))
