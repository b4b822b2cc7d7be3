"""How much work one solve may spend on proofs and last resorts: counted, not timed, so the same anywhere.

The unit is one operation of interval arithmetic on the boxes of one level of a search. What is left out for
want of it shows in the outcome: a search that was cut short does not claim to be complete.
"""

from __future__ import annotations

SOLVE = 60_000
BLOCK = 12_000
LAST_RESORTS = 2


class Budget:
    """What is left of the work of one solve, shared by all of its blocks and cases."""

    def __init__(self) -> None:
        self.left = SOLVE
        self.of_block = BLOCK
        self.last_resorts = LAST_RESORTS

    def begin_block(self) -> None:
        self.of_block = min(self.left, BLOCK)

    def levels(self, operations: int, most: int) -> int:
        """So many levels of a search, each of so many operations, can still be afforded."""
        return min(most, self.of_block // max(operations, 1))

    def spend(self, work: int) -> None:
        self.left, self.of_block = max(self.left - work, 0), max(self.of_block - work, 0)

    def last_resort(self) -> bool:
        """Whether a search may still be tried that costs more than all others and rarely helps."""
        self.last_resorts -= 1
        return self.last_resorts >= 0
