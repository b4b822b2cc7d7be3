"""A branch of answers kept along a sweep: each row continues the previous rows.

The ranking of ``ranking.py`` decides in the first row of a stretch in which the inputs move
steadily. From there the answer is kept that lies clearly nearest to the straight line through its
last two rows; if none does, the ranking decides again. If the ranges of the answers lie far apart,
single rows need not be examined: bounds of the same distances decide for hundreds of rows at once.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from solver.numerics.tolerances import SAME_VALUE

Array = NDArray[Any]
Points = NDArray[np.float64]

STEADY = 2.0
"""Ratio of the steps of an input up to which rows count as a sweep."""
BACK = 1.0 + 1e-9
"""Ratio of two steps up to which one takes the other back."""
CLEARLY_NEARER = 0.5
"""Share of the distance of the next answer, below which an answer continues a branch."""
SPAN = 256
"""Rows that are decided at once."""
ROOM = 2**16
"""Rows that are compared at once."""


class Answers(NamedTuple):
    """The answers of n rows: ``counts`` (n,), and ``planes`` of the first answers, of the second
    ones, and so on, each with a column (n,) for each wanted variable. Values in a plane beyond the
    count of a row are meaningless.

    In rows ``start + 2`` to ``end`` of ``runs`` each answer clearly continues the one of its plane
    in the row before, and only the planes of row ``start + 1`` need be in the order of the ranking.
    """

    counts: Array
    planes: list[list[Array]]
    runs: tuple[tuple[int, int], ...] = ()

    def cut(self, start: int, end: int) -> Answers:
        """Those of some rows."""
        planes = [[column[start:end] for column in plane] for plane in self.planes]
        pairs = ((max(first - start, 0), min(last, end) - start) for first, last in self.runs)
        return Answers(self.counts[start:end], planes, tuple(p for p in pairs if p[1] - p[0] > 2))

    def of(self, rows: Array) -> Answers:
        """Those of the rows of a mask (n,), which all runs lie in."""
        planes = [[column[rows] for column in plane] for plane in self.planes]
        before = np.cumsum(~rows)
        runs = (
            (int(first - before[first]), int(last - before[first])) for first, last in self.runs
        )
        return Answers(self.counts[rows], planes, tuple(runs))

    def chosen(self, first: Array, own: bool = False) -> list[Array]:
        """A column for each wanted variable: the answers ``first`` (n,), else nan or None.

        ``own``: the planes are not read any more, and may be overwritten.
        """
        most = int(np.bincount(first).argmax()) if first.any() else 0
        kinds = range(len(self.planes)) if first.any() else ()
        others = [(k, np.flatnonzero(first == k)) for k in kinds if k != most]
        none = np.flatnonzero(self.counts[: 1 if _alone(self.counts) else None] == 0)
        columns = []
        for values in zip(*self.planes, strict=True):
            column = values[most]
            if len(none) or others:
                symbols = any(other.dtype == object for other in values)
                column = column.astype(object if symbols else float, copy=not own)
                for k, rows in others:
                    column[rows] = values[k][rows]
                column[none] = None if symbols else np.nan
            columns.append(column)
        return columns

    def listed(self) -> list[Array]:
        """A column for each wanted variable, all answers row after row; nan or None for a row
        without one."""
        there = np.arange(len(self.planes)) < np.maximum(self.counts, 1)[:, None]
        columns = []
        for first, *others in zip(*self.planes, strict=True):
            if not self.counts.all():
                first = first.copy()
                first[self.counts == 0] = None if first.dtype == object else np.nan
            columns.append(np.stack([first, *others], axis=1)[there])
        return columns

    def points(self, rows: Array, count: int) -> Points:
        """The numbers (v, count, rows) of so many answers of these rows; symbols are coded."""
        columns = zip(*self.planes[:count], strict=True)
        return np.array([[numbers_of(values[rows]) for values in column] for column in columns])


def _alone(column: Array) -> bool:
    """Whether one number stands for all rows, of which there are some."""
    return column.strides == (0,) and len(column) > 0


def together(parts: Sequence[tuple[Array, Answers]], count: int) -> Answers:
    """The answers of all rows, from those of parts of them. A first part of all rows is taken over;
    its rows in other parts are empty."""
    if parts and len(parts[0][0]) == count:
        (_, every), *parts = parts
    else:
        every = Answers(np.zeros(count, dtype=np.int64), [])
    counts, planes, runs = every.counts, every.planes, list(every.runs)
    for rows, found in parts:
        counts[rows] = found.counts
        runs += [(int(rows[first]), int(rows[last - 1]) + 1) for first, last in found.runs]
        planes += [[np.zeros(count) for _ in plane] for plane in found.planes[len(planes) :]]
        for plane, columns in zip(planes, found.planes, strict=False):
            for place, column in enumerate(columns):
                if column.dtype != plane[place].dtype:
                    plane[place] = plane[place].astype(object)
                plane[place][rows] = column
    return Answers(counts, planes, tuple(sorted(runs)))


def kept(
    inputs: Sequence[Array],
    answers: Answers,
    turns: Points,
    line: int,
    at: int = 0,
    known: Sequence[int] = (),
) -> Array:
    """For each row (n,) the number of the answer that comes first, 0 for the first of the ranking.

    ``turns`` (v,) are whole turns of angles, else infinite. A stretch ends after ``line`` rows; the
    first row is row ``at`` of the sweep. Those of the first rows are ``known``.
    """
    counts = answers.counts
    if _alone(counts) and counts[0] < 2:
        return np.broadcast_to(np.intp(0), counts.shape)
    asked = counts > 1
    asked[: max(len(known), 1)] = False
    for start, end in answers.runs:
        asked[start + 2 : end] = False
    rows = np.flatnonzero(asked)
    if not (len(rows) or any(known)) or not len(turns):
        return np.broadcast_to(np.intp(0), counts.shape)
    chosen = np.zeros(len(counts), dtype=np.intp)
    chosen[: len(known)] = known
    ends = {start + 1: end for start, end in answers.runs}
    for row, place in enumerate(known):
        chosen[row + 1 : ends.get(row, 0)] = place
    rows = rows[_along(inputs, counts, rows, line, at)]
    onward = np.zeros((len(answers.planes), len(rows)), dtype=np.intp)
    steady = _along(inputs, counts, rows - 1, line, at)
    before, here = (np.sign(_into(inputs, into)) for into in (rows - 1, rows))
    turned = np.any(before * here < 0.0, axis=0)
    sizes = np.array([np.where(steady, counts[rows - 2], 0), counts[rows - 1], counts[rows]])
    origin = np.full(len(rows), -1)
    for here in _alike(sizes):
        back, before, now = sizes[:, here[0]].tolist()
        source = heading = answers.points(rows[here] - 1, before)
        if back:
            earlier = answers.points(rows[here] - 2, back)
            nearest, _ = continued(source, earlier, turns)
            if before == 1:
                origin[here] = nearest[0]
            step = source - np.take_along_axis(earlier, nearest[None], axis=1)
            step[:, :, turned[here]] *= -1.0
            heading = source + without_turns(step, turns[:, None, None])
        nearest, clear = continued(heading, answers.points(rows[here], now), turns)
        onward[:before, here] = np.where(clear, nearest, 0)
    if not (onward[0].any() or any(known)):
        return chosen
    told = zip(rows.tolist(), origin.tolist(), onward.T.tolist(), strict=True)
    for row, came_from, places_onward in told:
        # what is alone in a row between others is not kept after it if it was not before it
        is_kept = came_from in (-1, chosen[row - 2])
        chosen[row] = place = places_onward[chosen[row - 1]] if is_kept else 0
        if place and row in ends:
            chosen[row + 1 : ends[row]] = place
    return chosen


def found_again(answers: Answers, before: Points, turns: Points) -> list[int]:
    """The answers of the first rows (k,) with the numbers (v, k)."""
    again = []
    for row, numbers in enumerate(before.T):
        points = answers.points(np.array([row]), int(answers.counts[row]))
        again.append(
            int(distances(numbers[:, None, None], points, turns).argmin()) if points.size else 0
        )
    return again


def _alike(sizes: Array) -> Iterator[Array]:
    """The places of equal columns of counts, not too many at once."""
    base = 1 + int(sizes.max(initial=0))
    codes = (sizes[0] * base + sizes[1]) * base + sizes[2]
    for code in np.unique(codes).tolist():
        here = np.flatnonzero(codes == code)
        yield from np.array_split(here, 1 + len(here) // ROOM)


def _along(
    inputs: Sequence[Array], counts: Array, rows: Array, line: int, at: int
) -> NDArray[np.bool_]:
    """Whether the step into each of these rows is as even as those before and after it: of
    unordered rows one in nine is so by chance. One of the three may turn back, or stand still."""

    def step(into: Array) -> Points:
        there = (into > 0) & (into < len(counts)) & ((into + at) % line != 0)
        return np.where(there, _into(inputs, np.where(there, into, 0)), np.nan)

    @np.errstate(over="ignore", invalid="ignore")
    def even(one: Points, other: Points, by: float = STEADY) -> NDArray[np.bool_]:
        near = (one * other > 0.0) & (abs(other) <= by * abs(one)) & (abs(one) <= by * abs(other))
        alike = ((one == 0.0) & (other == 0.0)) | near
        return np.asarray(np.all(alike, axis=0) & np.any(near, axis=0))

    before, here, after = map(step, (rows - 1, rows, rows + 1))
    still = np.all(here == 0.0, axis=0)
    steady = [even(here, beside) for beside in (before, after)]
    sides = [
        same | np.isnan(beside[0]) | np.all(beside == 0.0, axis=0) | even(-here, beside, BACK)
        for same, beside in zip(steady, (before, after), strict=True)
    ]
    along = still | (sides[0] & sides[1] & (steady[0] | steady[1]))
    return np.asarray(along & (rows > 0) & (counts[rows - 1] > 0))


def _into(inputs: Sequence[Array], rows: Array) -> Points:
    """The steps (inputs, n) of the inputs into these rows."""
    return np.array([numbers_of(column[rows]) - numbers_of(column[rows - 1]) for column in inputs])


def continued(heading: Points, points: Points, turns: Points) -> tuple[Array, NDArray[np.bool_]]:
    """For places (v, k, r) the nearest of points (v, j, r): (k, r), and whether clearly so."""
    apart = distances(heading, points, turns)
    nearest = apart.argmin(axis=1)
    least = np.take_along_axis(apart, nearest[:, None], axis=1)[:, 0]
    np.put_along_axis(apart, nearest[:, None], np.inf, axis=1)
    return nearest, least <= CLEARLY_NEARER * apart.min(axis=1)


def distances(heading: Points, points: Points, turns: Points) -> Points:
    """From each place (v, k, r) to each answer (v, j, r): (k, j, r), variables scaled by their
    spread. Those that are equal in all answers do not count."""
    total = np.zeros((heading.shape[1], *points.shape[1:]))
    for here, there, turn in zip(heading, points, turns, strict=True):
        off = abs(without_turns(here[:, None] - there[None], turn))
        differs = np.ptp(there, axis=0) > SAME_VALUE * abs(there).max(axis=0)
        total += np.divide(off, off.max(axis=(0, 1)), out=np.zeros_like(off), where=differs)
    return total


def steady_runs(
    inputs: Sequence[Array],
    rows: Array | None,
    planes: Sequence[list[Array]],
    whole: Array,
    turns: Points,
) -> list[tuple[int, int]]:
    """The runs of ``Answers`` among all or some ``rows`` (n,) of a sweep: spans whose inputs move
    steadily and whose answers all exist, ``whole`` (n,), and are far apart, by bounds on
    ``distances`` from the least and the largest numbers of the answers in each span and the two
    rows before it."""
    starts = np.arange(0, len(whole) - SPAN + 1, SPAN)
    if len(planes) < 2 or len(starts) < 2 or not len(turns):
        return []
    far = np.logical_and.reduceat(whole, starts)
    if rows is not None:
        first, last = np.maximum(starts - 2, 0), np.append(starts[1:], len(rows)) - 1
        far &= rows[last] - rows[first] == last - first  # without gaps
    far &= moving(inputs)
    if far.any():
        far &= far_apart(np.array([[_ends(c, starts) for c in plane] for plane in planes]), turns)
    edges = np.append(starts, len(whole))[np.flatnonzero(np.diff(far, prepend=False, append=False))]
    return [(max(start - 2, 0), end) for start, end in edges.reshape(-1, 2).tolist()]


@np.errstate(all="ignore")
def _ends(column: Array, starts: Array) -> Points:
    """The least and the largest number (2, spans) of each span of a column and the two rows before
    it."""
    ends = np.empty((2, len(starts)))
    for extreme, found in zip((np.minimum, np.maximum), ends, strict=True):
        extreme.reduceat(column, starts, out=found)
        extreme(found[1:], extreme(column[starts[1:] - 1], column[starts[1:] - 2]), out=found[1:])
    return ends


@np.errstate(all="ignore")
def moving(inputs: Sequence[Array], span: int = SPAN) -> NDArray[np.bool_]:
    """Whether the inputs (n,) move steadily in each span and the two rows before it."""
    count = len(inputs[0])
    starts = np.arange(0, count - span + 1, span)
    some, every = np.zeros(len(starts), dtype=bool), np.ones(len(starts), dtype=bool)
    low, high = np.empty((2, len(starts)))
    room, many = np.empty(min(ROOM, count) + 2 * span), max(ROOM // span, 1)
    for column in inputs:
        for at in range(0, len(starts), many):
            here = starts[at : at + many]
            first, end = max(here[0] - 2, 1), count if at + many >= len(starts) else here[-1] + span
            steps = np.subtract(
                column[first:end], column[first - 1 : end - 1], out=room[: end - first]
            )
            edges = np.maximum(np.stack((here - 2, here + span), axis=1).ravel()[:-1] - first, 0)
            low[at : at + many] = np.minimum.reduceat(steps, edges)[::2]
            high[at : at + many] = np.maximum.reduceat(steps, edges)[::2]
        even = ((low > 0.0) & (high <= STEADY * low)) | ((high < 0.0) & (low >= STEADY * high))
        some |= even
        every &= even | ((low == 0.0) & (high == 0.0))
    return some & every


@np.errstate(all="ignore")
def far_apart(ends: Points, turns: Points) -> NDArray[np.bool_]:
    """Whether in each span every answer clearly continues itself, whatever its steps are."""
    count = len(ends)
    low, high = ends[:, :, 0], ends[:, :, 1]
    middle, width = (high + low) / 2.0, (high - low)[:, None]
    apart = abs(without_turns(middle[:, None] - middle[None], turns[:, None]))
    reach = (3.0 * width + width.swapaxes(0, 1)) / 2.0  # of an answer and where another was heading
    least = np.maximum(apart - reach, 0.0)
    most, around = (apart + reach).max(axis=(0, 1)), least.max(axis=(0, 1))
    own = np.where(most > 0.0, np.minimum(2.0 * width / around, 1.0), 0.0).sum(axis=2)
    other = np.where(most > 0.0, least / most, 0.0).sum(axis=2)
    clear: NDArray[np.bool_] = own <= CLEARLY_NEARER * other
    clear[np.arange(count), np.arange(count)] = True
    return np.asarray(clear.all(axis=(0, 1)))


def numbers_of(column: Array) -> Points:
    """The numbers of a column; a symbol is a number by its letters, far from all others, and the
    same in every process."""
    if column.dtype != object:
        return np.nan_to_num(column)
    numbers = (
        int.from_bytes(value.encode()[:4], "big") if isinstance(value, str) else value or 0.0
        for value in column.tolist()
    )
    return np.fromiter(numbers, dtype=float, count=len(column))


def without_turns(apart: Points, turns: Any) -> Points:
    """Differences without whole turns."""
    turned = np.where(np.isfinite(turns), turns, 1.0)
    return np.where(np.isfinite(turns), apart - turned * np.rint(apart / turned), apart)
