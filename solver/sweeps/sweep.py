"""Many solves of one plan: sweeps, a status for each row; and samples drawn within tolerances."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from importlib.util import find_spec
from math import inf
from time import time
from typing import Any

import numpy as np

from rulesheets.deadline import Interrupted, time_limit
from rulesheets.diagnosis import RuleSheetError
from rulesheets.inputs import variable_named, variables_named
from rulesheets.model import Model, Tolerance, Value, expect_model
from rulesheets.units import scaling
from solver.derivatives import tolerances_of
from solver.files import missing_extra
from solver.files.tables import Chunk, Column, Table, column_of, joined, one_length
from solver.path.planner import planner
from solver.result import SPREADS, Result, Samples
from solver.sweeps import Plan, prepare
from solver.sweeps.stream import Grid, grid_chunks, grid_lessons
from solver.sweeps.work import ENDLESS, Branches, Follower, Solved, Work
from solver.sweeps.workers import solved_pieces


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
    """Solve the model for every row of ``inputs``: arrays of one length; with ``grid``, each combination.

    ``inputs`` is a mapping of names to columns, or a data frame (pandas, polars, Arrow) with these columns.
    A column may be given with its unit, ``(values, "in")``, or as an array of pint.
    With ``all`` every answer has a row of its own and a number in the column ``answer`` (0: none),
    which stays with its branch from row to row. With ``jit`` the rows run through machine code (extra
    ``jit``), which pays from about 1e5 of them. ``jobs`` processes share the work (None: as many as pay),
    or the workers of a dask cluster, by the address of its ``scheduler``; the table is the same.

    With ``follow`` the curve of answers is followed through its turning points: rows are points along it,
    every branch has a number, and the table is a ``CurveTable``, which knows limit positions and ends.

    ``timeout``: seconds for the whole sweep; rows that are not solved by then are ``failed``.

    Raises RuleSheetError for unknown names, ValueError for arrays that are no columns of one length and for
    a wrong number of ``jobs``.
    """
    expect_model(model)
    if not isinstance(inputs, Mapping):
        names = getattr(inputs, "column_names", None) or getattr(inputs, "columns", None)
        if names is None:
            raise TypeError(f"inputs are a mapping or a data frame, not of the type {type(inputs).__name__}")
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
    work = work_of(plan, grid_lessons(rows), rows.shape[-1], every=all, jit=jit, timeout=timeout)
    chunks = grid_chunks(rows) if len(rows) else iter([rows.at(np.arange(0))])
    solved = solved_pieces(work, chunks, len(rows), jobs, scheduler)
    table = joined([piece.table for piece in followed(work, solved)])
    return Table(table, table.status, model.files, table.answers)


def _in_its_unit(model: Model, name: str, column: Any) -> Any:
    """``(values, "in")`` and arrays of pint in the unit of a variable; all else as it is."""
    variable = variable_named(name, model)
    if isinstance(column, tuple) and len(column) == 2 and isinstance(column[1], str) and variable.unit:
        values, unit = column
    elif hasattr(column, "to_base_units"):
        base = column.to_base_units()
        values, unit = base.magnitude, f"{base.units:C}"
    else:
        return column
    factor, shift = scaling(unit, variable)
    return np.asarray(values, dtype=float) * factor + shift


def work_of(
    plan: Plan,
    lessons: Chunk = (),
    line: int = ENDLESS,
    *,
    every: bool = False,
    jit: bool = False,
    timeout: float | None = None,
) -> Work:
    """A plan as something that any process can do.

    Raises RuleSheetError (E441) where machine code is asked for and its extra is not there.
    """
    if jit and find_spec("llvmlite") is None:
        raise RuleSheetError(missing_extra("machine code needs", "llvmlite", "jit"))
    until = None if timeout is None else time() + timeout
    known = plan.model, plan.inputs, plan.want, plan.given, plan.guesses
    return Work(*known, lessons, every, jit, line, until)


def followed(work: Work, pieces: Iterator[Solved]) -> Iterator[Solved]:
    """The pieces with branches kept: in the numbers of answers where all are asked for, else in the first."""
    turn = planner(work.model).graph.turn
    follow: Callable[[Solved], Solved]
    if work.every:
        answer, *wanted = work.names[len(work.inputs) :]
        follow = Follower(answer, wanted, {name: turn(name) or inf for name in wanted}, work.line)
    else:
        follow = Branches(work, np.array([turn(name) or inf for name in work.want]))
    try:
        yield from map(follow, pieces)
    except Interrupted as reached:
        raise Interrupted(reached.rows, tuple(map(follow, reached.kept))) from None


def monte_carlo(
    result: Result,
    samples: int = 1000,
    seed: int = 0,
    distribution: str = "uniform",
    tolerances: Mapping[str, float | Tolerance] | None = None,
    outputs: Iterable[str] | None = None,
) -> Samples:
    """Solve for ``samples`` draws of the inputs that have a tolerance, near the primary answer of ``result``.

    Inputs are drawn independently of one another; the same ``seed`` gives the same draws. Of several
    answers of a sample the nearest to the primary one counts. ``tolerances`` override those of the sheet,
    in the units of the inputs.

    Raises ValueError for an unknown distribution, for less than two samples, and where nothing is solved to
    start from; RuleSheetError for unknown names.
    """
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
    columns = []
    for name, size in sizes.items():  # deviations in units of a tolerance
        normal = distribution == "normal"
        off = draw.normal(0.0, SPREADS["normal"], samples) if normal else draw.uniform(-1.0, 1.0, samples)
        columns.append(float(result.inputs[name]) + size * off)
    given = {name: result.inputs.get(name) for name in model.variables}
    plan = prepare(model, list(sizes), wanted, given, numbers)
    return Samples(plan.sweep(*columns), sizes, wanted, distribution, seed)
