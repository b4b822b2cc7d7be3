"""A sheet as text in its canonical layout; rules in LaTeX, tables in HTML."""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from html import escape
from itertools import pairwise
from typing import Any, ClassVar, TypeAlias

from rulesheets.syntax import nodes

Node: TypeAlias = nodes.Expression | nodes.Condition

_OR, _AND, _COMPARISON, _NOT, _SUM, _PRODUCT, _FACTOR, _ATOM = range(8)
"""Precedences: a node that binds less tightly than its context requires is put in parentheses."""


def format_number(value: float) -> str:
    """The shortest text that reads back as the same float: ``3``, ``0.1``, ``1e-5``, ``1e22``."""
    digits, mark, exponent = repr(value).partition("e")
    return digits.removesuffix(".0") + (f"e{int(exponent)}" if mark else "")


class Notation:
    """Expressions and conditions on one line in the language: sums are spaced, products are not."""

    brackets = "({})"
    and_, or_, not_ = " and ", " or ", "not "
    relations: ClassVar[dict[str, str]] = {}

    def written(self, node: Node, place: int = _OR) -> str:
        """In parentheses if it binds less tightly than its context requires."""
        text, binds = self.bound(node)
        return text if binds >= place else self.brackets.format(text)

    def bound(self, node: Node) -> tuple[str, int]:
        """The text of a node without outer parentheses, and how tightly it binds."""
        match node:
            case nodes.Number():
                return self.number(node)
            case nodes.Name(name):
                return self.name(name), _ATOM
            case nodes.Symbol(name):
                return self.symbol(name), _ATOM
            case nodes.Call(function, arguments):
                return self.call(function, arguments), _ATOM
            case nodes.Power(base, exponent):
                return self.power(base, exponent), _FACTOR
            case nodes.Negative(operand):
                return f"-{self.written(operand, _FACTOR)}", _FACTOR
            case nodes.Product() | nodes.Quotient():
                return self.chain(node), _PRODUCT
            case nodes.Sum(terms):
                first, *others = terms
                return self.written(first, _PRODUCT) + "".join(map(self._added, others)), _SUM
            case nodes.Comparison(operator, left, right):
                relation = self.relations.get(operator, operator)
                return f"{self.written(left)} {relation} {self.written(right)}", _COMPARISON
            case nodes.Given(name):
                return self.given(name), _ATOM
            case nodes.Not(term):
                return f"{self.not_}{self.written(term, _NOT)}", _NOT
            case nodes.And(terms):
                return self.and_.join(self.written(term, _COMPARISON) for term in terms), _AND
            case nodes.Or(terms):
                return self.or_.join(self.written(term, _AND) for term in terms), _OR

    def _added(self, term: nodes.Expression) -> str:
        sign = "+"
        if isinstance(term, nodes.Negative):
            sign, term = "-", term.operand
        elif isinstance(term, nodes.Number) and term.value < 0:
            sign, term = "-", nodes.Number(-term.value, unit=term.unit)
        return f" {sign} {self.written(term, _PRODUCT)}"

    # --- differences between notations ---

    def number(self, node: nodes.Number) -> tuple[str, int]:
        text = format_number(node.value) + ("" if node.unit is None else f"[{node.unit}]")
        return text, _ATOM if node.value >= 0 else _FACTOR

    def name(self, name: str) -> str:
        return name

    def given(self, name: str) -> str:
        return f"given('{name})"

    def symbol(self, name: str) -> str:
        return f"'{name}"

    def call(self, function: str, arguments: tuple[nodes.Expression, ...]) -> str:
        inside = ", ".join(map(self.written, arguments))
        return function if function == "pi" else f"{function}({inside})"

    def power(self, base: nodes.Expression, exponent: nodes.Expression) -> str:
        return f"{self.written(base, _ATOM)}^{self.written(exponent, _FACTOR)}"

    def chain(self, node: nodes.Expression) -> str:
        """``a*b/c``"""
        (_, first), *others = nodes.chain(node)
        rest = (sign + self.written(factor, _FACTOR) for sign, factor in others)
        return self.written(first, _PRODUCT) + "".join(rest)


format_expression: Callable[[nodes.Expression], str] = Notation().written
format_condition: Callable[[nodes.Condition], str] = Notation().written


# --- in LaTeX -------------------------------------------------------------------

_GREEK = (
    "alpha|beta|gamma|delta|epsilon|zeta|eta|theta|iota|kappa|lambda|mu|nu|xi|pi|rho|sigma|tau|"
    "upsilon|phi|chi|psi|omega|Gamma|Delta|Theta|Lambda|Xi|Pi|Sigma|Phi|Psi|Omega"
)
_WORD = r"\math"
"""The start of a name of several upright or slanted letters."""
_GREEK_NAME = re.compile(rf"({_GREEK})_?(|[A-Z0-9_].*)")
_LETTER_NAME = re.compile(r"([A-Za-z])_?([A-Z0-9][A-Za-z0-9_]*|_.+)", re.ASCII)
_COORDINATE = re.compile(r"([xyz])([a-z]\d*)", re.ASCII)
_COMPONENT = re.compile(r"([a-ce-wA-Z])([xyz]\d*)", re.ASCII)
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
    for pattern in (_COORDINATE, _COMPONENT, _LETTER_NAME):
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


_OWN = "sin", "cos", "tan", "sinh", "cosh", "tanh", "ln", "exp", "min", "max"
_LATEX_FUNCTIONS = {name: f"\\{name}" for name in _OWN}
_LATEX_FUNCTIONS |= {"asin": r"\arcsin", "acos": r"\arccos", "atan": r"\arctan", "gamma": r"\Gamma"}


class Latex(Notation):
    """The same in LaTeX, in mathematics mode: ``omegaAO*AO`` is ``\\omega_{AO} \\mathit{AO}``."""

    brackets = r"\left({}\right)"
    and_, or_, not_ = r" \text{ and } ", r" \text{ or } ", r"\text{not } "
    relations: ClassVar[dict[str, str]] = {"<>": r"\neq", "<=": r"\leq", ">=": r"\geq"}

    def bound(self, node: Node) -> tuple[str, int]:
        if isinstance(node, nodes.Negative) and isinstance(
            node.operand, nodes.Product | nodes.Quotient
        ):
            return self._added(node).lstrip(), _PRODUCT
        return super().bound(node)

    def number(self, node: nodes.Number) -> tuple[str, int]:
        digits, mark, exponent = format_number(node.value).partition("e")
        text = rf"{digits} \cdot 10^{{{exponent}}}" if mark else digits
        return text, _FACTOR if node.value < 0 or mark else _ATOM

    def name(self, name: str) -> str:
        return latex_name(name)

    def given(self, name: str) -> str:
        return rf"\text{{given }} {latex_name(name)}"

    def symbol(self, name: str) -> str:
        return rf"\text{{'{_plain(name)}}}"

    def call(self, function: str, arguments: tuple[nodes.Expression, ...]) -> str:
        inside = ", ".join(map(self.written, arguments))
        match function:
            case "pi":
                return r"\pi"
            case "sqrt":
                return rf"\sqrt{{{inside}}}"
            case "abs":
                return rf"\left|{{{inside}}}\right|"
        return self._function(function) + self.brackets.format(inside)

    @staticmethod
    def _function(name: str) -> str:
        return _LATEX_FUNCTIONS.get(name, rf"\operatorname{{{_plain(name)}}}")

    def _added(self, term: nodes.Expression) -> str:
        text = super()._added(term)
        return text[:3] + self.brackets.format(text[3:]) if text[3] == "-" else text

    def power(self, base: nodes.Expression, exponent: nodes.Expression) -> str:
        """A power; for a function, the exponent follows its name."""
        raised = f"^{{{self.written(exponent)}}}"
        if isinstance(base, nodes.Call) and base.function not in ("pi", "sqrt", "abs"):
            inside = ", ".join(map(self.written, base.arguments))
            return self._function(base.function) + raised + self.brackets.format(inside)
        return self.written(base, _ATOM) + raised

    def chain(self, node: nodes.Expression) -> str:
        """A product; with divisors, one fraction: ``-a*b/c`` is not ``- a b \\frac{1}{c}``."""
        (_, first), *others = nodes.chain(node)
        below = [factor for sign, factor in others if sign == "/"]
        above = [factor for sign, factor in others if sign == "*"]
        negative = isinstance(first, nodes.Negative)
        above.insert(0, first.operand if isinstance(first, nodes.Negative) else first)
        if below:
            ones = [f for f in above if isinstance(f, nodes.Negative) and f.operand == nodes.ONE]
            negative ^= len(ones) % 2 == 1
            above = [f for f in above if f != nodes.ONE and f not in ones] or [nodes.ONE]
        text = self._times(above)
        if below:
            text = rf"\frac{{{text}}}{{{self._times(below)}}}"
        return f"- {text}" if negative else text

    def _times(self, factors: Sequence[nodes.Expression]) -> str:
        """Factors next to each other, with a dot before a number, and a space beside a word."""
        if len(factors) == 1:
            return self.written(factors[0])
        texts = [self.written(factor, _FACTOR) for factor in factors]
        texts[1:] = [self.brackets.format(t) if t.startswith("-") else t for t in texts[1:]]
        whole = texts[0]
        for before, text in pairwise(texts):
            apart = r"\, " if before.startswith(_WORD) or text.startswith(_WORD) else ""
            whole += rf" \cdot {text}" if text[0].isdigit() else f" {apart}{text}"
        return whole


# --- rules ----------------------------------------------------------------------


def format_list(expressions: tuple[nodes.Expression, ...]) -> str:
    """``a, b, c``."""
    return ", ".join(map(format_expression, expressions))


WIDTH = 80
"""Characters beyond which a conditional with ``else`` is broken into lines."""

_INDENTED = 32
"""Where ``then`` stands further to the right than this, ``else`` is not put below it."""


def format_rule(body: nodes.RuleBody) -> str:
    """The rule on one line."""
    match body:
        case nodes.Equality(left, right):
            return f"{_side(left)} = {_side(right)}"
        case nodes.Inequality(comparisons):
            first, *others = map(format_condition, comparisons)
            starts = (len(format_expression(comparison.left)) for comparison in comparisons[1:])
            return first + "".join(text[start:] for text, start in zip(others, starts, strict=True))
        case nodes.CallRule(function, arguments, results):
            shown = f"; {format_list(results)}" if results else ""
            return f"call {function}({format_list(arguments)}{shown})"
        case nodes.IfRule():
            return " ".join(_arms(body))


def _arms(rule: nodes.IfRule) -> list[str]:
    """``if … then …``, ``else if … then …``, ``else …``. A conditional after ``then`` is put in
    parentheses, so that an ``else`` is not read as its own."""
    arms = []
    word = "if"
    rest: nodes.RuleBody | None = rule
    while isinstance(rest, nodes.IfRule):
        then = format_rule(rest.then)
        then = f"({then})" if isinstance(rest.then, nodes.IfRule) else then
        arms.append(f"{word} {format_condition(rest.condition)} then {then}")
        word, rest = "else if", rest.otherwise
    if rest is not None:
        arms.append(f"else {format_rule(rest)}")
    return arms


def _side(expressions: tuple[nodes.Expression, ...]) -> str:
    text = format_list(expressions)
    return f"({text})" if len(expressions) > 1 else format_expression(expressions[0])


_INDENT = "  "
_WIDE = 60
"""Code wider than this does not push the comments of the lines around it to the right."""


def format_sheet(sheet: nodes.RuleSheet) -> str:
    """The canonical text of a sheet, with a line end after the last line (an empty sheet is empty).

    Comments and single blank lines inside sections are kept.
    """
    top: list[str] = []
    for index, line in enumerate(sheet.comments):
        top += [""] * bool(line.gap and index) + [_comment(line.text)]
    for use in sheet.uses:
        paths = ", ".join(f'"{path}"' for path in use.paths)
        top += _commented([f"use python {paths}" if use.python else f"use {paths}"], use.comment, 0)
    sections = [
        top,
        ["units", *_units(sheet.units)] if sheet.units else [],
        [] if sheet.variables is None else ["variables", *_variables(sheet.variables)],
        ["rules", *_rules(sheet.rules)] if sheet.rules else [],
        *(list(_figure(figure)) for figure in sheet.figures),
        *(list(_function(function)) for function in sheet.functions),
    ]
    text = "\n\n".join("\n".join(lines) for lines in sections if lines)
    return text and f"{text}\n"


def _comment(text: str) -> str:
    return f'" {text}'.rstrip()


def _commented(lines: list[str], comment: str, column: int) -> list[str]:
    """The lines with a comment after the last, two spaces away or in the given column."""
    if not comment:
        return lines
    *others, last = lines
    return [*others, f"{last.ljust(column)}  {_comment(comment)}"]


# --- units and variables --------------------------------------------------------


def _lines(rows: Iterable[Any], written: Callable[[Any], list[str]], column: int) -> Iterator[str]:
    """Rows as written, comments in a column; comment lines and single blank lines between."""
    for index, row in enumerate(rows):
        if row.gap and index:
            yield ""
        if isinstance(row, nodes.CommentLine):
            yield _INDENT + _comment(row.text)
        else:
            yield from _commented([_INDENT + line for line in written(row)], row.comment, column)


def _units(rows: Sequence[nodes.UnitRow | nodes.CommentLine]) -> Iterator[str]:
    def written(row: nodes.UnitRow) -> list[str]:
        return [" = ".join(filter(None, (", ".join(row.names), row.meaning)))]

    return _lines(rows, written, 0)


def _variables(rows: Sequence[nodes.VariableRow | nodes.CommentLine]) -> Iterator[str]:
    cells = [_cells(row) for row in rows if isinstance(row, nodes.VariableRow)]
    widths = [max(map(len, column)) for column in zip(*cells, strict=True)]

    def written(row: nodes.VariableRow) -> list[str]:
        pairs = zip(_cells(row), widths, strict=True)
        return [" ".join(cell.ljust(width) for cell, width in pairs if width).rstrip()]

    return _lines(rows, written, len(_INDENT) + sum(width + 1 for width in widths if width) - 1)


def _cells(row: nodes.VariableRow) -> tuple[str, str, str, str]:
    """Name, value or guess, range, unit."""
    value = unit = ""
    if row.value is not None:
        value = f"= {format_expression(row.value)}"
        if row.tolerance is not None:
            value += f" ± {format_expression(row.tolerance.size)}" + "%" * row.tolerance.percent
    elif row.guess is not None:
        value = f"~ {format_expression(row.guess)}"
    if row.display_unit is not None:
        unit = f"[{row.unit} -> {row.display_unit}]" if row.unit else f"[-> {row.display_unit}]"
    elif row.unit is not None:
        unit = f"[{row.unit}]"
    return row.name, value, _range(row.range), unit


def _range(bounds: Sequence[nodes.Comparison]) -> str:
    ends = [format_expression(bound.right) for bound in bounds]
    if [bound.operator for bound in bounds] == [">=", "<="]:
        return f"in [{ends[0]}, {ends[1]}]"
    pairs = zip(bounds, ends, strict=True)
    return ", ".join(f"{bound.operator} {end}" for bound, end in pairs)


# --- rules and functions --------------------------------------------------------


def _rules(rules: Sequence[nodes.Rule | nodes.Mark | nodes.CommentLine]) -> Iterator[str]:
    remarked = (rule for rule in rules if not isinstance(rule, nodes.CommentLine) and rule.comment)
    ends = [len(_INDENT) + len(_said(rule)[-1]) for rule in remarked]
    return _lines(rules, _said, max((end for end in ends if end <= _WIDE), default=0))


def _said(rule: nodes.Rule | nodes.Mark) -> list[str]:
    """A long conditional has a line for each arm, ``else`` below ``then``."""
    if isinstance(rule, nodes.Mark):
        name = "" if rule.name is None else f"{rule.name} = "
        return [f"{rule.kind} {name}({format_list(rule.arguments)})"]
    body, whole = rule.body, format_rule(rule.body)
    if not isinstance(body, nodes.IfRule) or body.otherwise is None or len(whole) <= WIDTH:
        return [whole]
    first, *others = _arms(body)
    below_then = len(f"if {format_condition(body.condition)} ")
    margin = " " * (below_then if len(others) == 1 and below_then <= _INDENTED else 2)
    return [first, *(margin + arm for arm in others)]


def _head(block: nodes.Figure | nodes.Function, head: str) -> list[str]:
    return [*(_comment(line.text) for line in block.above), *_commented([head], block.comment, 0)]


def _figure(figure: nodes.Figure) -> Iterator[str]:
    unit = "" if figure.unit is None else f" [{figure.unit}]"
    yield from _head(figure, f"figure {figure.name}{unit}")
    yield from _rules(figure.marks)


def _function(function: nodes.Function) -> Iterator[str]:
    results = f"; {', '.join(function.results)}" if function.results else ""
    head = f"function {function.name}({', '.join(function.arguments)}{results})"
    yield from _head(function, head)
    if function.parameters:
        line = f"parameters {', '.join(function.parameters)}"
        yield from _commented([line], function.parameters_comment, 0)
    yield "rules"
    yield from _rules(function.rules)


# --- tables in HTML ---

ROWS = 60
"""Rows of a table that are shown."""

_CELL = "padding:2px 10px;vertical-align:top;text-align:"


def html_table(
    heads: Sequence[str], rows: Iterable[Sequence[str]], numeric: Collection[int]
) -> str:
    """A table of texts; the columns ``numeric`` are aligned to the right."""
    styles = [_CELL + ("right" if at in numeric else "left") for at in range(len(heads))]

    def line(kind: str, texts: Sequence[str]) -> str:
        pairs = zip(texts, styles, strict=False)
        cells = (f'<{kind} style="{style}">{escape(text)}</{kind}>' for text, style in pairs)
        return f"<tr>{''.join(cells)}</tr>"

    body = "".join(line("td", row) for row in rows)
    whole = "border-collapse:collapse;font-variant-numeric:tabular-nums"
    return f'<table style="{whole}"><thead>{line("th", heads)}</thead><tbody>{body}</tbody></table>'


def more(count: int, noun: str = "rows") -> str:
    """A note on the rows that are not shown."""
    return f"<p>… {count - ROWS:,} more {noun}</p>" if count > ROWS else ""
