"""Isolation: one equation solved for one unknown, as a chain of inverse operations.

The chain starts with the value of the side that is free of the unknown and undoes,
one stage after another, what was done to the unknown. Each stage says what it asks of
its target (the image of the operation that it undoes) so that a refusal can name the
rule, the operation and the value: ``cosd = 1.08``.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterator, Sequence
from math import inf
from typing import NamedTuple

from rulesheets.functions import TABLE, named
from rulesheets.functions.row import Function
from rulesheets.syntax import nodes
from rulesheets.syntax.nodes import (
    ZERO,
    Call,
    Expression,
    Name,
    Negative,
    Number,
    Power,
    Product,
    Quotient,
    Sum,
    add,
    call,
    divide,
    exchange,
    is_number,
    multiply,
    negative,
    power,
    substitute,
    subtract,
)
from solver.path import rational


def is_linear(expression: Expression, unknowns: Collection[str]) -> bool:
    """Whether the expression, as it is written, is linear in the unknowns, with any coefficients."""
    stack = [expression]
    while stack:
        match stack.pop():
            case Negative(operand):
                stack.append(operand)
            case Sum(terms):
                stack.extend(terms)
            case Product(left, right) if _free(left, unknowns):
                stack.append(right)
            case Product(left, right) if _free(right, unknowns):
                stack.append(left)
            case Quotient(left, right) if _free(right, unknowns):
                stack.append(left)
            case Name():
                pass
            case part if not _free(part, unknowns):
                return False
    return True


def _free(expression: Expression, unknowns: Collection[str]) -> bool:
    return not any(name in unknowns for name in nodes.names(expression))


def plainly_resolvable(left: Expression, right: Expression) -> frozenset[str]:
    """Unknowns that ``left = right`` gives at no cost: they occur once, in a sum, with a numeric factor.

    Others may be resolvable too; that takes an isolation to tell.
    """
    occurrences = Counter((*nodes.names(left), *nodes.names(right)))
    plain: list[str] = []
    stack = [left, right]
    while stack:
        match stack.pop():
            case Name(name):
                plain.append(name)
            case Negative(operand) | Product(Number(), operand) | Product(operand, Number()):
                stack.append(operand)
            case Quotient(operand, Number()):
                stack.append(operand)
            case Sum(terms):
                stack.extend(terms)
    return frozenset(name for name in plain if occurrences[name] == 1)


TARGET = Name("#")
"""Stands for the target of a stage in its forms."""


class Stage(NamedTuple):
    """Undo one operation: the preimages of the target ``#`` are the ``forms``, principal first.

    The target must lie between ``low`` and ``high`` (the image of ``operation``), and
    ``divisor``, where there is one, must not vanish (for a root that is the exponent).
    ``period`` is that of the operation in its argument.
    """

    operation: str
    forms: tuple[Expression, ...]
    low: float = -inf
    high: float = inf
    low_open: bool = False
    high_open: bool = False
    divisor: Expression | None = None
    period: float | None = None

    @property
    def divides(self) -> bool:
        """Whether it divides by what may vanish."""
        return self.divisor is not None and (
            is_number(self.divisor, 0.0) or not isinstance(self.divisor, Number)
        )

    @property
    def proven(self) -> bool:
        """Whether there are no other preimages: of a registered function its author says which there are."""
        row = TABLE.get(self.operation)
        return row is None or row.source is None


class Quadratic(NamedTuple):
    """``c + b*x + a*x^2 = 0`` with coefficients free of the unknown, for an unknown that occurs twice."""

    c: Expression
    b: Expression
    a: Expression


class Isolation(NamedTuple):
    """``unknown`` from ``start`` through ``stages`` (or by ``quadratic``).

    ``cost``: 0 one preimage, always defined; 1 one preimage, but a divisor may vanish or
    the target may leave the image; n ≥ 2 n preimages. ``verify``: preimages may be
    extraneous and must be tried in the equation. ``common``: the equation was solved for a part that holds
    the unknown several times, so that it may still depend on the unknown where the formula is 0/0.
    """

    unknown: str
    start: Expression
    stages: tuple[Stage, ...]
    cost: int
    branches: int = 1
    verify: bool = False
    quadratic: Quadratic | None = None
    common: bool = False

    @property
    def identity(self) -> bool:
        """Whether the unknown just takes the value of the other side."""
        return not self.stages and self.quadratic is None

    @property
    def period(self) -> float | None:
        return next((stage.period for stage in self.stages if stage.period), None)

    @property
    def proven(self) -> bool:
        """Whether there are no other preimages than those of the formulas."""
        return all(stage.proven for stage in self.stages)

    def forms(self) -> tuple[Expression, ...]:
        """Explicit forms of the unknown, principal first; the quadratic by its formula."""
        if self.quadratic is not None:
            return _quadratic_forms(self.quadratic)
        forms: tuple[Expression, ...] = (self.start,)
        for stage in self.stages:
            forms = tuple(substitute(form, {TARGET.name: target}) for target in forms for form in stage.forms)
        return forms


def isolate(left: Expression, right: Expression, unknown: str) -> Isolation | None:
    """Solve ``left = right`` for ``unknown``; None where no chain of inverse operations does it."""
    in_left = sum(1 for name in nodes.names(left) if name == unknown)
    in_right = sum(1 for name in nodes.names(right) if name == unknown)
    if in_left + in_right == 1:
        inside, other = (left, right) if in_left else (right, left)
        return _chain(inside, other, unknown)
    if in_left + in_right > 1:
        return _by_formula(left, right, unknown) or _by_common_part(left, right, unknown)
    return None


def operand(left: Expression, right: Expression, unknown: str, depth: int) -> Expression:
    """The part of an equation, isolable by stages, that holds the unknown under its outermost operations."""
    node = left if unknown in nodes.names(left) else right
    for _ in range(depth):
        undone = _undo(node, unknown)
        assert undone is not None
        node = undone[1]
    return node


def _chain(inside: Expression, other: Expression, unknown: str) -> Isolation | None:
    stages = _stages(inside, unknown)
    return None if stages is None else _through(stages, other, unknown)


def _stages(node: Expression, unknown: str) -> list[Stage] | None:
    """What undoes an expression, one operation after another; None where that is not known."""
    stages: list[Stage] = []
    while not isinstance(node, Name):
        if sum(unknown in nodes.names(part) for part in nodes.children(node)) > 1:
            rest = _repeated(node, unknown)
            return None if rest is None else [*stages, *rest]
        undone = _undo(node, unknown)
        if undone is None:
            return None
        stage, node = undone
        stages.append(stage)
    return stages


def _through(stages: Sequence[Stage], other: Expression, unknown: str, common: bool = False) -> Isolation:
    branches = 1
    for stage in stages:
        branches *= len(stage.forms)
    doubtful = any(_may_fail(stage) for stage in stages)
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


def _may_fail(stage: Stage) -> bool:
    """Whether the target may leave the image, or the form divide by what may vanish, or take a root."""
    if stage.operation == "root":
        return True  # always defined, but a polynomial no more
    bounded = stage.low > -inf or stage.high < inf
    divides = any(not isinstance(form, Product) for form in stage.forms)
    return bounded or (divides and stage.divides)


def _undo(node: Expression, unknown: str) -> tuple[Stage, Expression] | None:
    """The stage that undoes the outermost operation, and the operand with the unknown."""
    match node:
        case Negative(operand):
            return Stage("negative", (negative(TARGET),)), operand
        case Sum(terms):
            return _undo_sum(terms, unknown)
        case Product(left, right):
            inner, factor = (left, right) if unknown in nodes.names(left) else (right, left)
            return Stage("product", (divide(TARGET, factor),), divisor=factor), inner
        case Quotient(left, right) if unknown in nodes.names(left):
            return Stage("quotient", (multiply(TARGET, right),), divisor=right), left
        case Quotient(Number(0.0), right):  # of no divisor, as 0 times it is of no factor
            return Stage("product", (divide(TARGET, ZERO),), divisor=ZERO), right
        case Quotient(left, right):
            return Stage("quotient", (divide(left, TARGET),), divisor=TARGET), right
        case Power(base, exponent) if unknown in nodes.names(base):
            return _undo_power(exponent), base
        case Power(base, exponent):
            return _undo_exponent(base), exponent
        case Call(function, arguments):
            return _undo_call(function, arguments, unknown)
    return None


def _undo_sum(terms: tuple[Expression, ...], unknown: str) -> tuple[Stage, Expression]:
    at = next(i for i, term in enumerate(terms) if unknown in nodes.names(term))
    others = add(*terms[:at], *terms[at + 1 :])
    inner = terms[at]
    if isinstance(inner, Negative):
        return Stage("sum", (subtract(others, TARGET),)), inner.operand
    return Stage("sum", (subtract(TARGET, others),)), inner


def _undo_exponent(base: Expression) -> Stage:
    form = divide(call("ln", TARGET), call("ln", base))
    return Stage("power", (form,), low=0.0, low_open=True, divisor=call("ln", base))


def _undo_power(exponent: Expression) -> Stage:
    root = power(TARGET, divide(Number(1.0), exponent))
    signed = multiply(call("sgn", TARGET), power(call("abs", TARGET), divide(Number(1.0), exponent)))
    match exponent:
        case Number(value) if value == 2.0:
            principal = call("sqrt", TARGET)
            return Stage("square", (principal, negative(principal)), low=0.0)
        case Number(value) if value > 0 and value % 2 == 0:
            return Stage("power", (root, negative(root)), low=0.0)
        case Number(value) if value > 0 and value % 2 == 1:
            return Stage("root", (signed,))
        case Number(value) if value != value // 1:
            return Stage("power", (root,), low=0.0)
        case _:
            positive = power(call("abs", TARGET), divide(Number(1.0), exponent))
            return Stage("power", (positive, negative(positive)), divisor=exponent)


def _undo_call(
    function: str, arguments: tuple[Expression, ...], unknown: str
) -> tuple[Stage, Expression] | None:
    row = TABLE[function]
    if row.direction and len(arguments) == 2:
        return _undo_direction(row, arguments, unknown)
    preimage = row.inverse
    if preimage is None or len(arguments) != 1:
        return None
    stage = Stage(
        function,
        preimage.branches(TARGET),
        preimage.low,
        preimage.high,
        preimage.low_open,
        preimage.high_open,
        period=preimage.period,
    )
    return stage, arguments[0]


def _undo_direction(
    row: Function, arguments: tuple[Expression, ...], unknown: str
) -> tuple[Stage, Expression]:
    """``atan2(y, x) = t`` gives ``y*cos(t) = x*sin(t)``; the half plane is left to verification.

    The forms stay quotients where a factor is 0: all of a half line has the direction 0.
    """
    sine, cosine = row.sine_and_cosine
    y, x = arguments
    s, c = call(sine, TARGET), call(cosine, TARGET)
    half = (row.angle or 0.0) / 2
    if unknown in nodes.names(y):
        return Stage(row.name, (Quotient(Product(x, s), c),), -half, half, divisor=c), y
    return Stage(row.name, (Quotient(Product(y, c), s),), -half, half, divisor=s), x


def _by_formula(left: Expression, right: Expression, unknown: str) -> Isolation | None:
    found = rational.equation(left, right, unknown)
    if found is None:
        return None
    polynomial, multiplied = found
    if len(polynomial) == 2:
        c, b = polynomial
        stage = Stage("product", (divide(TARGET, b),), divisor=b)
        cost = 0 if isinstance(b, Number) else 1
        return Isolation(unknown, negative(c), (stage,), cost, verify=multiplied)
    if len(polynomial) == 3:
        quadratic = Quadratic(*polynomial)
        return Isolation(unknown, polynomial[0], (), 2, 2, verify=multiplied, quadratic=quadratic)
    return None


# --- an unknown that occurs several times, all in one part ---

PART = "#part"
"""Stands for the part of an equation that holds all occurrences of the unknown."""


def _by_common_part(left: Expression, right: Expression, unknown: str) -> Isolation | None:
    """Solve for the part that holds every occurrence, such as ``exp(-x)`` or ``(1 + i)^x``: undo what
    encloses them all, then solve a linear equation for that part; last, undo the part itself."""
    both = unknown in nodes.names(left) and unknown in nodes.names(right)
    if both and (powers := _powers(left, right, unknown)) is not None:
        return powers
    if both:
        left, right = subtract(left, right), ZERO
    inside, other = (left, right) if unknown in nodes.names(left) else (right, left)
    stages = _stages(inside, unknown)
    if stages is None or any(stage.period for stage in stages):
        return None
    return _through(stages, other, unknown, common=True)


def _repeated(node: Expression, unknown: str) -> list[Stage] | None:
    """What undoes an expression of which several operands hold the unknown."""
    signed = _signed_square(node, unknown)
    if signed is not None:
        return signed
    formula = _ratio(node, unknown)
    if formula is not None:
        return [formula]
    for part in _enclosing(node, unknown):
        exchanged = exchange(node, part, Name(PART))
        if unknown not in nodes.names(exchanged) and (formula := _ratio(exchanged, PART)) is not None:
            rest = _stages(part, unknown)
            return None if rest is None else [formula, *rest]
    return None


def _ratio(node: Expression, unknown: str) -> Stage | None:
    """``node = target`` as a linear equation in the unknown, its denominators multiplied away."""
    found = rational.equation(node, TARGET, unknown)
    if found is None or len(found[0]) != 2:
        return None
    c, b = found[0]
    return Stage("ratio", (divide(negative(c), b),), divisor=b)


def _enclosing(node: Expression, unknown: str) -> Iterator[Expression]:
    """The operands that hold the first occurrence of the unknown, the largest first, but not itself."""
    while not isinstance(node, Name):
        node = next(part for part in nodes.children(node) if unknown in nodes.names(part))
        if not isinstance(node, Name):
            yield node


def _signed_square(node: Expression, unknown: str) -> list[Stage] | None:
    """What undoes ``x*abs(x)``, the square with the sign of x, as in the head loss of a pipe."""
    factors, divisors = _factors(node)
    held = [factor for factor in factors if unknown in nodes.names(factor)]
    if any(unknown in nodes.names(divisor) for divisor in divisors) or len(held) != 2:
        return None
    one, other = held
    if one == Call("abs", (other,)):
        one, other = other, one
    if other != Call("abs", (one,)) or (rest := _stages(one, unknown)) is None:
        return None
    known = [factor for factor in factors if factor not in held]
    factor = divide(_product(known), _product(divisors))
    root = multiply(call("sgn", TARGET), call("sqrt", call("abs", TARGET)))
    return [Stage("product", (divide(TARGET, factor),), divisor=factor), Stage("root", (root,)), *rest]


def _powers(left: Expression, right: Expression, unknown: str) -> Isolation | None:
    """``p*a^x = q*b^x`` as ``(a/b)^x = q/p``."""
    (above, below), (under, over) = _factors(left), _factors(right)
    above, below = [*above, *over], [*below, *under]
    held = [part for part in (*above, *below) if unknown in nodes.names(part)]
    exponents = {part.exponent for part in held if isinstance(part, Power)}
    bases = [part.base for part in held if isinstance(part, Power)]
    if len(bases) < len(held) or len(exponents) != 1 or not _free(_product(bases), (unknown,)):
        return None
    (exponent,) = exponents
    rest = _stages(exponent, unknown)
    if rest is None or any(stage.period for stage in rest):
        return None
    base = divide(_product(_bases(above, held)), _product(_bases(below, held)))
    start = divide(
        _product([p for p in below if p not in held]), _product([p for p in above if p not in held])
    )
    return _through([_undo_exponent(base), *rest], start, unknown, common=True)


def _bases(parts: Sequence[Expression], held: Sequence[Expression]) -> list[Expression]:
    return [part.base for part in parts if part in held and isinstance(part, Power)]


def _factors(node: Expression) -> tuple[list[Expression], list[Expression]]:
    """The factors and the divisors of a product, signs among them."""
    match node:
        case Product(left, right):
            (above, below), (over, under) = _factors(left), _factors(right)
            return [*above, *over], [*below, *under]
        case Quotient(left, right):
            (above, below), (under, over) = _factors(left), _factors(right)
            return [*above, *over], [*below, *under]
        case Negative(operand):
            above, below = _factors(operand)
            return [Number(-1.0), *above], below
        case _:
            return [node], []


def _product(factors: Sequence[Expression]) -> Expression:
    product: Expression = Number(1.0)
    for factor in factors:
        product = multiply(product, factor)
    return product


def _quadratic_forms(quadratic: Quadratic) -> tuple[Expression, ...]:
    a, b, c = quadratic.a, quadratic.b, quadratic.c
    discriminant = subtract(power(b, Number(2.0)), multiply(Number(4.0), multiply(a, c)))
    root = call("sqrt", discriminant)
    twice = multiply(Number(2.0), a)
    return tuple(divide(add(negative(b), sign), twice) for sign in (root, negative(root)))
