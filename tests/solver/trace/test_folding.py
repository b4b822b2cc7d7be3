"""Error bounds of constants that were computed, against rational numbers."""

from __future__ import annotations

import math
import operator
from collections.abc import Callable
from fractions import Fraction
from typing import Any

import pytest
from hypothesis import assume, example, given
from hypothesis import strategies as st

from solver.trace.graph import folded_error

OPERATIONS: dict[str, Callable[[Any, Any], Any]] = {
    "add": operator.add,
    "sub": operator.sub,
    "mul": operator.mul,
    "div": operator.truediv,
}
NUMBERS = st.floats(allow_nan=False, allow_infinity=False)


@pytest.mark.parametrize("name", OPERATIONS)
@given(a=NUMBERS, b=NUMBERS)
@example(a=1e-200, b=1e-200)
@example(a=3e-170, b=1e-150)
@example(a=2.0**-600, b=2.0**-460)
@example(a=5e-324, b=3.0)
def test_the_rounding_of_an_operation_is_within_its_bound(name: str, a: float, b: float) -> None:
    """Exact operands: what is off is the rounding alone, of numbers below floats too."""
    operation = OPERATIONS[name]
    assume(b or name != "div")
    result = operation(a, b)
    assume(math.isfinite(result))
    off = abs(operation(Fraction(a), Fraction(b)) - Fraction(result))
    assert off <= Fraction(folded_error(operation, name, result, [(a, 0.0), (b, 0.0)]))


@given(st.floats(0.0, allow_infinity=False, allow_nan=False))
def test_the_rounding_of_a_root_is_within_its_bound(a: float) -> None:
    result = math.sqrt(a)
    bound = Fraction(folded_error(math.sqrt, "sqrt", result, [(a, 0.0)]))
    low, high = Fraction(result) - bound, Fraction(result) + bound
    assert max(low, Fraction(0)) ** 2 <= Fraction(a) <= high**2
