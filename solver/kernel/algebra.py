"""What algebra tells of a block at given numbers: every answer by a closed form, or that there is none."""

from __future__ import annotations

import itertools
import math
from collections import Counter
from collections.abc import Callable, Collection, Iterator, Mapping
from fractions import Fraction
from math import inf, isfinite, isinf
from typing import NamedTuple, TypeAlias

from rulesheets.evaluate import Undefined, value
from rulesheets.evaluate.number import Inexact, exactly, number_text
from rulesheets.functions import TABLE, named
from rulesheets.model import Value
from rulesheets.syntax.nodes import Call, Expression, Negative, Power, Product, Quotient, Sum, names
from rulesheets.syntax.nodes import Number as NumberNode
from rulesheets.syntax.program import walk
from solver.facts import Conflict, NoValue
from solver.kernel.candidates import Candidates
from solver.kernel.question import Question
from solver.numerics.linear_algebra import gauss_jordan, solve_linear
from solver.numerics.tolerances import BACKWARD, CLEAR, UNCANCELLED
from solver.path.elimination import Circle, ClosedForm, Coefficient, Formula, Let, Parabola

MOST = 300
"""Candidates that whole turns make of one."""


class Unclear(Exception):
    """A divisor or a discriminant too near to zero for the formulas to cover every solution."""


def solve_by_formula(question: Question, candidates: Candidates, form: ClosedForm) -> bool:
    """Find the answers by the closed form; False where it does not settle which they are."""
    try:
        found = evaluate(form, question.values)
    except (Unclear, ArithmeticError):
        return False
    points = [point for one in found for point in _turned(question, one)]
    trial = Candidates(question)
    if not all(map(trial.settles, points)):
        return False
    candidates.take(trial)
    for point in points:
        candidates.note(point)
    return True


def _turned(question: Question, values: Mapping[str, float]) -> list[dict[str, float]]:
    """The candidate, with every whole turn of its angles that a declared range has room for.

    Of too many the ones nearest to 0, which are still more than are listed.
    """
    points = [{name: values[name] for name in question.unknowns}]
    ranged = [v for v in question.variables if v.low > -math.inf or v.high < math.inf]
    angles = [(v, turn) for v in ranged if (turn := question.turn(v.name)) is not None]
    most = round(MOST ** (1 / max(len(angles), 1)))
    for variable, turn in angles:
        low, high = question.domain(variable.name)
        number = values[variable.name]
        turns = range(math.ceil((low - number) / turn), math.floor((high - number) / turn) + 1)
        if len(turns) > most:
            first = min(max(turns.start, round(-number / turn) - most // 2), turns.stop - most)
            turns = range(first, first + most)
        points = [{**p, variable.name: number + k * turn} for p in points for k in turns or (0,)]
    return points


def evaluate(form: ClosedForm, values: Mapping[str, Value]) -> list[dict[str, float]]:
    """Candidates: all solutions are among them. Raises Unclear, and Undefined for what overflows."""
    found: list[dict[str, float]] = [{}]
    for formula in form:
        found = [{**one, **more} for one in found for more in _values(formula, {**values, **one})]
    return found


def _values(formula: Formula, values: Mapping[str, Value]) -> Iterator[dict[str, float]]:
    def rounded(coefficient: Coefficient) -> Rounded:
        return Rounded(value(coefficient.expression, values), value(coefficient.size, values))

    match formula:
        case Let(name, expression, divisor, size):
            number = value(expression, values)
            if divisor and (size is None or abs(number) <= CLEAR * value(size, values)):
                raise Unclear
            yield {name: number}
        case Parabola(name, a, b, c):
            for root in roots(*(rounded(part) for part in (a, b, c))):
                yield {name: root}
        case Circle(x, y, a, b, k, square):
            for point in meets(*(rounded(part) for part in (a, b, k, square))):
                yield dict(zip((x, y), point, strict=True))


class Rounded(NamedTuple):
    """A number and the size of the terms that it was added up from."""

    value: float
    size: float


def roots(a: Rounded, b: Rounded, c: Rounded) -> tuple[float, ...]:
    """The real roots of ``a x² + b x + c``. Raises Unclear where rounding may hide or make some."""
    if a.size == 0.0:
        if b.value == 0.0 or abs(b.value) <= CLEAR * b.size:
            raise Unclear
        return (-c.value / b.value,)
    discriminant = b.value * b.value - 4.0 * a.value * c.value
    if abs(a.value) <= CLEAR * a.size:
        raise Unclear
    _clear(
        discriminant,
        b.value * b.value + abs(4.0 * a.value * c.value),
        b.size * b.size + 4.0 * a.size * c.size,
    )
    if discriminant < 0.0:
        return ()
    q = -0.5 * (b.value + math.copysign(math.sqrt(discriminant), b.value))
    return q / a.value, c.value / q


def meets(a: Rounded, b: Rounded, k: Rounded, square: Rounded) -> tuple[tuple[float, float], ...]:
    """Where ``a x + b y = k`` meets ``x² + y² = square``: two points or none. Raises Unclear between."""
    length = a.value * a.value + b.value * b.value
    _clear(length, length, a.size * a.size + b.size * b.size)
    discriminant = length * square.value - k.value * k.value
    _clear(
        discriminant,
        length * abs(square.value) + k.value * k.value,
        (a.size * a.size + b.size * b.size) * square.size + k.size * k.size,
    )
    if discriminant < 0.0:
        return ()
    root = math.sqrt(discriminant)
    return tuple(
        (
            (a.value * k.value - sign * b.value * root) / length,
            (b.value * k.value + sign * a.value * root) / length,
        )
        for sign in (1.0, -1.0)
    )


def _clear(number: float, terms: float, size: float) -> None:
    """Raise Unclear unless a number is known to be no zero: by what it came from, and by rounding."""
    if not (math.isfinite(size) and abs(number) > max(CLEAR * terms, UNCANCELLED * size)):
        raise Unclear


# --- rules of a block that contradict each other, or a function, whatever the values are ---
#
# ``x*y = 6`` contradicts ``x*y = 7``: every rule is taken as linear in what it adds up. ``erfc(u) = 2`` and
# ``exp(w) = 0`` ask for a value outside an image. A search over an infinite range can't tell an end of an
# image that is never attained; the rules themselves tell, where a sum of multiples of them leaves nothing but
# the function and a number, computed in fractions. They are taken as sums of monomials, products of powers of
# whatever is not added up. ``x/y`` is one, and a rule is multiplied by what it divides by, which is not 0 at
# any answer.

MAX_RULES = 40


def contradiction(question: Question) -> Conflict | None:
    """The rules of a block that can't hold together, where linear algebra shows it."""
    forms = question.kernel.forms
    if len(forms) > MAX_RULES:
        return None
    unknowns = frozenset(question.unknowns)

    def number(part: Expression) -> Fraction | None:
        return Fraction(value(part, question.here)) if unknowns.isdisjoint(names(part)) else None

    try:
        rows = [monomials(form, number) for form in forms]
        atoms = list(dict.fromkeys(monomial for row in rows for monomial in row if monomial))
        matrix = [[float(row.get(atom, 0.0)) for atom in atoms] for row in rows]
        rhs = [-float(row.get(ONE, 0.0)) for row in rows]
    except (Undefined, ArithmeticError, ValueError):
        return None
    facts = solve_linear(matrix, rhs)
    size = max(
        (abs(m * rhs[row]) for row, m in zip(facts.conflict, facts.multipliers, strict=True)), default=0.0
    )
    if not facts.conflict or abs(facts.miss) <= CLEAR * size:
        return None
    equations = tuple(question.equations[row] for row in facts.conflict)
    return Conflict(equations, facts.miss, dict(question.values))


Monomial: TypeAlias = frozenset[tuple[Expression, int]]
"""Factors with their exponents; none of them for a constant."""

Row: TypeAlias = dict[Monomial, Fraction]
ONE: Monomial = frozenset()


def monomials(expression: Expression, number: Callable[[Expression], Fraction | None]) -> Row:
    """The sum that an expression is; ``number`` gives the parts that are exactly known.

    Raises ZeroDivisionError for a known divisor that is 0.
    """
    row: Row = {}

    def add(part: Expression, factor: Fraction) -> None:
        known = number(part)
        if known is not None:
            row[ONE] = row.get(ONE, Fraction(0)) + factor * known
            return
        match part:
            case Negative(operand):
                add(operand, -factor)
            case Sum(terms):
                for term in terms:
                    add(term, factor)
            case Product(left, right) if (known := number(left)) is not None:
                add(right, factor * known)
            case Product(left, right) if (known := number(right)) is not None:
                add(left, factor * known)
            case Quotient(left, right) if (known := number(right)) is not None:
                add(left, factor / known)
            case _:
                coefficient, monomial = _monomial(part, number)
                row[monomial] = row.get(monomial, Fraction(0)) + factor * coefficient

    add(expression, Fraction(1))
    return {monomial: c for monomial, c in row.items() if c}


def _monomial(part: Expression, number: Callable[[Expression], Fraction | None]) -> tuple[Fraction, Monomial]:
    coefficient, powers = Fraction(1), Counter[Expression]()
    stack = [(part, 1)]
    while stack:
        factor, exponent = stack.pop()
        known = number(factor)
        match factor:
            case _ if known is not None:
                coefficient *= known**exponent
            case Product(left, right):
                stack += [(left, exponent), (right, exponent)]
            case Quotient(left, right):
                stack += [(left, exponent), (right, -exponent)]
            case Negative(operand):
                coefficient, stack = -coefficient, [*stack, (operand, exponent)]
            case Power(base, NumberNode(power)) if power in range(1, 65):
                stack.append((base, exponent * int(power)))
            case _:
                powers[factor] += exponent
    return coefficient, frozenset((factor, exponent) for factor, exponent in powers.items() if exponent)


def _cleared(row: Row) -> Row:
    """The row times what its monomials divide by."""
    lowest: Counter[Expression] = Counter()
    for monomial in row:
        for factor, exponent in monomial:
            lowest[factor] = min(lowest[factor], exponent)
    below = {factor: -exponent for factor, exponent in lowest.items() if exponent < 0}
    if not below:
        return row
    found: Row = {}
    for monomial, coefficient in row.items():
        powers = dict(monomial)
        raised = {factor: powers.get(factor, 0) + below.get(factor, 0) for factor in {**powers, **below}}
        key = frozenset((factor, exponent) for factor, exponent in raised.items() if exponent)
        found[key] = found.get(key, Fraction(0)) + coefficient
    return {monomial: c for monomial, c in found.items() if c}


HUGE = 10**300
"""Beyond that a number is shown as infinite."""
_LIMITED = named(
    lambda row: row.image or (row.inverse and (row.inverse.low, row.inverse.high) != (-inf, inf))
)
"""Functions that have an image with ends."""


def unattained(question: Question, given: Collection[str]) -> NoValue | None:
    """The rule of a block that a function would have to leave the inside of its image for, if there is one.

    ``given``: the known names whose values are exact; others are rounded, and prove nothing.
    """
    if len(question.equations) > MAX_RULES:
        return None
    calls: dict[Monomial, tuple[Call, int]] = {}
    for index, rule in zip(question.equations, question.kernel.equations, strict=True):
        for part in itertools.chain(walk(rule.left), walk(rule.right)):
            if isinstance(part, Call) and part.function in _LIMITED:
                calls.setdefault(frozenset({(part, 1)}), (part, index))
    if not calls:
        return None
    numbers = {name: value for name, value in question.here.items() if name in given}
    exact = {n: Fraction(v) for n, v in numbers.items() if not isinstance(v, str) and isfinite(v)}

    def number(part: Expression) -> Fraction | None:
        try:
            return exactly(part, exact)
        except (Inexact, ZeroDivisionError):
            return None

    try:
        rows = [_cleared(monomials(form, number)) for form in question.kernel.forms]
    except ZeroDivisionError:
        return None
    columns = sorted({m for row in rows for m in row if m}, key=calls.__contains__)
    matrix = [[row.get(monomial, Fraction(0)) for monomial in columns] for row in rows]
    found, _ = gauss_jordan(matrix, [-row.get(ONE, Fraction(0)) for row in rows])
    for *entries, constant in (row[: len(columns) + 1] for row in found):
        asked = [(monomial, entry) for monomial, entry in zip(columns, entries, strict=True) if entry]
        if len(asked) != 1 or asked[0][0] not in calls:
            continue
        (call, index), target = calls[asked[0][0]], Fraction(constant, asked[0][1])
        if _outside(call.function, target):
            unknown = next(name for name in (*names(call), *question.unknowns) if name in question.unknowns)
            shown = float(target) if abs(target) < HUGE else math.copysign(inf, target)
            return NoValue(index, unknown, f"{call.function} = {number_text(shown)}")
    return None


def _outside(function: str, target: Fraction) -> bool:
    """Whether a function never is the target. (Ends such as π/2 are no floats: they say nothing.)"""
    row = TABLE[function]
    low, high, low_open, high_open = -inf, inf, True, True
    if row.image is not None:
        low, high = row.image
    elif row.inverse is not None:
        _, low, high, low_open, high_open, _ = row.inverse
    if not all(isinf(end) or end.is_integer() for end in (low, high)):
        return False
    at_end = (low_open and target == low) or (high_open and target == high)
    return at_end or any(  # below an end by more than the rounding of what it was made of
        end != -inf and number < Fraction(end) - Fraction(BACKWARD) * max(Fraction(1), abs(Fraction(end)))
        for end, number in ((low, target), (-high, -target))
    )
