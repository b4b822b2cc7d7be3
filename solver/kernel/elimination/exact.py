"""Expressions as polynomials of one unknown with exact fractions for coefficients."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from fractions import Fraction
from itertools import zip_longest
from typing import TypeAlias

from rulesheets.deadline import expect_time
from rulesheets.syntax.nodes import (
    Call,
    Expression,
    Name,
    Negative,
    Number,
    Power,
    Product,
    Quotient,
    Sum,
)
from solver.kernel.question import Question
from solver.path.smooth import smooth

HIGHEST_DEGREE = 12

Polynomial: TypeAlias = list[Fraction]
"""Coefficients, lowest degree first."""

Sizes: TypeAlias = list[float]
Value: TypeAlias = tuple[Polynomial, Sizes, int]
"""A polynomial over (1 + t²) to that power; second, how large its coefficients were before they cancelled."""

CANCELLED = 1e-9
"""A coefficient this small beside what it was made of may be nothing but the rounding of the inputs."""

CIRCLE: Polynomial = [Fraction(1), Fraction(0), Fraction(1)]
ROUND: Sizes = [1.0, 0.0, 1.0]
COSINE: Value = [Fraction(1), Fraction(0), Fraction(-1)], ROUND, 1
SINE: Value = [Fraction(0), Fraction(2)], [0.0, 2.0], 1


class NotPolynomial(Exception):
    """Something that is no polynomial of low degree, or whose coefficients are not exact."""


class Quarters:
    """An angle that the unknown t is half the tangent of. ``at_half_turn``: how often t = ∞ is a root."""

    def __init__(self, name: str, turn: float) -> None:
        self.name, self.turn = name, turn
        self.functions = ("cosd", "sind") if turn == 360.0 else ("cos", "sin")
        self.at_half_turn = 0

    def wave(self, call: Call) -> Value:
        """Sine or cosine of plus or minus the angle and some quarter turns. Raises NotPolynomial."""
        if call.function not in self.functions:
            raise NotPolynomial
        sign, offset = self._argument(call.arguments[0])
        quarters, rest = divmod(offset, 90.0)
        if rest or (offset and self.turn != 360.0):
            raise NotPolynomial
        cosine, sine = COSINE, (SINE if sign > 0 else _scaled(SINE, -1))
        for _ in range(int(quarters) % 4):
            cosine, sine = _scaled(sine, -1), cosine
        return cosine if call.function == self.functions[0] else sine

    def _argument(self, node: Expression) -> tuple[int, float]:
        match node:
            case Name(name) if name == self.name:
                return 1, 0.0
            case Negative(operand):
                sign, offset = self._argument(operand)
                return -sign, -offset
            case Sum((Number(number), other)) | Sum((other, Number(number))):
                sign, offset = self._argument(other)
                return sign, offset + number
            case Sum((other, Negative(Number(number)))):
                sign, offset = self._argument(other)
                return sign, offset - number
            case _:
                raise NotPolynomial


def closing(
    question: Question, forms: Sequence[tuple[str, Expression]], quarters: Quarters | None = None
) -> Polynomial:
    """What must vanish in the tear, or in the tangent of half of it. Raises NotPolynomial."""
    block = question.kernel.block
    values = {n: _number(v) for n, v in zip(question.kernel.known, question.known, strict=True)}
    if quarters is None:
        values[block.tears[0]] = [Fraction(0), Fraction(1)], [0.0, 1.0], 0
    for name, form in forms:
        expect_time()
        values[name] = _value(form, values, quarters)
    equation = question.graph.model.equations[block.residuals[0]]
    polynomial, gross, power = _value(smooth(equation.left, equation.right), values, quarters)
    if any(0 != abs(c) <= CANCELLED * size for c, size in zip(polynomial, gross, strict=False)):
        raise NotPolynomial
    if quarters is not None:
        quarters.at_half_turn = 2 * power + 1 - len(polynomial)
    return polynomial


def residuals_in(
    question: Question,
    forms: Sequence[tuple[str, Expression]],
    fixed: Mapping[str, Fraction],
    tear: str,
) -> tuple[Polynomial, ...]:
    """What must vanish in one tear, the others ``fixed``. Raises NotPolynomial."""
    block = question.kernel.block
    values = {n: _number(v) for n, v in zip(question.kernel.known, question.known, strict=True)}
    values |= {name: ([x], [abs(float(x))], 0) for name, x in fixed.items()}
    values[tear] = [Fraction(0), Fraction(1)], [0.0, 1.0], 0
    for name, form in forms:
        expect_time()
        values[name] = _value(form, values, None)
    equations = (question.graph.model.equations[index] for index in block.residuals)
    return tuple(_value(smooth(e.left, e.right), values, None)[0] for e in equations)


def _value(node: Expression, known: Mapping[str, Value], quarters: Quarters | None) -> Value:
    match node:
        case Number(number):
            return _number(number)
        case Name(name):
            if name not in known:
                raise NotPolynomial
            return known[name]
        case Negative(operand):
            return _scaled(_value(operand, known, quarters), -1)
        case Sum(terms):
            total = _value(terms[0], known, quarters)
            for term in terms[1:]:
                expect_time()
                total = _plus(total, _value(term, known, quarters))
            return total
        case Product(left, right):
            return _times(_value(left, known, quarters), _value(right, known, quarters))
        case Quotient(left, right):
            divisor, gross, power = _value(right, known, quarters)
            if len(divisor) > 1 or power or abs(divisor[0]) <= CANCELLED * gross[0]:
                raise NotPolynomial
            return _scaled(_value(left, known, quarters), 1 / divisor[0])
        case Power(base, Number(exponent)) if exponent in range(1, HIGHEST_DEGREE + 1):
            factor = total = _value(base, known, quarters)
            for _ in range(int(exponent) - 1):
                total = _times(total, factor)
            return total
        case Call() if quarters is not None:
            return quarters.wave(node)
        case _:
            raise NotPolynomial


def _number(number: float) -> Value:
    if not math.isfinite(number):
        raise NotPolynomial
    return [Fraction(number)], [abs(number)], 0


def _scaled(value: Value, number: Fraction | int) -> Value:
    factor, size = Fraction(number), abs(float(number))
    return [factor * c for c in value[0]], [size * c for c in value[1]], value[2]


def _plus(a: Value, b: Value) -> Value:
    power = max(a[2], b[2])
    a, b = _raised(a, power), _raised(b, power)
    sizes = [x + y for x, y in zip_longest(a[1], b[1], fillvalue=0.0)]
    return _sum(a[0], b[0]), sizes, power


def _raised(value: Value, power: int) -> Value:
    """The same over a higher power of 1 + t²."""
    polynomial, gross, own = value
    for _ in range(power - own):
        polynomial, gross = _product(polynomial, CIRCLE), _size_of_product(gross, ROUND)
    return polynomial, gross, power


def _times(a: Value, b: Value) -> Value:
    return _product(a[0], b[0]), _size_of_product(a[1], b[1]), a[2] + b[2]


def _sum(a: Polynomial, b: Polynomial) -> Polynomial:
    size = max(len(a), len(b))
    padded = ([*p, *[Fraction(0)] * (size - len(p))] for p in (a, b))
    return _trimmed([x + y for x, y in zip(*padded, strict=True)])


def _size_of_product(a: Sizes, b: Sizes) -> Sizes:
    product = [0.0] * (len(a) + len(b) - 1)
    for i, x in enumerate(a):
        expect_time()
        for j, y in enumerate(b):
            product[i + j] += x * y
    return product


def _product(a: Polynomial, b: Polynomial) -> Polynomial:
    if len(a) + len(b) - 2 > HIGHEST_DEGREE:
        raise NotPolynomial
    product = [Fraction(0)] * (len(a) + len(b) - 1)
    for i, x in enumerate(a):
        expect_time()
        for j, y in enumerate(b):
            product[i + j] += x * y
    return _trimmed(product)


def _trimmed(polynomial: Polynomial) -> Polynomial:
    while len(polynomial) > 1 and not polynomial[-1]:
        polynomial.pop()
    return polynomial
