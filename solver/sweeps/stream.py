"""A sweep from its first piece to its last: pieces handed to the sinks, counted, and ended well."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

from solver.result import Status
from solver.sweeps.interrupts import Interrupts
from solver.sweeps.sinks import Sink
from solver.sweeps.work import Solved

_STATUSES = tuple(Status)


@dataclass(frozen=True)
class Outcome:
    """``counts`` are the rows by status code; ``interrupted`` says that there would have been more."""

    counts: tuple[int, ...]
    interrupted: bool = False

    @property
    def rows(self) -> int:
        return sum(self.counts)

    @property
    def all_solved(self) -> bool:
        return self.counts[_STATUSES.index(Status.SOLVED)] == self.rows

    def __str__(self) -> str:
        """``361 rows: 340 solved, 21 infeasible``."""
        if not self.rows:
            return "no rows"
        pairs = zip(self.counts, _STATUSES, strict=True)
        parts = ", ".join(f"{count:,} {status}" for count, status in pairs if count)
        return f"{self.rows:,} {'row' if self.rows == 1 else 'rows'}: {parts}"


def run(
    pieces: Iterator[Solved], sinks: Sequence[Sink], progress: Callable[[int], None] | None = None
) -> Outcome:
    """Hand every piece to every sink. ``progress`` hears the number of rows done.

    An interrupt ends the sweep and keeps what is done; anything else that ends it early discards the
    sinks and is raised. A second interrupt, while the files are finished, discards them too.
    """
    counts = [0] * len(_STATUSES)
    with Interrupts() as interrupts:
        try:
            while (piece := _next(pieces, interrupts)) is not None:
                for sink in sinks:
                    sink.add(piece)
                counts = [done + more for done, more in zip(counts, piece.counts, strict=True)]
                if progress is not None:
                    progress(sum(counts))
            for sink in sinks:
                sink.close()
        except BaseException:
            for sink in sinks:
                sink.discard()
            raise
        return Outcome(tuple(counts), interrupts.asked)


def _next(pieces: Iterator[Solved], interrupts: Interrupts) -> Solved | None:
    """The next piece; None where there is none, or where no more are wanted."""
    if interrupts.asked:
        return None
    try:
        with interrupts.open():
            return next(pieces, None)
    except KeyboardInterrupt:
        return None
