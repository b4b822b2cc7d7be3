"""The only door to sympy: every equation of a model as ``Eq(left, right)`` with its guard."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple, TypeAlias

import sympy

from rulesheets.functions import TABLE
from rulesheets.functions.row import Forms, Function
from rulesheets.model import Model, Premise
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
)

Form: TypeAlias = Callable[..., Any]


def _form(row: Function) -> Form:
    def defined(template: Expression, places: Mapping[str, Any]) -> Any:
        return expression_in_sympy(template).subs(places, simultaneous=True)

    return row.form("sympy", sympy, defined) or (lambda *arguments: sympy.Function(row.name)(*arguments))


FORMS = Forms(TABLE, _form)
"""Every function as sympy has it; angles of the degree functions in degrees."""

_RELATIONS: Mapping[str, Callable[..., Any]] = {
    "=": sympy.Eq,
    "<>": sympy.Ne,
    "<": sympy.Lt,
    "<=": sympy.Le,
    ">": sympy.Gt,
    ">=": sympy.Ge,
}


def expression_in_sympy(node: Expression) -> Any:
    """Variables are plain symbols of their full names, the symbol ``'open`` a symbol named ``'open``; numbers
    are integers where they are whole, else floats of the digits that they print with."""
    match node:
        case Number(value) if value.is_integer() and abs(value) < 1e15:
            return sympy.Integer(int(value))
        case Number(value):
            return sympy.Float(repr(value), 17)
        case Name(name):
            return sympy.Symbol(name)
        case Symbol(name):
            return sympy.Symbol(f"'{name}")
        case Negative(operand):
            return -expression_in_sympy(operand)
        case Sum(terms):
            return sympy.Add(*map(expression_in_sympy, terms))
        case Product() | Quotient():
            factors: list[Any] = []
            while isinstance(node, Product | Quotient):  # such a chain may be longer than recursion reaches
                right = expression_in_sympy(node.right)
                factors.append(1 / right if isinstance(node, Quotient) else right)
                node = node.left
            return sympy.Mul(expression_in_sympy(node), *reversed(factors))
        case Power(base, exponent):
            return sympy.Pow(expression_in_sympy(base), expression_in_sympy(exponent))
        case Call(function, arguments):
            return FORMS[function](*map(expression_in_sympy, arguments))


def condition_in_sympy(node: Condition) -> Any:
    """The parts are left as they are written."""
    match node:
        case Comparison(operator, left, right):
            relation = _RELATIONS[operator]
            return relation(expression_in_sympy(left), expression_in_sympy(right), evaluate=False)
        case And(terms):
            return sympy.And(*map(condition_in_sympy, terms), evaluate=False)
        case Or(terms):
            return sympy.Or(*map(condition_in_sympy, terms), evaluate=False)
        case Not(term):
            return sympy.Not(condition_in_sympy(term), evaluate=False)
        case Given(name):
            return sympy.Symbol(f"given('{name})")


class SympyEquation(NamedTuple):
    """``equation`` holds where ``guard`` does (``true`` for a rule without ``if``); ``place`` is its rule."""

    equation: sympy.Eq
    guard: Any
    place: Span


def sympy_equations(model: Model) -> tuple[SympyEquation, ...]:
    """Every equation of a model in sympy with its guard and its place in the text, in the model's order."""

    def premise_in_sympy(premise: Premise) -> Any:
        condition = condition_in_sympy(model.conditions[premise.condition])
        return condition if premise.holds else sympy.Not(condition, evaluate=False)

    found = []
    for rule in model.equations:
        sides = expression_in_sympy(rule.left), expression_in_sympy(rule.right)
        parts = [premise_in_sympy(premise) for premise in rule.guard]
        guard = parts[0] if len(parts) == 1 else sympy.And(*parts, evaluate=not parts)
        found.append(SympyEquation(sympy.Eq(*sides, evaluate=False), guard, rule.rule))
    return tuple(found)
