"""Answers followed from row to row: the primary one keeps its branch, and every other its number."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from solver.files.columns import Array, Columns, stacked
from solver.ranking.branches import ROOM, Answers, Points, distances, kept, numbers_of, together, wound
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


class Follower:
    """Renumbers the answers of each row by those of the row before.

    The answers of two neighbouring rows are paired by the least distance between where a branch is
    heading (on a straight line through its last two rows) and where an answer lies. An answer that
    continues no branch takes the smallest number that is free. Numbers start anew at every ``line``
    rows: where an outer input of a grid changes. The order of the answers within a row stays.
    """

    def __init__(self, column: str, wanted: Sequence[str], turns: Mapping[str, float], line: int) -> None:
        self._column, self._wanted, self._line = column, tuple(wanted), line
        self._turns = np.array([turns.get(name, np.inf) for name in wanted])
        self._row, self._in_order = 0, False
        self._start_anew()

    def _start_anew(self) -> None:
        """The branches of the last row: their numbers, where they are (v, k), and their steps to there."""
        self._labels: list[int] = []
        self._at: Points = np.zeros((len(self._wanted), 0))
        self._steps = self._at

    def numbered(self, piece: Solved) -> Solved:
        return replace(piece, table=self(piece.table))

    def __call__(self, table: Columns) -> Columns:
        """The next piece of the table, renumbered."""
        ranks = table.values[self._column]
        points = np.array([numbers_of(table.values[name]) for name in self._wanted])
        starts = np.flatnonzero(ranks < 2)
        counts = np.where(ranks[starts] == 0, 0, np.diff(starts, append=len(ranks)))
        plain = self._plain_rows(points, starts, counts)
        ends = np.append(np.flatnonzero(~plain), len(counts))
        numbers, row = ranks.copy(), 0
        while row < len(counts):
            end = row + 1
            if plain[row] and self._in_order:
                end = int(ends[np.searchsorted(ends, row)])
                now, before = (points[:, starts[r] : starts[r] + counts[r]] for r in (end - 1, end - 2))
                self._at, self._steps = now, self._apart(now, before)
            else:
                self._one(points[:, starts[row] : starts[row] + counts[row]])
            places = slice(starts[row], starts[row] + len(self._labels) * (end - row))
            numbers[places] = np.tile(self._labels, end - row)
            self._row, row = self._row + end - row, end
        return replace(table, values={**table.values, self._column: numbers})

    def _one(self, found: Points) -> None:
        """Number the answers (v, j) of one row by the row before."""
        if self._row % self._line == 0:
            self._start_anew()
        count, before = found.shape[1], self._labels
        labels: dict[int, int] = {}
        steps: Points = np.zeros(found.shape)
        heading = (self._at + self._steps)[..., None]
        apart = distances(heading, found[..., None], self._turns) if before and count else None
        for flat in [] if apart is None else np.argsort(apart, axis=None, kind="stable").tolist():
            branch, place = divmod(flat, count)
            if place not in labels and before[branch] not in labels.values():
                labels[place] = before[branch]
                steps[:, place] = self._apart(found[:, [place]], self._at[:, [branch]])[:, 0]
        free = (n for n in range(1, 2 * count + 1) if n not in labels.values())
        self._labels = [labels[place] if place in labels else next(free) for place in range(count)]
        self._in_order = self._labels == before
        self._at, self._steps = found, steps

    def _plain_rows(self, points: Points, starts: Array, counts: Array) -> NDArray[np.bool_]:
        """Rows in which each answer is nearer to the one of its place in the row before than to any other.

        Pairing them one by one would come to the same, if the row before them came in the order of the
        one before that; which is so for all rows but a few.
        """
        alike = (np.arange(self._row, self._row + len(counts)) % self._line >= 2) | (counts == 0)
        alike[:2] = False
        alike[2:] &= (counts[2:] == counts[1:-1]) & (counts[2:] == counts[:-2])
        for count in np.unique(counts[alike & (counts > 1)]).tolist():  # a single answer has no rival
            same, places = np.flatnonzero(alike & (counts == count)), np.arange(count)
            for rows in np.array_split(same, 1 + len(same) // ROOM):
                now, before, earlier = (
                    points[:, starts[rows - back] + places[:, None]] for back in (0, 1, 2)
                )
                apart = distances(before + self._apart(before, earlier), now, self._turns)
                own = apart[places, places].copy()
                apart[places, places] = np.inf
                alike[rows] = (own < np.minimum(apart.min(axis=0), apart.min(axis=1))).all(axis=0)
        return np.asarray(alike)

    def _apart(self, there: Points, here: Points) -> Points:
        """The differences of numbers of the variables (v, …), by whole turns as small as they get."""
        return wound(there - here, self._turns.reshape(-1, *(1,) * (there.ndim - 1)))
