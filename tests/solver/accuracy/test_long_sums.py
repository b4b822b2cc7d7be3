"""What it costs to check a rule of thousands of terms, in which rounding decides."""

from __future__ import annotations

from collections.abc import Callable

import pytest

import rulesheets
import solver
from tests.oracles.operations import growth

RULES = {
    "sum": lambda names: "s = " + " + ".join(names),
    "root of squares": lambda names: "s = sqrt(" + " + ".join(f"{name}^2" for name in names) + ")",
}


@pytest.mark.parametrize("rule", RULES)
def test_the_cost_of_a_solve_is_linear(rule: str) -> None:
    """A difference quotient for each variable made it quadratic: 91 s for 2,000 terms."""

    def known(n: int) -> Callable[[], object]:
        names = [f"a{k}" for k in range(n)]
        lines = [f"{name} = {k}*0.7 + 0.3" for k, name in enumerate(names)]
        model = rulesheets.loads("\n".join([*lines, RULES[rule](names)]))
        return lambda: solver.solve(model)

    assert growth(known, 100, 8) < 1.35
    result = known(300)()
    assert isinstance(result, solver.Result)
    assert str(result.status) == "solved"
