"""Pieces of a sweep solved by several processes of this machine, in order.

Each worker is a fresh interpreter, whatever this process has done before (threads, a script without a
main guard), and is spoken to by a thread of this one. A worker that ends too early loses nothing: its
piece is given to a new one.
"""

from __future__ import annotations

import json
import os
import pickle
import signal
import subprocess
import sys
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import CancelledError, Future, ThreadPoolExecutor
from contextlib import closing, suppress
from queue import SimpleQueue
from typing import Any

from rulesheets.diagnosis import RuleSheetError, error
from solver.interruption import Interrupted
from solver.sweeps.chunks import Chunk
from solver.sweeps.work import Solved, Work

PATIENCE = 5.0
"""Seconds that a worker has to end after an interrupt."""
TRIES = 3
"""Workers that may end over one piece before the sweep is given up."""

_START = (
    "import sys, json; sys.path[:] = json.loads(sys.argv[1]); from solver.sweeps.worker import serve; serve()"
)


def solved_by_workers(work: Work, chunks: Iterable[Chunk], jobs: int) -> Iterator[Solved]:
    """The pieces in their order; two a worker are under way at any time.

    Raises RuleSheetError (E446) where workers keep ending over one piece.
    """
    with closing(_Workers(work.packed(), jobs)) as workers:
        yield from in_order(workers.submit, chunks, lambda: 2 * jobs, workers.interrupt)


def in_order(
    submit: Callable[[Chunk], Any],
    chunks: Iterable[Chunk],
    window: Callable[[], int],
    interrupt: Callable[[], None] | None = None,
) -> Iterator[Solved]:
    """Results of futures in the order of the pieces, never more than ``window()`` of them under way.

    At an interrupt the pieces under way are cut short by ``interrupt``, and Interrupted is raised with what
    there is of them up to the first row that is not solved.
    """
    under_way: deque[Any] = deque()
    try:
        for chunk in chunks:
            under_way.append(submit(chunk))
            while len(under_way) >= window():
                yield _whole(under_way[0].result())
                under_way.popleft()
        while under_way:
            yield _whole(under_way[0].result())
            under_way.popleft()
    except KeyboardInterrupt:
        if interrupt is None:
            raise
        interrupt()
        kept = tuple(_left(under_way))
        raise Interrupted(sum(sum(piece.counts) for piece in kept), kept) from None


def _whole(answer: Any) -> Solved:
    assert isinstance(answer, Solved)
    return answer


def _left(under_way: Iterable[Any]) -> Iterator[Solved]:
    """What is solved of pieces under way, up to the first gap."""
    for future in under_way:
        try:
            answer = future.result(PATIENCE)
        except (TimeoutError, CancelledError, RuleSheetError):
            return
        if not isinstance(answer, Solved):
            yield from answer
            return
        yield answer


class _Workers:
    def __init__(self, work: bytes, jobs: int) -> None:
        self._work = work
        self._threads = ThreadPoolExecutor(jobs, thread_name_prefix="worker")
        self._idle: SimpleQueue[_Worker] = SimpleQueue()
        self._all: list[_Worker] = []
        self._closed = self._ending = False
        for _ in range(jobs):
            self._idle.put(self._started())

    def interrupt(self) -> None:
        """Ask the workers for what they have, and start no other piece."""
        self._ending = True
        for worker in self._all:
            worker.interrupt()

    def submit(self, chunk: Chunk) -> Future[Solved | tuple[Solved, ...]]:
        return self._threads.submit(self._solve, chunk)

    def close(self) -> None:
        """End the workers, whatever they are doing."""
        self._closed = True
        for worker in self._all:
            worker.kill()
        self._threads.shutdown(wait=True, cancel_futures=True)
        for worker in self._all:
            worker.end()

    def _solve(self, chunk: Chunk) -> Solved | tuple[Solved, ...]:
        """A piece, or as a tuple what an interrupt has left of it."""
        for _ in range(TRIES):
            worker = self._idle.get()
            if self._closed or self._ending:
                self._idle.put(worker)
                return ()
            try:
                answer = worker.ask(chunk)
            except (OSError, EOFError, pickle.UnpicklingError):
                worker.end()
                self._idle.put(worker if self._closed else self._started())
            else:
                self._idle.put(worker)
                if isinstance(answer, Exception):
                    raise answer
                assert isinstance(answer, Solved | tuple)
                return answer
        raise RuleSheetError(error("E446", notes=("free some memory, or give --jobs 1",)))

    def _started(self) -> _Worker:
        worker = _Worker(self._work)
        self._all.append(worker)
        return worker


class _Worker:
    """One process. It is out of reach of the terminal's interrupt, and ends when this process does."""

    def __init__(self, work: bytes) -> None:
        self._work: bytes | None = work
        self._process = subprocess.Popen(
            [sys.executable, "-c", _START, json.dumps(sys.path)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            env={**os.environ, "OMP_NUM_THREADS": "1", "NUMBA_NUM_THREADS": "1"},
            start_new_session=True,
        )

    def ask(self, chunk: Chunk) -> object:
        assert self._process.stdin is not None and self._process.stdout is not None
        if self._work is not None:
            pickle.dump(self._work, self._process.stdin, protocol=5)
            self._work = None
        pickle.dump(chunk, self._process.stdin, protocol=5)
        self._process.stdin.flush()
        return pickle.load(self._process.stdout)

    def interrupt(self) -> None:
        self._process.send_signal(signal.SIGINT)

    def kill(self) -> None:
        self._process.kill()

    def end(self) -> None:
        """No thread may be asking any more."""
        assert self._process.stdin is not None and self._process.stdout is not None
        self._process.kill()
        self._process.wait()
        for pipe in (self._process.stdin, self._process.stdout):
            with suppress(OSError):  # what the process did not read any more goes nowhere
                pipe.close()
