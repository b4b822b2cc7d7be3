"""A branch of answers kept along a sweep: the row after a row goes on where it was heading.

The rule of ``ranking.py`` decides in the first row of a stretch in which the inputs move steadily. From there
an answer is kept that lies clearly nearest to the straight line through its last two rows; where
none does, the rule decides again.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]
Points = NDArray[np.float64]

STEADY = 2.0
"""Ratio of the steps of an input up to which rows are taken for a sweep."""
SAME, DIFFERENT = 1e-9, 1e-6
"""Shares of the largest distance between answers that are next to nothing, and that are something."""
CLEAR = 0.5
"""Share of the distance of the next answer, below which an answer continues a branch."""


def kept(
    inputs: Sequence[Array],
    counts: Array,
    points: Points,
    turns: Points,
    line: int,
    at: int,
    fixed: int,
) -> Array:
    """Of each row (n,) the number of the answer that comes first, 0 where it is the one that the rule says.

    ``points`` (v, answers) are those of all rows one after another, as many as ``counts`` (n,) says, in the
    order of the rule. ``turns`` (v,) are whole turns of angles, else infinite. A stretch ends where ``line``
    rows are full; the first row is row ``at`` of the sweep. In so many first rows it is ``fixed`` that the
    first answer stays so.
    """
    chosen = np.zeros(len(counts), dtype=np.intp)
    several = np.flatnonzero(counts > 1)
    if not len(several):
        return chosen
    steps = _steps(inputs, len(counts), line, at)
    along = _along(steps, counts)
    rows = several[along[several] & (several >= max(fixed, 1))]
    if _first_goes_on(points, counts, turns, rows, along):
        return chosen
    answers = _Answers(points, counts, turns)
    before = rows[along[rows - 1]] - 1
    back, _ = answers.nearest(points, before, before - 1)
    heading = points.copy()
    known = np.flatnonzero(back >= 0)
    heading[:, known] += wound(points[:, known] - points[:, back[known]], turns[:, None])
    onward, clear = answers.nearest(heading, rows - 1, rows)
    starts = answers.starts.tolist()
    for row in rows.tolist():
        here = starts[row - 1] + int(chosen[row - 1])
        if clear[here]:
            chosen[row] = onward[here] - starts[row]
    return chosen


def _first_goes_on(
    points: Points, counts: Array, turns: Points, rows: Array, along: NDArray[np.bool_]
) -> bool:
    """Whether the first answer of the rule goes on throughout: by each variable it is nearest to where the
    row before was heading. Asked of rows with one number of answers.
    """
    each = int(counts[0])
    if (counts != each).any() or not len(rows):
        return False
    nearer = np.zeros(len(rows), dtype=bool)
    for values, turn in zip(points.reshape(len(points), -1, each), turns, strict=True):
        first = values[:, 0]
        step = np.where(along[rows - 1], _apart(first[rows - 1], first[rows - 2], turn), 0.0)
        heading = first[rows - 1] + step
        own = abs(_apart(heading, first[rows], turn))
        for other in values[:, 1:].T:
            onward = abs(_apart(heading, other[rows], turn)) - own
            back = abs(_apart(first[rows - 1], other[rows - 2], turn)) - abs(step)
            least, size = np.minimum(onward, back), max(float(onward.max()), float(own.max()))
            if least.min() < -SAME * size:
                return False
            nearer |= least > DIFFERENT * size
    return bool(nearer.all())


def _apart(one: Points, other: Points, turn: float) -> Points:
    return one - other if turn == np.inf else wound(one - other, turn)


def points_of(columns: Sequence[Array], rows: int) -> Points:
    """The numbers of each variable (v, n); a symbol, near to nothing but itself, counts by its letters."""
    points = np.zeros((len(columns), rows))
    for place, column in enumerate(columns):
        if column.dtype == object:
            points[place] = [_coded(value) for value in column.tolist()]
        else:
            points[place] = np.nan_to_num(column)
    return points


def _coded(value: float | str | None) -> float:
    """A number that is the same for the same symbol in every process."""
    if isinstance(value, str):
        return float(int.from_bytes(value.encode()[:4], "big"))
    return value or 0.0


def _steps(inputs: Sequence[Array], rows: int, line: int, at: int) -> Points:
    """How far each input moves into each row (k, n); nan where no step leads there."""
    steps = np.full((len(inputs), rows), np.nan)
    for place, column in enumerate(points_of(inputs, rows)):
        steps[place, 1:] = np.diff(column)
    steps[:, (np.arange(rows) + at) % line == 0] = np.nan
    return steps


def _along(steps: Points, counts: Array) -> NDArray[np.bool_]:
    """Whether the step into each row is one of a sweep, as even as the one before it or after it."""
    one, other = steps[:, :-1], steps[:, 1:]
    with np.errstate(over="ignore", invalid="ignore"):
        near = (one * other > 0.0) & (abs(other) <= STEADY * abs(one)) & (abs(one) <= STEADY * abs(other))
        even = (((one == 0.0) & (other == 0.0)) | near).all(axis=0) & near.any(axis=0)
    along = np.zeros(len(counts), dtype=bool)
    along[1:] |= even
    along[:-1] |= even
    along[1:] &= counts[:-1] > 0
    along[0] = False
    return along


class _Answers:
    """The answers of rows: ``points`` (v, answers), and where those of each row start."""

    def __init__(self, points: Points, counts: Array, turns: Points) -> None:
        self.points, self.counts, self.turns = points, counts, turns
        self.starts = np.cumsum(counts) - counts

    def nearest(self, heading: Points, sources: Array, targets: Array) -> tuple[Array, NDArray[np.bool_]]:
        """Of each answer (answers,) of the ``sources`` the nearest one of the row in ``targets``, from where
        it is ``heading``; -1 elsewhere. And whether it is clearly the nearest.
        """
        near = np.full(self.points.shape[1], -1, dtype=np.intp)
        clear = np.zeros(self.points.shape[1], dtype=bool)
        sizes = self.counts[sources], self.counts[targets]
        base = int(self.counts.max()) + 1
        for code in np.flatnonzero(np.bincount(sizes[0] * base + sizes[1])).tolist():
            few, many = divmod(code, base)
            here = (sizes[0] == few) & (sizes[1] == many)
            mine = self.starts[sources[here]] + np.arange(few)[:, None]
            theirs = self.starts[targets[here]] + np.arange(many)[:, None]
            apart = self._distances(heading[:, mine], self.points[:, theirs])
            first = apart.argmin(axis=1)
            near[mine] = np.take_along_axis(theirs, first, axis=0)
            least = np.take_along_axis(apart, first[:, None], axis=1)[:, 0]
            np.put_along_axis(apart, first[:, None], np.inf, axis=1)
            clear[mine] = least <= CLEAR * apart.min(axis=1) if many > 1 else True
        return near, clear

    def _distances(self, heading: Points, points: Points) -> Points:
        """From each place (v, k, r) to each answer (v, j, r): (k, j, r), variables scaled by their spread."""
        total = np.zeros((heading.shape[1], *points.shape[1:]))
        for place, (here, there) in enumerate(zip(heading, points, strict=True)):
            off = abs(wound(here[:, None] - there[None], self.turns[place]))
            around = off.max(axis=(0, 1))
            total += np.divide(off, around, out=np.zeros_like(off), where=around > 0)
        return total


def wound(apart: Points, turns: Any) -> Points:
    """Differences without whole turns."""
    turned = np.where(np.isfinite(turns), turns, 1.0)
    return np.where(np.isfinite(turns), apart - turned * np.rint(apart / turned), apart)
