"""Pieces of a sweep solved by the workers of a dask cluster, in order (the only import of dask).

The work travels as bytes that the scheduler keeps, so that a worker that dies loses nothing that cannot be
computed again; dask gives its pieces to the others.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import ExitStack
from functools import lru_cache
from importlib.metadata import version
from threading import Lock
from typing import Any

from rulesheets.diagnosis import Diagnosis, RuleSheetError, error
from solver.files.replacing import missing_extra
from solver.sweeps.chunks import Chunk
from solver.sweeps.work import Solved, Solver, Work, unpacked
from solver.sweeps.workers import in_order

PATIENCE = 10
"""Seconds to wait for a scheduler, and for its first worker."""

_one_at_a_time = Lock()


def solved_on_cluster(work: Work, chunks: Iterable[Chunk], scheduler: Any) -> Iterator[Solved]:
    """The pieces in their order. ``scheduler`` is an address, or a ``distributed.Client``.

    Two pieces a thread of the cluster are under way at any time. Raises RuleSheetError: E441 without
    dask, E444 for a scheduler or workers that cannot be used.
    """
    distributed = _distributed()
    with ExitStack() as stack:
        client = stack.enter_context(_client(scheduler)) if isinstance(scheduler, str) else scheduler
        _workers(client, scheduler)
        packed = client.submit(bytes, work.packed(), pure=False)
        here = version("backsolve")

        def submit(chunk: Chunk) -> Any:
            return client.submit(solve_piece, packed, here, chunk, pure=False)

        def window() -> int:
            threads: dict[str, int] = client.nthreads()
            return 2 * max(1, sum(threads.values()))

        try:
            yield from in_order(submit, chunks, window)
        except distributed.KilledWorker as killed:
            raise RuleSheetError(
                _unusable("its workers keep ending over the same rows", str(killed))
            ) from None
        except distributed.CancelledError:
            raise RuleSheetError(_unusable("the connection to the scheduler is lost")) from None
        except ModuleNotFoundError as missing:
            raise RuleSheetError(_unusable(f"its workers have no module {missing.name}")) from None


def solve_piece(packed: bytes, expected: str, chunk: Chunk) -> Solved:
    """Runs on a worker. The threads of a worker take turns: a plan serves one at a time."""
    with _one_at_a_time:
        return _solver(packed, expected)(chunk)


@lru_cache(maxsize=4)
def _solver(packed: bytes, expected: str) -> Solver:
    here = version("backsolve")
    if here != expected:
        raise RuleSheetError(_unusable(f"its workers have Backsolve {here}, and this is {expected}"))
    return Solver(unpacked(packed))


def _client(address: str) -> Any:
    try:
        return _distributed().Client(address, timeout=PATIENCE, set_as_default=False)
    except (OSError, ValueError) as failure:
        raise RuleSheetError(_unusable(f"no scheduler answers at {address}", str(failure))) from None


def _workers(client: Any, scheduler: object) -> None:
    try:
        client.wait_for_workers(1, timeout=PATIENCE)
    except TimeoutError:
        raise RuleSheetError(_unusable(f"the scheduler at {scheduler} has no workers")) from None


def _distributed() -> Any:
    try:
        import distributed
    except ImportError:
        raise RuleSheetError(missing_extra("clusters need", "dask", "dask")) from None
    return distributed


def _unusable(reason: str, detail: str = "") -> Diagnosis:
    notes = ("workers are started with `dask worker ADDRESS --nthreads 1`, where Backsolve is installed",)
    return error("E444", f"the cluster cannot be used: {reason}", notes=(*filter(None, (detail,)), *notes))
