"""A sweep from its rows to its table: cut into pieces, solved, joined or written in order.

The cuts depend only on the rows, never on the time: a row can be solved from the answer of its
neighbour, so pieces decide the last bits. With the same cuts a sweep gives the same bytes in one
process, in several, and on a cluster.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from math import lcm, prod
from time import time
from typing import Any, NamedTuple, Protocol, TypeAlias

import numpy as np

from rulesheets.deadline import interrupted, time_limit
from rulesheets.diagnosis import RuleSheetError, refusal
from rulesheets.inputs import variable_named, variables_named, with_unit
from rulesheets.model import Model, Tolerance, Value, Values, expect
from rulesheets.units import displays, scaling
from solver.derivatives import tolerances_of
from solver.facts import Status
from solver.files import other_sweep, require_extra
from solver.files.tables import (
    CODES,
    SPREADS,
    WORDS,
    Array,
    Chunk,
    Column,
    Samples,
    Table,
    column_of,
    free_name,
    heading,
    joined,
    one_length,
    pieces,
    stacked,
)
from solver.solution.solving import Result
from solver.sweeps import Plan, prepare
from solver.sweeps.work import ENDLESS, Every, Primary, Rows, Work
from solver.sweeps.workers import one_interrupt, solved_pieces


def sweep(
    model: Model,
    inputs: Mapping[str, Column],
    want: Iterable[str] | None = None,
    *,
    grid: bool = False,
    all: bool = False,
    follow: bool = False,
    given: Mapping[str, Value | None] | None = None,
    guesses: Mapping[str, float] | None = None,
    jit: bool = False,
    jobs: int | None = 1,
    scheduler: object = None,
    timeout: float | None = None,
) -> Table:
    """Solve the model for every row of ``inputs``: arrays of one length; with ``grid``, each
    combination.

    ``inputs`` is a mapping of names to columns, or a data frame (pandas, polars, Arrow) with these
    columns. A column may be given with its unit, ``(values, "in")``, or as an array of pint. With
    ``all`` every answer has a row of its own and a number in the column ``answer`` (0: none), which
    stays with its branch from row to row. With ``jit`` the rows run through machine code (extra
    ``jit``), which pays off from about 1e5 of them. ``jobs`` processes share the work (None: as
    many as pay off), or the workers of a dask cluster, by the address of its ``scheduler``; the
    table is the same.

    With ``follow`` the curve of answers is followed through its turning points: rows are points
    along it, every branch has a number, and the table is a ``CurveTable`` with limit positions and
    ends.

    ``timeout``: seconds for the whole sweep; rows that are not solved by then are ``failed``.
    Raises RuleSheetError for unknown names, ValueError for arrays that are not columns of one
    length and for a wrong number of ``jobs``.
    """
    expect(Model, model)
    if not isinstance(inputs, Mapping):
        names = getattr(inputs, "column_names", None) or getattr(inputs, "columns", None)
        if names is None:
            kind = type(inputs).__name__
            raise TypeError(f"inputs are a mapping or a data frame, not of the type {kind}")
        inputs = {str(name): np.asarray(inputs[name]) for name in names}
    inputs = {name: _in_its_unit(model, name, column) for name, column in inputs.items()}
    if jobs is not None and jobs < 1:
        raise ValueError(f"{jobs} is no number of processes")
    if follow:
        from solver.sweeps.curves import follow_sweep

        if len(inputs) != 1:
            raise ValueError("a curve is followed over one swept variable")
        with time_limit(timeout):
            return follow_sweep(model, *next(iter(inputs.items())), want, given, guesses)
    if not len(inputs):
        raise ValueError("a sweep needs an input that varies")
    axes = tuple(column_of(values, name) for name, values in inputs.items())
    if not grid:
        one_length(tuple(inputs), axes)
    plan = prepare(model, inputs, want, given, guesses)
    rows = Grid(axes, zipped=not grid)
    work = work_of(plan, grid_warmup(rows), rows.shape[-1], every=all, jit=jit, timeout=timeout)
    chunks = grid_chunks(rows) if len(rows) else iter([rows.at(np.arange(0))])
    solved = solved_pieces(work, chunks, len(rows), jobs, scheduler)
    table = joined(list(followed(work, solved)))
    return Table(table, table.status, model.files, table.answers)


def _in_its_unit(model: Model, name: str, column: Any) -> Any:
    """``(values, "in")`` and arrays of pint in the unit of a variable; others unchanged."""
    variable, pair = variable_named(name, model), with_unit(column)
    if pair is None or (pair is column and not variable.unit):  # two symbols
        return column
    factor, shift = scaling(pair[1], variable)
    return np.asarray(pair[0], dtype=float) * factor + shift


def work_of(
    plan: Plan,
    warmup: Chunk = (),
    line: int = ENDLESS,
    *,
    every: bool = False,
    jit: bool = False,
    timeout: float | None = None,
) -> Work:
    """A plan as work that any process can do.

    Raises RuleSheetError (E441) if machine code is requested without its extra.
    """
    if jit:
        require_extra("jit", "machine code needs", "llvmlite")
    until = None if timeout is None else time() + timeout
    known = plan.model, plan.inputs, plan.want, plan.given, plan.guesses
    return Work(*known, warmup, every, jit, line, until)


def followed(work: Work, pieces: Iterator[Rows]) -> Iterator[Table]:
    """The pieces as tables, with branches kept: in the numbers of answers if all are wanted, else
    in the first. After an interrupt, rows from the first failed one on are dropped."""
    tabled = (Every if work.every else Primary)(work)
    for rows in pieces:
        failed = np.flatnonzero(rows.codes == CODES[Status.FAILED])
        if interrupted() and len(failed):
            yield tabled(rows.cut(0, int(failed[0])))
            return
        yield tabled(rows)


def monte_carlo(
    result: Result,
    samples: int = 1000,
    seed: int = 0,
    distribution: str = "uniform",
    tolerances: Mapping[str, float | Tolerance] | None = None,
    outputs: Iterable[str] | None = None,
) -> Samples:
    """Solve for ``samples`` draws of the inputs that have a tolerance, near the primary answer of
    ``result``.

    Inputs are drawn independently; the same ``seed`` gives the same draws. Of several answers of a
    sample the nearest to the primary one counts. ``tolerances`` override those of the sheet, in the
    units of the inputs. Raises ValueError for an unknown distribution, for less than two samples,
    and without an answer to start from; RuleSheetError for unknown names.
    """
    expect(Result, result, "solver.solve")
    if distribution not in SPREADS:
        raise ValueError(f"the distributions are {', '.join(SPREADS)}, not {distribution}")
    if samples < 2:
        raise ValueError("at least two samples are needed")
    if not result.solutions:
        raise ValueError("there is no answer to sample around")
    model, answer = result.model, result.solutions[0]
    sizes = tolerances_of(model, result.inputs, tolerances)
    numbers = {n: v for n, v in answer.items() if isinstance(v, float) and n not in result.inputs}
    named = () if outputs is None else variables_named(outputs, model)
    wanted = tuple(name for name in named or result.wanted if name in numbers)
    draw = np.random.default_rng(seed)
    # deviations in units of a tolerance
    kind = draw.normal if distribution == "normal" else draw.uniform
    ends = (0.0, SPREADS["normal"]) if distribution == "normal" else (-1.0, 1.0)
    pairs = ((float(result.inputs[name]), size) for name, size in sizes.items())
    columns = [middle + size * kind(*ends, samples) for middle, size in pairs]
    given = {name: result.inputs.get(name) for name in model.variables}
    plan = prepare(model, list(sizes), wanted, given, numbers)
    return Samples(plan.sweep(*columns), sizes, wanted, distribution, seed)


_EXACT = 2**53
"""Integers below this are floats."""


@dataclass(frozen=True)
class Stretch:
    """``start``, ``start + step``, …: ``count`` values, each the float nearest to the exact one."""

    start: Fraction
    step: Fraction
    count: int

    def __len__(self) -> int:
        return self.count

    def __getitem__(self, places: Array | slice) -> Array:
        """If numerator and denominator are exact floats (below 2^53), one division rounds once."""
        if isinstance(places, slice):
            places = np.arange(*places.indices(self.count))
        bottom = lcm(self.start.denominator, self.step.denominator)
        begin, each = int(self.start * bottom), int(self.step * bottom)
        span = each * (self.count - 1)
        if max(bottom, abs(begin), abs(span), abs(begin + span)) < _EXACT:
            return np.asarray((places * float(each) + begin) / bottom)
        return np.array([float(self.start + self.step * place) for place in places.tolist()])


Axis: TypeAlias = Stretch | Array
"""The values of one input: in equal steps, or one by one, objects where symbols are among them."""


@dataclass(frozen=True)
class Grid:
    """Every combination of the axes, the last one varying fastest; only the axes are stored.

    ``zipped``: the axes side by side instead, row k with the value k of each; all have one length.
    """

    axes: tuple[Axis, ...]
    zipped: bool = False

    def __len__(self) -> int:
        return prod(self.shape)

    @property
    def shape(self) -> tuple[int, ...]:
        """The last number is that of the rows of a line, along which only the last input
        changes."""
        return tuple(map(len, self.axes[:1] if self.zipped else self.axes))

    def at(self, places: Array) -> Chunk:
        along = [places] * len(self.axes) if self.zipped else np.unravel_index(places, self.shape)
        return tuple(axis[there] for axis, there in zip(self.axes, along, strict=True))


SMALLEST, LARGEST = 256, 65_536
LESSONS = 256


def size(done: int, total: int | None) -> int:
    """Rows of the next piece: few at first, so that slow rows show soon, and many of many."""
    limit = LARGEST if total is None else min(LARGEST, total // 16)
    return max(SMALLEST, min(limit, done // 4))


def grid_chunks(rows: Grid) -> Iterator[Chunk]:
    """Pieces of a grid, each made on demand."""
    total, done = len(rows), 0
    while done < total:
        end = min(total, done + size(done, total))
        yield rows.at(np.arange(done, end))
        done = end


def grid_warmup(rows: Grid, total: int | None = None) -> Chunk:
    """Some rows from all over a grid for records in advance: few enough to be cheap for ``total``
    rows, its own if that is None; none for a small grid."""
    count = min(LESSONS, (total or len(rows)) // 64)
    places = np.linspace(0, len(rows) - 1, count).astype(np.int64)
    return rows.at(places) if len(places) else ()


def file_chunks(pieces: Iterable[Chunk], total: int | None) -> Iterator[Chunk]:
    """Pieces of a file, independent of how it was cut when it was read."""
    done, waiting, held = 0, list[Chunk](), 0
    for piece in pieces:
        waiting.append(piece)
        held += len(piece[0])
        while held >= size(done, total):
            whole = tuple(map(stacked, zip(*waiting, strict=True)))
            count = size(done, total)
            yield tuple(column[:count] for column in whole)
            done, held = done + count, held - count
            waiting = [tuple(column[count:] for column in whole)]
    if held:
        yield tuple(map(stacked, zip(*waiting, strict=True)))


class Sink(Protocol):
    """Takes the pieces of a table in order; then it is closed, complete, or discarded."""

    def add(self, table: Table) -> None: ...
    def close(self) -> None: ...
    def discard(self) -> None: ...


def heads(names: Iterable[str], model: Model) -> tuple[str, ...]:
    """The headings of a table: ``v``, or ``v [km/h]`` for a unit other than that of the rules."""
    units = {name: f" [{model.variables[name].display_unit}]" for name in displays(model, names)}
    return tuple(name + units.get(name, "") for name in names)


def shown_columns(table: Table, model: Model) -> Table:
    """The columns in display units, by their names."""
    values = dict(table)
    for name, (factor, shift) in displays(model, values).items():
        values[name] = values[name].astype(float) * factor + shift
    return table.having(values)


def resumed(path: str, work: Work, chunks: Iterator[Chunk]) -> tuple[Table, Iterator[Chunk]]:
    """The rows of a file from an earlier run of a sweep, and the remaining chunks.

    Failed rows at its end are left out: they are solved again, perhaps with more time. Raises
    RuleSheetError: E448 for units that are not those of the rules, for a file with other columns or
    rows, E440, E441.
    """
    if found := next(iter(displays(work.model, work.names)), None):
        unit = work.model.variables[found].display_unit
        note = f"{found} is shown in {unit}; start anew, or show none so"
        raise refusal("E448", "--resume goes on in the units of the rules", None, note)
    names = (*work.names, free_name("status", work.names))
    if heading(path)[0] != names:
        raise RuleSheetError(other_sweep(path, "its columns are others"))
    read = list(pieces(path, names))
    nothing = [np.zeros(0) for _ in names]
    *columns, words = [stacked(column) for column in zip(*read, strict=True)] or nothing
    if not set(WORDS) >= set(words.tolist()):
        raise RuleSheetError(other_sweep(path, "it has rows without a status"))
    codes = np.array([WORDS.index(word) for word in words.tolist()], dtype=np.int8)
    done = np.flatnonzero(codes != CODES[Status.FAILED])
    values = dict(zip(work.names, columns, strict=True))
    values[work.names[-1]] = columns[-1].astype(np.int64)  # the numbers of answers
    table = Table(values, codes).rows(0, int(done[-1]) + 1 if len(done) else 0)
    return table, _after(path, table, chunks, work.inputs)


def _after(
    path: str, table: Table, chunks: Iterator[Chunk], inputs: Sequence[str]
) -> Iterator[Chunk]:
    """The remaining rows. Raises RuleSheetError (E448) if the earlier ones are different."""
    done, rows = 0, len(table.status)
    for chunk in chunks:
        count = min(len(chunk[0]), rows - done)
        for name, column in zip(inputs, chunk, strict=True):
            both = table[name][done : done + count], column[:count]
            one, other = ([None if v != v else v for v in part.tolist()] for part in both)
            if one != other:
                raise RuleSheetError(other_sweep(path, "its rows have other inputs"))
        done += count
        if count < len(chunk[0]):
            yield tuple(column[count:] for column in chunk)
    if done < rows:
        raise RuleSheetError(other_sweep(path, "it has more rows"))


class Outcome(NamedTuple):
    """``counts`` are the rows by status code, ``several`` those that show one of several answers;
    ``interrupted``: there would have been more. ``unsolved`` is the first row without an answer."""

    counts: tuple[int, ...]
    interrupted: bool = False
    several: int = 0
    unsolved: Values | None = None

    @property
    def rows(self) -> int:
        return sum(self.counts)

    @property
    def all_solved(self) -> bool:
        return self.counts[CODES[Status.SOLVED]] == self.rows

    def __str__(self) -> str:
        """``361 rows: 340 solved, 21 infeasible``."""
        if not self.rows:
            return "no rows"
        pairs = zip(self.counts, WORDS, strict=True)
        parts = ", ".join(f"{count:,} {status}" for count, status in pairs if count)
        rows = f"{self.rows:,} row{'s' * (self.rows > 1)}"
        have = "has" if self.several == 1 else "have"
        first = f"\n{self.several:,} of {rows} {have} several answers; the first of each is shown"
        return f"{rows}: {parts}{first if self.several else ''}"


def run(
    pieces: Iterator[Table],
    sinks: Sequence[Sink],
    progress: Callable[[int], None] | None = None,
    model: Model | None = None,
    every: bool = False,
) -> Outcome:
    """Hand every piece of a table to every sink, in the display units of a ``model``.

    ``every``: each answer has a row of its own. ``progress`` is called with the number of rows
    done. An interrupt ends the sweep and keeps what is done. Anything else that ends it early
    discards the sinks and is raised, as is a second interrupt.
    """
    counts, several, unsolved = np.zeros(len(WORDS), dtype=np.int64), 0, None
    with one_interrupt():
        try:
            for table in pieces:
                shown = table if model is None else shown_columns(table, model)
                for sink in sinks:
                    sink.add(shown)
                status = table.status[table.begins()] if every else table.status
                counts += np.bincount(status, minlength=len(WORDS))
                if unsolved is None and not table.solved.all():
                    row = int(np.argmin(table.solved))
                    unsolved = {name: column[row] for name, column in table.items()}
                several += 0 if every else int((table.answers > 1).sum())
                if progress is not None:
                    progress(int(counts.sum()))
            for sink in sinks:
                sink.close()
        finally:
            for sink in sinks:  # what is closed stays
                sink.discard()
        return Outcome(tuple(counts.tolist()), interrupted(), several, unsolved)
