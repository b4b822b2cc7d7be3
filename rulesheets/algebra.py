"""The only door to sympy: rules as sympy's equations, and as people read them.

Every equation of a model can be had as ``Eq(left, right)`` with its guard, every model as a listing
in text or LaTeX, and as tables in HTML.

The roots of the *eliminants* of an equation with quotients, roots and absolute values include every
solution. Quotients are multiplied away; a root s of degree q of an expression e is one more unknown
with s^q = e. Those are eliminated one by one by resultants (J. J. Sylvester). An absolute value is
its argument or the opposite: there is an eliminant for each choice of signs. The polynomials may
have further roots, such as those of another sign, or poles. Where an explicit form is 0/0 its
unknown is free, and a solution there may be none of their roots.
"""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction
from functools import partial, reduce
from html import escape
from math import isfinite
from typing import Any, NamedTuple, TypeAlias

import sympy
from sympy import QQ, Poly, resultant
from sympy.polys.fields import field
from sympy.polys.rings import ring

from rulesheets.deadline import expect_time
from rulesheets.evaluate import Undefined, value
from rulesheets.evaluate.number import Arithmetic
from rulesheets.format import ROWS, Latex, Notation, html_table, more
from rulesheets.functions import TABLE
from rulesheets.functions.row import Forms, Function
from rulesheets.model import Equation, Model, Requirement, Variable
from rulesheets.syntax import Span
from rulesheets.syntax.nodes import (
    And,
    Call,
    Comparison,
    Condition,
    Expression,
    Given,
    Name,
    Negative,
    Not,
    Number,
    Or,
    Power,
    Product,
    Quotient,
    Sum,
    Symbol,
    chain,
    conjunction,
    rebuilt,
)

Form: TypeAlias = Callable[..., Any]


def _form(row: Function) -> Form:
    def defined(template: Expression, places: Mapping[str, Any]) -> Any:
        return mathematics(template).subs(places, simultaneous=True)

    form: Form = row.form("sympy", sympy, defined) or sympy.Function(row.name)
    return form


MATHEMATICS = Forms(TABLE, _form)
"""Every function as sympy has it; angles of the degree functions in degrees."""

_RELATIONS = {"=": "Eq", "<>": "Ne", "<": "Lt", "<=": "Le", ">": "Gt", ">=": "Ge"}


def mathematics(node: Expression) -> Any:
    """An expression in sympy, which reorders arithmetic.

    Variables are symbols with their full names; so is the symbol ``'open``, by this name.
    """
    match node:
        case Number(value):
            return number(value)
        case Name(name):
            return sympy.Symbol(name)
        case Symbol(name):
            return sympy.Symbol(f"'{name}")
        case Negative(operand):
            return -mathematics(operand)
        case Sum(terms):
            return sympy.Add(*map(mathematics, terms))
        case Product() | Quotient():
            parts = ((sign, mathematics(factor)) for sign, factor in chain(node))
            return sympy.Mul(*(part if sign == "*" else 1 / part for sign, part in parts))
        case Power(base, exponent):
            return sympy.Pow(mathematics(base), mathematics(exponent))
        case Call(function, arguments):
            return MATHEMATICS[function](*map(mathematics, arguments))


def _condition(node: Condition) -> Any:
    match node:
        case Comparison(operator, left, right):
            relation = getattr(sympy, _RELATIONS[operator])
            return relation(mathematics(left), mathematics(right), evaluate=False)
        case And(terms):
            return sympy.And(*map(_condition, terms), evaluate=False)
        case Or(terms):
            return sympy.Or(*map(_condition, terms), evaluate=False)
        case Not(term):
            return sympy.Not(_condition(term), evaluate=False)
        case Given(name):
            return sympy.Symbol(f"given('{name})")


def number(value: float) -> Any:
    """A sympy integer for a whole value, else a float with the digits that the value prints."""
    if value.is_integer() and abs(value) < 1e15:
        return sympy.Integer(int(value))
    return sympy.Float(repr(value), 17)


class SympyEquation(NamedTuple):
    """``equation`` holds if ``guard`` does (``true`` without ``if``); ``place``: its rule."""

    equation: sympy.Eq
    guard: Any
    place: Span


def sympy_equations(model: Model) -> tuple[SympyEquation, ...]:
    """Every equation of a model in sympy, in order, with its guard and its place in the text."""
    found = []
    for equation in model.equations:
        sides = sympy.Eq(mathematics(equation.left), mathematics(equation.right), evaluate=False)
        outcomes = model.outcomes(equation.guard)
        guard = _condition(conjunction(outcomes)) if outcomes else sympy.true
        found.append(SympyEquation(sides, guard, equation.rule))
    return tuple(found)


_NEGATED = {"=": "<>", "<>": "="}


def listing(model: Model, latex: bool = False) -> str:
    """Every equation with its place, then every requirement, a line each; guards after ``if``.

    In LaTeX the lines are rows of an ``align*`` environment, the places in comments.
    """
    rules: tuple[Equation | Requirement, ...] = (*model.equations, *model.requirements)
    places = [f"{os.path.basename(rule.rule.file)}:{rule.rule.line}" for rule in rules]
    rows = [*zip(places, (_row(rule, model, latex) for rule in rules), strict=True)]
    if latex:
        lines = (f"  % {place}\n  {row}" for place, row in rows)
        return "\\begin{align*}\n" + " \\\\\n".join(lines) + "\n\\end{align*}"
    width = max(map(len, places), default=0)
    return "\n".join(f"{place:<{width}}  {row}" for place, row in rows)


def _row(rule: Equation | Requirement, model: Model, latex: bool) -> str:
    notation = Latex() if latex else Notation()
    if isinstance(rule, Requirement):
        row = ("& " if latex else "") + notation.written(rule.comparison)
    else:
        left, right = notation.written(rule.left), notation.written(rule.right)
        row = f"{left} {'&=' if latex else '='} {right}"
    if not rule.guard:
        return row
    guard = notation.written(conjunction(model.outcomes(rule.guard), _not))
    return rf"{row} && \text{{if }} {guard}" if latex else f"{row}   if {guard}"


def _not(condition: Condition) -> Condition:
    """The opposite of a condition, without ``not`` if it is a single comparison.

    The opposite of ``<`` is not ``>=``: compared with a symbol both are false.
    """
    match condition:
        case Comparison(operator, left, right) if operator in _NEGATED:
            return Comparison(_NEGATED[operator], left, right)
        case Not(term):
            return term
        case _:
            return Not(condition)


def model_html(model: Model) -> str:
    """Name, variables with their values, and the rules with their places."""
    variables = [v for v in model.variables.values() if v.posted]
    rows = [(v.name, _written(v), v.unit or "", v.comment) for v in variables[:ROWS]]
    rules = listing(model).splitlines()
    shown = escape("\n".join(rules[:ROWS]))
    table = html_table(("Name", "Value", "Unit", "Comment"), rows, {1})
    tail = f"<pre>{shown}</pre>{more(len(rules), 'rules')}"
    return f"<div><b>{escape(model.name)}</b>{table}{more(len(variables), 'variables')}{tail}</div>"


def _written(variable: Variable) -> str:
    """The value, or the guess after ``~``, or the range."""
    value = variable.value
    if value is not None:
        return f"'{value}" if isinstance(value, str) else f"{value:.10g}"
    if variable.guess is not None:
        return f"~ {variable.guess:.10g}"
    low, high = variable.low, variable.high
    return f"in [{low:.6g}, {high:.6g}]" if isfinite(low) and isfinite(high) else ""


# --- polynomials over the rationals ---------------------------------------------

MAX_RADICALS = 3
MAX_ROOT = 4
MAX_DEGREE = 24
MAX_CHOICES = 64
"""Of the signs of absolute values."""
CLEAR = Fraction(1, 10**9)
"""Share of two numbers by which they differ clearly."""

Coefficients: TypeAlias = list[Fraction]
"""Of a polynomial, lowest degree first."""


def exact(number: float | Fraction) -> Any:
    return QQ(*number.as_integer_ratio())


def resultant_of(*polynomials: Mapping[tuple[int, ...], Fraction]) -> Coefficients:
    """The resultant of polynomials in y and x, by exponents of these, in x; none of 0."""
    made, *_ = ring(["y", "x"], QQ)
    p, q = (made.from_dict({m: exact(c) for m, c in p.items()}) for p in polynomials)
    dense = p.resultant(q).to_dense()
    return [Fraction(int(c.numerator), int(c.denominator)) for c in reversed(dense)]


# --- the eliminant --------------------------------------------------------------


class Eliminant(NamedTuple):
    """``polynomial``: its roots, and those of ``indeterminate``, at which forms may be 0/0, include
    every solution at which the polynomials ``positive`` are not negative; empty if there is no
    solution."""

    polynomial: Coefficients
    indeterminate: tuple[Coefficients, ...]
    positive: tuple[Coefficients, ...]


class NotAlgebraic(Exception):
    """The equation is not an algebraic function of low degree of the unknown."""


def eliminants(
    left: Expression,
    right: Expression,
    unknown: str,
    forms: Sequence[tuple[str, Expression]],
    known: Mapping[str, float],
) -> list[Eliminant] | None:
    """The eliminants, one for each choice of signs; None if the equation is not algebraic.

    ``forms`` are further unknowns by those before them; ``known`` numbers are exact.
    """
    found, waiting = list[Eliminant](), [tuple[int, ...]()]
    try:
        while waiting:
            one = _Eliminator(unknown, known, waiting.pop())
            found.append(one.run(left, right, forms))
            waiting += one.others
            if len(found) + len(waiting) > MAX_CHOICES:
                return None
    except (NotAlgebraic, OverflowError):
        return None
    return found


class _Eliminator(Arithmetic[Any]):
    """Quotients of polynomials (sympy's ``FracElement``) in the unknown and the radicals.

    ``signs`` are those of the first absolute values; ``others`` wait for eliminations.
    """

    def __init__(self, unknown: str, known: Mapping[str, float], signs: tuple[int, ...]) -> None:
        self.signs, self.others = signs, list[tuple[int, ...]]()
        self.chosen: dict[Any, int] = {}
        symbols = ["x", *(f"s{k}" for k in range(MAX_RADICALS))]
        self.field, first, *self.radicals = field(symbols, QQ)
        self.values = {name: self._exact(number) for name, number in known.items()}
        self.values[unknown] = first
        self.relations: dict[tuple[Any, int], Any] = {}
        self.common: list[Any] = []

    def run(
        self, left: Expression, right: Expression, forms: Sequence[tuple[str, Expression]]
    ) -> Eliminant:
        for name, form in forms:
            self.values[name] = self.of(form)
        factors = map(self._bare, self.common)
        common = (factor for factor in factors if not factor or not factor.is_ground)
        indeterminate = tuple(map(self._coefficients, common))
        sides = self.of(left), self.of(right)
        found = self._bare(self._bounded(sides[0] - sides[1]).numer)
        chosen = [(a.numer * a.denom, sign) for a, sign in [*self.chosen.items()][::2]]
        within = tuple(self._coefficients(sign * a) for a, sign in chosen if not _has_radicals(a))
        if within and found and found.is_ground and all(map(self._is_constant, sides)):
            # a case without a solution, unless that is by rounding
            one, other = map(self._constant, sides)
            if abs(one - other) > CLEAR * max(abs(one), abs(other)):
                return Eliminant([], indeterminate, within)
        return Eliminant(self._coefficients(found), indeterminate, within)

    def _bare(self, found: Any) -> Any:
        """A polynomial without radicals, whose roots include those of ``found``."""
        for (inside, degree), radical in reversed(self.relations.items()):
            expect_time()
            relation = radical.numer**degree * inside.denom - inside.numer
            if max(found.degrees()) > MAX_DEGREE:
                raise NotAlgebraic
            symbol = radical.as_expr()
            if symbol in found.as_expr().free_symbols:
                eliminated = resultant(found.as_expr(), relation.as_expr(), symbol)
                found = self.field.ring.from_expr(eliminated.expand())
        return found

    def _coefficients(self, found: Any) -> Coefficients:
        polynomial = Poly(found.as_expr(), self.field.gens[0].as_expr(), domain=QQ)
        if polynomial.degree() > MAX_DEGREE or polynomial.degree() < 1:
            raise NotAlgebraic
        return [Fraction(int(c.p), int(c.q)) for c in reversed(polynomial.all_coeffs())]

    # --- expressions ---

    def _exact(self, number: float) -> Any:
        if not math.isfinite(number):
            raise NotAlgebraic
        return self.field(exact(number))

    def number(self, node: Number) -> Any:
        return self._exact(node.value)

    def name(self, node: Name) -> Any:
        if node.name not in self.values:
            raise NotAlgebraic
        return self.values[node.name]

    def sum(self, node: Sum) -> Any:
        total = self.field.zero
        for term in node.terms:
            total = self._bounded(total + self.of(term))
        return total

    def product(self, node: Product) -> Any:
        return self._bounded(super().product(node))

    def divided(self, node: Quotient, above: Any, below: Any) -> Any:
        """The quotient; where both may be 0 is noted: roots may be 0 without a common factor."""
        if not below:
            raise NotAlgebraic
        one, other = above.numer, below.numer
        if not other.is_ground and not (one and one.is_ground):
            bare = not (_has_radicals(one) or _has_radicals(other))
            factor = one.gcd(other) if bare else other
            if not factor.is_ground:
                self.common.append(factor)
        return self._bounded(above / below)

    def raised(self, node: Power, base: Any, exponent: Any) -> Any:
        number = self._constant(exponent)
        near = number.limit_denominator(MAX_ROOT)
        if float(near) != float(number):
            return self._evaluated(node, base, exponent)
        return self._power(base, near)

    def applied(self, node: Call, arguments: list[Any]) -> Any:
        match node.function:
            case "pi":
                return self._exact(math.pi)
            case "sqrt":
                return self._power(arguments[0], Fraction(1, 2))
            case "abs":
                return self._absolute(arguments[0])
            case "min" | "max":  # of two: half of the sum, less or more half of the distance
                return reduce(partial(self._end, 1 if node.function == "max" else -1), arguments)
            case _:
                return self._evaluated(node, *arguments)

    def _absolute(self, argument: Any) -> Any:
        if self._is_constant(argument):
            return argument if self._constant(argument) >= 0 else -argument
        if argument not in self.chosen:
            place = len(self.chosen) // 2
            if place == len(self.signs):
                self.others.append((*self.signs, -1))
                self.signs = (*self.signs, 1)
            self.chosen |= {argument: self.signs[place], -argument: -self.signs[place]}
        return self.chosen[argument] * argument

    def _end(self, sign: int, one: Any, other: Any) -> Any:
        return self._bounded(one + other + sign * self._absolute(one - other)) / 2

    def _evaluated(self, node: Expression, *parts: Any) -> Any:
        """A function of numbers, rounded as one of the inputs is."""
        numbers = (Number(float(self._constant(part))) for part in parts)
        try:
            return self._exact(value(rebuilt(node, tuple(numbers)), {}))
        except Undefined:
            raise NotAlgebraic from None

    def _is_constant(self, element: Any) -> bool:
        return bool(element.numer.is_ground and element.denom.is_ground)

    def _constant(self, element: Any) -> Fraction:
        if not self._is_constant(element):
            raise NotAlgebraic
        number = element.numer.coeff(1) / element.denom.coeff(1)
        return Fraction(int(number.numerator), int(number.denominator))

    def symbol(self, node: Symbol) -> Any:
        raise NotAlgebraic

    def _power(self, base: Any, exponent: Fraction) -> Any:
        if exponent.denominator > 1:
            key = base, exponent.denominator
            if key not in self.relations:
                if len(self.relations) == MAX_RADICALS:
                    raise NotAlgebraic
                self.relations[key] = self.radicals[len(self.relations)]
            base = self.relations[key]
        if abs(exponent.numerator) > MAX_DEGREE or (exponent <= 0 and not base):
            raise NotAlgebraic
        return self._bounded(base**exponent.numerator)

    def _bounded(self, found: Any) -> Any:
        expect_time()
        degree = max(*found.numer.degrees(), *found.denom.degrees())
        if len(found.numer) + len(found.denom) > 400 or degree > 2 * MAX_DEGREE:
            raise NotAlgebraic
        return found


def _has_radicals(polynomial: Any) -> bool:
    return any(any(powers[1:]) for powers in polynomial.monoms())
