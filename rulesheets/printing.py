"""Models as people read them: listings in text and LaTeX, tables in HTML."""

from __future__ import annotations

import os
import re
from collections.abc import Collection, Iterable, Sequence
from html import escape
from math import isfinite

from rulesheets.format import format_condition, format_expression, format_number, readable
from rulesheets.model import Equation, Model, Premise, Requirement, Variable
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

_GREEK = (
    *("alpha", "beta", "gamma", "delta", "epsilon", "zeta", "eta", "theta", "iota", "kappa", "lambda", "mu"),
    *("nu", "xi", "pi", "rho", "sigma", "tau", "upsilon", "phi", "chi", "psi", "omega"),
)
_CAPITALS = ("Gamma", "Delta", "Theta", "Lambda", "Xi", "Pi", "Sigma", "Phi", "Psi", "Omega")
_STEM = "|".join(sorted((*_GREEK, *_CAPITALS), key=len, reverse=True))

_GREEK_NAME = rf"({_STEM})_?(|[A-Z0-9_].*)"
_LETTER_NAME = r"([A-Za-z])_?([A-Z0-9][A-Za-z0-9_]*|_.+)"
_COORDINATE = r"([xyz])([a-z][0-9]*)"
_NUMBERED = r"([A-Za-z]{2,})_?([0-9]+)"


def latex_name(name: str) -> str:
    r"""LaTeX of a variable's full name.

    >>> latex_name("omegaAB"), latex_name("thetaAO"), latex_name("xa11"), latex_name("offset")
    ('\\omega_{AB}', '\\theta_{AO}', 'x_{a11}', '\\mathrm{offset}')
    """
    *scope, name = name.split(".")
    prefix = "".join(rf"\text{{{_plain(part)}.}}" for part in scope)
    return prefix + _local(name)


def _local(name: str) -> str:
    if greek := re.fullmatch(_GREEK_NAME, name):
        return "\\" + greek[1] + _index(greek[2])
    if len(name) == 1:
        return name
    if name.isupper() and name.isalpha():
        return rf"\mathit{{{name}}}"
    for pattern in (_COORDINATE, _LETTER_NAME):
        if parts := re.fullmatch(pattern, name):
            return parts[1] + _index(parts[2])
    if numbered := re.fullmatch(_NUMBERED, name):
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
    places = [f"{os.path.basename(rule.rule.file)}:{rule.rule.line}" for rule in rules]
    rows = [_latex_row(rule, model) if latex else _text_row(rule, model) for rule in rules]
    if latex:
        lines = (f"  % {place}\n{row}" for place, row in zip(places, rows, strict=True))
        return "\\begin{align*}\n" + " \\\\\n".join(lines) + "\n\\end{align*}"
    width = max(map(len, places), default=0)
    return "\n".join(f"{place:<{width}}  {row}" for place, row in zip(places, rows, strict=True))


def _text_row(rule: Equation | Requirement, model: Model) -> str:
    if isinstance(rule, Requirement):
        row = format_condition(rule.comparison)
    else:
        row = f"{format_expression(rule.left)} = {format_expression(rule.right)}"
    return f"{row}   if {format_condition(_joined(rule.guard, model))}" if rule.guard else row


def _latex_row(rule: Equation | Requirement, model: Model) -> str:
    if isinstance(rule, Requirement):
        row = f"  & {condition_latex(rule.comparison)}"
    else:
        row = f"  {expression_latex(rule.left)} &= {expression_latex(rule.right)}"
    guard = condition_latex(_joined(rule.guard, model)) if rule.guard else ""
    return rf"{row} && \text{{if }} {guard}" if guard else row


def _joined(guard: tuple[Premise, ...], model: Model) -> Condition:
    """All premises joined by ``and``."""
    premises = ((model.conditions[premise.condition], premise.holds) for premise in guard)
    conditions = tuple(condition if holds else _not(condition) for condition, holds in premises)
    return conditions[0] if len(conditions) == 1 else And(conditions)


_SUM, _PRODUCT, _FACTOR, _ATOM = range(4)
"""How tightly an expression binds: where one stands that binds less, it goes in parentheses."""


def expression_latex(node: Expression, place: int = _SUM) -> str:
    r"""An expression as it is written, in LaTeX: ``omegaAO*AO`` is ``\omega_{AO} \mathit{AO}``."""
    text, binds = _bound(node)
    return text if binds >= place else rf"\left({text}\right)"


def _bound(node: Expression) -> tuple[str, int]:
    """The LaTeX of a node without parentheses around it, and how tightly it binds."""
    match node:
        case Number(value) if value >= 0:
            digits, mark, exponent = format_number(value).partition("e")
            return (rf"{digits} \cdot 10^{{{exponent}}}", _FACTOR) if mark else (digits, _ATOM)
        case Name(name):
            return latex_name(name), _ATOM
        case Symbol(name):
            return rf"\text{{'{_plain(name)}}}", _ATOM
        case Call("pi", ()):
            return r"\pi", _ATOM
        case Call("sqrt", (inner,)):
            return rf"\sqrt{{{expression_latex(inner)}}}", _ATOM
        case Call("abs", (inner,)):
            return rf"\left|{{{expression_latex(inner)}}}\right|", _ATOM
        case Call():
            return _call(node), _ATOM
        case Power(Call(function) as call, exponent) if function not in ("pi", "sqrt", "abs"):
            return _call(call, f"^{{{expression_latex(exponent)}}}"), _FACTOR
        case Power(base, exponent):
            return f"{expression_latex(base, _ATOM)}^{{{expression_latex(exponent)}}}", _FACTOR
        case Product() | Quotient():
            return _fraction(node)
        case Sum(terms):
            first, *others = map(_signed, terms)
            text = ("- " if first[0] else "") + expression_latex(first[1], _PRODUCT)
            for negative, term in others:
                shown = expression_latex(term, _PRODUCT)
                shown = rf"\left({shown}\right)" if shown.startswith("-") else shown
                text += f" {'-' if negative else '+'} {shown}"
            return text, _SUM
        case Number() | Negative():
            negative, rest = _signed(node)
            sign = ("-" if isinstance(node, Number) else "- ") if negative else ""
            return sign + expression_latex(rest, _PRODUCT), _PRODUCT


def _call(call: Call, power: str = "") -> str:
    name = _LATEX_FUNCTIONS.get(call.function, rf"\operatorname{{{call.function}}}")
    return rf"{name}{power}\left({', '.join(map(expression_latex, call.arguments))}\right)"


def _signed(node: Expression) -> tuple[bool, Expression]:
    """Whether a minus sign stands before a term or factor, and what is left without it."""
    match node:
        case Negative(operand):
            negative, rest = _signed(operand)
            return not negative, rest
        case Number(value) if value < 0:
            return True, Number(-value)
        case _:
            return False, node


def _fraction(node: Expression) -> tuple[str, int]:
    r"""A chain of products and quotients as one fraction: ``-a*b/c`` is not ``- a b \frac{1}{c}``."""
    sides: tuple[list[Expression], list[Expression]] = ([], [])
    negative = False
    while isinstance(node, Product | Quotient):
        minus, factor = _signed(node.right)
        sides[isinstance(node, Quotient)].append(factor)
        negative, node = negative ^ minus, node.left
    minus, factor = _signed(node)
    sides[0].append(factor)
    above, below = sides
    sign = "- " if negative ^ minus else ""
    if not below:
        return sign + _factors(above), _PRODUCT
    above = [f for f in above if not (isinstance(f, Number) and f.value == 1.0)]
    return rf"{sign}\frac{{{_factors(above)}}}{{{_factors(below)}}}", _PRODUCT if sign else _FACTOR


def _factors(nodes: Sequence[Expression]) -> str:
    """Factors that are listed from the last to the first."""
    if len(nodes) < 2:
        return expression_latex(nodes[0]) if nodes else "1"
    text = ""
    for factor in (expression_latex(node, _FACTOR) for node in reversed(nodes)):
        dot = r"\cdot " if text[-1:].isdigit() and factor[:1].isdigit() else ""
        text += f" {dot}{factor}" if text else factor
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
    top, *body = (
        "".join(f'<{tag} style="{s}">{escape(text)}</{tag}>' for text, s in zip(row, styles, strict=False))
        for tag, row in (("th", heads), *(("td", row) for row in rows))
    )
    shown = "".join(f"<tr>{row}</tr>" for row in body)
    whole = "border-collapse:collapse;font-variant-numeric:tabular-nums"
    return f'<table style="{whole}"><thead><tr>{top}</tr></thead><tbody>{shown}</tbody></table>'


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
        return readable(value)
    if variable.guess is not None:
        return f"~ {variable.guess:.10g}"
    low, high = variable.low, variable.high
    return f"in [{low:.6g}, {high:.6g}]" if isfinite(low) and isfinite(high) else ""
