"""Measurements as a table for the terminal, and as CSV."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

from rulesheets.diagnosis import plural
from solver.chart.measure import Mark
from solver.report.table import table

COLUMNS = ("method", "tolerance", "at", "status", "error", "iterations", "seconds", "radius")


def chart_table(marks: Sequence[Mark]) -> str:
    """One line a method, at one set of inputs."""
    rows = [
        (
            mark.method,
            mark.status,
            _error(mark.error),
            "" if mark.radius is None else _error(mark.radius),
            _count(mark.iterations),
            f"{1e6 * mark.seconds:.1f}",
        )
        for mark in marks
    ]
    return table(("Method", "Status", "Error", "Radius", "Iterations", "µs"), rows)


def stability_table(marks: Sequence[Mark], name: str) -> str:
    """One line a value of the input, one column a method: its error, or what it said instead."""
    methods = tuple(dict.fromkeys(mark.method for mark in marks))
    found = {(mark.at, mark.method): mark for mark in marks}
    rows = [
        (repr(at), *(_cell(found.get((at, method))) for method in methods))
        for at in dict.fromkeys(mark.at for mark in marks)
    ]
    return table((name, *methods), rows)


def summary(marks: Iterable[Mark]) -> str:
    """How many were solved, false, or without an answer, by family."""
    marks = tuple(marks)
    lines = []
    for method in dict.fromkeys(mark.method for mark in marks):
        mine = [mark for mark in marks if mark.method == method]
        solved, false = (sum(mark.status == status for mark in mine) for status in ("solved", "false"))
        parts = [f"{solved} of {plural(len(mine), 'point')} solved"]
        parts += [f"{false} false"] if false else []
        parts += [f"{len(mine) - solved - false} without an answer"] if solved + false < len(mine) else []
        lines.append(f"{method}: {', '.join(parts)}")
    return "\n".join(lines)


def chart_csv(marks: Iterable[Mark]) -> str:
    """One line a measurement, all digits; empty where there is nothing."""
    lines = [",".join(COLUMNS)]
    for mark in marks:
        cells = (
            mark.method,
            "" if mark.tolerance is None else repr(mark.tolerance),
            "" if mark.at is None else repr(mark.at),
            mark.status,
            "" if math.isnan(mark.error) else repr(mark.error),
            "" if mark.iterations is None else str(mark.iterations),
            repr(mark.seconds),
            "" if mark.radius is None else repr(mark.radius),
        )
        lines.append(",".join(f'"{cell}"' if "," in cell else cell for cell in cells))
    return "\n".join(lines) + "\n"


def _cell(mark: Mark | None) -> str:
    if mark is None:
        return ""
    if math.isnan(mark.error):
        return mark.status
    return _error(mark.error) + (" false" if mark.status == "false" else "")


def _error(error: float) -> str:
    return "" if math.isnan(error) else "0" if error == 0.0 else f"{error:.0e}"


def _count(iterations: int | None) -> str:
    return "" if iterations is None else str(iterations)
