"""``backsolve sweep``: one solve for each row, as a table, or with ``--follow`` whole branches."""

from __future__ import annotations

import os
import sys
from argparse import Namespace
from collections.abc import Callable, Iterator, Sequence
from datetime import timedelta
from itertools import chain
from math import inf
from time import monotonic
from typing import TextIO

from rulesheets.deadline import WATCH, expired, setting
from rulesheets.diagnosis import plural, refusal
from rulesheets.inputs import readable, symbolic
from rulesheets.model import Value, Values, Variable
from rulesheets.syntax import escaped
from rulesheets.units import shown
from solver.commands import (
    GIVEN,
    UNITS,
    WANTED,
    Command,
    Request,
    read_request,
    tell_of_units,
)
from solver.commands.over import Swept, read_axes, read_swept
from solver.facts import Status
from solver.files import Printed, write_file
from solver.files.tables import Chunk, CsvFile, Table, free_name, joined, table_file
from solver.path.planner import planner
from solver.pictures import PICTURES, picture_kind
from solver.report import table
from solver.solution.solving import solve
from solver.sweeps import prepare
from solver.sweeps.curves import Branch, follow_sweep
from solver.sweeps.sweep import Sink, followed, heads, resumed, work_of
from solver.sweeps.sweep import run as streamed
from solver.sweeps.work import Work
from solver.sweeps.workers import solved_pieces

PAUSE = 0.5
"""Seconds between two states of the line, and before the first."""


class Progress:
    """The progress of a sweep on a terminal. Called with the number of finished rows.

    ``within`` counts rows of the current piece; ``end`` clears the line.
    """

    def __init__(self, stream: TextIO, total: int | None) -> None:
        self._stream, self._total, self._began, self._done = stream, total, monotonic(), 0
        self._due = self._began + PAUSE if stream.isatty() else inf

    def __call__(self, done: int) -> None:
        self._done = done
        self.within(0)

    def within(self, rows: int) -> None:
        if (now := monotonic()) >= self._due:
            self._due = now + PAUSE
            self._show(progress_line(self._done + rows, self._total, now - self._began))

    def end(self) -> None:
        """Clear the line, also for other output on the same terminal."""
        if self._due < inf:
            self._show("")

    def _show(self, line: str) -> None:
        self._stream.write(f"\r\x1b[K{line}")
        self._stream.flush()


def progress_line(done: int, total: int | None, seconds: float) -> str:
    """``1,200,000 of 4,000,000 rows  600,000.0 rows/s  0:00:05 left``."""
    line = f"{done:,} rows" if total is None else f"{done:,} of {total:,} rows"
    if done:
        line += f"  {done / seconds:,.1f} rows/s"
    if done and total is not None:
        line += f"  {timedelta(seconds=round((total - done) * seconds / done))} left"
    return line


ROWS_DRAWN = 1_000_000
"""Rows that a picture may have: all of them are held."""


class PlotSink:
    """Collects the rows and draws them after the last one.

    Raises RuleSheetError: E433 for an ending that is not of a picture, E445 for a sweep that cannot
    be drawn, E416.
    """

    def __init__(self, path: str, work: Work, swept: Swept) -> None:
        self._path, self._work, self._shape = path, work, swept.shape
        self._form = picture_kind(path, PICTURES)[1:]
        self._answer = work.answer
        self._pieces: list[Table] = []
        self._count(swept.total or 0)
        self._rows = 0

    def _count(self, rows: int) -> None:
        self._rows = rows
        if rows > ROWS_DRAWN:
            said, notes = f"a picture shows at most {ROWS_DRAWN:,} rows", ("take a larger step",)
            raise refusal("E445", said, None, *notes)

    def add(self, table: Table) -> None:
        self._count(self._rows + (int(table.begins().sum()) if self._answer else len(table.status)))
        self._pieces.append(table)

    def close(self) -> None:
        from solver.pictures import plot

        if not self._pieces:
            return
        model, turn = self._work.model, planner(self._work.model).graph.turn
        drawn, whole = (*model.variables, self._answer), joined(self._pieces)
        table = whole.having({n: column for n, column in whole.items() if n in drawn})
        shape = self._shape or (self._rows,)
        drawing = plot.arranged(table, self._work.inputs, shape, self._answer)
        angles = {name: around for name in table if (around := turn(name))}
        turns = {n: shown(a, model.variables[n], difference=True) for n, a in angles.items()}
        write_file(self._path, plot.plotted(drawing, model, turns, self._form))

    def discard(self) -> None:
        self._pieces = []


class Screenful:
    """Lines of a table on a terminal, with the digits of a solve."""

    def __init__(self, file: Printed, names: Sequence[str]) -> None:
        self._file, self._head = file, (*names, free_name("status", names))
        self.close, self.discard = file.keep, file.discard
        self._least: list[int] = []

    def add(self, piece: Table) -> None:
        rows = list(piece.lines())
        columns = zip(*filter(None, (self._head, *rows)), strict=True)
        self._least = self._least or [max(map(len, column)) for column in columns]
        self._file.write(f"{table(self._head, rows, self._least, soft=())}\n".encode())
        self._head = ()


def _printed(names: Sequence[str], clear: Callable[[], None] = lambda: None) -> Sink:
    """A table for people on a terminal, else CSV."""
    file = Printed(sys.stdout, clear)
    return Screenful(file, names) if sys.stdout.isatty() else CsvFile(file, names)


INTERRUPTED = 130


SWEEP = f"""\
{GIVEN}{WANTED}{UNITS}
--over NAME=START:STOP:STEP*   values of an input, or NAME=A,B,…; several make every combination
--zip                          combine several ranges value by value instead
--rows FILE                    take inputs from the columns of a CSV or Parquet file
--columns NAME,…*              take only these columns
--all                          give every answer a row of its own
--follow                       follow every branch of answers through its turning points
-o --output FILE.csv|.parquet  write the table instead of printing it
--resume                       continue with the rows that the file of -o lacks
--plot FILE.png|.svg|.pdf      draw the wanted variables over the swept one
--jobs N                       number of processes (automatic by default)
--jit                          compile to machine code; pays off from about 100,000 rows
--scheduler ADDRESS            solve on a dask cluster
"""


def _run(arguments: Namespace) -> int:
    """Sweep, write and print: exit code 0 if every row is solved, else 1; 130 if interrupted."""
    if arguments.follow:
        return follow(arguments)
    request = read_request(arguments)
    if arguments.rows:
        request = request._replace(files=(*request.files, arguments.rows))
    request.expect_output(arguments.output)
    request.expect_output(arguments.plot)
    swept = read_swept(arguments, request)
    work, before, chunks = _prepared(arguments, swept, request)
    progress = Progress(sys.stderr, swept.total)
    names, sinks = heads(work.names, work.model), list[Sink]()
    if arguments.output:
        sinks.append(table_file(arguments.output, names, symbolic(work.model)))
    if arguments.plot:  # after the table, which is in its place before the picture is drawn
        sinks.append(PlotSink(arguments.plot, work, swept))
    sinks = sinks or [_printed(names, progress.end)]
    pieces = solved_pieces(work, chunks, swept.total, arguments.jobs, arguments.scheduler)
    try:
        with setting(WATCH, progress.within):
            tables = chain(before, followed(work, pieces))
            outcome = streamed(tables, sinks, progress, work.model, work.every)
    finally:
        progress.end()
    if expired():
        print("the time was up: rows that were not solved by then are failed", file=sys.stderr)
    print(outcome, file=sys.stderr)  # 361 rows: 340 solved, 21 infeasible
    tell_of_units(work.model)
    if not outcome.interrupted:
        if outcome.unsolved and not expired():
            print(_reason(work, outcome.unsolved), end="", file=sys.stderr)
        return 0 if outcome.all_solved else 1
    of = "" if swept.total is None else f" of {swept.total:,}"
    path = arguments.output or arguments.plot
    place = f"; {escaped(path)} is whole, with these rows" if path else ""
    print(f"interrupted after {outcome.rows:,}{of} rows{place}", file=sys.stderr)
    return INTERRUPTED


def _reason(work: Work, row: Values) -> str:
    """Why a row is not solved, on a line: the message of its solve, and how that is cured."""
    known = {name: row[name] for name in work.inputs if row[name] == row[name]}
    given = {**dict.fromkeys(work.model.variables), **work.given, **known}
    result = solve(work.model, given, work.want, work.guesses)
    if result.status is Status.SOLVED or not result.diagnoses:
        return ""
    found = result.diagnoses[0]
    where = ", ".join(f"{n} = {_shown(v, work.model.variables[n])}" for n, v in known.items())
    return f"{where}: {'; '.join((found.message, *found.notes[:1]))}\n"


def _shown(value: Value, variable: Variable) -> str:
    return readable(value if isinstance(value, str) else shown(value, variable))


def _prepared(
    arguments: Namespace, swept: Swept, request: Request
) -> tuple[Work, list[Table], Iterator[Chunk]]:
    """The work of a sweep, the rows that an earlier run has left, and the remaining rows."""
    given = {name: value for name, value in request.inputs.items() if name not in swept.names}
    plan = prepare(request.model, swept.names, request.want, given, request.guesses)
    options = {"every": arguments.all, "jit": arguments.jit, "timeout": arguments.timeout}
    work = work_of(plan, swept.warmup, swept.line, **options)
    if arguments.resume and (arguments.all or not arguments.output):
        notes = ("add -o FILE, the file of the interrupted sweep", "--all and --follow start anew")
        said = "--resume needs a file to go on with, of one answer a row"
        raise refusal("E448", said, None, *notes)
    if not arguments.resume or not os.path.exists(arguments.output):
        return work, [], swept.chunks
    done, chunks = resumed(arguments.output, work, swept.chunks)
    return work, [done], chunks


ALONE = ("rows", "zip", "all", "plot", "jobs", "scheduler", "resume")
"""Options of a sweep row by row, which have no meaning for a curve."""


def follow(arguments: Namespace) -> int:
    """Follow and write branches: exit code 0 if there are any and only limits are singular."""
    request = read_request(arguments)
    request.expect_output(arguments.output)
    others = [f"; --{option} does not go with it" for option in ALONE if getattr(arguments, option)]
    if len(arguments.over) != 1 or others:
        said = f"a curve is followed over one range{''.join(others[:1])}"
        raise refusal("E447", said, None, "give one --over, and --want")
    ((name, axis),) = read_axes(arguments.over, request).items()
    model, given = request.model, {n: value for n, value in request.inputs.items() if n != name}
    table = follow_sweep(model, name, axis[:], request.want, given, request.guesses)
    names = heads(tuple(table), model)
    sink = _printed(names)
    if arguments.output:
        sink = table_file(arguments.output, names, symbolic(model))
    streamed(iter([table]), [sink], model=model)
    late, count = expired(), len(table.branches)
    if late:
        print("the time was up: there may be branches that were not found", file=sys.stderr)
    if count:
        branches = "1 branch" if count == 1 else f"{count} branches"
        print(f"{plural(len(table.status), 'row')} on {branches}", file=sys.stderr)
    elif not late:
        print(f"no value of {name} has an answer to begin at", file=sys.stderr)
    for branch in table.branches:
        print(f"branch {branch.number}: {_told(model.variables[name], branch)}", file=sys.stderr)
    limits = {limit.row for branch in table.branches for limit in branch.limits}
    solved = enumerate(table.solved.tolist())
    return 0 if len(table.status) and all(there or row in limits for row, there in solved) else 1


def _told(swept: Variable, branch: Branch) -> str:
    """A summary of a branch: its rows, where it turns back, and its ends."""
    there = ((shown(one.value, swept), one.greatest) for one in branch.limits)
    turns = ", ".join(f"{x:.12g} ({'greatest' if most else 'least'})" for x, most in there)
    back = f"; {swept.name} turns back at {turns}" if turns else ""
    ends = f"it begins where {branch.start}, and ends where {branch.end}"
    end = "it is closed" if branch.closed else ends
    return f"rows {branch.first + 1} to {branch.last}{back}; {end}"


COMMANDS = {"sweep": Command(SWEEP, _run)}
