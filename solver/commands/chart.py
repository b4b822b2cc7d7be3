"""``backsolve chart``: what speed costs in accuracy on a sheet of one's own, and where methods fail."""

from __future__ import annotations

import csv
import math
import os
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import asdict
from io import StringIO
from typing import TYPE_CHECKING

from rulesheets.diagnosis import Label, RuleSheetError, error, plural
from rulesheets.syntax.source import escaped
from solver.chart import FALSE, Mark, measure, measure_along
from solver.commands.inputs import Option, Request, add_input_options, read_request
from solver.commands.over import read_approach, read_axes
from solver.commands.running import Command
from solver.files.replacing import write_file
from solver.report.table import table
from solver.report.text import result_text
from solver.solving import solve

if TYPE_CHECKING:
    from argparse import ArgumentParser, Namespace

    from matplotlib.figure import Figure


COLUMNS = ("method", "tolerance", "at", "status", "error", "iterations", "seconds", "radius")


def chart_table(marks: Sequence[Mark]) -> str:
    """One line a method, at one set of inputs."""
    rows = [
        (
            mark.method,
            mark.status,
            _error(mark.error),
            "" if mark.radius is None else _error(mark.radius),
            "" if mark.iterations is None else str(mark.iterations),
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
    """How many were solved, false, or without an answer, by method."""
    counts: dict[str, Counter[str]] = {}
    for mark in marks:
        said = mark.status if mark.status in ("solved", "false") else "without an answer"
        counts.setdefault(mark.method, Counter())[said] += 1
    return "\n".join(f"{method}: {', '.join(_counted(count))}" for method, count in counts.items())


def _counted(count: Counter[str]) -> Iterator[str]:
    yield f"{count['solved']} of {plural(count.total(), 'point')} solved"
    yield from (f"{count[said]} {said}" for said in ("false", "without an answer") if count[said])


def chart_csv(marks: Iterable[Mark]) -> str:
    """One line a measurement, all digits; empty where there is nothing."""
    text = StringIO()
    writer = csv.DictWriter(text, COLUMNS, extrasaction="ignore", lineterminator="\n")
    writer.writeheader()
    for mark in marks:
        writer.writerow({**asdict(mark), "error": "" if math.isnan(mark.error) else mark.error})
    return text.getvalue()


def _cell(mark: Mark | None) -> str:
    if mark is None:
        return ""
    if math.isnan(mark.error):
        return mark.status
    return _error(mark.error) + (" false" if mark.status == "false" else "")


def _error(error: float) -> str:
    return "" if math.isnan(error) else "0" if error == 0.0 else f"{error:.0e}"


KINDS = (".png", ".svg", ".csv")
DPI = 130.0
MOST = 2_000
"""Values of a chart over an input: each is solved by every method several times."""


def _arguments(parser: ArgumentParser) -> None:
    add_input_options(parser)
    along = parser.add_mutually_exclusive_group()
    along.add_argument("--over", metavar="NAME=START:STOP:STEP", help="a chart over the values of an input")
    along.add_argument("--approach", metavar="NAME=LIMIT:1e-1..1e-15", help="a chart towards a limit of it")
    parser.add_argument("-o", "--output", metavar="FILE", help="write the chart: .png, .svg or .csv")


def _run(arguments: Namespace) -> int:
    """Measure, print, draw; 0 where there is something to measure, 1 where the sheet has no answer."""
    kind = _kind(arguments.output)
    request = read_request(arguments)
    request.expect_output(arguments.output)
    name, numbers, distances = _line(arguments, request)
    marks = _measured(request, name, numbers)
    if not marks:
        return _unsolved(request, name, numbers)
    if name is None:
        print(chart_table(marks))
    else:
        print(stability_table(marks, name), summary(marks), sep="\n\n")
    if kind == ".csv":
        _write(arguments.output, chart_csv(marks).encode())
    elif kind:
        from solver.pictures.page import encode

        places = dict(zip(numbers, distances, strict=True)) if distances else None
        figure = _drawn(request, marks, name, places)
        _write(arguments.output, encode(figure, kind[1:], DPI))
    return 0


def _kind(path: str | None) -> str:
    from solver.pictures.drawing import require_matplotlib

    if path is None:
        return ""
    kind = os.path.splitext(path)[1].lower()
    if kind not in KINDS:
        raise RuleSheetError(error("E433", f"{path}: a chart ends in {', '.join(KINDS[:-1])} or {KINDS[-1]}"))
    if kind != ".csv":
        require_matplotlib()
    return kind


def _line(arguments: Namespace, request: Request) -> tuple[str | None, list[float], list[float]]:
    """The varied input with its values, and their distances from a limit; no name where nothing varies."""
    if arguments.approach:
        name, numbers, distances = read_approach(arguments.approach, request.model)
        request.swept([name])
        return name, numbers, distances
    if arguments.over:
        ((name, axis),) = read_axes([arguments.over], request.model).items()
        request.swept([name])
        values = axis.cut(0, min(len(axis), MOST + 1)).tolist()
        if len(values) > MOST or not all(isinstance(value, float) for value in values):
            place = Label(Option("over", arguments.over).place(arguments.over))
            raise RuleSheetError(error("E424", f"a chart is over at most {MOST:,} numbers", place))
        return name, values, []
    return None, [], []


def _measured(request: Request, name: str | None, numbers: Sequence[float]) -> tuple[Mark, ...]:
    model, inputs, want, guesses = request.model, request.inputs, request.want, request.guesses
    if name is None:
        return measure(model, inputs, want, guesses)
    return tuple(measure_along(model, inputs, want, guesses, name, numbers))


def _unsolved(request: Request, name: str | None, numbers: Sequence[float]) -> int:
    """Say what ``solve`` says of the sheet: there is nothing to compare methods on."""
    inputs = {**request.inputs, name: numbers[0]} if name and numbers else request.inputs
    print(result_text(solve(request.model, inputs, want=request.want, guesses=request.guesses)))
    print("\nthere is no isolated answer to measure methods by")
    return 1


def _drawn(
    request: Request, marks: Sequence[Mark], name: str | None, places: dict[float, float] | None
) -> Figure:
    from solver.pictures.chart import speed_picture, stability_picture

    sheet = request.model.name
    if name is None:
        return speed_picture(marks, sheet, FALSE)
    unit = request.model.variables[name].unit
    label = f"{name}, {unit}" if unit else name
    label = f"relative distance of {name} from its limit" if places else label
    return stability_picture(marks, sheet, label, FALSE, places)


def _write(path: str, data: bytes) -> None:
    write_file(path, data)
    print(f"\n{escaped(path)}")


COMMANDS = {"chart": Command(_arguments, _run)}
