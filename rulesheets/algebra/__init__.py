"""The only door to sympy: rules as sympy's equations, and as people read them.

Every equation of a model can be had as ``Eq(left, right)`` with its guard, every model as a listing in text
or LaTeX, and as tables in HTML.
"""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from html import escape
from math import isfinite
from typing import Any, NamedTuple, TypeAlias

import sympy
from sympy import Mul, Pow
from sympy.core.alphabets import greeks
from sympy.printing.latex import LatexPrinter

from rulesheets.format import format_condition, format_expression
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
    conjunction,
)

Form: TypeAlias = Callable[..., Any]


def _form(row: Function) -> Form:
    def defined(template: Expression, places: Mapping[str, Any]) -> Any:
        return AS_MATHEMATICS.expression(template).subs(places, simultaneous=True)

    return row.form("sympy", sympy, defined) or _named(row)


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


class SympyEquation(NamedTuple):
    """``equation`` holds where ``guard`` does (``true`` for a rule without ``if``); ``place`` is its rule."""

    equation: sympy.Eq
    guard: Any
    place: Span


def sympy_equations(model: Model) -> tuple[SympyEquation, ...]:
    """Every equation of a model in sympy with its guard and its place in the text, in the model's order."""
    told = AS_MATHEMATICS.condition
    guards = (told(conjunction(model.outcomes(e.guard))) if e.guard else sympy.true for e in model.equations)
    return tuple(
        SympyEquation(AS_MATHEMATICS.equation(equation), guard, equation.rule)
        for equation, guard in zip(model.equations, guards, strict=True)
    )


_GREEK = tuple(name for name in greeks if name != "omicron")  # of which LaTeX has no letter
_CAPITALS = ("Gamma", "Delta", "Theta", "Lambda", "Xi", "Pi", "Sigma", "Phi", "Psi", "Omega")
_STEM = "|".join(sorted((*_GREEK, *_CAPITALS), key=len, reverse=True))

_GREEK_NAME = re.compile(rf"({_STEM})_?(|[A-Z0-9_].*)")
_LETTER_NAME = re.compile(r"([A-Za-z])_?([A-Z0-9][A-Za-z0-9_]*|_.+)", re.ASCII)
_COORDINATE = re.compile(r"([xyz])([a-z]\d*)", re.ASCII)
_NUMBERED = re.compile(r"([A-Za-z]{2,})_?(\d+)", re.ASCII)


def latex_name(name: str) -> str:
    r"""LaTeX of a variable's full name.

    >>> latex_name("omegaAB"), latex_name("thetaAO"), latex_name("xa11"), latex_name("offset")
    ('\\omega_{AB}', '\\theta_{AO}', 'x_{a11}', '\\mathrm{offset}')
    """
    *scope, local = name.split(".")
    prefix = "".join(rf"\text{{{_plain(part)}.}}" for part in scope)
    return prefix + _local(local)


def _local(name: str) -> str:
    if greek := _GREEK_NAME.fullmatch(name):
        return "\\" + greek[1] + _index(greek[2])
    if len(name) == 1:
        return name
    if name.isupper() and name.isalpha():
        return rf"\mathit{{{name}}}"
    for pattern in (_COORDINATE, _LETTER_NAME):
        if parts := pattern.fullmatch(name):
            return parts[1] + _index(parts[2])
    if numbered := _NUMBERED.fullmatch(name):
        return rf"\mathrm{{{numbered[1]}}}" + _index(numbered[2])
    return rf"\mathrm{{{_plain(name)}}}"


def _index(text: str) -> str:
    index = _plain(text.strip("_"))
    return f"_{{{index}}}" if index else ""


def _plain(text: str) -> str:
    return text.replace("_", r"\_").replace("#", r"\#")


_LATEX_FUNCTIONS = {
    **{
        name: f"\\{name}" for name in ("sin", "cos", "tan", "sinh", "cosh", "tanh", "ln", "exp", "min", "max")
    },
    "asin": r"\arcsin",
    "acos": r"\arccos",
    "atan": r"\arctan",
    "gamma": r"\Gamma",
}
_LATEX_RELATIONS = {"<>": r"\neq", "<=": r"\leq", ">=": r"\geq"}
_JOINT = {And: r" \text{ and } ", Or: r" \text{ or } "}
_NEGATED = {"=": "<>", "<>": "="}


def listing(model: Model, latex: bool = False) -> str:
    """Every equation on a line of its own with its place, then every requirement; guards after ``if``.

    In LaTeX the lines are rows of an ``align*`` environment, the places in comments.
    """
    rules: tuple[Equation | Requirement, ...] = (*model.equations, *model.requirements)
    if latex:
        rows = [_latex_row(rule, model) for rule in rules]
        return "\\begin{align*}\n" + " \\\\\n".join(rows) + "\n\\end{align*}"
    places = [_place(rule) for rule in rules]
    width = max((len(place) for place in places), default=0)
    return "\n".join(
        f"{place:<{width}}  {_text_row(rule, model)}" for place, rule in zip(places, rules, strict=True)
    )


def _place(rule: Equation | Requirement) -> str:
    return f"{os.path.basename(rule.rule.file)}:{rule.rule.line}"


def _text_row(rule: Equation | Requirement, model: Model) -> str:
    if isinstance(rule, Requirement):
        row = format_condition(rule.comparison)
    else:
        row = f"{format_expression(rule.left)} = {format_expression(rule.right)}"
    guard = conjunction(model.outcomes(rule.guard), _not) if rule.guard else None
    return f"{row}   if {format_condition(guard)}" if guard else row


def _latex_row(rule: Equation | Requirement, model: Model) -> str:
    if isinstance(rule, Requirement):
        row = f"  & {condition_latex(rule.comparison)}"
    else:
        row = f"  {expression_latex(rule.left)} &= {expression_latex(rule.right)}"
    if rule.guard:
        row += rf" && \text{{if }} {condition_latex(conjunction(model.outcomes(rule.guard), _not))}"
    return f"  % {_place(rule)}\n{row}"


def expression_latex(expression: Expression) -> str:
    r"""An expression as it is written, in LaTeX: ``omegaAO*AO`` is ``\omega_{AO} \mathit{AO}``."""
    text: str = _LatexPrinter({"order": "none"}).doprint(AS_WRITTEN.expression(expression))
    return text


def condition_latex(node: Condition) -> str:
    """A condition in LaTeX, in the order in which it is written, which sympy's ``And`` does not keep."""
    match node:
        case Comparison(operator, left, right):
            relation = _LATEX_RELATIONS.get(operator, operator)
            return f"{expression_latex(left)} {relation} {expression_latex(right)}"
        case And(terms) | Or(terms):
            parts = [
                f"({condition_latex(term)})" if isinstance(term, And | Or) else condition_latex(term)
                for term in terms
            ]
            return _JOINT[type(node)].join(parts)
        case Not(term):
            return rf"\text{{not }} \left({condition_latex(term)}\right)"
        case Given(name):
            return rf"\text{{given }} {latex_name(name)}"


class _LatexPrinter(LatexPrinter):  # type: ignore[misc]
    def _print_Symbol(self, symbol: Any, style: str = "plain") -> str:
        if symbol.name.startswith("'"):
            return rf"\text{{{symbol.name}}}".replace("_", r"\_")
        return latex_name(symbol.name)

    def _print_Mul(self, expr: Any) -> str:
        """A product with divisors as one fraction: ``-a*b/c`` is not ``- a b \\frac{1}{c}``."""
        below = [factor.base for factor in expr.args if _inverse(factor)]
        above = [factor for factor in expr.args if not _inverse(factor)]
        if not below:
            return str(super()._print_Mul(expr))
        negative = above.count(-1) % 2 == 1
        numerator, denominator = (
            self._print(Mul(*factors, evaluate=False))
            for factors in ([factor for factor in above if factor not in (1, -1)], below)
        )
        return ("- " if negative else "") + rf"\frac{{{numerator}}}{{{denominator}}}"

    def _print_Function(self, expr: Any, exp: str | None = None) -> str:
        function = expr.func.__name__
        name = _LATEX_FUNCTIONS.get(function, rf"\operatorname{{{function}}}")
        arguments = ", ".join(self._print(argument) for argument in expr.args)
        power = "" if exp is None else f"^{{{exp}}}"
        return rf"{name}{power}\left({arguments}\right)"


def _inverse(factor: Any) -> bool:
    return isinstance(factor, Pow) and factor.exp == -1


def _not(condition: Condition) -> Condition:
    """What holds where the condition does not, without ``not`` where that is one comparison.

    The opposite of ``<`` is not ``>=``: compared with a symbol both are false.
    """
    match condition:
        case Comparison(operator, left, right) if operator in _NEGATED:
            return Comparison(_NEGATED[operator], left, right)
        case Not(term):
            return term
        case _:
            return Not(condition)


ROWS = 60
"""Rows of a table that are shown."""

_CELL = "padding:2px 10px;vertical-align:top;text-align:"


def html_table(heads: Sequence[str], rows: Iterable[Sequence[str]], numeric: Collection[int] = ()) -> str:
    """A table of texts; the columns ``numeric`` are aligned to the right."""
    styles = [_CELL + ("right" if at in numeric else "left") for at in range(len(heads))]

    def line(kind: str, texts: Sequence[str]) -> str:
        cells = (f'<{kind} style="{s}">{escape(t)}</{kind}>' for t, s in zip(texts, styles, strict=False))
        return f"<tr>{''.join(cells)}</tr>"

    body = "".join(line("td", row) for row in rows)
    whole = "border-collapse:collapse;font-variant-numeric:tabular-nums"
    return f'<table style="{whole}"><thead>{line("th", heads)}</thead><tbody>{body}</tbody></table>'


def more(count: int, noun: str = "rows") -> str:
    """How many rows are not shown."""
    return f"<p>… {count - ROWS:,} more {noun}</p>" if count > ROWS else ""


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
