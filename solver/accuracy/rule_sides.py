"""A rule at an answer in floats: its sides with their slopes, its size, and what the last places of
numbers leave open."""

from __future__ import annotations

import math
from collections.abc import Container, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from struct import pack, unpack
from typing import Any, NamedTuple

from rulesheets.evaluate import Undefined, derivatives, rounded_derivatives, value
from rulesheets.evaluate.gradient import BY_SIZE
from rulesheets.functions import TABLE, named
from rulesheets.model import Equation, Row, Values
from rulesheets.syntax import nodes
from solver.numerics.tolerances import BACKWARD, SAFETY, STEEP, UNIT_ROUNDOFF
from solver.path.graph import MOST, Shape, shape_of

MANY = 30
"""Rules up to which each is checked by itself, beyond it all at once (``alike.py``)."""
_JUMPING = named(lambda row: row.jumps)


class RuleCheck(NamedTuple):
    """``scaled`` is |F| / Σ|∂F/∂v · v|; ``miss`` is F, None if a side has no number.

    ``delicate``: floats could not decide; values in more digits may satisfy a rule that these do
    not.
    """

    holds: bool
    miss: float | None
    scaled: float = 0.0
    delicate: bool = False


class Sides(NamedTuple):
    """The values of both sides of a rule, the slopes of left minus right by variable, and a bound
    of its rounding."""

    left: float
    right: float
    slopes: dict[str, float]
    noise: float


LATEST = 4
"""Points at which an equation stays known: error bars are asked for when all answers are
checked."""


@dataclass
class Remembered:
    """The results for an equation at some values, which several callers request."""

    at: Row
    sides: Sides | None = None
    check: RuleCheck | None = None


def remembered(equation: Equation, values: Values) -> Remembered:
    at = tuple([values[name] for name in equation.names])
    latest: list[Remembered] = equation.__dict__.setdefault("_latest", [])
    for kept in latest:
        if kept.at == at and not (0.0 in at and str(kept.at) != str(at)):  # zeros have signs
            return kept
    kept = Remembered(at)
    latest[:] = [kept, *latest[: LATEST - 1]]
    return kept


def sides(equation: Equation, values: Values) -> Sides:
    """Both sides at the values; slopes must not be changed. Raises Undefined."""
    kept = remembered(equation, values)
    if kept.sides is None:
        left, slopes, noise = rounded_derivatives(equation.left, values)
        right, others, more = rounded_derivatives(equation.right, values)
        for name, slope in others.items():
            slopes[name] = slopes.get(name, 0.0) - slope
        kept.sides = Sides(left, right, slopes, noise + more)
    return kept.sides


def explained(
    equation: Equation, values: Values, miss: float | None, errors: Mapping[str, float]
) -> bool:
    """Whether the errors of the values may explain by how much they miss the equation."""
    try:
        slopes = sides(equation, values).slopes
    except Undefined:
        return True
    reach = sum(abs(slope) * errors.get(name, 0.0) for name, slope in slopes.items())
    return miss is not None and not abs(miss) > SAFETY * reach


def may_hold(equation: Equation, values: Values, moved: Mapping[str, float]) -> bool:
    """Whether an equation that holds at the values may hold with numbers ``moved`` next to them, as
    far as its slopes tell."""
    try:
        left, right, slopes, noise = sides(equation, values)
    except Undefined:
        return True
    numbers = [(n, s, v) for n, s in slopes.items() if isinstance(v := values[n], float)]
    miss = left - right + sum(s * (moved.get(n, v) - v) for n, s, v in numbers)
    return not abs(miss) > 2 * (noise + BACKWARD * sum(abs(s * v) for _, s, v in numbers))


def leads_to_zero(miss: Any, off: Any, moves: Sequence[Any], size: Any) -> Any:
    """Whether slopes alone show that F, which is ``off`` at most, is 0 for values that differ by a
    share BACKWARD: by ``moves`` that change it by no more than a share STEEP of the ``size`` of its
    sides."""
    reaches = [BACKWARD * move for move in moves]
    gentle = sum(reach * (reach <= STEEP * size) for reach in reaches)
    return (miss <= BACKWARD * size) & ((sum(reaches) <= STEEP * size) | (off <= gentle))


def size(equation: Equation, values: Values) -> float:
    """Σ|∂F/∂v · v| over the variables of an equation, with the size of a negative base for its
    slope by a whole exponent; infinite if a slope has no value."""
    try:
        total = sum(moves_of(sides(equation, values).slopes, values))
        if math.isnan(total):
            slopes = rounded_derivatives(equation.form, values, BY_SIZE)[1]
            total = sum(moves_of(slopes, values))
    except Undefined:
        return math.inf
    return total if math.isfinite(total) else math.inf


def symbol_of(side: nodes.Expression, values: Values) -> str | None:
    """The symbol that a side is, or that its variable has; None for a number."""
    if isinstance(side, nodes.Symbol):
        return side.name
    found = values.get(side.name) if isinstance(side, nodes.Name) else None
    return found if isinstance(found, str) else None


def gross(equation: Equation, values: Values) -> float:
    """The size of the terms of an equation before they cancel: the scale of its rounding errors."""
    try:
        return sum(abs(value(term, values)) for term in nodes.terms(*equation.sides))
    except Undefined:
        return math.inf


def jumps(equation: Equation) -> bool:
    """Whether some function in the equation jumps."""
    return _has_jumps(shape_of(equation)[0])


@lru_cache(MOST)
def _has_jumps(shape: Shape) -> bool:
    return any(call.function in _JUMPING for call in nodes.calls(shape.left, shape.right))


def heights(equation: Equation) -> Iterator[tuple[str, nodes.Expression]]:
    """The functions with jumps, each with the expression for the distance from its jumps."""
    for node in nodes.walk(*equation.sides):
        match node:
            case nodes.Call("int" | "frac" | "round" | "sgn" as function, (x,)):
                yield function, x
            case nodes.Call("mod", (x, y)):
                yield "int", x / y
            case nodes.Call("step", (x, a)):
                yield "step", x - a


def moves_of(slopes: Mapping[str, float], values: Values) -> Iterator[float]:
    """|∂F/∂v · v| for each variable."""
    return (
        abs(slope * v)
        for name, slope in slopes.items()
        if isinstance(v := values[name], float) and v
    )


def passed_end(
    undefined: Undefined, values: Values, share: float, exact: Container[str] = ()
) -> tuple[nodes.Expression, float] | None:
    """The argument with which an operation has left its domain, and the end of this that it lies
    beyond by no more than a share of what it is made of: rounding may have led it there.

    Numbers, and the names that are ``exact``, are made of nothing else.
    """
    match undefined.expression:
        case nodes.Call(function, arguments):
            ends = TABLE[function].domain
        case nodes.Quotient(_, divisor):
            arguments, ends = (divisor,), (0.0, 0.0)
        case nodes.Power(base, _):
            arguments, ends = (base,), (0.0, 0.0)
        case _:
            return None
    for argument in arguments:
        try:
            number, slopes, rounded = rounded_derivatives(argument, values)
        except (Undefined, KeyError):  # of the stages before the unknown
            continue
        made_of = sum(moves_of(slopes, values))
        known = isinstance(argument, nodes.Number) or (
            isinstance(argument, nodes.Name) and argument.name in exact
        )
        lost = number == 0.0 and rounded != 0.0  # for want of floats as small as it
        for end in ends:
            if lost or (not known and abs(number - end) <= share * made_of):
                return argument, end
    return None


# --- what the last places of given numbers leave open: of inputs, and of numbers in rules ---
#
# A number that takes all the digits of a float stands for any that rounds to it, up to half a unit
# of its last place: 0.3 does, 0.25 and 3 do not. Only by accident can it rest on less than that
# whether something is determined.


def half_unit(number: float) -> float:
    """The possible error of a given number: none for one with few digits."""
    short = abs(number) < 1e38 and unpack("f", pack("f", number))[0] == number
    return 0.0 if short else abs(number) * UNIT_ROUNDOFF


def with_named_numbers(expression: nodes.Expression, numbers: dict[str, float]) -> nodes.Expression:
    """The expression with names for its numbers that have last places; ``numbers`` receives their
    values.

    A number that is written twice is one number with one error.
    """

    def named(leaf: nodes.Name | nodes.Number | nodes.Symbol) -> nodes.Expression:
        if not isinstance(leaf, nodes.Number) or not half_unit(leaf.value):
            return leaf
        name = f"#{leaf.value!r}"
        numbers[name] = leaf.value
        return nodes.Name(name)

    return nodes.map_leaves(expression, named)


def perturbation(
    parts: Iterable[tuple[float, nodes.Expression, Values]],
    known: Mapping[str, float],
    slack: float = 1.0,
) -> float:
    """How far a sum of expressions, each with a factor and values of its own, moves to first order
    if numbers have the errors ``known``, by name, and those in the expressions errors of ``slack``
    half units of their last places. Infinite if an expression has no value, nan if a slope has
    none."""
    total, off = dict[str, float](), dict(known)
    try:
        for factor, expression, values in parts:
            numbers = dict[str, float]()
            named = with_named_numbers(expression, numbers)
            off |= {name: slack * half_unit(number) for name, number in numbers.items()}
            for name, slope in derivatives(named, {**values, **numbers})[1].items():
                total[name] = total.get(name, 0.0) + factor * slope
    except Undefined:
        return math.inf
    return sum(abs(slope) * off[name] for name, slope in total.items() if off.get(name))
