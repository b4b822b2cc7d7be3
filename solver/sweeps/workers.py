"""Solves the pieces of a sweep in order: here, by several processes, or on a dask cluster.

Each worker is a fresh interpreter, whatever this process has done before (threads, a script without
a main guard), and a thread of this process communicates with it. If a worker dies, its piece is
given to a new one.
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
from contextlib import ExitStack, closing, contextmanager, suppress
from functools import lru_cache
from importlib import import_module
from importlib.metadata import version
from itertools import takewhile
from math import inf
from threading import Lock, current_thread, local, main_thread
from time import thread_time
from types import FrameType
from typing import Any

from rulesheets.deadline import INTERRUPTS, interrupted
from rulesheets.diagnosis import RuleSheetError, error, refusal
from rulesheets.registered import in_memory
from solver.files import require_extra
from solver.files.tables import Chunk
from solver.sweeps.work import Rows, Solver, Work, unpacked

PAUSE, PATIENCE = 0.2, 5.0
"""Seconds between two looks for an interrupt, and those that a worker has to end after one."""
TRIES = 3
"""Workers that may die over one piece before the sweep is abandoned."""

_START = (
    "import sys, json; sys.path[:] = json.loads(sys.argv[1]); "
    "from solver.sweeps.workers import serve; serve()"
)


def solved_by_workers(work: Work, chunks: Iterable[Chunk], jobs: int) -> Iterator[Rows]:
    """The pieces in their order; two for each worker are in progress at any time.

    Raises RuleSheetError (E446) if workers repeatedly die over one piece.
    """
    with closing(_Workers(work.packed(), jobs)) as workers:
        yield from in_order(workers.submit, chunks, lambda: 2 * jobs, workers.interrupt)


def in_order(
    submit: Callable[[Chunk], Any],
    chunks: Iterable[Chunk],
    window: Callable[[], int],
    interrupt: Callable[[], None] | None = None,
) -> Iterator[Rows]:
    """Results of futures in the order of the pieces, never more than ``window()`` of them in
    progress.

    At an interrupt the pieces in progress are cut short by ``interrupt``, else abandoned.
    """
    under_way, left = deque[Any](), iter(chunks)
    while True:
        while len(under_way) < window() and (chunk := next(left, None)) is not None:
            under_way.append(submit(chunk))
        if not under_way or (rows := _awaited(under_way.popleft(), interrupt)) is None:
            return
        yield rows


def _awaited(future: Any, interrupt: Callable[[], None] | None) -> Rows | None:
    """The piece of a future; None if an interrupt leaves none of it."""
    patience = PAUSE
    while True:
        try:
            rows: Rows = future.result(patience)
            return rows
        except CancelledError:
            return None
        except TimeoutError:
            if interrupted() and (interrupt is None or patience > PAUSE):
                return None
            if interrupted() and interrupt is not None:
                interrupt()
                patience = PATIENCE


class _Workers:
    """Processes, with a thread for each, which starts its own with its first piece. The terminal's
    interrupt does not reach them, and they end when this process does."""

    def __init__(self, work: bytes, jobs: int) -> None:
        self._work, self._ending = work, False
        self._threads = ThreadPoolExecutor(jobs, thread_name_prefix="worker")
        self._own, self._all = local(), list[Any]()

    def interrupt(self) -> None:
        """Request the finished rows from the workers, and start no other piece."""
        for worker in [] if self._ending else self._all:
            worker.send_signal(signal.SIGINT)
        self._ending = True

    def submit(self, chunk: Chunk) -> Future[Rows]:
        return self._threads.submit(self._solve, chunk)

    def close(self) -> None:
        """End the workers, whatever they are doing."""
        self._ending = True
        for worker in self._all:
            worker.kill()
        self._threads.shutdown(wait=True, cancel_futures=True)
        for worker in self._all:
            worker.kill()
            worker.wait()
            for pipe in (worker.stdin, worker.stdout):
                with suppress(OSError):  # the unread input of the process is discarded
                    pipe.close()

    def _solve(self, chunk: Chunk) -> Rows:
        for _ in range(TRIES):
            if self._ending:
                raise CancelledError
            try:
                worker = vars(self._own).get("worker") or self._started()
                pickle.dump(chunk, worker.stdin, protocol=5)
                worker.stdin.flush()
                answer = pickle.load(worker.stdout)
            except (OSError, EOFError, pickle.UnpicklingError):
                if worker := vars(self._own).pop("worker", None):
                    worker.kill()
                continue
            if isinstance(answer, Exception):
                raise answer
            assert isinstance(answer, Rows)
            return answer
        raise RuleSheetError(error("E446", notes=("free some memory, or give --jobs 1",)))

    def _started(self) -> Any:
        worker = subprocess.Popen(
            [sys.executable, "-c", _START, json.dumps(sys.path)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            env={**os.environ, "OMP_NUM_THREADS": "1", "NUMBA_NUM_THREADS": "1"},
            start_new_session=True,
        )
        self._own.worker = worker
        self._all.append(worker)
        if self._ending:  # since it was asked
            worker.kill()
        pickle.dump(self._work, worker.stdin, protocol=5)  # type: ignore[arg-type]
        return worker


ENDING = (signal.SIGINT, signal.SIGTERM)
"""Ctrl-C, and the signal with which a batch system ends a process."""


@contextmanager
def one_interrupt() -> Iterator[None]:
    """Within this context, the first interrupt ends the time, and a second one is raised.

    Only the main thread receives signals: elsewhere nothing changes.
    """
    before = dict[signal.Signals, Any]()
    if current_thread() is main_thread():
        before = {number: signal.signal(number, _heard) for number in ENDING}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
        if before:
            INTERRUPTS.clear()


def _heard(number: int, frame: FrameType | None) -> None:
    INTERRUPTS.append(number)
    if len(INTERRUPTS) > 1:
        raise KeyboardInterrupt


def serve() -> None:
    """Solve pieces until there are no more. An interrupt lets the remaining rows fail."""
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)
    questions = sys.stdin.buffer
    with one_interrupt():
        solve = Solver(unpacked(pickle.load(questions)))
        while True:
            try:
                columns = pickle.load(questions)
            except EOFError:
                return
            try:
                answer: object = solve(columns)
            except Exception as failure:
                answer = failure
            pickle.dump(answer, answers, protocol=5)
            answers.flush()


ANSWER_WITHIN = 10
"""Seconds to wait for a scheduler, and for its first worker."""

_one_at_a_time = Lock()


def solved_on_cluster(work: Work, chunks: Iterable[Chunk], scheduler: Any) -> Iterator[Rows]:
    """The pieces in their order. ``scheduler`` is an address, or a ``distributed.Client``.

    Two pieces for each thread of the cluster are in progress at any time. Raises RuleSheetError:
    E441 without dask, E444 for a scheduler or workers that cannot be used.
    """
    require_extra("dask", "clusters need", "dask", "distributed")
    distributed = import_module("distributed")
    with ExitStack() as stack:
        client = scheduler
        if isinstance(scheduler, str):
            try:
                client = distributed.Client(scheduler, timeout=ANSWER_WITHIN, set_as_default=False)
            except (OSError, ValueError) as failure:
                raise _unusable(f"no scheduler answers at {scheduler}", str(failure)) from None
            stack.enter_context(client)
        try:
            client.wait_for_workers(1, timeout=ANSWER_WITHIN)
        except TimeoutError:
            raise _unusable(f"the scheduler at {scheduler} has no workers") from None
        packed, here = client.submit(bytes, work.packed(), pure=False), version("backsolve")
        try:
            yield from in_order(
                lambda chunk: client.submit(solve_piece, packed, here, chunk, pure=False),
                chunks,
                lambda: 2 * max(1, sum(client.nthreads().values())),
            )
        except distributed.KilledWorker as killed:
            raise _unusable("its workers keep ending over the same rows", str(killed)) from None
        except distributed.CancelledError:
            raise _unusable("the connection to the scheduler is lost") from None
        except ModuleNotFoundError as missing:
            raise _unusable(f"its workers have no module {missing.name}") from None


def solve_piece(packed: bytes, expected: str, chunk: Chunk) -> Rows:
    """Runs on a worker. The threads of a worker take turns: a plan serves one at a time."""
    with _one_at_a_time:
        return _solver(packed, expected)(chunk)


@lru_cache(maxsize=4)
def _solver(packed: bytes, expected: str) -> Solver:
    if (here := version("backsolve")) != expected:
        raise _unusable(f"its workers have Backsolve {here}, and this is {expected}")
    return Solver(unpacked(packed))


def _unusable(reason: str, *details: str) -> RuleSheetError:
    start = "workers are started with `dask worker ADDRESS --nthreads 1`"
    notes = (*filter(None, details), f"{start}, where Backsolve is installed")
    return refusal("E444", f"the cluster cannot be used: {reason}", None, *notes)


WORTH = 2.0
"""Seconds that workers must save to be started: about twice what starting them takes."""
ENOUGH = 0.02
"""Seconds below which measurements show overhead rather than rows."""
LEARNING = 1.0
"""Seconds of the first piece that recording and loading what they need can explain."""
CARRIAGE = 0.15e-6
"""Seconds that a row of six numbers is on its way to a worker and back."""


def processors() -> int:
    allowed = getattr(os, "sched_getaffinity", None)
    return len(allowed(0)) if allowed else os.cpu_count() or 1


def solved_pieces(
    work: Work,
    chunks: Iterator[Chunk],
    total: int | None,
    jobs: int | None = None,
    scheduler: object = None,
) -> Iterator[Rows]:
    """The pieces in their order: the same whoever solves them.

    ``jobs`` is a number of processes; None starts as many as there are processors if that pays off.
    Functions that are registered only in this process are computed by it. ``scheduler`` is the
    address of a dask cluster. An interrupt ends the pieces.
    """
    chunks = takewhile(lambda _: not interrupted(), chunks)
    if scheduler is not None:
        return solved_on_cluster(work, chunks, scheduler)
    if in_memory(side for one in work.model.equations for side in one.sides):
        jobs = 1
    if jobs is None and processors() > 1:
        return _adaptively(work, chunks, total, processors())
    if jobs is not None and jobs > 1:
        return solved_by_workers(work, chunks, jobs)
    return map(Solver(work), chunks)


def _adaptively(
    work: Work, chunks: Iterator[Chunk], total: int | None, jobs: int
) -> Iterator[Rows]:
    """Solve here, until the remaining work is worth starting workers for.

    If the number of remaining rows is unknown, it is assumed to equal the number solved so far. The
    first piece makes the records that serve the others, so its time does not count, unless its rows
    were slow by themselves; of two pieces in a row the quicker counts, since one may have a row
    that was solved step by step. Processor time is measured: on a busy machine workers pay off no
    sooner.
    """
    solve, done, before = Solver(work), 0, inf
    for number, chunk in enumerate(chunks):
        started = thread_time()
        solved = solve(chunk)
        spent, rows = thread_time() - started, len(chunk[0])
        done += rows
        yield solved
        if not number and spent < LEARNING:
            continue
        each, before = min(spent / rows, before), spent / rows
        left = done if total is None else total - done
        if spent >= ENOUGH and left * (each - CARRIAGE) * (1 - 1 / jobs) > WORTH:
            yield from solved_by_workers(work, chunks, jobs)
            return
