"""The only door to sympy: rules as sympy's equations, and as people read them.

Every equation of a model can be had as ``Eq(left, right)`` with its guard, every model as a listing
in text or LaTeX, and as tables in HTML.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from fractions import Fraction
from html import escape
from math import isfinite
from typing import Any, NamedTuple, TypeAlias

import sympy
from sympy import QQ
from sympy.polys.rings import ring

from rulesheets.format import ROWS, Latex, Notation, html_table, more
from rulesheets.functions import TABLE
from rulesheets.functions.row import Forms, Function
from rulesheets.model import Equation, Model, Requirement, Variable
from rulesheets.syntax import Span, nodes

Form: TypeAlias = Callable[..., Any]


def _form(row: Function) -> Form:
    def defined(template: nodes.Expression, places: Mapping[str, Any]) -> Any:
        return mathematics(template).subs(places, simultaneous=True)

    form: Form = row.form("sympy", sympy, defined) or sympy.Function(row.name)
    return form


MATHEMATICS = Forms(TABLE, _form)
"""Every function as sympy has it; angles of the degree functions in degrees."""

_RELATIONS = {"=": "Eq", "<>": "Ne", "<": "Lt", "<=": "Le", ">": "Gt", ">=": "Ge"}


def mathematics(node: nodes.Expression) -> Any:
    """An expression in sympy, which reorders arithmetic.

    Variables are symbols with their full names; so is the symbol ``'open``, by this name.
    """
    match node:
        case nodes.Number(value):
            return number(value)
        case nodes.Name(name):
            return sympy.Symbol(name)
        case nodes.Symbol(name):
            return sympy.Symbol(f"'{name}")
        case nodes.Negative(operand):
            return -mathematics(operand)
        case nodes.Sum(terms):
            return sympy.Add(*map(mathematics, terms))
        case nodes.Product() | nodes.Quotient():
            parts = ((sign, mathematics(factor)) for sign, factor in nodes.chain(node))
            return sympy.Mul(*(part if sign == "*" else 1 / part for sign, part in parts))
        case nodes.Power(base, exponent):
            return sympy.Pow(mathematics(base), mathematics(exponent))
        case nodes.Call(function, arguments):
            return MATHEMATICS[function](*map(mathematics, arguments))


def _condition(node: nodes.Condition) -> Any:
    match node:
        case nodes.Comparison(operator, left, right):
            relation = getattr(sympy, _RELATIONS[operator])
            return relation(mathematics(left), mathematics(right), evaluate=False)
        case nodes.And(terms):
            return sympy.And(*map(_condition, terms), evaluate=False)
        case nodes.Or(terms):
            return sympy.Or(*map(_condition, terms), evaluate=False)
        case nodes.Not(term):
            return sympy.Not(_condition(term), evaluate=False)
        case nodes.Given(name):
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
        guard = _condition(nodes.conjunction(outcomes)) if outcomes else sympy.true
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
    guard = notation.written(nodes.conjunction(model.outcomes(rule.guard), _not))
    return rf"{row} && \text{{if }} {guard}" if latex else f"{row}   if {guard}"


def _not(condition: nodes.Condition) -> nodes.Condition:
    """The opposite of a condition, without ``not`` if it is a single comparison.

    The opposite of ``<`` is not ``>=``: compared with a symbol both are false.
    """
    match condition:
        case nodes.Comparison(operator, left, right) if operator in _NEGATED:
            return nodes.Comparison(_NEGATED[operator], left, right)
        case nodes.Not(term):
            return term
        case _:
            return nodes.Not(condition)


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


# --- polynomials with rational coefficients, by generators and their exponents ---

Powers: TypeAlias = tuple[tuple[str, int], ...]
Terms: TypeAlias = Mapping[Powers, Fraction]


def resultant(one: Terms, other: Terms, by: str) -> dict[Powers, Fraction]:
    """The resultant by one generator, in the others: 0 wherever both are 0 for some ``by``."""
    names, (p, q) = _in_ring(one, other, by)
    return _terms(p.resultant(q), names[1:])


def without_factors(one: Terms, other: Terms) -> dict[Powers, Fraction]:
    """The first polynomial without the factors that it has in common with the other one."""
    names, (p, q) = _in_ring(one, other)
    while not (common := p.gcd(q)).is_ground:
        p = p.exquo(common)
    return _terms(p, names)


def _in_ring(one: Terms, other: Terms, first: str = "") -> tuple[list[str], list[Any]]:
    """The generators, that one first, and two polynomials in sympy."""
    names = sorted({n for terms in (one, other) for powers in terms for n, _ in powers})
    names.sort(key=lambda name: name != first)
    made, *_ = ring(names, QQ)
    found = []
    for terms in (one, other):
        powers = ((tuple(dict(p).get(n, 0) for n in names), c) for p, c in terms.items())
        found.append(made.from_dict({p: QQ(*c.as_integer_ratio()) for p, c in powers}))
    return names, found


def _terms(polynomial: Any, names: list[str]) -> dict[Powers, Fraction]:
    found = {}
    for powers, c in polynomial.items():
        generators = tuple((n, p) for n, p in zip(names, powers, strict=True) if p)
        found[generators] = Fraction(int(c.numerator), int(c.denominator))
    return found
