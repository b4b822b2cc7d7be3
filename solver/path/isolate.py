"""Isolation: one equation solved for one unknown, as a chain of inverse operations.

The chain starts with the value of the side without the unknown and undoes the operations on the
unknown, one stage after another. Each stage states the condition on its target (the image of the
operation that it undoes), so that a refusal can name the rule, the operation and the value: ``cosd
= 1.08``.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from functools import reduce
from itertools import zip_longest
from math import inf, prod
from typing import TypeAlias

from rulesheets.functions import LOGARITHMS, TABLE, named
from rulesheets.syntax import nodes
from solver.path import TARGET, Isolation, Quadratic, Stage
from solver.path.polynomial import NoForm


def isolate(left: nodes.Expression, right: nodes.Expression, unknown: str) -> Isolation | None:
    """Solve ``left = right`` for ``unknown``; None if no chain of inverse operations does it."""
    in_left, in_right = (nodes.names(side).count(unknown) for side in (left, right))
    if not in_left and not in_right:
        return None
    if in_left + in_right == 1:
        inside, other = (left, right) if in_left else (right, left)
        stages = _stages(inside, unknown)
        return None if stages is None else _through(stages, other, unknown)
    match polynomial_of(left, right, unknown):
        case (c, b), multiplied:
            stage = Stage("product", (TARGET / b,), divisor=b)
            cost = 0 if isinstance(b, nodes.Number) else 1
            return Isolation(unknown, -c, (stage,), cost, verify=multiplied)
        case (c, b, a), multiplied:
            return Isolation(unknown, c, (), 2, 2, verify=multiplied, quadratic=Quadratic(c, b, a))
    # every occurrence is in one part, such as exp(-x) or (1 + i)^x: undo the operations around it,
    # solve a linear equation for that part; last, undo the part itself
    if in_left and in_right:
        if (powers := _powers(left, right, unknown)) is not None:
            return powers
        left, right = left - right, nodes.ZERO
    inside, other = (left, right) if unknown in nodes.names(left) else (right, left)
    stages = _stages(_with_one_sign(inside, unknown), unknown)
    if stages is None or any(stage.period for stage in stages):
        return None
    return _through(stages, other, unknown, common=True)


def _with_one_sign(node: nodes.Expression, unknown: str) -> nodes.Expression:
    """The expression with ``1/b^n`` for ``b^-n``: the loan in ``m*(1 - b^-n)/i + rest/b^n``."""
    match node:
        case nodes.Power(base, nodes.Negative(exponent)) if unknown in nodes.names(exponent):
            return nodes.ONE / base**exponent
    return nodes.rebuilt(node, tuple(_with_one_sign(part, unknown) for part in node.parts))


def _stages(node: nodes.Expression, unknown: str) -> list[Stage] | None:
    """The stages that undo an expression, one operation after another; None if there are none."""
    stages: list[Stage] = []
    while not isinstance(node, nodes.Name):
        if sum(unknown in nodes.names(part) for part in node.parts) > 1:
            rest = _repeated(node, unknown)
            return None if rest is None else [*stages, *rest]
        undone = _undo(node, unknown)
        if undone is None:
            return None
        stage, node = undone
        stages.append(stage)
    return stages


def _through(
    stages: Sequence[Stage], other: nodes.Expression, unknown: str, common: bool = False
) -> Isolation:
    branches, doubtful = 1, False
    for stage in stages:
        branches *= len(stage.forms)
        bounded = stage.low > -inf or stage.high < inf
        divides = stage.divides and any(not isinstance(form, nodes.Product) for form in stage.forms)
        # a root is always defined, but a polynomial no more
        doubtful = doubtful or bounded or divides or stage.operation == "root"
    return Isolation(
        unknown,
        other,
        tuple(stages),
        cost=branches if branches > 1 else int(doubtful),
        branches=branches,
        verify=common or any(stage.operation in _EXTRANEOUS for stage in stages),
        common=common,
    )


_EXTRANEOUS = named(lambda row: row.direction) | {"power"}
"""Operations whose forms cover more than their preimage."""


def _undo(node: nodes.Expression, unknown: str) -> tuple[Stage, nodes.Expression] | None:
    """The stage that undoes the outermost operation, and the operand with the unknown."""
    match node:
        case nodes.Negative(operand):
            return Stage("negative", (-TARGET,)), operand
        case nodes.Sum(terms):
            at = next(i for i, term in enumerate(terms) if unknown in nodes.names(term))
            others, inner = nodes.add(*terms[:at], *terms[at + 1 :]), terms[at]
            if isinstance(inner, nodes.Negative):
                return Stage("sum", (others - TARGET,)), inner.operand
            return Stage("sum", (TARGET - others,)), inner
        case nodes.Product(left, right):
            inner, factor = (left, right) if unknown in nodes.names(left) else (right, left)
            return Stage("product", (TARGET / factor,), divisor=factor), inner
        case nodes.Quotient(left, right) if unknown in nodes.names(left):
            return Stage("quotient", (TARGET * right,), divisor=right), left
        case nodes.Quotient(
            nodes.Number(0.0), right
        ):  # of no divisor, as 0 times it is of no factor
            return Stage("product", (TARGET / nodes.ZERO,), divisor=nodes.ZERO), right
        case nodes.Quotient(left, right):
            return Stage("quotient", (left / TARGET,), divisor=TARGET), right
        case nodes.Power(base, exponent) if unknown in nodes.names(base):
            return _undo_power(exponent), base
        case nodes.Power(base, exponent):
            return _undo_exponent(base), exponent
        case nodes.Call(function, arguments):
            return _undo_call(function, arguments, unknown)
    return None


def _undo_exponent(base: nodes.Expression) -> Stage:
    divisor = nodes.call("ln", base)
    return Stage(
        "power", (nodes.call("ln", TARGET) / divisor,), low=0.0, low_open=True, divisor=divisor
    )


def _undo_power(exponent: nodes.Expression) -> Stage:
    root = TARGET ** (1.0 / exponent)
    positive = nodes.call("abs", TARGET) ** (1.0 / exponent)
    match exponent:
        case nodes.Number(value) if value == 2.0:
            principal = nodes.call("sqrt", TARGET)
            return Stage("square", (principal, -principal), low=0.0)
        case nodes.Number(value) if value > 0 and value % 2 == 0:
            return Stage("power", (root, -root), low=0.0)
        case nodes.Number(value) if value > 0 and value % 2 == 1:
            return Stage("root", (nodes.call("sgn", TARGET) * positive,))
        case nodes.Number(value) if value != value // 1:
            return Stage("power", (root,), low=0.0)
        case _:
            return Stage("power", (positive, -positive), divisor=exponent)


def _undo_call(
    function: str, arguments: tuple[nodes.Expression, ...], unknown: str
) -> tuple[Stage, nodes.Expression] | None:
    row = TABLE[function]
    if row.direction and len(arguments) == 2:
        # atan2(y, x) = t gives y*cos(t) = x*sin(t); the half plane is left to verification. The
        # forms stay quotients where a factor is 0: all of a half line has the direction 0
        (y, x), (s, c) = arguments, (nodes.call(name, TARGET) for name in row.sine_and_cosine)
        half = (row.angle or 0.0) / 2
        if unknown in nodes.names(y):
            return Stage(
                row.name, (nodes.Quotient(nodes.Product(x, s), c),), -half, half, divisor=c
            ), y
        return Stage(row.name, (nodes.Quotient(nodes.Product(y, c), s),), -half, half, divisor=s), x
    image = row.inverse
    if image is None or len(arguments) != 1:
        return None
    ends = image.low, image.high, image.low_open, image.high_open
    return Stage(function, image.branches(TARGET), *ends, period=image.period), arguments[0]


# --- an unknown that occurs several times, all in one part ---

PART = "#part"
"""Stands for the part of an equation that holds all occurrences of the unknown."""


def _repeated(node: nodes.Expression, unknown: str) -> list[Stage] | None:
    """The stages that undo an expression of which several operands hold the unknown."""
    if (signed := _signed_square(node, unknown)) is not None:
        return signed
    if (formula := _ratio(node, unknown)) is not None:
        return [formula]
    last = list(_around(node, unknown, last=True))
    for part in _around(node, unknown):
        if part not in last:  # it does not hold all occurrences
            continue
        exchanged = nodes.exchange(node, part, nodes.Name(PART))
        if (
            unknown not in nodes.names(exchanged)
            and (formula := _ratio(exchanged, PART)) is not None
        ):
            rest = _stages(part, unknown)
            return None if rest is None else [formula, *rest]
    return None


def _around(node: nodes.Expression, unknown: str, last: bool = False) -> Iterator[nodes.Expression]:
    """The parts of a node that hold the first or the last occurrence of an unknown, the largest
    first, except the node and the unknown themselves."""
    while True:
        operands = node.parts
        node = next(part for part in operands[:: -1 if last else 1] if unknown in nodes.names(part))
        if isinstance(node, nodes.Name):
            return
        yield node


def _ratio(node: nodes.Expression, unknown: str) -> Stage | None:
    """``node = target`` as a linear equation in the unknown, its denominators multiplied away.

    None if the unknown is a common factor, as in ``x/(x + x*y)``: then 0 is no value of it.
    """
    match polynomial_of(node, TARGET, unknown):
        case (c, b), _ if not nodes.is_number(c, 0.0):
            return Stage("ratio", (-c / b,), divisor=b)
        case _:
            return None


def _signed_square(node: nodes.Expression, unknown: str) -> list[Stage] | None:
    """The stage that undoes ``x*abs(x)``, as in the head loss of a pipe."""
    factors, divisors = _factors(node)
    held = [factor for factor in factors if unknown in nodes.names(factor)]
    if len(held) != 2 or any(unknown in nodes.names(divisor) for divisor in divisors):
        return None
    one, other = held if held[1] == nodes.Call("abs", (held[0],)) else held[::-1]
    if other != nodes.Call("abs", (one,)) or (rest := _stages(one, unknown)) is None:
        return None
    factor = prod((part for part in factors if part not in held), start=nodes.ONE) / prod(
        divisors, start=nodes.ONE
    )
    root = nodes.call("sgn", TARGET) * nodes.call("sqrt", nodes.call("abs", TARGET))
    return [Stage("product", (TARGET / factor,), divisor=factor), Stage("root", (root,)), *rest]


def _powers(left: nodes.Expression, right: nodes.Expression, unknown: str) -> Isolation | None:
    """``p*a^x = q*b^x`` as ``(a/b)^x = q/p``."""
    (above, below), (under, over) = _factors(left), _factors(right)
    free: list[nodes.Expression] = []
    bases: list[nodes.Expression] = []
    exponents: set[nodes.Expression] = set()
    for parts in (above + over, below + under):
        held = [part for part in parts if unknown in nodes.names(part)]
        exponents.update(part.exponent if isinstance(part, nodes.Power) else part for part in held)
        bases.append(
            prod(
                (part.base if isinstance(part, nodes.Power) else part for part in held),
                start=nodes.ONE,
            )
        )
        free.append(prod((part for part in parts if part not in held), start=nodes.ONE))
    if len(exponents) != 1 or any(unknown in nodes.names(base) for base in bases):
        return None
    rest = _stages(exponents.pop(), unknown)
    if rest is None or any(stage.period for stage in rest):
        return None
    return _through(
        [_undo_exponent(bases[0] / bases[1]), *rest], free[1] / free[0], unknown, common=True
    )


def _factors(node: nodes.Expression) -> tuple[list[nodes.Expression], list[nodes.Expression]]:
    """The factors and the divisors of a product, signs among them."""
    match node:
        case nodes.Product(left, right) | nodes.Quotient(left, right):
            (above, below), (over, under) = _factors(left), _factors(right)
            if isinstance(node, nodes.Quotient):
                over, under = under, over
            return [*above, *over], [*below, *under]
        case nodes.Negative(operand):
            above, below = _factors(operand)
            return [nodes.Number(-1.0), *above], below
        case _:
            return [node], []


# --- rules as quotients of polynomials in one unknown, and without roots and jumps ---

Polynomial: TypeAlias = tuple[nodes.Expression, ...]
"""Coefficients, lowest degree first."""
Rational: TypeAlias = tuple[Polynomial, Polynomial]
"""Numerator and denominator."""

_UNIT: Polynomial = (nodes.ONE,)


def polynomial_of(
    left: nodes.Expression, right: nodes.Expression, unknown: str
) -> tuple[Polynomial, bool] | None:
    """``left - right`` as one polynomial, and whether a denominator was multiplied away.

    None if it is not one of degree 2 at most.
    """
    try:
        numerator, denominator = _rational(right, unknown)
        negated = tuple(map(nodes.negative, numerator)), denominator
        numerator, denominator = _add(_rational(left, unknown), negated)
    except NoForm:
        return None
    return numerator, denominator != _UNIT


def _rational(expression: nodes.Expression, unknown: str) -> Rational:
    """The expression as a quotient of polynomials in ``unknown``. Raises NoForm."""
    if unknown not in nodes.names(expression):
        return (expression,), _UNIT
    match expression:
        case nodes.Name():
            return (nodes.ZERO, nodes.ONE), _UNIT
        case nodes.Negative(operand):
            numerator, denominator = _rational(operand, unknown)
            return tuple(map(nodes.negative, numerator)), denominator
        case nodes.Sum(terms):
            zero: Rational = (nodes.ZERO,), _UNIT
            return reduce(_add, (_rational(term, unknown) for term in terms), zero)
        case nodes.Product(left, right):
            return _multiply(_rational(left, unknown), _rational(right, unknown))
        case nodes.Quotient(left, right):
            numerator, denominator = _rational(right, unknown)
            return _multiply(_rational(left, unknown), (denominator, numerator))
        case nodes.Power(base, nodes.Number(1.0)):
            return _rational(base, unknown)
        case nodes.Power(base, nodes.Number(2.0)):
            inner = _rational(base, unknown)
            return _multiply(inner, inner)
    raise NoForm


def _add(left: Rational, right: Rational) -> Rational:
    (a, b), (c, d) = left, right
    if b == d:
        return _plus(a, c), b
    return _plus(_times(a, d), _times(c, b)), _times(b, d)


def _multiply(left: Rational, right: Rational) -> Rational:
    (a, b), (c, d) = left, right
    if c == _UNIT and len(d) == 1:
        return tuple(part / d[0] for part in a), b
    return _times(a, c), _times(b, d)


def _plus(left: Polynomial, right: Polynomial) -> Polynomial:
    return _trim([a + b for a, b in zip_longest(left, right, fillvalue=nodes.ZERO)])


def _times(left: Polynomial, right: Polynomial) -> Polynomial:
    """Raises NoForm."""
    product: list[nodes.Expression] = [nodes.ZERO] * (len(left) + len(right) - 1)
    if len(product) > 3:
        raise NoForm
    for i, a in enumerate(left):
        for j, b in enumerate(right):
            product[i + j] += a * b
    return _trim(product)


def _trim(polynomial: list[nodes.Expression]) -> Polynomial:
    while len(polynomial) > 1 and nodes.is_number(polynomial[-1], 0.0):
        polynomial.pop()
    return tuple(polynomial)


_TANGENTS = named(lambda row: row.half_turn)
_DIRECTIONS = named(lambda row: row.direction)
_ROUGH = frozenset({"sqrt", "abs", *_TANGENTS, *_DIRECTIONS})


def _single(
    form: nodes.Expression, functions: Collection[str]
) -> tuple[nodes.Call, nodes.Expression, nodes.Expression] | None:
    """The single operation of some kinds in which a form is linear, its factor, and the rest."""
    linear = []
    for part in dict.fromkeys(part for part in nodes.calls(form) if part.function in functions):
        match polynomial_of(nodes.exchange(form, part, nodes.Name(PART)), nodes.ZERO, PART):
            case (rest, factor), False:
                linear.append((part, factor, rest))
    return linear[0] if len(linear) == 1 else None


def without_logarithm(form: nodes.Expression) -> nodes.Expression:
    """An expression that vanishes where a form does: for ``factor*ln(x) + rest`` it is ``x -
    exp(-rest/factor)``, which has no pole. Other forms are unchanged."""
    if (found := _single(form, LOGARITHMS)) is None:
        return form
    logarithm, factor, rest = found
    inverse = TABLE[logarithm.function].inverse
    assert inverse is not None
    return logarithm.arguments[0] - inverse.branches(-rest / factor)[0]


def smooth(left: nodes.Expression, right: nodes.Expression) -> nodes.Expression:
    """An expression that vanishes wherever ``left = right`` does, smooth if possible.

    It is smooth if the equation is ``factor*rough + rest = 0`` for a single rough operation, which
    is undone.
    """
    form = left - right
    if (found := _single(form, _ROUGH)) is None:
        return form
    rough, factor, rest = found
    inside = rough.arguments
    if rough.function == "sqrt":
        return factor**2.0 * inside[0] - rest**2.0
    if rough.function == "abs":
        return (factor * inside[0]) ** 2.0 - rest**2.0
    names = TABLE[rough.function].sine_and_cosine
    if rough.function in _TANGENTS:
        sine, cosine = (nodes.call(name, *inside) for name in names)
        return factor * sine + rest * cosine
    if len(inside) != 2 or not (nodes.is_number(factor, 1.0) or nodes.is_number(factor, -1.0)):
        return factor * rough + rest
    angle = -rest if nodes.is_number(factor, 1.0) else rest
    sine, cosine = (nodes.call(name, angle) for name in names)
    return inside[0] * cosine - inside[1] * sine
