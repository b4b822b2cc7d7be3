"""What solving a block came to."""

from __future__ import annotations

from rulesheets.record import dataclass
from solver.attempts import Attempt
from solver.facts import Fact, OutOfRange
from solver.kernel.candidates import Answer


@dataclass(frozen=True, slots=True)
class BlockOutcome:
    """``answers`` are distinct, the preferred one first; ``complete`` where they are proven to be all.

    ``facts`` explain what is missing; ``free`` are unknowns that the block does not determine (then
    the one answer holds what it does determine). ``attempts`` are the methods that were tried.
    """

    answers: tuple[Answer, ...] = ()
    complete: bool = False
    facts: tuple[Fact, ...] = ()
    free: tuple[str, ...] = ()
    attempts: tuple[Attempt, ...] = ()

    @classmethod
    def out_of_range(cls, equations: tuple[int, ...], name: str, value: float) -> BlockOutcome:
        return cls(complete=True, facts=(OutOfRange(equations[0], name, value),))
