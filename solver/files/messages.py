"""What is said about files of rows: the wording of their diagnoses, side by side."""

from __future__ import annotations

from rulesheets.diagnosis import Diagnosis, Label, error
from rulesheets.syntax.source import Source, Span


def unreadable_rows(path: str, reason: str) -> Diagnosis:
    return error(
        "E440",
        f"{path} cannot be read as rows: {reason}",
        notes=("rows come from a CSV file with a heading of names, or from a Parquet file",),
    )


def uneven_row(path: str, line: int, cells: int, columns: int) -> Diagnosis:
    return error(
        "E440",
        f"line {line} of {path} has {cells} cells, and the heading {columns}",
        notes=("a row has a cell for each name of the heading; a cell may be blank",),
    )


def wrong_cell(path: str, line: int, text: str, name: str, *, number: bool = False) -> Diagnosis:
    kinds = "a number" if number else "a number, a symbol ('open)"
    place = Span(Source(f"{path}, line {line}", text), 0, len(text))
    return error(
        "E440",
        f"line {line} of {path}: this is no value for {name}",
        Label(place, ""),
        notes=(f"a cell is {kinds}, or blank where the row has no value",),
    )


def missing_extra(purpose: str, package: str, extra: str) -> Diagnosis:
    return error(
        "E441",
        f"{purpose} {package}, which is not installed",
        notes=(f"pip install 'backsolve[{extra}]'",),
    )


def unknown_form(path: str, forms: str) -> Diagnosis:
    return error(
        "E442",
        f"{path} has an ending that no table is written under",
        notes=(f"choose a name that ends in {forms}",),
    )


def output_is_input(path: str, read: str) -> Diagnosis:
    what = "it is read" if path == read else f"it is {read}, which is read"
    return error(
        "E418",
        f"{path} is an input of this command, and would be overwritten: {what}",
        notes=("write to another file",),
    )


def other_sweep(path: str, reason: str) -> Diagnosis:
    return error(
        "E448",
        f"{path} is not the beginning of this sweep: {reason}",
        notes=(
            "give the options that it was written with, or another file",
            "without --resume it is replaced",
        ),
    )
