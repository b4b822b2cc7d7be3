"""Expressions, conditions and equations as sympy objects: as mathematics, or as names to be printed."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from typing import Any, NamedTuple, TypeAlias

import sympy

from rulesheets.functions import TABLE, Function
from rulesheets.functions.row import Forms
from rulesheets.model import Equation, Model, Premise
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
    match row.sympy:
        case None if row.definition is not None:
            return partial(_by_definition, row)
        case None:
            return _named(row)
        case str() as name:
            form: Form = getattr(sympy, name)
            return form
        case form:
            return partial(form, sympy)


def _by_definition(row: Function, *arguments: Any) -> Any:
    template, places = row.defined(arguments)
    return AS_MATHEMATICS.expression(template).subs(places, simultaneous=True)


def _named(row: Function) -> Form:
    return lambda *arguments: sympy.Function(row.name)(*arguments)


def _printed(row: Function) -> Form:
    match row.name:
        case "pi":
            return lambda: sympy.pi
        case "sqrt":
            return lambda x: sympy.sqrt(x, evaluate=False)
        case "abs":
            return lambda x: sympy.Abs(x, evaluate=False)
        case _:
            return _named(row)


MATHEMATICS = Forms(TABLE, _form)
"""Every function as sympy has it; angles of the degree functions in degrees."""
PRINTED = Forms(TABLE, _printed)
"""The same by their names in the language, so that a printed rule reads like the sheet."""


_RELATIONS: Mapping[str, Callable[..., Any]] = {
    "=": sympy.Eq,
    "<>": sympy.Ne,
    "<": sympy.Lt,
    "<=": sympy.Le,
    ">": sympy.Gt,
    ">=": sympy.Ge,
}


class Conversion(NamedTuple):
    """How trees become sympy: as mathematics, or left as written for printing.

    ``evaluate`` lets sympy put arithmetic in its own order; without it ``xB - xA`` stays.
    Variables are plain symbols of their full names, the symbol ``'open`` a symbol named ``'open``.
    """

    forms: Mapping[str, Form]
    evaluate: bool

    def expression(self, node: Expression) -> Any:
        match node:
            case Number(value):
                return number(value)
            case Name(name):
                return sympy.Symbol(name)
            case Symbol(name):
                return sympy.Symbol(f"'{name}")
            case Negative(operand):
                return self._negative(self.expression(operand))
            case Sum(terms):
                return sympy.Add(*[self.expression(term) for term in terms], evaluate=self.evaluate)
            case Product() | Quotient():
                return sympy.Mul(*self._factors(node), evaluate=self.evaluate)
            case Power(base, exponent):
                return sympy.Pow(self.expression(base), self.expression(exponent), evaluate=self.evaluate)
            case Call(function, arguments):
                return self.forms[function](*[self.expression(argument) for argument in arguments])

    def _negative(self, operand: Any) -> Any:
        if operand.is_Number:
            return -operand
        return sympy.Mul(sympy.S.NegativeOne, operand, evaluate=self.evaluate)

    def _factors(self, node: Expression) -> list[Any]:
        """The factors of a chain of products and quotients, left to right, divisors inverted."""
        factors: list[Any] = []
        while isinstance(node, Product | Quotient):
            right = self.expression(node.right)
            if isinstance(node, Quotient):
                right = sympy.Pow(right, sympy.S.NegativeOne, evaluate=self.evaluate)
            factors.append(right)
            node = node.left
        if isinstance(node, Negative) and not self.evaluate:  # -a*b, not (-a)*b
            factors.append(self.expression(node.operand))
            return [sympy.S.NegativeOne, *reversed(factors)]
        return [self.expression(node), *reversed(factors)]

    def condition(self, node: Condition) -> Any:
        match node:
            case Comparison(operator, left, right):
                relation = _RELATIONS[operator]
                return relation(self.expression(left), self.expression(right), evaluate=False)
            case And(terms):
                return sympy.And(*[self.condition(term) for term in terms], evaluate=False)
            case Or(terms):
                return sympy.Or(*[self.condition(term) for term in terms], evaluate=False)
            case Not(term):
                return sympy.Not(self.condition(term), evaluate=False)
            case Given(name):
                return sympy.Symbol(f"given('{name})")

    def guard(self, guard: tuple[Premise, ...], model: Model) -> Any:
        """The premises joined by ``and``; true where there is none."""
        parts = [
            condition if premise.holds else sympy.Not(condition, evaluate=False)
            for premise in guard
            for condition in (self.condition(model.conditions[premise.condition]),)
        ]
        return parts[0] if len(parts) == 1 else sympy.And(*parts, evaluate=not parts)

    def equation(self, equation: Equation) -> Any:
        left, right = self.expression(equation.left), self.expression(equation.right)
        return sympy.Eq(left, right, evaluate=False)


AS_MATHEMATICS = Conversion(MATHEMATICS, evaluate=True)
AS_WRITTEN = Conversion(PRINTED, evaluate=False)


def number(value: float) -> Any:
    """A sympy integer where the value is whole, else a float of the digits that the value prints with."""
    if value.is_integer() and abs(value) < 1e15:
        return sympy.Integer(int(value))
    return sympy.Float(repr(value), 17)
