"""How the rows of a sweep are cut into pieces: a matter of the rows alone, never of the clock.

A row can be solved from where its neighbour ended, so pieces decide the last bits. Cut alike, a sweep
gives the same bytes in one process, in several, and on a cluster.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np

from solver.files.columns import Array, stacked
from solver.sweeps.grid import Rows

SMALLEST, LARGEST = 256, 65_536
LESSONS = 256

Chunk = tuple[Array, ...]
"""The inputs of some rows, a column each."""


def size(done: int, total: int | None) -> int:
    """Rows of the next piece: few at first, so that slow rows show soon, and many of many."""
    limit = LARGEST if total is None else min(LARGEST, total // 16)
    return max(SMALLEST, min(limit, done // 4))


def grid_chunks(rows: Rows) -> Iterator[Chunk]:
    """Pieces of a grid, each made when it is asked for."""
    total, done = len(rows), 0
    while done < total:
        end = min(total, done + size(done, total))
        yield rows.columns(done, end)
        done = end


def grid_lessons(rows: Rows) -> Chunk:
    """Some rows from all over a grid, to learn from; of a short one none."""
    count = lessons(len(rows))
    places = np.linspace(0, len(rows) - 1, count).astype(np.int64) if count else ()
    made = [rows.columns(int(place), int(place) + 1) for place in places]
    return _joined(made) if made else ()


def first_lessons(chunk: Chunk) -> Chunk:
    """Some rows of the first piece, where nothing is known of the others."""
    count = lessons(16 * len(chunk[0])) if chunk else 0
    places = np.linspace(0, len(chunk[0]) - 1, count).astype(np.int64) if count else ()
    return tuple(column[places] for column in chunk) if count else ()


def lessons(total: int) -> int:
    """Rows to learn from: as many as do not weigh among so many."""
    return min(LESSONS, total // 64)


def file_chunks(pieces: Iterable[Chunk], total: int | None) -> Iterator[Chunk]:
    """Pieces of a file, however it was cut when it was read."""
    done, waiting, held = 0, list[Chunk](), 0
    for piece in pieces:
        waiting.append(piece)
        held += len(piece[0])
        while held >= size(done, total):
            whole = _joined(waiting)
            count = size(done, total)
            yield tuple(column[:count] for column in whole)
            done, held = done + count, held - count
            waiting = [tuple(column[count:] for column in whole)]
    if held:
        yield _joined(waiting)


def _joined(pieces: list[Chunk]) -> Chunk:
    return tuple(stacked(columns) for columns in zip(*pieces, strict=True))
