"""What it costs to compute a rule to many digits, in arithmetic operations to fifty digits.

Counted, not timed, so that a search that ends for want of it ends at the same point anywhere. Where ``erf``
and ``erfc`` come within 1e-800 of their ends, mpmath takes thousands of times as long as for a product.
"""

from __future__ import annotations

from rulesheets.nodes import Call, Expression
from rulesheets.program import walk

_ERROR = frozenset({"erf", "erfc"})
_SPECIAL = frozenset(
    {"gamma", "lgamma", "digamma", "beta", "j0", "j1", "jn", "y0", "y1", "yn", "i0", "k0"}
    | {"bessel_i1", "bessel_k1"}
)
_ERROR_UNIT, _SPECIAL_UNIT = 200, 1_500
"""The square of the digits over that is what one value costs."""


def effort(expression: Expression, digits: int) -> int:
    """Of one value of an expression: an operation for each of its parts, and more for special functions."""
    return sum(1 for _ in walk(expression)) + special_effort(expression, digits)


def special_effort(expression: Expression, digits: int) -> int:
    """Of the special functions alone in one value of an expression."""
    units = (_unit(part.function) for part in walk(expression) if isinstance(part, Call))
    return sum(digits * digits // unit for unit in units if unit)


def _unit(function: str) -> int:
    return _ERROR_UNIT if function in _ERROR else _SPECIAL_UNIT if function in _SPECIAL else 0
