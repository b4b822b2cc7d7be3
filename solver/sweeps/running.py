"""Where the pieces of a sweep are solved: here, in several processes, or on a cluster."""

from __future__ import annotations

import os
from collections import deque
from collections.abc import Iterator
from time import thread_time

from rulesheets.functions.registered import in_memory
from solver.sweeps.chunks import Chunk
from solver.sweeps.work import Solved, Solver, Work

WORTH = 2.0
"""Seconds that workers must save to be started: about twice what starting them takes."""
RECENT = 5
"""Pieces that say what a row takes."""
ENOUGH = 0.02
"""Seconds below which they say more of their own overhead than of their rows."""
LEARNING = 1.0
"""Seconds of the first piece that recording and loading what they need can explain."""
CARRIAGE = 0.15e-6
"""Seconds that a row of six numbers is on its way to a worker and back."""


def processors() -> int:
    """Processors that this process may use."""
    allowed = getattr(os, "sched_getaffinity", None)
    return len(allowed(0)) if allowed else os.cpu_count() or 1


def solved_by_workers(work: Work, chunks: Iterator[Chunk], jobs: int) -> Iterator[Solved]:
    """The pieces in their order, from so many processes."""
    from solver.sweeps import workers  # with threads and pipes: dear where none is started

    return workers.solved_by_workers(work, chunks, jobs)


def solved_pieces(
    work: Work,
    chunks: Iterator[Chunk],
    total: int | None,
    jobs: int | None = None,
    scheduler: object = None,
) -> Iterator[Solved]:
    """The pieces in their order: the same whoever solves them.

    ``jobs`` is a number of processes; None starts as many as there are processors where that pays.
    Functions that are registered in this process alone are computed by it. ``scheduler`` is the address of a
    dask cluster.
    """
    if scheduler is not None:
        from solver.sweeps.cluster import solved_on_cluster

        return solved_on_cluster(work, chunks, scheduler)
    if in_memory(side for one in work.model.equations for side in (one.left, one.right)):
        jobs = 1
    if jobs is None and processors() > 1:
        return _as_it_pays(work, chunks, total, processors())
    if jobs is not None and jobs > 1:
        return solved_by_workers(work, chunks, jobs)
    return map(Solver(work), chunks)


def _as_it_pays(work: Work, chunks: Iterator[Chunk], total: int | None, jobs: int) -> Iterator[Solved]:
    """Here, until what is left turns out to be worth starting workers for.

    Where nobody knows how many rows are left it may be as many as there have been. The first piece teaches
    the records that serve the others, and is no measure of them, unless its rows were slow by themselves; nor
    is a piece with a row that had to go step by step, so that the typical one of the last pieces counts.
    Measured is the time of the processor: on a machine that others keep busy workers pay no sooner.
    """
    solve, done = Solver(work), 0
    recent: deque[tuple[float, float]] = deque(maxlen=RECENT)
    for number, chunk in enumerate(chunks):
        started = thread_time()
        solved = solve(chunk)
        spent = thread_time() - started
        done += len(chunk[0])
        yield solved
        if number or spent >= LEARNING:
            recent.append((spent / len(chunk[0]), spent))
        if not recent:
            continue
        each, typical = sorted(recent)[(len(recent) - 1) // 2]
        left = done if total is None else total - done
        if typical * len(recent) >= ENOUGH and left * (each - CARRIAGE) * (1 - 1 / jobs) > WORTH:
            yield from solved_by_workers(work, chunks, jobs)
            return
