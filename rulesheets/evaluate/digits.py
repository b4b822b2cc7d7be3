"""Expressions and functions in many digits, by mpmath: values, slopes, limits.

Each precision has a context of its own (in each thread), so nothing here touches mpmath's global
one."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from functools import cache, lru_cache, partial
from threading import get_ident
from typing import Any, NamedTuple, TypeAlias

from rulesheets.evaluate.gradient import Part, Traced
from rulesheets.evaluate.number import Arithmetic, Undefined, value
from rulesheets.functions import TABLE
from rulesheets.functions.row import Forms, Function
from rulesheets.syntax.nodes import (
    Call,
    Expression,
    Name,
    Number,
    Power,
    Product,
    Quotient,
    Values,
    calls,
    names,
)

Extended: TypeAlias = Any
"""A number of mpmath (which has no types of its own)."""


def context(digits: int) -> Any:
    """The context that works with ``digits`` decimal digits, one of each thread: mpmath changes the
    precision of a context while it computes."""
    return _of_thread(get_ident(), digits)[0]


@cache
def _of_thread(thread: int, digits: int) -> tuple[Any, Any, Any]:
    """A context, the functions of the table in it, and the numbers that floats are in it."""
    from mpmath import MPContext  # many solves need no more digits than floats have

    made = MPContext()
    made.dps = digits
    # a rule is evaluated many times at numbers most of which stay
    return made, Forms(TABLE, partial(_over_reals, made)), lru_cache(maxsize=4096)(made.mpf)


def _over_reals(mp: Any, row: Function) -> Callable[..., Extended]:
    """The function over the reals: complex and infinite answers are refused."""
    digits = mp.dps

    def defined(template: Expression, places: ExtendedValues) -> Extended:
        try:
            return Digits(places, digits).of(template)
        except Undefined as undefined:
            raise ValueError(f"{row.name} has no value: {undefined}") from undefined

    function = row.form("digits", mp, defined)

    @lru_cache(maxsize=1024)  # a check asks again for what the check of the slopes has asked for
    def value(*arguments: Extended) -> Extended:
        if function is None:
            raise ValueError(f"{row.name} is known in floats only")
        try:
            result = function(*arguments)
        except mp.NoConvergence as endless:
            raise ValueError("no value within the limits of mpmath") from endless
        if isinstance(result, mp.mpc) or not mp.isfinite(result):
            raise ValueError("no real value")
        return mp.mpf(result)

    return value


ExtendedValues: TypeAlias = Mapping[str, Any]
"""Floats or mpmath numbers (taken exactly) and symbols, by the full names of variables."""


LARGE_BITS = 40
"""Binary digits before the point of an exponent from which on it is large."""
LARGEST_BITS = 4_000
"""The same from which on a power has no value here: floats end at 1,024."""
MOST_BITS = 100_000
"""Binary exponents of arguments beyond which a function may take all memory."""


def extended(expression: Expression, values: ExtendedValues, digits: int = 50) -> Extended:
    """The value of ``expression`` computed with ``digits`` decimal digits, an mpmath number.

    Floats, also in the expression, are taken as exact binary numbers. Raises Undefined if an
    operation has no real value, KeyError for a variable without one.
    """
    return Digits(values, digits).of(expression)


def extended_derivatives(
    expression: Expression,
    values: ExtendedValues,
    digits: int,
    along: Collection[str] | None = None,
) -> tuple[Extended, dict[str, Extended]]:
    """Value and partial derivatives by every variable in the expression, or by those in ``along``,
    with ``digits`` decimal digits.

    Raises Undefined if the expression or one of these slopes has no real value, KeyError for a
    variable without one.
    """
    traced = TracedDigits(Digits(values, digits), along)
    part = traced.of(expression)
    return part.value, traced.gradient(part, context(digits).zero)[0]


def in_many_digits(expression: Expression) -> bool:
    """Whether every function in it has a form in many digits."""
    rows = (TABLE[call.function] for call in calls(expression))
    return all(row.digits or row.definition for row in rows)


class Digits(Arithmetic[Extended]):
    """Numbers of mpmath, and ``functions`` of them for every row of ``TABLE``.

    Outside its domain, or without a form in many digits, one raises ValueError or
    ZeroDivisionError.
    """

    def __init__(self, values: ExtendedValues, digits: int) -> None:
        self.values, self.digits = values, digits
        mp, self.functions, self.exactly = _of_thread(get_ident(), digits)
        self.mpf = mp.mpf

    def number(self, node: Number) -> Extended:
        return self.exactly(node.value)

    def name(self, node: Name) -> Extended:
        number = self.values[node.name]
        if isinstance(number, str):
            raise Undefined("symbol", (), node)
        if type(number) is self.mpf:
            return number
        return self.exactly(number) if type(number) is float else self.mpf(number)

    def divided(self, node: Quotient, above: Extended, below: Extended) -> Extended:
        if below == 0:
            raise Undefined("/", (0.0,), node)
        return above / below

    def raised(self, node: Power, base: Extended, exponent: Extended) -> Extended:
        size = exponent.exp + exponent.bc if exponent else 0
        if size > LARGEST_BITS:  # before any whole number of so many bits
            raise Undefined("overflow", (math.inf,), node)
        negative_root = base < 0 and exponent != int(exponent)
        if negative_root or (base == 0 and exponent < 0):
            raise Undefined("^", (float(base), float(exponent)), node)
        if size <= LARGE_BITS or exponent == int(exponent):
            return base**exponent
        # a large exponent multiplies the rounding of the logarithm
        mp = context(self.digits + size // 3)
        return +self.mpf(mp.mpf(base) ** mp.mpf(exponent))

    def applied(self, node: Call, arguments: list[Extended]) -> Extended:
        for argument in arguments:
            if argument and abs(argument.exp + argument.bc) > MOST_BITS:
                raise Undefined("overflow", (math.inf,), node)
        try:
            return self.functions[node.function](*arguments)
        except (ValueError, ZeroDivisionError, OverflowError):
            raise Undefined(node.function, tuple(map(float, arguments)), node) from None


class TracedDigits(Traced[Extended]):
    """Parts in many digits; variables that are not in ``along`` are numbers."""

    numbers: Digits
    rounds = False

    def __init__(self, numbers: Digits, along: Collection[str] | None) -> None:
        super().__init__(numbers)
        self.along = along

    def name(self, node: Name) -> Part[Extended]:
        part = super().name(node)
        if self.along is None or node.name in self.along:
            return part
        return Part(part.value, exact=True)

    def by_base(self, base: Part[Extended], exponent: Part[Extended], node: Power) -> Extended:
        if not exponent.value:
            return 0.0
        return exponent.value * self.numbers.raised(node, base.value, exponent.value - 1)

    def slope(
        self, template: Expression, arguments: Sequence[Part[Extended]], node: Expression
    ) -> Extended:
        values = {str(place): part.value for place, part in enumerate(arguments)}
        try:
            return Digits(values, self.numbers.digits).of(template)
        except Undefined as error:
            raise Undefined(error.operation, error.arguments, node) from None


DIGITS = 160
DISTANCES = (1e-20, 1e-40)
AGREEMENT = 1e-16
"""Relative difference of the values at the two distances; it is of the order of the larger one."""
TRIALS = (0.7390851, 2.6651441)
"""Numbers in place of unknowns without a value."""
_SHARES = ((1.0, 0.7, 1.3, 0.9, 1.1), (0.6, -1.2, 0.8, -0.7, 1.4), (-0.9, 1.1, 0.5, 1.3, -0.6))
"""Directions of the lines: how far each variable moves, by turns."""


class Indeterminate(NamedTuple):
    """A part of an expression that has the ``form`` 0/0 at a point, and no value.

    ``limit`` is its two-sided limit, None if there is none; ``is_open``: it depends on an unknown
    without a value.
    """

    part: Expression
    form: str
    limit: float | None
    is_open: bool = False


def indeterminate(expression: Expression, values: Values) -> Indeterminate | None:
    """The innermost part of an expression that is indeterminate at the values, for any others."""
    found = _indeterminate(expression, values)
    unknown = [name for name in dict.fromkeys(names(expression)) if name not in values]
    if found is not None or not unknown:
        return found
    numbers = ({name: x * (1.0 + 0.173 * k) for k, name in enumerate(unknown)} for x in TRIALS)
    first, second = (_indeterminate(expression, {**values, **trial}) for trial in numbers)
    if first is None or second is None or first.limit is None:
        return None
    return Indeterminate(first.part, first.form, None, is_open=True)


def _indeterminate(expression: Expression, values: Values) -> Indeterminate | None:
    for chain in _undefined(expression, values):
        for part, above in zip(chain, (*chain[1:], None), strict=True):
            sides = (part.left, part.right) if isinstance(part, Quotient) else ()
            form = "0/0" if sides and all(vanishes(side, values) for side in sides) else ""
            found = limit(part, values) if form or part is not chain[0] else None
            if form or found is not None:
                other_form = "1^∞" if isinstance(part, Power) else "0·∞"
                return Indeterminate(part, form or other_form, found)
            if isinstance(above, Product):  # a part that becomes infinite may have a limit in these
                other = above.right if above.left is part else above.left
                compensates = vanishes(other, values)
            else:
                compensates = isinstance(above, Quotient | Power | Call) and is_known(above, values)
            if not compensates:
                break
    return None


def _undefined(expression: Expression, values: Values) -> Iterator[tuple[Expression, ...]]:
    """Parts without a value whose own parts have one, each with all around it, inside out."""
    stack: list[tuple[Expression, ...]] = [(expression,)]
    while stack:
        chain = stack.pop()
        if _has_value(chain[0], values):
            continue
        inner = [part for part in chain[0].parts if not _has_value(part, values)]
        stack.extend((part, *chain) for part in inner)
        if not inner and is_known(chain[0], values):
            yield chain


def is_known(part: Expression, values: Values) -> bool:
    return all(name in values for name in names(part))


def _has_value(part: Expression, values: Values) -> bool:
    if not is_known(part, values):
        return False
    try:
        value(part, values)
    except Undefined as undefined:
        return undefined.overflow
    except TypeError:
        return True  # a symbol, which has no limit
    return True


def vanishes(part: Expression, values: Values) -> bool:
    """Whether the variables of a part are known, and it is 0 to all digits considered."""
    try:
        return (
            is_known(part, values)
            and not extended(part, values, 50)
            and not extended(part, values, 100)
        )
    except Undefined:
        return False


def limit(expression: Expression, values: Values) -> float | None:
    """The two-sided limit at a point, along every line through it; None if there is none.

    The expression is evaluated in many digits on both sides of the point along several lines, at
    two distances, one the square of the other. Only a value on which all agree is a limit.
    """
    found = dict.fromkeys(names(expression))
    moving = [name for name in found if not isinstance(values[name], str)]
    lines = [{n: shares[k % 5] for k, n in enumerate(moving)} for shares in _SHARES]
    far, near = list[Extended](), list[Extended]()
    try:
        for ends, distance in ((far, DISTANCES[0]), (near, DISTANCES[1])):
            steps = ((line, step) for line in lines for step in (distance, -distance))
            ends += (extended(expression, beside(values, *one), DIGITS) for one in steps)
    except Undefined:
        return None
    if all(abs(b) <= AGREEMENT * abs(a) for a, b in zip(far, near, strict=True)):
        return 0.0
    first = near[0]
    apart = ((abs(first - number), max(abs(first), abs(number))) for number in (*far, *near))
    return float(first) if all(gap <= AGREEMENT * size for gap, size in apart) else None


def beside(values: Values, line: Mapping[str, float], distance: float) -> ExtendedValues:
    """A point at a distance, relative to each value, on a line through the values."""
    mp = context(DIGITS)
    moved: dict[str, object] = dict(values)
    for name, share in line.items():
        at = mp.mpf(values[name])
        moved[name] = at + mp.mpf(share) * mp.mpf(distance) * (abs(at) or 1)
    return moved
