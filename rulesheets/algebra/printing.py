"""The equations of a model, one a line: where the rule stands, what it says, under which condition."""

from __future__ import annotations

import os
import re
from typing import Any

import sympy
from sympy.printing.latex import LatexPrinter
from sympy.printing.str import StrPrinter

from rulesheets.algebra.convert import AS_WRITTEN
from rulesheets.algebra.names import latex_name
from rulesheets.model import Equation, Model

_LATEX_FUNCTIONS = {"asin": r"\arcsin", "acos": r"\arccos", "atan": r"\arctan", "gamma": r"\Gamma"}
_RELATIONS = {"==": "=", "!=": "<>"}
_SYMBOL = re.compile(r"'\w+")


def listing(model: Model, latex: bool = False) -> str:
    """Every equation on a line of its own with its place; guards after ``if``.

    In LaTeX the lines are rows of an ``align*`` environment, the places in comments.
    """
    if latex:
        rows = [_latex_row(equation, model) for equation in model.equations]
        return "\\begin{align*}\n" + " \\\\\n".join(rows) + "\n\\end{align*}"
    places = [_place(equation) for equation in model.equations]
    width = max((len(place) for place in places), default=0)
    return "\n".join(
        f"{place:<{width}}  {_text(equation, model)}"
        for place, equation in zip(places, model.equations, strict=True)
    )


def _place(equation: Equation) -> str:
    return f"{os.path.basename(equation.rule.file)}:{equation.rule.line}"


def _text(equation: Equation, model: Model) -> str:
    printer = _TextPrinter({"order": "none", "full_prec": False})
    text: str = printer.doprint(AS_WRITTEN.equation(equation))
    if equation.guard:
        text += f"   if {printer.doprint(AS_WRITTEN.guard(equation.guard, model))}"
    return text.replace("**", "^")


def _latex_row(equation: Equation, model: Model) -> str:
    printer = _LatexPrinter({"order": "none"})
    converted = AS_WRITTEN.equation(equation)
    row = f"  {printer.doprint(converted.lhs)} &= {printer.doprint(converted.rhs)}"
    if equation.guard:
        row += rf" && \text{{if }} {printer.doprint(AS_WRITTEN.guard(equation.guard, model))}"
    return f"  % {_place(equation)}\n{row}"


class _TextPrinter(StrPrinter):  # type: ignore[misc]
    """Sheets say ``=`` and ``and`` where Python says ``==`` and ``&``."""

    def _print_Relational(self, relation: Any) -> str:
        operator = _RELATIONS.get(relation.rel_op, relation.rel_op)
        return f"{self._print(relation.lhs)} {operator} {self._print(relation.rhs)}"

    def _print_And(self, conjunction: Any) -> str:
        return " and ".join(self._part(part, sympy.Or) for part in conjunction.args)

    def _print_Or(self, disjunction: Any) -> str:
        return " or ".join(self._part(part, sympy.And) for part in disjunction.args)

    def _print_Not(self, negation: Any) -> str:
        return f"not({self._print(negation.args[0])})"

    def _part(self, part: Any, bracketed: type) -> str:
        text: str = self._print(part)
        return f"({text})" if isinstance(part, bracketed) else text


class _LatexPrinter(LatexPrinter):  # type: ignore[misc]
    def _print_Symbol(self, symbol: Any, style: str = "plain") -> str:
        if _SYMBOL.fullmatch(symbol.name) or symbol.name.startswith("given("):
            return rf"\text{{{symbol.name}}}".replace("_", r"\_")
        return latex_name(symbol.name)

    def _print_Function(self, expr: Any, exp: str | None = None) -> str:
        name = _LATEX_FUNCTIONS.get(expr.func.__name__, rf"\operatorname{{{expr.func.__name__}}}")
        if expr.func.__name__ in ("sin", "cos", "tan", "sinh", "cosh", "tanh", "ln", "exp", "min", "max"):
            name = "\\" + expr.func.__name__
        arguments = ", ".join(self._print(argument) for argument in expr.args)
        power = "" if exp is None else f"^{{{exp}}}"
        return rf"{name}{power}\left({arguments}\right)"
