"""``backsolve chart``: what speed costs in accuracy on a sheet of one's own, and where methods fail."""

from __future__ import annotations

import csv
import math
import os
from argparse import ArgumentParser, Namespace
from collections import Counter
from collections.abc import Iterable, Sequence
from io import StringIO

from rulesheets.diagnosis import RuleSheetError, error
from rulesheets.syntax.source import escaped
from solver.commands.inputs import Option, Request, add_input_options, read_request
from solver.commands.measure import measure
from solver.commands.over import read_approach, read_axes
from solver.commands.running import Command
from solver.facts import Mark
from solver.files.replacing import write_file
from solver.pictures.drawing import require_matplotlib
from solver.report.table import table
from solver.report.text import result_text
from solver.solving import solve

COLUMNS = ("method", "tolerance", "at", "status", "error", "iterations", "seconds", "radius")
KINDS = (".png", ".svg", ".csv")
DPI = 130.0
MOST = 2_000
"""Values of a chart over an input: each is solved by every method several times."""


def chart_table(marks: Sequence[Mark]) -> str:
    """One line a method, at one set of inputs."""
    rows = (
        (
            mark.method,
            mark.status,
            _short(mark.error),
            "" if mark.radius is None else _short(mark.radius),
            "" if mark.iterations is None else str(mark.iterations),
            f"{1e6 * mark.seconds:.1f}",
        )
        for mark in marks
    )
    return table(("Method", "Status", "Error", "Radius", "Iterations", "µs"), rows)


def stability_table(marks: Sequence[Mark], name: str) -> str:
    """One line a method: values of the input that it solved, where it is worst, and the median time."""
    by_method: dict[str, list[Mark]] = {}
    for mark in marks:
        by_method.setdefault(mark.method, []).append(mark)
    heads = ("Method", "Solved", "False", "Nothing", "Worst error", f"at {name}", "µs")
    return table(heads, (_row(method, mine) for method, mine in by_method.items()))


def _row(method: str, marks: Sequence[Mark]) -> tuple[str, ...]:
    said = Counter(mark.status for mark in marks)
    silent = len(marks) - said["solved"] - said["false"]
    worst = max(marks, key=lambda mark: -1.0 if math.isnan(mark.error) else mark.error)
    median = sorted(mark.seconds for mark in marks)[len(marks) // 2]
    at = "" if math.isnan(worst.error) else f"{worst.at:.10g}"
    counts = f"{said['solved']} of {len(marks)}", str(said["false"]), str(silent)
    return method, *counts, _short(worst.error), at, f"{1e6 * median:.1f}"


def chart_csv(marks: Iterable[Mark]) -> str:
    """One line a measurement, all digits; empty where there is nothing."""
    text = StringIO()
    writer = csv.DictWriter(text, COLUMNS, extrasaction="ignore", lineterminator="\n")
    writer.writeheader()
    for mark in marks:
        writer.writerow({**mark._asdict(), "error": "" if math.isnan(mark.error) else mark.error})
    return text.getvalue()


def _short(error: float) -> str:
    return "" if math.isnan(error) else "0" if error == 0.0 else f"{error:.0e}"


def _arguments(parser: ArgumentParser) -> None:
    add_input_options(parser)
    along = parser.add_mutually_exclusive_group()
    along.add_argument("--over", metavar="NAME=START:STOP:STEP", help="a chart over the values of an input")
    along.add_argument("--approach", metavar="NAME=LIMIT:1e-1..1e-15", help="a chart towards a limit of it")
    parser.add_argument("-o", "--output", metavar="FILE", help="write the chart: .png, .svg or .csv")


def _run(arguments: Namespace) -> int:
    """Measure, print, draw; 0 where there is something to measure, 1 where the sheet has no answer."""
    path = arguments.output
    kind = "" if path is None else _kind(path)
    request = read_request(arguments)
    request.expect_output(path)
    name, places = _line(arguments, request)
    asked = request.model, request.inputs, request.want, request.guesses
    marks = tuple(measure(*asked, name, list(places)))
    if not marks:
        first = {**request.inputs, name: next(iter(places))} if name and places else request.inputs
        print(result_text(solve(request.model, first, want=request.want, guesses=request.guesses)))
        print("\nthere is no isolated answer to measure methods by")
        return 1
    print(chart_table(marks) if name is None else stability_table(marks, name))
    if path is not None:
        data = chart_csv(marks).encode() if kind == ".csv" else _drawn(request, marks, name, places, kind)
        write_file(path, data)
        print(f"\n{escaped(path)}")
    return 0


def _kind(path: str) -> str:
    kind = os.path.splitext(path)[1].lower()
    if kind not in KINDS:
        raise RuleSheetError(error("E433", f"{path}: a chart ends in {', '.join(KINDS[:-1])} or {KINDS[-1]}"))
    if kind != ".csv":
        require_matplotlib()
    return kind


def _line(arguments: Namespace, request: Request) -> tuple[str | None, dict[float, float]]:
    """The varied input, and where each of its values is drawn: at itself, or at its distance from a limit."""
    if arguments.approach:
        name, places = read_approach(arguments.approach, request.model)
        request.swept([name])
        return name, places
    if arguments.over:
        ((name, axis),) = read_axes([arguments.over], request.model).items()
        request.swept([name])
        values = axis.cut(0, min(len(axis), MOST + 1)).tolist()
        if len(values) > MOST or not all(isinstance(value, float) for value in values):
            said, note = f"a chart is over at most {MOST:,} numbers", "take a larger step"
            raise RuleSheetError(Option("over", arguments.over).wrong("E424", said, note))
        return name, {value: value for value in values}
    return None, {}


def _drawn(
    request: Request, marks: Sequence[Mark], name: str | None, places: dict[float, float], kind: str
) -> bytes:
    from solver.pictures.chart import speed_picture, stability_picture
    from solver.pictures.page import encode

    sheet = request.model.name
    if name is None:
        figure = speed_picture(marks, sheet)
    else:
        near = any(place != value for value, place in places.items())
        unit = request.model.variables[name].unit
        label = f"relative distance of {name} from its limit" if near else f"{name}, {unit}" if unit else name
        figure = stability_picture(marks, sheet, label, places if near else None)
    return encode(figure, kind[1:], DPI)


COMMANDS = {"chart": Command(_arguments, _run)}
