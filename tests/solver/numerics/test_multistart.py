"""Points that fill ranges."""

from __future__ import annotations

import math

from hypothesis import given
from hypothesis import strategies as st

from solver.numerics.box_search import place

BOUNDS = st.sampled_from([-math.inf, -1e9, -5.0, 0.0, 1e-6, 3.0, 1e9, math.inf])


@given(st.floats(0, 1, exclude_max=True), BOUNDS, BOUNDS, st.floats(1e-9, 1e9))
def test_starts_lie_in_their_range(share: float, low: float, high: float, scale: float) -> None:
    if low < high:
        x = place(share, low, high, scale)
        assert math.isfinite(x)
        assert low <= x <= high
