"""How far a constant that was computed may be from the number that it stands for."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

UNIT = 2.0**-52
SMALLEST = math.ulp(0.0)
LIBRARY = 4.0
"""Units in the last place that a function of the library may be off by."""
WIDE = 2.0**16
_ROUNDED = frozenset({"add", "sub", "mul", "div", "sqrt"})
_EXACT = frozenset({"neg", "abs", "rint", "where", "max", "sooner"})


def folded_error(
    function: Callable[..., float | bool], name: str, result: float, operands: Sequence[tuple[float, float]]
) -> float:
    """The error bound of ``result``, the value of a function of operands (value, error bound of it)."""
    values = [value for value, _ in operands]
    exact = name in _EXACT or _is_exact(name, result, values)
    total = 0.0 if exact else max(abs(result) * UNIT, SMALLEST)  # what is below floats is rounded to one
    if name not in _ROUNDED:
        total *= LIBRARY
    for place, (value, off) in enumerate(operands):
        if off:
            total += _moved(function, values, place, value, off, result)
    return total


def _moved(
    function: Callable[..., float | bool],
    values: Sequence[float],
    place: int,
    value: float,
    off: float,
    result: float,
) -> float:
    """How far the result moves with one operand, to first order: by a larger move than rounding can hide."""
    moved = 0.0
    for near in (value - WIDE * off, value + WIDE * off):
        try:
            found = function(*values[:place], near, *values[place + 1 :])
        except (ArithmeticError, ValueError):
            return math.inf
        moved = max(moved, abs(found - result))
    return moved / WIDE * 1.01


def _is_exact(name: str, result: float, values: Sequence[float]) -> bool:
    """Whether an operation on exact numbers was exact."""
    if name not in _ROUNDED or not all(map(math.isfinite, (result, *values))):
        return False
    above, below = result.as_integer_ratio()
    (a, b), *others = (float(value).as_integer_ratio() for value in values)
    if name == "sqrt":
        return above * above * b == a * below * below
    ((c, d),) = others
    if name == "div":
        return above * b * c == a * d * below
    if name == "mul":
        return above * b * d == a * c * below
    c = c if name == "add" else -c
    return above * b * d == (a * d + c * b) * below
