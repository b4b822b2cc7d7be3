"""What solving a block came to."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from solver.attempts import Attempt
from solver.facts import Fact, OutOfRange
from solver.kernel.candidates import Answer
from solver.kernel.code.chain import Chain


@dataclass(frozen=True, slots=True)
class Stretch:
    """A short interval of the tear of a ``chain`` that a search could not settle.

    ``turn``: the period of the tear, where it is an angle.
    """

    chain: Chain
    low: float
    high: float
    turn: float | None = None


@dataclass(frozen=True, slots=True)
class BlockOutcome:
    """``answers`` are distinct, the preferred one first; ``complete`` where they are proven to be all.

    ``facts`` explain what is missing; ``free`` are unknowns that the block does not determine (then
    the one answer holds what it does determine). ``attempts`` are the methods that were tried.
    ``suspects`` are points that satisfy the block so nearly that floats do not tell whether two roots lie
    there, one, or none. Where ``complete`` fails on that alone, ``stretches`` are where it does.
    ``refused`` are next to roots that are proven to be, of which floats have no digits good enough to be
    answers; if they were, all would be known where ``whole`` says so. ``blurred`` are where floats converge
    and cannot tell whether the block is satisfied. ``doubtful``: rounding may have decided whether a linear
    block determines its unknowns, or contradicts itself. ``remote``: there is a root beyond 1e60.
    ``cut``: there are more answers than are listed.
    """

    answers: tuple[Answer, ...] = ()
    complete: bool = False
    facts: tuple[Fact, ...] = ()
    free: tuple[str, ...] = ()
    attempts: tuple[Attempt, ...] = ()
    suspects: tuple[Mapping[str, float], ...] = ()
    stretches: tuple[Stretch, ...] = ()
    refused: tuple[Mapping[str, float], ...] = ()
    whole: bool = False
    blurred: tuple[Mapping[str, float], ...] = ()
    doubtful: bool = False
    remote: bool = False
    cut: bool = False

    @property
    def delicate(self) -> bool:
        unclear = self.suspects or self.refused or self.blurred
        return self.doubtful or self.remote or bool(unclear) or any(answer.double for answer in self.answers)

    @classmethod
    def out_of_range(cls, equations: tuple[int, ...], name: str, value: float) -> BlockOutcome:
        return cls(complete=True, facts=(OutOfRange(equations[0], name, value),))
