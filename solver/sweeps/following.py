"""Answers followed from row to row, so that one number stays with one branch of the solution."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from solver.files.columns import Columns


@dataclass(frozen=True)
class _Branch:
    """Where an answer was in the last row (a number a wanted variable), and its step from the row before."""

    at: NDArray[np.float64]
    step: NDArray[np.float64]


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

    def __call__(self, table: Columns) -> Columns:
        """The next piece of the table, renumbered."""
        ranks = table.values[self._column]
        points = _points([table.values[name] for name in self._wanted], len(table))
        numbers = ranks.copy()
        starts = np.flatnonzero(ranks < 2)
        for start, end in pairwise([*starts.tolist(), len(ranks)]):
            if self._row % self._line == 0:
                self._branches = {}
            self._row += 1
            found = points[start:end] if ranks[start] else points[:0]
            labels = self._labels(found)
            if labels:
                numbers[start:end] = labels
            self._branches = {n: self._branch(n, point) for n, point in zip(labels, found, strict=True)}
        return replace(table, values={**table.values, self._column: numbers})

    def _branch(self, number: int, point: NDArray[np.float64]) -> _Branch:
        before = self._branches.get(number)
        return _Branch(point, self._apart(point, before.at) if before else np.zeros(len(point)))

    def _labels(self, found: NDArray[np.float64]) -> list[int]:
        labels: dict[int, int] = {}
        pairs = sorted(
            (self._distance(branch, point, found), number, place)
            for number, branch in self._branches.items()
            for place, point in enumerate(found)
        )
        for _, number, place in pairs:
            if place not in labels and number not in labels.values():
                labels[place] = number
        free = (n for n in range(1, 2 * len(found) + 1) if n not in labels.values())
        return [labels[place] if place in labels else next(free) for place in range(len(found))]

    def _distance(self, branch: _Branch, point: NDArray[np.float64], found: NDArray[np.float64]) -> float:
        others = np.array([one.at for one in self._branches.values()])
        around = np.abs(self._apart(np.concatenate([others, found]), point)).max(axis=0)
        apart = np.abs(self._apart(point, branch.at + branch.step))
        return float(np.sum(np.divide(apart, around, out=np.zeros_like(apart), where=around > 0)))

    def _apart(self, there: NDArray[np.float64], here: NDArray[np.float64]) -> NDArray[np.float64]:
        """The difference, by whole turns as small as it gets where a variable is an angle."""
        apart = there - here
        turning = np.isfinite(self._turns)
        turn = np.where(turning, self._turns, 1.0)
        wound: NDArray[np.float64] = np.where(turning, apart - turn * np.round(apart / turn), apart)
        return wound


def _points(columns: Sequence[NDArray[np.float64]], rows: int) -> NDArray[np.float64]:
    """The numbers of each row; a symbol, which is near to nothing but itself, counts by its letters."""
    points = np.zeros((rows, len(columns)))
    for place, column in enumerate(columns):
        if column.dtype == object:
            points[:, place] = [_coded(value) for value in column.tolist()]
        else:
            points[:, place] = np.nan_to_num(column)
    return points


def _coded(value: float | str | None) -> float:
    """A number that is the same for the same symbol in every process."""
    if isinstance(value, str):
        return float(int.from_bytes(value.encode()[:4], "big"))
    return value or 0.0
