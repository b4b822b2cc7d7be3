"""Records on arrays: rows that one settles at once, with all their answers, and the others one by one."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from rulesheets.model import Value
from solver.facts import Status
from solver.interruption import Interrupted
from solver.trace.arrays import ArrayKernel
from solver.trace.flow import Flow
from solver.trace.graph import NotCompilable, copied
from solver.trace.program import Program, counts, every
from solver.trace.records import Records

Array: TypeAlias = NDArray[Any]
Keep: TypeAlias = Callable[[Array, Status], None]
"""Takes the status of rows."""

WORTH = 16
"""So many rows pay for the set-up of a record on arrays."""


MANY = 512
"""So many rows that its quick form does not settle pay for the patient form of a record."""
LARGE = 800
"""Operations of blocks that take longer to compile to machine code than most sweeps take without it."""
TOGETHER = 2**17
"""Rows up to which the columns of a piece share a block of memory, which the next piece takes again."""


class Refusals:
    """The refusals of one pattern, on arrays."""

    def __init__(self, jit: bool = False) -> None:
        self.jit = jit
        self._kernels: dict[int, tuple[Program, Callable[..., None] | None]] = {}

    def left(self, program: Program, columns: Sequence[Array], left: Array, keep: Keep) -> Array:
        """The rows that are still left after a refusal had its turn."""
        kernel = self._kernel(program)
        if kernel is None or not len(left):
            return left
        holds = np.empty(len(left), dtype=bool)
        kernel([c if len(left) == len(c) else c[left] for c in columns], (holds,))
        if holds.any():
            keep(left[holds], Status.INFEASIBLE)
        return left[~holds]

    def _kernel(self, program: Program) -> Callable[..., None] | None:
        known = self._kernels.get(id(program))
        if known is None:
            kernel = None
            if not program.symbols:
                with suppress(NotCompilable):
                    holds = counts(program.flow, program.endings[0])
                    kernel = kernel_of(program.flow, (holds,), self.jit)
            known = program, kernel
            self._kernels[id(program)] = known  # the program is kept, so that its number stays its own
        return known[1]


def kernel_of(flow: Flow, wanted: Sequence[int], jit: bool, unrolled: bool = False) -> Callable[..., None]:
    """Machine code where it is asked for and can hold the functions, else blocks of numpy.

    ``unrolled``: roots of blocks by a few steps in straight lines.
    """
    if unrolled and flow.finders:
        flow, wanted = _unrolled(flow, wanted)
        jit = jit and len(flow.nodes) < LARGE
    if jit:
        from solver.trace.llvm import NativeKernel, available

        if not available():
            raise ImportError("machine code needs llvmlite: pip install 'backsolve[jit]'")
        with suppress(NotCompilable):
            return NativeKernel(flow, wanted)
    return ArrayKernel(flow, wanted)


def _unrolled(flow: Flow, wanted: Sequence[int]) -> tuple[Flow, list[int]]:
    target = Flow(flow.plain)
    places = [int(node[1]) for node in flow.nodes if node[0] == "input"]
    inputs = [target.input(place) for place in range(1 + max(places, default=-1))]
    return target, copied(flow, target, wanted, inputs)


def columns_of(number: int, count: int) -> list[Array]:
    """Columns (n,) to be filled."""
    if count <= TOGETHER:
        return list(np.empty((number, count)))
    return [np.empty(count) for _ in range(number)]


Outcome: TypeAlias = Callable[[int], tuple[Status, list[tuple[Value, ...]]]]
"""Solves a row: its status, and the wanted values of every answer."""


@dataclass(frozen=True)
class Answers:
    """The answers of rows: how many each has (n,), and a column for each wanted variable, row after row."""

    counts: Array
    values: list[Array]

    def first(self, rows: int) -> Answers:
        """Those of the first rows."""
        counts = self.counts[:rows]
        return Answers(counts, [column[: int(counts.sum())] for column in self.values])


class AnswerKernel:
    """One record on arrays: the answers of the rows that it settles, and a mask (n,) of these.

    First the roots of blocks get a few steps in straight lines, and rules the short form of their checks; the
    rows that are left get as many steps as they need. Answers are sorted in those rows alone whose order is
    not known beforehand.
    """

    def __init__(self, program: Program, jit: bool = False) -> None:
        if program.symbols:
            raise NotCompilable
        self.program, self.jit = program, jit
        sorts = bool(program.order.keys) and not program.order.usual
        self.symbols, self._known = self._compiled(in_order=sorts, quick=True)

    def _compiled(self, in_order: bool, quick: bool) -> tuple[tuple[tuple[str, ...] | None, ...], _Columns]:
        found = every(self.program, in_order, quick)
        nodes = [node for place in found.places for node in place.results]
        logical = (*found.there, found.holds, found.usual)
        kernel = kernel_of(self.program.flow, (*nodes, *logical), self.jit, quick)
        return found.symbols, _Columns(kernel, len(nodes), len(found.there))

    @cached_property
    def _sorted(self) -> _Columns:
        return self._compiled(in_order=True, quick=True)[1]

    @cached_property
    def _patient(self) -> _Columns:
        return self._compiled(in_order=bool(self.program.order.keys), quick=False)[1]

    def __call__(self, columns: Sequence[Array]) -> tuple[Answers, Array]:
        found, there, holds, usual = self._known(columns)
        if not (usual | ~holds).all():
            self._replace(self._sorted, columns, holds & ~usual, found, there, holds)
        if len(holds) - np.count_nonzero(holds) > MANY:
            self._replace(self._patient, columns, ~holds, found, there, holds)
        there &= holds
        if len(there) == 1:
            values = found if holds.all() else [column[holds] for column in found]
        else:
            values = self._one_below_the_other(found, there)
        named = [self._named(column, words) for column, words in zip(values, self.symbols, strict=True)]
        counts = there.sum(axis=0, dtype=np.int64)
        return Answers(counts if holds.all() else counts[holds], named), holds

    @staticmethod
    def _replace(
        kernel: _Columns,
        columns: Sequence[Array],
        mask: Array,
        found: list[Array],
        there: Array,
        holds: Array,
    ) -> None:
        """Ask another kernel about some rows."""
        rows = np.flatnonzero(mask)
        again, others, still, _ = kernel([column[rows] for column in columns])
        for column, values in zip((*found, *there, holds), (*again, *others, still), strict=True):
            column[rows] = values

    def _one_below_the_other(self, found: list[Array], there: Array) -> list[Array]:
        wanted = len(self.symbols)
        if (there[0] & (there[1:] == there[0]).all(axis=0)).all():  # every row has them all
            return [np.stack(found[name::wanted], axis=1).ravel() for name in range(wanted)]
        these = there.T
        return [np.stack(found[name::wanted], axis=1)[these] for name in range(wanted)]

    @staticmethod
    def _named(column: Array, words: tuple[str, ...] | None) -> Array:
        return column if words is None else np.array(words, dtype=object)[column.astype(np.intp)]


@dataclass(frozen=True)
class _Columns:
    """A kernel, and how many numbers and places of answers it has results of."""

    kernel: Callable[..., None]
    numbers: int
    places: int

    def __call__(self, columns: Sequence[Array]) -> tuple[list[Array], Array, Array, Array]:
        count = len(columns[0])
        found = columns_of(self.numbers, count)
        logical = np.empty((self.places + 2, count), dtype=bool)
        self.kernel(columns, (*found, *logical))
        return found, logical[:-2], logical[-2], logical[-1]


class AnswerSweeper:
    """The rows of sweeps of one pattern, with every answer of each."""

    def __init__(self, records: Records, jit: bool = False) -> None:
        self.records, self.jit = records, jit
        self._refusals = Refusals(jit)
        self._kernels: dict[int, tuple[Program, AnswerKernel | None]] = {}

    def run(self, columns: Sequence[Array], wanted: int, outcome: Outcome, keep: Keep) -> Answers:
        """The answers of the rows of ``columns`` (n,): by the records there are and those made of its rows.

        ``outcome`` has the word on a row that no record settles (and learns from it); ``keep`` is told the
        status of rows that are not solved.
        """
        known = set(map(id, self.records.programs))
        self._kernels = {key: kernel for key, kernel in self._kernels.items() if key in known}
        parts: list[tuple[Array, Answers]] = []
        count = len(columns[0])
        left = np.arange(count)
        records = refusals = 0
        alone: dict[int, list[tuple[Value, ...]]] = {}
        while len(left):
            if len(left) > WORTH:
                for program in self.records.programs[records:]:
                    left = self._settled(program, columns, left, parts)
                for program in self.records.refusals[refusals:]:
                    left = self._refusals.left(program, columns, left, keep)
            records, refusals = len(self.records.programs), len(self.records.refusals)
            for row in left.tolist():
                try:
                    status, alone[row] = outcome(row)
                except KeyboardInterrupt:
                    parts += [_one_by_one(alone, wanted)] if alone else []
                    raise Interrupted(row, together(parts, count, wanted)) from None
                left = left[1:]
                if status is not Status.SOLVED:
                    keep(np.array([row]), status)
                if (records, refusals) != (len(self.records.programs), len(self.records.refusals)):
                    break  # what was learned may settle the others
        if alone:
            parts.append(_one_by_one(alone, wanted))
        return together(parts, count, wanted)

    def _settled(
        self, program: Program, columns: Sequence[Array], left: Array, parts: list[tuple[Array, Answers]]
    ) -> Array:
        """The rows that are still left after a record had its turn."""
        kernel = self._kernel(program)
        if kernel is None or not len(left):
            return left
        found, holds = kernel([c if len(left) == len(c) else c[left] for c in columns])
        if holds.all():
            parts.append((left, found))
            return left[:0]
        if holds.any():
            parts.append((left[holds], found))
        return left[~holds]

    def _kernel(self, program: Program) -> AnswerKernel | None:
        known = self._kernels.get(id(program))
        if known is None:
            try:
                known = program, AnswerKernel(program, self.jit)
            except NotCompilable:
                known = program, None
            self._kernels[id(program)] = known  # the program is kept, so that its number stays its own
        return known[1]


def _one_by_one(alone: dict[int, list[tuple[Value, ...]]], wanted: int) -> tuple[Array, Answers]:
    """Rows that were solved one by one."""
    rows = np.fromiter(alone, dtype=np.intp, count=len(alone))
    counts = np.array([len(found) for found in alone.values()])
    return rows, Answers(counts, written([values for found in alone.values() for values in found], wanted))


def written(answers: Sequence[tuple[Value, ...]], wanted: int) -> list[Array]:
    """Answers as columns."""
    columns: list[Sequence[Value]] = list(zip(*answers, strict=True)) or [()] * wanted
    symbolic = [any(isinstance(value, str) for value in column) for column in columns]
    return [np.array(c, dtype=object if odd else float) for c, odd in zip(columns, symbolic, strict=True)]


def together(parts: list[tuple[Array, Answers]], count: int, wanted: int) -> Answers:
    """The answers of all rows, in their order."""
    if len(parts) == 1 and len(parts[0][0]) == count:
        return parts[0][1]
    counts = np.zeros(count, dtype=np.int64)
    for rows, found in parts:
        counts[rows] = found.counts
    starts = np.cumsum(counts) - counts
    symbolic = [any(f.values[k].dtype == object for _, f in parts) for k in range(wanted)]
    values: list[Array] = [np.empty(counts.sum(), dtype=object if odd else float) for odd in symbolic]
    for rows, found in parts:
        before = np.cumsum(found.counts) - found.counts
        places = np.repeat(starts[rows] - before, found.counts) + np.arange(found.counts.sum())
        for column, here in zip(values, found.values, strict=True):
            column[places] = here
    return Answers(counts, values)
