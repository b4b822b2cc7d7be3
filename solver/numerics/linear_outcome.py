"""What is known of a linear system after it was solved."""

from __future__ import annotations

from dataclasses import dataclass

from solver.numerics.outcome import Outcome


@dataclass(frozen=True, slots=True)
class LinearOutcome:
    """The facts about A x = b with A of m rows and n columns.

    ``solution``: correctly rounded where exact; entry j is None where unknown j is not determined. None
    as a whole where the rows contradict one another.
    ``nullspace``: a basis, each vector (n,); unknown j is free if any vector has a nonzero j-th entry.
    ``conflict``: a smallest-by-inclusion set of rows whose combination reads 0 = miss with miss ≠ 0;
    ``multipliers`` are the factors of those rows, ``miss`` their combined right-hand side.
    ``condition``: of the row-scaled matrix in the 1-norm, None where decided exactly.
    """

    outcome: Outcome
    rank: int
    solution: tuple[float | None, ...] | None
    nullspace: tuple[tuple[float, ...], ...] = ()
    conflict: tuple[int, ...] = ()
    multipliers: tuple[float, ...] = ()
    miss: float = 0.0
    exact: bool = True
    condition: float | None = None

    @property
    def free(self) -> tuple[int, ...]:
        """Indices of the unknowns that the rows leave free."""
        size = len(self.nullspace[0]) if self.nullspace else 0
        return tuple(j for j in range(size) if any(vector[j] for vector in self.nullspace))
