"""Random ordinary sheets: the planted state is found, nothing is false, and no worse answer comes
first."""

from __future__ import annotations

import pytest

from benchmarks.everyday import judged, mark
from benchmarks.everyday_sheets import random_sheet


@pytest.mark.parametrize("seed", range(60))
def test_planted_state_comes_first(seed: int) -> None:
    made = random_sheet(seed)
    found = judged(made)
    assert not found.false, found.false
    assert mark(found, made.state) in ("first", "rival"), f"{found}\n{made.text}"
