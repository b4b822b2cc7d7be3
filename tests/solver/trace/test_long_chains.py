"""Records of long chains of rules are written without deep nesting."""

from __future__ import annotations

import numpy as np
import pytest

import rulesheets
import solver


@pytest.mark.parametrize("count", [250, 1200])
def test_a_plan_may_follow_a_thousand_rules(count: int) -> None:
    rules = "\n".join(f"x{k + 1} = x{k}*1.001 + {k % 7}" for k in range(count))
    model, name = rulesheets.loads(rules), f"x{count}"
    plan = solver.prepare(model, ["x0"], [name])
    expected = solver.solve(model, {"x0": 2.5})[name]
    assert plan(2.5)[0] == pytest.approx(expected, rel=1e-13)
    assert plan.sweep(np.array([2.5, 2.5]))[name] == pytest.approx([expected] * 2, rel=1e-13)
