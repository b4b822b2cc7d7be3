"""Records on arrays: rows that one covers at once, with all their answers, and the others one by
one."""

from __future__ import annotations

from collections.abc import Callable, Container, Iterator, Sequence
from contextlib import suppress
from functools import cached_property
from itertools import chain
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from rulesheets.model import Row
from solver.facts import Status
from solver.ranking.branches import (
    Answers,
    continued,
    far_apart,
    found_again,
    moving,
    steady_runs,
    together,
)
from solver.trace.arrays import ArrayKernel
from solver.trace.flow import Flow
from solver.trace.graph import NotCompilable, computed_from, copied
from solver.trace.program import AllAnswers, Program, counts, each_of, every
from solver.trace.ranges import Pair, Ranges
from solver.trace.records import Records

Array: TypeAlias = NDArray[Any]
PATIENT = False, False
"""The form of a record that gives the roots of blocks as many steps as they need, not sorted."""
Keep: TypeAlias = Callable[[Array, Status], None]
"""Takes the status of rows."""

WORTH = 16
"""The number of rows that is worth the set-up of a record on arrays, for each of its answers: every
two of these are compared."""


MANY = 512
"""The number of rows left by its quick form that is worth the patient form of a record."""
LARGE = 800
"""Operations of blocks that take longer to compile to machine code than most sweeps take without
it."""
WIDE = 4096
"""Rows of a steady sweep whose inputs are examined together."""
SPAN, AHEAD = 1024, 1024
"""Rows whose other answers are decided by ranges together, and how many such spans at once."""
FEW = 0.5
"""Share of the spans up to which those that ranges leave open are computed row by row."""
TOGETHER = 2**17
"""Rows up to which the columns of a piece share a block of memory, which the next piece takes
again."""
HUGE = 2**18
"""Numbers of a large page of memory. A long column that begins with one is had in few pages."""


def kernel_of(
    flow: Flow, wanted: Sequence[int], jit: bool, unrolled: bool = False
) -> Callable[..., None]:
    """Machine code if requested and possible for the functions, else blocks of numpy.

    ``unrolled``: roots of blocks by a few steps in straight-line code, for any known numbers.
    """
    if unrolled and flow.finders:
        target = Flow(flow.plain)
        flow, wanted = target, copied(flow, target, wanted)
        jit = jit and len(flow.nodes) < LARGE
    if jit:
        from solver.trace.llvm import NativeKernel, available

        if not available():
            raise ImportError("machine code needs llvmlite: pip install 'backsolve[jit]'")
        with suppress(NotCompilable):
            return NativeKernel(flow, wanted)
    return ArrayKernel(flow, wanted)


def columns_of(number: int, count: int) -> list[Array]:
    """Columns (n,) to be filled."""
    if count <= TOGETHER:
        return list(np.empty((number, count)))
    rooms = [np.empty(count + (HUGE if count > HUGE else 0)) for _ in range(number)]
    starts = [-room.ctypes.data // room.itemsize % HUGE if count > HUGE else 0 for room in rooms]
    return [room[start : start + count] for room, start in zip(rooms, starts, strict=True)]


Outcome: TypeAlias = Callable[[int], tuple[Status, list[Row]]]
"""Solves a row: its status, and the wanted values of every answer."""


class AnswerKernel:
    """One record on arrays: the answers of the rows that it covers, and a mask (n,) of these.

    First the roots of blocks get a few steps in straight-line code, and rules the short form of
    their checks; the remaining rows get as many steps as they need. ``turns`` (v,) are whole turns
    of wanted angles, else infinite.
    """

    def __init__(self, program: Program, jit: bool, turns: Array) -> None:
        if program.symbols:
            raise NotCompilable
        self.program, self.jit, self.turns = program, jit, turns
        self._made = dict[tuple[bool, bool], Callable[..., None]]()
        flow = program.flow
        within = sorted(
            n for n in computed_from(flow, program.wanted) if flow.nodes[n][0] == "unfolded"
        )
        self._within = [(flow.finders[int(flow.nodes[n][1])], flow.operands[n]) for n in within]
        """Computes whether known numbers of blocks lie in ranges, and the nodes of these."""
        self.symbols = every(program, in_order=False, quick=True).symbols
        self._asked, self._single = set[int](), dict[tuple[int, int], Callable[..., None]]()

    def _computed(
        self, columns: Sequence[Array], in_order: bool = False, quick: bool = True
    ) -> tuple[_Found, Array]:
        """The results of one form of the record, compiled on use; and rows that may be in
        ranges."""
        form, within = (in_order, quick), self._within if quick else []
        if form not in self._made:
            found = every(self.program, in_order, quick)
            known = (node for _, some in within for node in some)
            wanted = (*chain(*found.places), *found.there, found.holds, *known)
            self._made[form] = kernel_of(self.program.flow, wanted, self.jit, quick)
        count, places, each = len(columns[0]), len(self.program.endings), len(self.symbols)
        numbers, logical = (
            columns_of(places * each, count),
            np.empty((places + 1, count), dtype=bool),
        )
        asked = [np.empty((len(some), count)) for _, some in within]
        self._made[form](columns, (*numbers, *logical, *chain(*asked)))
        inside = np.full(count, True)
        for (finder, _), some in zip(within, asked, strict=True):
            told = finder.array(*some)
            logical[-1] &= told
            inside &= told | np.isnan(some).any(axis=0)
        planes = [numbers[place * each : (place + 1) * each] for place in range(places)]
        return (planes, logical[:-1], logical[-1]), inside

    def _replace(
        self,
        found: _Found,
        columns: Sequence[Array],
        rows: Array,
        in_order: bool = False,
        quick: bool = True,
    ) -> None:
        """Compute some rows again."""
        if not len(rows):
            return
        here = columns if len(rows) == len(columns[0]) else [column[rows] for column in columns]
        (planes, there, holds), _ = self._computed(here, in_order, quick)
        for target, source in zip((*found[0], found[1:]), (*planes, (there, holds)), strict=True):
            for column, values in zip(target, source, strict=True):
                column[..., rows] = values

    def __call__(
        self, columns: Sequence[Array], steady: bool = False, rows: Array | None = None
    ) -> tuple[Answers, Array]:
        """In a ``steady`` sweep answers are in order as far as ``Answers.runs`` says, else in every
        row; ``rows`` (n,) are their places, if some are left out."""
        found, within = self._computed(columns)
        planes, there, holds = found
        if np.count_nonzero(left := within & ~holds) > MANY:
            self._replace(found, columns, np.flatnonzero(left), quick=False)
        runs: list[tuple[int, int]] = []
        if steady and len(self.program.endings) > 1 and not any(self.symbols):
            most = 2 * np.count_nonzero(there & holds, axis=1) > np.count_nonzero(holds)
            order = np.argsort(~most, kind="stable")
            each = int(np.count_nonzero(most))
            planes, there = [planes[place] for place in order.tolist()], there[order]
            whole = holds & there[:each].all(axis=0) & ~there[each:].any(axis=0)
            runs = steady_runs(columns, rows, planes[:each], whole, self.turns)
            found = planes, there, holds
        if self.program.order.keys:
            runs = self._sort(found, columns, runs)
        there &= holds
        if there.all():
            counts = np.broadcast_to(np.int64(len(planes)), holds.shape)
        else:
            _pushed_up(planes, there)
            counts = there.sum(axis=0, dtype=np.int64)
        named = [list(map(_named, plane, self.symbols)) for plane in planes]
        return Answers(counts, named, tuple(runs)), holds

    # --- the answer that continues, and the ranges of the others ---

    @cached_property
    def _ranges(self) -> tuple[Ranges, AllAnswers, list[int]]:
        """Ranges of the numbers of all answers, then of all conditions."""
        found = every(self.program, in_order=False, quick=True)
        conditions = list(dict.fromkeys(each_of(self.program.flow, (found.holds, *found.there))))
        return Ranges(self.program.flow, (*chain(*found.places), *conditions)), found, conditions

    def clear(self, inputs: Sequence[Pair]) -> Array:
        """The spans (n,), from the ranges of their inputs, in which the answers are far apart and
        all conditions hold but those checked in every row. Conditions that no span decides are
        checked in every row from then on."""
        told, found, conditions = self._ranges
        pairs = told(inputs)
        ends = np.empty((len(pairs) - len(conditions), 2, len(inputs[0][0])))
        for target, pair in zip(ends, pairs, strict=False):
            target[0], target[1] = pair
        clear = far_apart(ends.reshape(len(found.places), -1, *ends.shape[1:]), self.turns)
        sure = {node: pair[0] for node, pair in zip(conditions, pairs[len(ends) :], strict=True)}
        ranged = (node for node, spans in sure.items() if not spans.any())
        self._asked.update(
            node for node in ranged if self.program.flow.nodes[node][0] != "unfolded"
        )
        for node in sure.keys() - self._asked:
            clear = clear & sure[node]
        return clear

    def each_row(self, columns: Sequence[Array], starts: Array) -> bool:
        """Whether all conditions hold in all rows of spans, and two before each, answers far
        apart."""
        rows = starts[:, None] + np.arange(-2, SPAN)
        planes, there, holds = self.quick([column[rows.ravel()] for column in columns])
        numbers: Array = np.array(planes).reshape(len(planes), -1, *rows.shape)
        ends = np.stack((numbers.min(axis=-1), numbers.max(axis=-1)), axis=2)
        return bool(there.all() and holds.all() and far_apart(ends, self.turns).all())

    def one(self, place: int, columns: Sequence[Array], targets: Sequence[Array]) -> bool:
        """Fill ``targets`` with one answer; return whether the row-by-row conditions hold."""
        flow, key = self.program.flow, (place, len(self._asked))
        if key not in self._single:
            wanted = *self._ranges[1].places[place], flow.over("and", sorted(self._asked))
            self._single[key] = kernel_of(flow, wanted, self.jit, unrolled=True)
        holding = np.empty(len(columns[0]), dtype=bool)
        self._single[key](columns, (*targets, holding))
        return bool(holding.all())

    def quick(self, columns: Sequence[Array]) -> _Found:
        """All answers of rows, unsorted."""
        return self._computed(columns)[0]

    def _sort(
        self, found: _Found, columns: Sequence[Array], runs: Sequence[tuple[int, int]]
    ) -> list[tuple[int, int]]:
        """Sort the answers of each row; for runs the second row, and the others like it. Returns
        the runs whose order is known."""
        planes, there, holds = found
        alone, told = holds.copy(), []
        for start, end in runs:
            # the first sampled row in which the record knows the order
            sampled = np.arange(start + 1, end - 1, 256)
            here = [column[sampled] for column in columns]
            (_, _, knows), _ = self._computed(here, in_order=True)
            if not knows[:1].all() and PATIENT in self._made:
                (_, _, knows), _ = self._computed(here, in_order=True, quick=False)
            if knows.any():
                first = int(sampled[np.argmax(knows)])
                told.append((first - 1, end))
                alone[first + 1 : end] = False
        seconds = [_row(planes, there, start + 1) for start, _ in told]
        rows = np.flatnonzero(alone)
        self._replace(found, columns, rows, in_order=True)
        left = rows[~holds[rows]]
        if len(left) > MANY or (len(left) and PATIENT in self._made):
            self._replace(found, columns, left, in_order=True, quick=False)
        for (start, end), second in zip(told, seconds, strict=True):
            nearest, _ = continued(_row(planes, there, start + 1), second, self.turns)
            order = nearest[:, 0].tolist()
            if order != sorted(order):
                _exchange(planes, [*order, *range(len(order), len(planes))], start + 2, end)
        return told


def _row(planes: list[list[Array]], there: Array, row: int) -> Array:
    """The numbers (v, answers, 1) of one row."""
    some = [planes[place] for place in np.flatnonzero(there[:, row]).tolist()]
    return np.array([[column[[row]] for column in columns] for columns in zip(*some, strict=True)])


def _exchange(planes: list[list[Array]], order: list[int], start: int, end: int) -> None:
    """Reorder the answers of some rows."""
    saved = [[column[start:end].copy() for column in planes[place]] for place in order]
    for plane, moved in zip(planes, saved, strict=True):
        for column, values in zip(plane, moved, strict=True):
            column[start:end] = values


def _pushed_up(planes: list[list[Array]], there: Array) -> None:
    """Move the answers of rows to earlier places without one."""
    if (there[1:] <= there[:-1]).all():
        return
    ranks = np.cumsum(there, axis=0) - 1
    for k, plane in enumerate(planes):
        rows = np.flatnonzero(there[k] & (ranks[k] < k))
        for rank in np.unique(ranks[k, rows]).tolist():
            here = rows[ranks[k, rows] == rank]
            for column, target in zip(plane, planes[rank], strict=True):
                target[here] = column[here]


def _named(column: Array, words: tuple[str, ...] | None) -> Array:
    return column if words is None else np.array(words, dtype=object)[column.astype(np.intp)]


_Found: TypeAlias = tuple[list[list[Array]], Array, Array]
"""Planes of answers, which of them are there (answers, n), and which rows they hold for (n,)."""


class Steady:
    """A long sweep in pieces, of which one answer is computed row by row if all of them continue
    steadily.

    That the others exist, count, and are far apart is shown for a span of rows at once, by the
    ranges of their numbers; conditions that ranges leave open (that a rule holds to rounding) are
    checked in every row.
    """

    def __init__(self, sweeper: AnswerSweeper, columns: Sequence[Array]) -> None:
        self.sweeper, self.columns = sweeper, columns
        self._place = 0
        self._clear_spans: tuple[object, int, Array] = None, 0, np.empty(0)

    def __call__(self, start: int, before: Array, targets: Sequence[Array]) -> int:
        """Fill ``targets``, columns (n,) of the rows from ``start``, with the answer that continues
        ``before`` (v, 2), its numbers in the first two rows. Returns the number of answers of each
        row, 0 where that is unclear."""
        program = self.sweeper.records.programs[self.sweeper.records.order[0]]
        kernel = self.sweeper.kernel(program)
        count = len(targets[0])
        here = [column[start : start + count] for column in self.columns]
        if kernel is None or any(kernel.symbols) or count < WIDE:
            return 0
        if before.shape[1] < 2 or not np.isfinite(before).all():
            return 0
        if not moving(here, WIDE).all():
            return 0
        clear = self._clear(kernel, start + 2, (count - 2) // SPAN)
        open_ = [
            *(2 + SPAN * np.flatnonzero(~clear)),
            *([count - SPAN] if (count - 2) % SPAN else []),
        ]
        if len(open_) > FEW * len(clear) or (open_ and not kernel.each_row(here, np.array(open_))):
            return 0
        if not kernel.one(self._place, here, targets):
            return 0
        if not all(
            (column[:2] == known).all() for column, known in zip(targets, before, strict=True)
        ):
            planes = kernel.quick([column[:2] for column in here])[0]
            place, second = found_again(
                Answers(np.full(2, len(planes)), planes), before, self.sweeper.turns
            )
            if place != second or (place != self._place and not kernel.one(place, here, targets)):
                return 0
            self._place = place
        return len(program.endings)

    def _clear(self, kernel: AnswerKernel, first: int, count: int) -> Array:
        """Of so many spans from row ``first`` those that ranges decide, if the inputs move
        steadily: their least and largest numbers are then the first and the last."""
        known, base, clear = self._clear_spans
        at = (first - base) // SPAN
        if known is not kernel or (first - base) % SPAN or not 0 <= at <= at + count <= len(clear):
            starts = np.arange(first, len(self.columns[0]) - SPAN + 1, SPAN)[: max(count, AHEAD)]
            ends = [(column[starts - 2], column[starts + SPAN - 1]) for column in self.columns]
            clear, at = kernel.clear([(np.minimum(*pair), np.maximum(*pair)) for pair in ends]), 0
            self._clear_spans = kernel, first, clear
        return clear[at : at + count]


class AnswerSweeper:
    """The rows of sweeps of one pattern, with every answer of each."""

    def __init__(self, records: Records, jit: bool, turns: Array) -> None:
        self.records, self.jit, self.turns = records, jit, turns
        self._kernels: dict[int, tuple[Program, Any]] = {}
        """By the number of a graph; the program is kept, so that its number stays its own."""

    def run(self, columns: Sequence[Array], outcome: Outcome, keep: Keep, steady: bool) -> Answers:
        """The answers of the rows of ``columns`` (n,): by existing records and those made of its
        rows.

        ``outcome`` solves a row that no record covers (and records it); ``keep`` is called with the
        status of rows that are not solved. In a ``steady`` sweep only a branch of answers has to be
        kept.
        """
        known = {id(program.flow) for program in (*self.records.programs, *self.records.refusals)}
        self._kernels = {key: kernel for key, kernel in self._kernels.items() if key in known}
        count = len(columns[0])
        parts = list[tuple[Array, Answers]]()
        left: Array = np.arange(count, dtype=np.int32 if count < 2**31 else np.int64)
        most = records = refusals = 0
        best = self.records.useful
        alone: dict[int, list[Row]] = {}
        while len(left):
            if len(left) > WORTH:
                for place in [p for p in self.records.order if p >= records]:
                    before, program = len(left), self.records.programs[place]
                    if before <= WORTH * len(program.endings):
                        continue
                    left = self._settled(program, columns, left, parts, steady)
                    if before - len(left) > most:
                        most, best = before - len(left), place
                for program in self.records.refusals[refusals:]:
                    left = self._not_refused(program, columns, left, keep)
            records, refusals = len(self.records.programs), len(self.records.refusals)
            for row in self._ahead(left.tolist(), alone):
                status, alone[row] = outcome(row)
                if status is not Status.SOLVED:
                    keep(np.array([row]), status)
                if (records, refusals) != (len(self.records.programs), len(self.records.refusals)):
                    break  # the new records may cover the others
            left = np.setdiff1d(
                left, np.fromiter(alone, left.dtype, len(alone)), assume_unique=True
            )
        self.records.useful = best
        if alone:  # in their order, which may skip rows that were solved ahead
            rows = sorted(alone)
            parts.append((np.array(rows, dtype=np.intp), listed([alone[row] for row in rows])))
        return together(parts, count)

    def _ahead(self, rows: list[int], done: Container[int]) -> Iterator[int]:
        """The rows, one after the other; after one that was recorded, more and more of them are
        skipped at first: later records may cover them."""
        for place, row in enumerate(rows):
            jump = 1
            while row not in done:
                learned = self.records.learned
                yield row
                if self.records.learned == learned:
                    break
                jump *= 2
                row = rows[min(place + jump, len(rows) - 1)]

    def _settled(
        self,
        program: Program,
        columns: Sequence[Array],
        left: Array,
        parts: list[tuple[Array, Answers]],
        steady: bool,
    ) -> Array:
        """The rows that remain after a record was tried."""
        kernel = self.kernel(program)
        if kernel is None or not len(left):
            return left
        whole = len(left) == len(columns[0])
        found, holds = kernel(
            columns if whole else [c[left] for c in columns], steady, None if whole else left
        )
        if holds.any():
            parts.append((left, found) if whole else (left[holds], found.of(holds)))
        return left[:0] if holds.all() else left[~holds]

    def kernel(self, program: Program) -> AnswerKernel | None:
        """A record on arrays, if possible."""
        found: AnswerKernel | None = self._kept(
            program, lambda: AnswerKernel(program, self.jit, self.turns)
        )
        return found

    def _kept(self, program: Program, made: Callable[[], Any]) -> Any:
        """The array form of a program, made once; None if there is none."""
        if id(program.flow) not in self._kernels:
            self._kernels[id(program.flow)] = program, None
            with suppress(NotCompilable):
                self._kernels[id(program.flow)] = program, made()
        return self._kernels[id(program.flow)][1]

    def _not_refused(
        self, program: Program, columns: Sequence[Array], left: Array, keep: Keep
    ) -> Array:
        """The rows that remain after a refusal was tried."""
        if program.symbols or not len(left):
            return left
        flow, ending = program.flow, program.endings[0]
        holds_in = self._kept(
            program, lambda: kernel_of(flow, [counts(flow, ending.holds)], self.jit)
        )
        if holds_in is None:
            return left
        holds = np.empty(len(left), dtype=bool)
        holds_in([c if len(left) == len(c) else c[left] for c in columns], (holds,))
        if holds.any():
            keep(left[holds], Status.INFEASIBLE)
        return left[~holds]


def listed(rows: Sequence[list[Row]]) -> Answers:
    """The answers of rows as planes."""
    counts = np.array([len(found) for found in rows], dtype=np.int64)
    planes = []
    for k in range(counts.max(initial=0)):
        some = next(found[k] for found in rows if len(found) > k)
        columns = list(zip(*(found[k] if len(found) > k else some for found in rows), strict=True))
        symbolic = [any(isinstance(value, str) for value in column) for column in columns]
        planes.append(
            [
                np.array(c, dtype=object if odd else float)
                for c, odd in zip(columns, symbolic, strict=True)
            ]
        )
    return Answers(counts, planes)
