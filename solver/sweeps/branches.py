"""Answers followed from row to row: the primary one keeps its branch, and every other its number."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from solver.files.columns import Array, Columns, stacked
from solver.ranking.branches import Answers, kept, numbers_of, together, wound
from solver.sweeps.work import Rows, Solved, Work


class Branches:
    """Replaces the answers that the rule put first by those that continue the branch of the row before.

    A row begins anew where the rows of a line are full: where an outer input of a grid changes.
    """

    def __init__(self, work: Work, turns: Points) -> None:
        self.work, self.turns = work, turns
        self._done = 0
        self._before: Rows | None = None

    def __call__(self, piece: Solved) -> Solved:
        assert piece.rows is not None
        last = piece.rows.last()
        if piece.several:
            rows = piece.rows if self._before is None else _together(self._before, piece.rows)
            extra = len(rows.codes) - len(piece.rows.codes)
            first = kept(rows.inputs, rows.answers, self.turns, self.work.line, self._done - extra, extra)
            if first.any():
                piece = replace(self.work.solved(piece.rows, first[extra:]), several=piece.several)
            last = rows.last()._replace(answers=_in_front(rows.last().answers, first[-2:]))
        self._before, self._done = last, self._done + sum(piece.counts)
        return piece


def _together(one: Rows, other: Rows) -> Rows:
    inputs = tuple(stacked(pair) for pair in zip(one.inputs, other.inputs, strict=True))
    codes, few = np.concatenate([one.codes, other.codes]), len(one.codes)
    parts = [(np.arange(few), one.answers), (np.arange(few, len(codes)), other.answers)]
    return Rows(inputs, codes, together(parts, len(codes)))


def _in_front(answers: Answers, first: Array) -> Answers:
    """The primary answers before the others."""
    planes = [[column.copy() for column in plane] for plane in answers.planes]
    for row, place in enumerate(first.tolist()):
        for values in zip(*planes, strict=True):
            values[0][row], values[place][row] = values[place][row], values[0][row]
    return Answers(answers.counts, planes)


Points: TypeAlias = NDArray[np.float64]
Numbers: TypeAlias = NDArray[np.int32]

ROOM = 2**18
"""Differences between answers that are reckoned at once."""


class _Branch(NamedTuple):
    """Where an answer was in the last row (a number a wanted variable), and its step from the row before."""

    at: Points
    step: Points


class Follower:
    """Renumbers the answers of each row by those of the row before.

    The answers of two neighbouring rows are paired by the least distance between where a branch is
    heading (on a straight line through its last two rows) and where an answer lies; distances are
    scaled by the spread of each variable, and whole ``turns`` of an angle make none. An answer that
    continues no branch takes the smallest number that is free. Numbers start anew at every ``line``
    rows: where an outer input of a grid changes. The order of the answers within a row stays.
    """

    def __init__(self, column: str, wanted: Sequence[str], turns: Mapping[str, float], line: int) -> None:
        self._column, self._wanted, self._line = column, tuple(wanted), line
        self._turns = np.array([turns.get(name, np.inf) for name in wanted])
        self._row = 0
        self._branches: dict[int, _Branch] = {}
        self._in_order = False

    def __call__(self, table: Columns) -> Columns:
        """The next piece of the table, renumbered."""
        ranks = table.values[self._column]
        points = np.array([numbers_of(table.values[name]) for name in self._wanted])
        starts = np.append(np.flatnonzero(ranks < 2), len(ranks))
        counts = np.where(ranks[starts[:-1]] == 0, 0, np.diff(starts))
        plain = self._plain_rows(points, starts, counts)
        after_empty, after_plain = _ends_of_runs(counts == 0), _ends_of_runs(plain)
        numbers = ranks.copy()
        row, last = 0, len(counts)
        while row < last:
            if not counts[row]:
                end = int(after_empty[row])
                self._branches, self._in_order = {}, True
            elif plain[row] and self._in_order:
                end = int(after_plain[row])
                self._run(points, starts, row, end, numbers)
            else:
                end = row + 1
                here = slice(starts[row], starts[end])
                self._one(points[:, here], numbers[here])
            self._row += end - row
            row = end
        return replace(table, values={**table.values, self._column: numbers})

    def numbered(self, piece: Solved) -> Solved:
        assert piece.table is not None
        return replace(piece, table=self(piece.table))

    def _one(self, found: Points, numbers: Numbers) -> None:
        """Number the answers of one row by the row before."""
        if self._row % self._line == 0:
            self._branches = {}
        labels = self._labels(found)
        numbers[:] = labels
        self._in_order = labels == list(self._branches)
        self._branches = {n: self._branch(n, point) for n, point in zip(labels, found.T, strict=True)}

    def _run(
        self,
        points: Points,
        starts: NDArray[np.intp],
        row: int,
        end: int,
        numbers: Numbers,
    ) -> None:
        """Rows whose answers continue in their order those of the row before."""
        labels = list(self._branches)
        numbers[starts[row] : starts[end]] = np.tile(labels, end - row)
        before, now = (points[:, starts[r] : starts[r + 1]] for r in (end - 2, end - 1))
        steps = self._apart(now, before)
        self._branches = {n: _Branch(at, step) for n, at, step in zip(labels, now.T, steps.T, strict=True)}

    def _plain_rows(
        self, points: Points, starts: NDArray[np.intp], counts: NDArray[np.intp]
    ) -> NDArray[np.bool_]:
        """Rows in which each answer is nearer to the one of its place in the row before than to any other.

        Pairing them one by one would come to the same, if the row before them came in the order of the
        one before that; which is so for all rows but a few.
        """
        rows = np.arange(self._row, self._row + len(counts)) % self._line
        alike = (counts > 0) & (rows >= 2)
        alike[:2] = False
        alike[2:] &= (counts[2:] == counts[1:-1]) & (counts[2:] == counts[:-2])
        for count in np.unique(counts[alike & (counts > 1)]).tolist():  # a single answer has no rival
            same = np.flatnonzero(alike & (counts == count))
            for here in np.array_split(same, 1 + len(same) * count * count * len(points) // ROOM):
                alike[here] = self._in_place(points, starts, here, count)
        return alike

    def _in_place(
        self, points: Points, starts: NDArray[np.intp], rows: NDArray[np.intp], count: int
    ) -> NDArray[np.bool_]:
        """Whether each of so many answers of these rows is nearest to that of its place in the row before."""
        places = np.arange(count)[:, None]
        now, before, earlier = (points[:, starts[rows - back] + places] for back in (0, 1, 2))
        apart = self._distances(now, before, self._apart(before, earlier))
        own = np.einsum("kkr->kr", apart).copy()
        np.einsum("kkr->kr", apart)[:] = np.inf
        near: NDArray[np.bool_] = (own < np.minimum(apart.min(axis=0), apart.min(axis=1))).all(axis=0)
        return near

    def _distances(self, now: Points, before: Points, steps: Points) -> Points:
        """Of each row (r), from where each branch (k) is heading to each answer (j): (k, j, r).

        ``now`` (v, j, r), ``before`` and ``steps`` (v, k, r) are numbers of the wanted variables (v).
        """
        total: Points = np.zeros((before.shape[1], now.shape[1], now.shape[2]))
        for place, (here, there) in enumerate(zip(now, before, strict=True)):
            every = np.concatenate([there, here])[:, None]
            turn = self._turns[place]
            around = np.abs(wound(every - here, turn)).max(axis=0)
            off = np.abs(wound(here - (there + steps[place])[:, None], turn))
            total += np.divide(off, around, out=np.zeros_like(off), where=around > 0)
        return total

    def _branch(self, number: int, point: Points) -> _Branch:
        before = self._branches.get(number)
        return _Branch(point, self._apart(point, before.at) if before else np.zeros(len(point)))

    def _labels(self, found: Points) -> list[int]:
        """Numbers for the answers (v, j) of a row."""
        labels: dict[int, int] = {}
        count = found.shape[1]
        if self._branches and count:
            numbers = list(self._branches)
            at = np.array([branch.at for branch in self._branches.values()]).T
            steps = np.array([branch.step for branch in self._branches.values()]).T
            apart = self._distances(found[..., None], at[..., None], steps[..., None])
            for flat in np.argsort(apart, axis=None, kind="stable").tolist():
                branch, place = divmod(flat, count)
                if place not in labels and numbers[branch] not in labels.values():
                    labels[place] = numbers[branch]
        free = (n for n in range(1, 2 * count + 1) if n not in labels.values())
        return [labels[place] if place in labels else next(free) for place in range(count)]

    def _apart(self, there: Points, here: Points) -> Points:
        """The differences of numbers of the variables (v, …), by whole turns as small as they get."""
        return wound(there - here, self._turns.reshape(-1, *(1,) * (there.ndim - 1)))


def _ends_of_runs(flags: NDArray[np.bool_]) -> NDArray[np.intp]:
    """For each place the first one from there on that has no flag."""
    stops = np.append(np.flatnonzero(~flags), len(flags))
    ends: NDArray[np.intp] = stops[np.searchsorted(stops, np.arange(len(flags)))]
    return ends
