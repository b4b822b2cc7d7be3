"""Where a list of answers that is cut off says that it ends."""

from __future__ import annotations

import mpmath

import rulesheets
from solver.leaves import Asked
from solver.solution.explore import PathSearch


def test_a_gap_is_told_by_numbers_of_many_digits_too() -> None:
    found = PathSearch(Asked(rulesheets.loads("sind(x) = 0.5"), {}, None, {}, ("x",)))
    listed = [{"x": mpmath.mpf(n)} for n in (1e16, 3e16, 2e16)]
    found.note(False, (0,), ("x",), listed, True)
    (gap,) = found.gaps.values()
    assert (gap.count, gap.low, gap.high) == (3, 1e16, 3e16)
