"""Models as people read them: equations in text or LaTeX, and tables in HTML."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from html import escape
from math import isfinite
from typing import TYPE_CHECKING, Any, NamedTuple

from sympy import Mul, Pow
from sympy.printing.latex import LatexPrinter
from sympy.printing.str import StrPrinter

from rulesheets.algebra.convert import AS_WRITTEN
from rulesheets.model import Equation, Model, Premise, Requirement
from rulesheets.syntax.nodes import And, Comparison, Condition, Expression, Given, Not, Or

if TYPE_CHECKING:
    from rulesheets.model import Variable


_GREEK = (
    *("alpha", "beta", "gamma", "delta", "epsilon", "zeta", "eta", "theta", "iota", "kappa", "lambda", "mu"),
    *("nu", "xi", "pi", "rho", "sigma", "tau", "upsilon", "phi", "chi", "psi", "omega"),
)
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


def expression_latex(expression: Expression) -> str:
    r"""An expression as it is written, in LaTeX: ``omegaAO*AO`` is ``\omega_{AO} \mathit{AO}``."""
    return _latex(expression)


def condition_latex(condition: Condition) -> str:
    """A condition as it is written, in LaTeX."""
    return _LATEX.condition(condition)


def _place(rule: Equation | Requirement) -> str:
    return f"{os.path.basename(rule.rule.file)}:{rule.rule.line}"


def _text_row(rule: Equation | Requirement, model: Model) -> str:
    if isinstance(rule, Requirement):
        row = _TEXT.condition(rule.comparison)
    else:
        row = f"{_text(rule.left)} = {_text(rule.right)}"
    guard = _TEXT.guard(rule.guard, model)
    return f"{row}   if {guard}" if guard else row


def _latex_row(rule: Equation | Requirement, model: Model) -> str:
    if isinstance(rule, Requirement):
        row = f"  & {_LATEX.condition(rule.comparison)}"
    else:
        row = f"  {_latex(rule.left)} &= {_latex(rule.right)}"
    guard = _LATEX.guard(rule.guard, model)
    if guard:
        row += rf" && \text{{if }} {guard}"
    return f"  % {_place(rule)}\n{row}"


def _text(expression: Expression) -> str:
    printer = StrPrinter({"order": "none", "full_prec": False})
    text: str = printer.doprint(AS_WRITTEN.expression(expression))
    return text.replace("**", "^")


def _latex(expression: Expression) -> str:
    text: str = _LatexPrinter({"order": "none"}).doprint(AS_WRITTEN.expression(expression))
    return text


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


class _ConditionPrinter(NamedTuple):
    """Conditions in the order that they were written in, which sympy's ``And`` does not keep."""

    expression: Callable[[Expression], str]
    relations: Mapping[str, str]
    joint: Mapping[type, str]
    negation: str
    given: Callable[[str], str]

    def guard(self, guard: tuple[Premise, ...], model: Model) -> str:
        """All premises joined by ``and``, empty where there are none."""
        conditions = tuple(
            model.conditions[premise.condition]
            if premise.holds
            else _not(model.conditions[premise.condition])
            for premise in guard
        )
        return self.condition(conditions[0] if len(conditions) == 1 else And(conditions))

    def condition(self, node: Condition) -> str:
        match node:
            case Comparison(operator, left, right):
                relation = self.relations.get(operator, operator)
                return f"{self.expression(left)} {relation} {self.expression(right)}"
            case And(terms) | Or(terms):
                parts = [
                    f"({self.condition(term)})" if isinstance(term, And | Or) else self.condition(term)
                    for term in terms
                ]
                return self.joint[type(node)].join(parts)
            case Not(term):
                return self.negation.format(self.condition(term))
            case Given(name):
                return self.given(name)


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


_TEXT = _ConditionPrinter(_text, {}, {And: " and ", Or: " or "}, "not({})", "given('{})".format)
_LATEX = _ConditionPrinter(
    _latex,
    _LATEX_RELATIONS,
    {And: r" \text{ and } ", Or: r" \text{ or } "},
    r"\text{{not }} \left({}\right)",
    lambda name: rf"\text{{given }} {latex_name(name)}",
)


ROWS = 60
"""Rows of a table that are shown."""

_CELL = "padding:2px 10px;vertical-align:top;text-align:"


def html_table(heads: Sequence[str], rows: Iterable[Sequence[str]], numeric: Collection[int] = ()) -> str:
    """A table of texts; the columns ``numeric`` are aligned to the right."""
    styles = [_CELL + ("right" if at in numeric else "left") for at in range(len(heads))]
    top = "".join(map(_head, heads, styles))
    body = "".join(f"<tr>{''.join(map(_datum, row, styles))}</tr>" for row in rows)
    whole = "border-collapse:collapse;font-variant-numeric:tabular-nums"
    return f'<table style="{whole}"><thead><tr>{top}</tr></thead><tbody>{body}</tbody></table>'


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


def _head(text: str, style: str) -> str:
    return f'<th style="{style}">{escape(text)}</th>'


def _datum(text: str, style: str) -> str:
    return f'<td style="{style}">{escape(text)}</td>'
