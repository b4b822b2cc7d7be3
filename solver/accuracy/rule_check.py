"""The independent check: does a rule, as written, hold at an answer?

A rule holds if its backward error is small: |F| ≤ 64 eps · Σ|∂F/∂v · v| over its variables, that
is, if values within a few ulp of those reported satisfy it exactly. Where the rounding of its own evaluation
may have made F (``cosd(x + 90)`` at a small x), or have hidden it (``tanh(x) = 1`` at 20), F and its slopes
are evaluated again to as many digits as it takes. Where F goes far within so small a change, slopes alone do
not tell (``cosd(x) = 2`` at 1e90): the other values must be enough, or F must change its sign there. Nor do
they next to a jump (``int(x) + x = 3`` below 2), where the values that they promise may lie beyond it.
Every decision that a rule is satisfied is made here, and nowhere else.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from struct import pack, unpack
from typing import NamedTuple

from rulesheets.evaluate import Undefined, derivatives, extended, rounded_derivatives, value
from rulesheets.functions import named
from rulesheets.model import Equation, Value
from rulesheets.syntax.nodes import (
    Call,
    Expression,
    Name,
    Number,
    Sum,
    Symbol,
    divide,
    map_leaves,
    names,
    subtract,
)
from rulesheets.syntax.program import walk
from solver.accuracy.many_digits import residual_in_many_digits
from solver.numerics.tolerances import BACKWARD, EPS, ROUNDINGS, STEEP, UNIT_ROUNDOFF

DIGITS = 50
LEAP = 4.0
"""How many times as far as a rule's slopes ask for its values are moved to see whether it jumps there."""
_JUMPING = named(lambda row: row.jumps)


class RuleCheck(NamedTuple):
    """``scaled`` is |F| / Σ|∂F/∂v · v|; ``miss`` is F, None where a side has no number.

    ``delicate``: floats could not decide; values in more digits may satisfy a rule that these do not.
    """

    holds: bool
    miss: float | None
    scaled: float = 0.0
    delicate: bool = False


class Sides(NamedTuple):
    """The values of both sides of a rule, the slopes of left minus right by variable, and the bound of what
    rounding makes of that."""

    left: float
    right: float
    slopes: dict[str, float]
    noise: float


@dataclass(slots=True)
class _Last:
    """What is known of an equation at the values it was last asked about: several ask of one answer."""

    at: tuple[Value, ...]
    sides: Sides | None = None
    check: RuleCheck | None = None


def _last(equation: Equation, values: Mapping[str, Value]) -> _Last:
    at = tuple([values[name] for name in equation.names])
    kept: _Last | None = equation.__dict__.get("_last")
    if kept is None or kept.at != at or (0.0 in at and str(kept.at) != str(at)):  # zeros have signs
        kept = equation.__dict__["_last"] = _Last(at)
    return kept


def is_checked(equation: Equation, values: Mapping[str, Value]) -> bool:
    """Whether the check of an equation is known at these values."""
    return _last(equation, values).check is not None


def note(equation: Equation, values: Mapping[str, Value], check: RuleCheck) -> None:
    """Keep what was found out about an equation elsewhere (``alike.py``)."""
    _last(equation, values).check = check


def sides(equation: Equation, values: Mapping[str, Value]) -> Sides:
    """Both sides at the values; slopes are to be read only. Raises Undefined."""
    kept = _last(equation, values)
    if kept.sides is None:
        left, slopes, noise = rounded_derivatives(equation.left, values)
        right, others, more = rounded_derivatives(equation.right, values)
        for name, slope in others.items():
            slopes[name] = slopes.get(name, 0.0) - slope
        kept.sides = Sides(left, right, slopes, noise + more)
    return kept.sides


def check_rule(equation: Equation, values: Mapping[str, Value]) -> RuleCheck:
    """Evaluate an equation all of whose variables have values."""
    kept = _last(equation, values)
    if kept.check is None:
        kept.check = _checked(equation, values)
    return kept.check


def _checked(equation: Equation, values: Mapping[str, Value]) -> RuleCheck:
    found = _by_slopes(equation, values)
    if found.holds and found.miss is not None and jumps(equation) and _leaps(equation, values):
        return RuleCheck(False, found.miss, found.scaled)
    return found


def _by_slopes(equation: Equation, values: Mapping[str, Value]) -> RuleCheck:
    left, right = equation.left, equation.right
    symbols = _symbol(left, values), _symbol(right, values)
    if symbols != (None, None):
        same = symbols[0] == symbols[1]
        return RuleCheck(same, None, 0.0 if same else math.inf)
    try:
        a, b, slopes, noise = sides(equation, values)
    except Undefined as error:
        underflow = 0.0 in error.arguments  # a divisor, or what a logarithm is taken of
        if error.overflow or underflow:
            return _look_again(equation, values, math.inf)
        return RuleCheck(False, None, math.inf)
    miss = a - b
    if miss == 0.0 and noise == 0.0:
        return RuleCheck(True, miss)
    moves = list(_moves(slopes, values))
    total = sum(moves)
    bound = BACKWARD * total
    if abs(miss) + noise <= bound < math.inf:
        limit = STEEP * (abs(a) + abs(b))
        near = abs(miss) <= BACKWARD * (abs(a) + abs(b))  # else slopes must show that they lead to 0
        gentle = sum(reach for move in moves if (reach := BACKWARD * move) <= limit)
        if near and (bound <= limit or abs(miss) + noise <= gentle):
            return RuleCheck(True, miss, abs(miss) / total)
    if abs(miss) > bound + ROUNDINGS * noise:
        return RuleCheck(False, miss, abs(miss) / total if total else math.inf)
    return _look_again(equation, values, noise)


def size(equation: Equation, values: Mapping[str, Value]) -> float:
    """Σ|∂F/∂v · v| over the variables of an equation; infinite where a slope has no value."""
    try:
        total = sum(_moves(sides(equation, values).slopes, values))
    except Undefined:
        return math.inf
    return total if math.isfinite(total) else math.inf


def gross(equation: Equation, values: Mapping[str, Value]) -> float:
    """How large the terms of an equation are before they cancel: what its rounding errors go by."""
    terms = [
        part
        for side in (equation.left, equation.right)
        for part in (side.terms if isinstance(side, Sum) else (side,))
    ]
    try:
        return sum(abs(value(term, values)) for term in terms)
    except Undefined:
        return math.inf


def _look_again(equation: Equation, values: Mapping[str, Value], noise: float) -> RuleCheck:
    if not all(isinstance(v := values[name], float) and math.isfinite(v) for name in equation.names):
        return RuleCheck(False, None, math.inf)
    found = residual_in_many_digits(equation, values, BACKWARD, STEEP, noise)
    miss = found.miss if math.isfinite(found.miss) else None
    return RuleCheck(found.reaches, miss, found.scaled, True)


def _leaps(equation: Equation, values: Mapping[str, Value]) -> bool:
    """Whether F jumps where its slopes promise 0: ``int(x) + x = 3`` is not satisfied below 2, nor at 2."""
    tied = {name for _, height in heights(equation) for name in names(height)}
    try:
        left, right, slopes, _ = sides(equation, values)
        miss = float(extended(equation.left, values, DIGITS) - extended(equation.right, values, DIGITS))
        moves = {
            n: (slopes.get(n, 0.0) * abs(v), abs(v))
            for n in equation.names
            if isinstance(v := values[n], float)
        }
        total = sum(abs(move) for move, _ in moves.values())
        if abs(miss) <= BACKWARD * sum(abs(move) for n, (move, _) in moves.items() if n not in tied):
            return False  # it is 0, or the other values make up for it
        moved, share = dict(values), LEAP * max(abs(miss) / total if total else 0.0, EPS)
        for name, (move, size) in moves.items():
            if move:
                moved[name] = float(values[name]) - math.copysign(share * size, move * miss)
        there = value(equation.left, moved) - value(equation.right, moved)
    except Undefined:
        return False
    return abs(there) > 4 * LEAP * (abs(miss) + EPS * (abs(left) + abs(right) + total))


def jumps(equation: Equation) -> bool:
    """Whether some function in the equation jumps (found once)."""
    found = equation.__dict__.get("_jumps")
    if found is None:
        found = equation.__dict__["_jumps"] = any(map(_has_jump, (equation.left, equation.right)))
    return bool(found)


def _has_jump(expression: Expression) -> bool:
    return any(isinstance(node, Call) and node.function in _JUMPING for node in walk(expression))


def heights(equation: Equation) -> Iterator[tuple[str, Expression]]:
    """The functions that jump, each with the expression that says how far from its jumps it is."""
    for node in (node for side in (equation.left, equation.right) for node in walk(side)):
        match node:
            case Call("int" | "frac" | "round" | "sgn" as function, (x,)):
                yield function, x
            case Call("mod", (x, y)):
                yield "int", divide(x, y)
            case Call("step", (x, a)):
                yield "step", subtract(x, a)


def _moves(slopes: Mapping[str, float], values: Mapping[str, Value]) -> Iterator[float]:
    """|∂F/∂v · v| for each variable."""
    return (abs(slope * v) for name, slope in slopes.items() if isinstance(v := values[name], float) and v)


def _symbol(expression: Expression, values: Mapping[str, Value]) -> str | None:
    if isinstance(expression, Symbol):
        return expression.name
    if isinstance(expression, Name):
        found = values[expression.name]
        return found if isinstance(found, str) else None
    return None


# --- what the last places of given numbers leave open: inputs, and numbers that stand in the rules ---
#
# A number that takes all the digits of a float stands for any that rounds to it, up to half a unit of its
# last place: 0.3 does, 0.25 and 3 do not. Only by accident can it rest on less than that whether something
# is determined.


def half_unit(number: float) -> float:
    """How far a given number may be from the one that was meant: nothing, for one with few digits."""
    short = abs(number) < 1e38 and unpack("f", pack("f", number))[0] == number
    return 0.0 if short else abs(number) * UNIT_ROUNDOFF


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
