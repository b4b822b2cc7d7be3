"""How much work one solve may spend on proofs and last resorts: counted, not timed, so the same anywhere.

The unit is one operation of interval arithmetic on the boxes of one level of a search. What is left out for
want of it shows in the outcome: a search that was cut short does not claim to be complete. Whoever asks for
more work also looks at the clock: a limit in time ends the solve (``rulesheets/deadline.py``).
"""

from __future__ import annotations

from rulesheets.deadline import expect_time

SOLVE = 60_000
BLOCK = 16_000
GLANCE = 1_500
"""For a block whose proof would be in vain, because it is known already that something was left out."""
ROUNDS = 40
LAST_RESORTS = 2
STEP, PLAN, SEARCH, ROUND, LAST_RESORT = 10, 50, 100, 8_000, 100_000
"""What else costs time, in the same unit."""


class Budget:
    """What is left of the work of one solve, shared by all of its blocks and cases.

    ``thorough``: a proof was asked for, and may cost what it costs. ``brief``: all that is asked is
    whether there is an answer, and what rarely finds one is left out.
    """

    def __init__(self, thorough: bool = False) -> None:
        self.thorough = thorough
        self.brief = False
        self.left = SOLVE
        self.used = 0
        self.of_block = BLOCK
        self.rounds = ROUNDS
        self.last_resorts = LAST_RESORTS

    def begin_block(self, proving: bool = True, shared: bool = False) -> None:
        """``proving``: whether a proof that a block has no other answers would still serve the whole.

        ``shared``: whether the block is one of many cases or values, which share what a solve may spend;
        others have their own.
        """
        expect_time()
        self.used += SEARCH
        self.shared = shared
        self.of_block = min(self.left if shared else BLOCK, BLOCK if proving else GLANCE)

    def levels(self, operations: int, most: int) -> int:
        """So many levels of a search, each of so many operations, can still be afforded."""
        expect_time()
        return min(most, self.of_block // max(operations, 1))

    def affords(self, work: int) -> bool:
        return work <= self.of_block

    def spend(self, work: int) -> None:
        self.used += work
        self.of_block = max(self.of_block - work, 0)
        if self.shared:
            self.left = max(self.left - work, 0)

    def another_round(self) -> bool:
        """Whether there may be one more round of starts, beside the first of each block."""
        expect_time()
        self.used += ROUND
        self.rounds -= self.shared
        return self.rounds >= 0

    def last_resort(self) -> bool:
        """Whether a search may still be tried that costs more than all others and rarely helps."""
        expect_time()
        self.last_resorts -= 1
        if self.last_resorts < 0 or self.brief:
            return False
        self.used += LAST_RESORT
        return True
