"""Of more rules than unknowns some are solved and the others checked."""

from __future__ import annotations

import rulesheets
import solver


def test_of_redundant_rules_the_linear_ones_are_solved() -> None:
    """The others would give a double root: of all rectangles of a given girth the square is the
    largest."""
    result = solver.solve(rulesheets.loads("x*y = z + 10\nx + y = 10\nx - y = 0"), {"z": 15.0})
    assert str(result.status) == "solved"
    assert dict(result.solutions[0]) == {"x": 5.0, "y": 5.0, "z": 15.0}
