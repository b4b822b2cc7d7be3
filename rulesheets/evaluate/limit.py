"""Where an expression is undefined: whether it is 0/0 there, and whether it has a limit all the same.

The limit is taken in many digits: the expression is evaluated on both sides of the point along several lines,
at two distances of which one is the square of the other. Only what all of these agree on is a limit.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from rulesheets.evaluate.number import Undefined, value
from rulesheets.evaluate.precise import ExtendedValues, extended
from rulesheets.functions.extended import Extended, context
from rulesheets.syntax.nodes import Call, Expression, Power, Product, Quotient, names, operands

DIGITS = 160
DISTANCES = (1e-20, 1e-40)
AGREEMENT = 1e-16
"""Relative difference of the values at the two distances; it is of the order of the larger one."""
TRIALS = (0.7390851, 2.6651441)
"""Numbers that stand for what has no value."""
_SHARES = ((1.0, 0.7, 1.3, 0.9, 1.1), (0.6, -1.2, 0.8, -0.7, 1.4), (-0.9, 1.1, 0.5, 1.3, -0.6))
"""Directions of the lines: how far each variable moves, by turns."""


@dataclass(frozen=True, slots=True)
class Indeterminate:
    """A part of an expression that has no value at a point, and takes one of the ``form`` 0/0 there.

    ``limit`` is its two-sided limit, None where it has none; ``is_open``: it depends on what has no value.
    """

    part: Expression
    form: str
    limit: float | None
    is_open: bool = False


def indeterminate(expression: Expression, values: Mapping[str, float | str]) -> Indeterminate | None:
    """The innermost part of an expression that is indeterminate at the values, whatever the others are."""
    found = _indeterminate(expression, values)
    unknown = [name for name in dict.fromkeys(names(expression)) if name not in values]
    if found is not None or not unknown:
        return found
    numbers = ({name: x * (1.0 + 0.173 * k) for k, name in enumerate(unknown)} for x in TRIALS)
    first, second = (_indeterminate(expression, {**values, **trial}) for trial in numbers)
    if first is None or second is None or first.limit is None:
        return None
    return Indeterminate(first.part, first.form, None, is_open=True)


def _indeterminate(expression: Expression, values: Mapping[str, float | str]) -> Indeterminate | None:
    for chain in _undefined(expression, values):
        for part, above in zip(chain, (*chain[1:], None), strict=True):
            form = _form(part, values)
            found = limit(part, values) if form or part is not chain[0] else None
            if form or found is not None:
                return Indeterminate(part, form or ("1^∞" if isinstance(part, Power) else "0·∞"), found)
            if above is None or not _may_compensate(above, part, values):
                break
    return None


def _undefined(expression: Expression, values: Mapping[str, float | str]) -> Iterator[tuple[Expression, ...]]:
    """Parts that have no value though their own parts have, each with all that it stands in, inside out."""
    stack: list[tuple[Expression, ...]] = [(expression,)]
    while stack:
        chain = stack.pop()
        if _has_value(chain[0], values):
            continue
        inner = [part for part in operands(chain[0]) if not _has_value(part, values)]
        stack.extend((part, *chain) for part in inner)
        if not inner and _read(chain[0], values):
            yield chain


def _read(part: Expression, values: Mapping[str, float | str]) -> bool:
    return all(name in values for name in names(part))


def _has_value(part: Expression, values: Mapping[str, float | str]) -> bool:
    if not _read(part, values):
        return False
    try:
        value(part, values)
    except Undefined as undefined:
        return undefined.overflow
    except TypeError:
        return True  # a symbol, which has no limit
    return True


def _form(part: Expression, values: Mapping[str, float | str]) -> str:
    """``0/0`` for a quotient whose numerator and divisor are 0, in many digits as in floats."""
    if isinstance(part, Quotient) and all(_vanishes(side, values) for side in (part.left, part.right)):
        return "0/0"
    return ""


def _vanishes(part: Expression, values: Mapping[str, float | str]) -> bool:
    try:
        return not extended(part, values, 50) and not extended(part, values, 100)
    except Undefined:
        return False


def _may_compensate(above: Expression, part: Expression, values: Mapping[str, float | str]) -> bool:
    """Whether an expression may have a limit where a part of it becomes infinite."""
    match above:
        case Product(left, right):
            other = right if left is part else left
            return _read(other, values) and _vanishes(other, values)
        case Quotient() | Power() | Call():
            return _read(above, values)
        case _:
            return False


def limit(expression: Expression, values: Mapping[str, float | str]) -> float | None:
    """The two-sided limit at a point, along every line through it; None where there is none.

    Where the expression has no value beside the point if all variables move, they move one by one.
    """
    moving = [name for name in dict.fromkeys(names(expression)) if not isinstance(values[name], str)]
    lines = [{n: shares[k % 5] for k, n in enumerate(moving)} for shares in _SHARES]
    try:
        return _common(expression, values, lines)
    except Undefined:
        pass
    found: list[float] = []
    for name in moving:
        try:
            alone = _common(expression, values, [{name: 1.0}])
        except Undefined:
            continue
        if alone is None:
            return None
        found.append(alone)
    return found[0] if found and all(_alike(found[0], other) for other in found) else None


def _common(
    expression: Expression, values: Mapping[str, float | str], lines: Sequence[Mapping[str, float]]
) -> float | None:
    """The limit that both sides of all lines agree on. Raises Undefined where one has no value."""
    sides = [(line, side) for line in lines for side in (1, -1)]
    far, near = (
        [extended(expression, beside(values, line, side * distance), DIGITS) for line, side in sides]
        for distance in DISTANCES
    )
    if all(abs(b) <= AGREEMENT * abs(a) for a, b in zip(far, near, strict=True)):
        return 0.0
    if all(_alike(near[0], number) for number in (*far, *near)):
        return float(near[0])
    return None


def beside(values: Mapping[str, float | str], line: Mapping[str, float], distance: float) -> ExtendedValues:
    """A point at a distance, relative to each value, on a line through the values."""
    mp = context(DIGITS)
    moved: dict[str, object] = dict(values)
    for name, share in line.items():
        at = mp.mpf(values[name])
        moved[name] = at + mp.mpf(share) * mp.mpf(distance) * (abs(at) or 1)
    return moved


def _alike(one: Extended | float, other: Extended | float) -> bool:
    return bool(abs(one - other) <= AGREEMENT * max(abs(one), abs(other)))
