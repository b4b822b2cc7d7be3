"""A rule that computes with a symbol has no answer, wherever it stands."""

from __future__ import annotations

import pytest

import rulesheets
import solver


@pytest.mark.parametrize(
    "text",
    [
        "x + y = 'open\nx*y = 2",
        "x^3 + y = 'open\nexp(x)*y = 2 + x",
        "x^3 + y + z = 'open\nexp(x)*y = 2 + x\nx*z = cos(y)",
    ],
)
def test_arithmetic_with_a_symbol_in_a_block_is_no_answer(text: str) -> None:
    result = solver.solve(rulesheets.loads(text))
    assert str(result.status) != "solved" and not result.solutions
