"""Values of special functions cost what mpmath takes for them, more or less."""

from __future__ import annotations

import rulesheets
from solver.accuracy.effort import effort, special_effort


def test_an_error_function_to_many_digits_costs_thousands_of_products() -> None:
    product, error = (rulesheets.loads(f"y = {text}").equations[0].right for text in ("x*x", "erfc(x)"))
    assert effort(product, 800) == effort(product, 50) == 3
    assert special_effort(product, 800) == 0
    assert effort(error, 800) > 1000 * effort(product, 800)
    assert effort(error, 50) < 10 * effort(product, 50)
