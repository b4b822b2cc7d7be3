"""Paths that fork at many steps: every combination is an answer of its own, and long ones fit into
memory."""

from __future__ import annotations

import tracemalloc
from itertools import product

import pytest

import rulesheets
import solver


def test_all_combinations_of_forks() -> None:
    """Roots that lead on to two, one and no further ones, with a case and a check on the way."""
    sheet = """a^2 = 9
b^2 = a + 3
abs(c - b) = 1
if c > 0 then d = c + 1
if c <= 0 then d = c - 1
e^2 = d + 2
f = a + b
f = 3 + b
"""
    expected = set()
    for b, step in product((6**0.5, -(6**0.5)), (1.0, -1.0)):
        c = b + step
        d = c + 1 if c > 0 else c - 1
        if d + 2 >= 0:
            expected |= {(3.0, b, c, d, sign * (d + 2) ** 0.5) for sign in (1.0, -1.0)}
    result = solver.solve(rulesheets.loads(sheet))
    assert result.complete
    found = {tuple(answer[name] for name in "abcde") for answer in result.solutions}
    assert sorted(found) == [pytest.approx(one) for one in sorted(expected)]


def test_steps_with_two_roots_each_fill_no_memory() -> None:
    """Logistic growth by implicit steps: by hand the positive root of each step."""
    n, y = 700, 5.0
    lines = [f"y{i} = y{i - 1} + 0.02*y{i}*(1 - y{i}/50)" for i in range(1, n + 1)]
    model = rulesheets.loads("\n".join(["y0 = 5", *lines]))
    tracemalloc.start()
    result = solver.solve(model)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    for i in range(1, n + 1):
        b, c = 0.98 / 0.0004, -y / 0.0004  # y^2/2500 + 0.98 y = the one before
        y = -2 * c / (b + (b * b - 4 * c) ** 0.5)
        assert result[f"y{i}"] == pytest.approx(y, rel=1e-12)
    assert peak < 4e7, peak
