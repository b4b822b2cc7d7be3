"""What the last places of given numbers leave open: inputs, and numbers that stand in the rules.

A number that takes all the digits of a float stands for any that rounds to it, up to half a unit of its last
place: 0.3 does, 0.25 and 3 do not. Only by accident can it rest on less than that whether something is
determined.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

from rulesheets.evaluate import Undefined, derivatives
from rulesheets.model import Value
from rulesheets.syntax.construct import map_leaves
from rulesheets.syntax.nodes import Expression, Name, Number, Symbol

UNIT = 2.0**-53


def half_unit(number: float) -> float:
    """How far a given number may be from the one that was meant: nothing, for one with few digits."""
    from struct import pack, unpack

    short = abs(number) < 1e38 and unpack("f", pack("f", number))[0] == number
    return 0.0 if short else abs(number) * UNIT


def with_named_numbers(expression: Expression, numbers: dict[str, float]) -> Expression:
    """The expression with names for its numbers that have last places; ``numbers`` learns their values.

    A number that is written twice is one number, and off by the same.
    """

    def named(leaf: Name | Number | Symbol) -> Expression:
        if not isinstance(leaf, Number) or not half_unit(leaf.value):
            return leaf
        name = f"#{leaf.value!r}"
        numbers[name] = leaf.value
        return Name(name)

    return map_leaves(expression, named)


def blur(expression: Expression, values: Mapping[str, Value], known: Mapping[str, float]) -> float:
    """How far an expression may be off where the numbers it reads are, by name, as far off as ``known``.

    Its own numbers count by their last places. Infinite where a slope has no value.
    """
    numbers: dict[str, float] = {}
    named = with_named_numbers(expression, numbers)
    try:
        slopes = derivatives(named, {**values, **numbers})[1]
    except Undefined:
        return math.inf
    off = {**known, **{name: half_unit(number) for name, number in numbers.items()}}
    total = sum(abs(slope) * off[name] for name, slope in slopes.items() if off.get(name))
    return math.inf if math.isnan(total) else total
