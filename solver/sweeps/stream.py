"""A sweep from its first piece to its last: pieces handed to the sinks, counted, and ended well."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

from solver.interruption import Interrupted
from solver.result import Status
from solver.sweeps.interrupts import Interrupts
from solver.sweeps.sinks import Sink
from solver.sweeps.work import Solved

_STATUSES = tuple(Status)


@dataclass(frozen=True)
class Outcome:
    """``counts`` are the rows by status code, ``several`` those of which one of several answers is shown;
    ``interrupted`` says that there would have been more.
    """

    counts: tuple[int, ...]
    interrupted: bool = False
    several: int = 0

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
        told = f"{self.rows:,} {'row' if self.rows == 1 else 'rows'}: {parts}"
        if not self.several:
            return told
        have = "has" if self.several == 1 else "have"
        rows = "row" if self.rows == 1 else "rows"
        first = "several answers; the first of each is shown"
        return f"{told}\n{self.several:,} of {self.rows:,} {rows} {have} {first}"


def run(
    pieces: Iterator[Solved], sinks: Sequence[Sink], progress: Callable[[int], None] | None = None
) -> Outcome:
    """Hand every piece to every sink. ``progress`` hears the number of rows done.

    An interrupt ends the sweep and keeps what is done; anything else that ends it early discards the
    sinks and is raised. A second interrupt, while the files are finished, discards them too.
    """
    counts, several = [0] * len(_STATUSES), 0
    with Interrupts() as interrupts:
        try:
            for piece in _each(pieces, interrupts):
                for sink in sinks:
                    sink.add(piece)
                counts = [done + more for done, more in zip(counts, piece.counts, strict=True)]
                several += piece.several
                if progress is not None:
                    progress(sum(counts))
            for sink in sinks:
                sink.close()
        except BaseException:
            for sink in sinks:
                sink.discard()
            raise
        return Outcome(tuple(counts), interrupts.asked, several)


def _each(pieces: Iterator[Solved], interrupts: Interrupts) -> Iterator[Solved]:
    """The pieces, and what an interrupt leaves of those that are under way."""
    while not interrupts.asked:
        try:
            with interrupts.open():
                piece = next(pieces, None)
        except Interrupted as reached:
            yield from reached.kept
            return
        except KeyboardInterrupt:
            return
        if piece is None:
            return
        yield piece
