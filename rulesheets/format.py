"""Sheet → text: the canonical print, which ``parse`` reads back as the same sheet."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from typing import Any

from rulesheets.syntax.nodes import (
    And,
    Call,
    CallRule,
    CommentLine,
    Comparison,
    Condition,
    Equality,
    Expression,
    Figure,
    Function,
    Given,
    IfRule,
    Inequality,
    Mark,
    Name,
    Negative,
    Not,
    Number,
    Or,
    Power,
    Product,
    Quotient,
    Range,
    Rule,
    RuleBody,
    RuleSheet,
    Sum,
    Symbol,
    Tolerance,
    UnitRow,
    Use,
    VariableRow,
)

_SUM, _PRODUCT, _FACTOR, _ATOM = range(4)
"""How tightly an expression binds: where one stands that binds less, it goes in parentheses."""

_OR, _AND, _NOT = range(3)
"""The same for conditions."""


def format_number(value: float) -> str:
    """The shortest text that reads back as the same float: ``3``, ``0.1``, ``1e-5``, ``1e22``."""
    digits, mark, exponent = repr(value).partition("e")
    return digits.removesuffix(".0") + (f"e{int(exponent)}" if mark else "")


DIGITS = 10
"""Significant digits that a person reads: all that a sheet is judged by, none of the rounding noise."""


def readable(value: float | str | None) -> str:
    """A value for the variable sheet: ``'open``, ``-41.46077186``, blank where there is none."""
    if value is None:
        return ""
    if isinstance(value, str):
        return f"'{value}"
    return f"{value + 0.0:.{DIGITS}g}"


def exact(value: float | str | None) -> str:
    """A value for a file, blank for None and NaN: reading it back gives the same float."""
    if value is None or value != value:
        return ""
    return f"'{value}" if isinstance(value, str) else repr(float(value) + 0.0).removesuffix(".0")


def format_expression(node: Expression) -> str:
    """An expression on one line: sums are spaced, products and powers are not."""
    return _expression(node, _SUM)


def format_condition(node: Condition) -> str:
    """A condition on one line, with infix ``and`` and ``or``."""
    return _condition(node, _OR)


def _expression(node: Expression, place: int) -> str:
    text, binds = _bound(node)
    return text if binds >= place else f"({text})"


def _bound(node: Expression) -> tuple[str, int]:
    """The text of a node without parentheses around it, and how tightly it binds."""
    match node:
        case Number(value, unit=unit):
            text = format_number(value) + ("" if unit is None else f"[{unit}]")
            return text, _ATOM if value >= 0 else _FACTOR
        case Name(name):
            return name, _ATOM
        case Symbol(name):
            return f"'{name}", _ATOM
        case Call("pi", ()):
            return "pi", _ATOM
        case Call(function, arguments):
            return f"{function}({format_list(arguments)})", _ATOM
        case Power(base, exponent):
            return f"{_expression(base, _ATOM)}^{_expression(exponent, _FACTOR)}", _FACTOR
        case Negative(operand):
            return f"-{_expression(operand, _FACTOR)}", _FACTOR
        case Product() | Quotient():
            return _chain(node), _PRODUCT
        case Sum(terms):
            first, *others = terms
            return _expression(first, _PRODUCT) + "".join(map(_added, others)), _SUM


def _chain(node: Expression) -> str:
    """``a*b/c``, by a loop: such a chain may be longer than recursion reaches."""
    parts = []
    while isinstance(node, Product | Quotient):
        sign = "*" if isinstance(node, Product) else "/"
        parts.append(sign + _expression(node.right, _FACTOR))
        node = node.left
    return _expression(node, _PRODUCT) + "".join(reversed(parts))


def _added(term: Expression) -> str:
    if isinstance(term, Negative):
        return f" - {_expression(term.operand, _PRODUCT)}"
    return f" + {_expression(term, _PRODUCT)}"


def format_list(expressions: tuple[Expression, ...]) -> str:
    """``a, b, c``."""
    return ", ".join(map(format_expression, expressions))


def _condition(node: Condition, place: int) -> str:
    match node:
        case Comparison(operator, left, right):
            return f"{format_expression(left)} {operator} {format_expression(right)}"
        case Given(name):
            return f"given('{name})"
        case Not(Comparison() as comparison):
            return f"not ({_condition(comparison, _OR)})"
        case Not(term):
            return f"not {_condition(term, _NOT)}"
        case And(terms):
            text, binds = " and ".join(_condition(term, _NOT) for term in terms), _AND
        case Or(terms):
            text, binds = " or ".join(_condition(term, _AND) for term in terms), _OR
    return text if binds >= place else f"({text})"


WIDTH = 80
"""Characters beyond which a conditional with ``else`` is broken into lines."""

_INDENTED = 32
"""Where ``then`` stands further to the right than this, ``else`` is not put below it."""


def format_rule(body: RuleBody) -> str:
    """The rule on one line."""
    match body:
        case Equality(left, right):
            return f"{_side(left)} = {_side(right)}"
        case Inequality(comparisons):
            first, *others = map(format_condition, comparisons)
            starts = (len(format_expression(comparison.left)) for comparison in comparisons[1:])
            return first + "".join(text[start:] for text, start in zip(others, starts, strict=True))
        case CallRule(function, arguments, results):
            shown = f"; {format_list(results)}" if results else ""
            return f"call {function}({format_list(arguments)}{shown})"
        case IfRule():
            return " ".join(_arms(body))


def rule_lines(body: RuleBody) -> list[str]:
    """The rule as lines: one, or for a long conditional one for each arm, ``else`` below ``then``."""
    whole = format_rule(body)
    if not isinstance(body, IfRule) or body.otherwise is None or len(whole) <= WIDTH:
        return [whole]
    first, *others = _arms(body)
    below_then = len(f"if {format_condition(body.condition)} ")
    margin = " " * (below_then if len(others) == 1 and below_then <= _INDENTED else 2)
    return [first, *(margin + arm for arm in others)]


def _arms(rule: IfRule) -> list[str]:
    """``if … then …``, ``else if … then …``, ``else …``."""
    arms = []
    word = "if"
    rest: RuleBody | None = rule
    while isinstance(rest, IfRule):
        arms.append(f"{word} {format_condition(rest.condition)} then {_then(rest.then)}")
        word, rest = "else if", rest.otherwise
    if rest is not None:
        arms.append(f"else {format_rule(rest)}")
    return arms


def _then(body: RuleBody) -> str:
    """A conditional after ``then`` goes in parentheses, so that an ``else`` cannot be taken for its own."""
    return f"({format_rule(body)})" if isinstance(body, IfRule) else format_rule(body)


def _side(expressions: tuple[Expression, ...]) -> str:
    text = format_list(expressions)
    return f"({text})" if len(expressions) > 1 else format_expression(expressions[0])


_INDENT = "  "
_WIDE = 60
"""Code wider than this does not push the comments of the lines around it to the right."""


def format_sheet(sheet: RuleSheet) -> str:
    """The canonical text of a sheet, with a line end after the last line (an empty sheet is empty).

    Comments and single blank lines inside sections are kept.
    """
    sections = [
        [*_top(sheet)],
        ["units", *_units(sheet.units)] if sheet.units else [],
        [] if sheet.variables is None else ["variables", *_variables(sheet.variables)],
        ["rules", *_rules(sheet.rules)] if sheet.rules else [],
        *(list(_figure(figure)) for figure in sheet.figures),
        *(list(_function(function)) for function in sheet.functions),
    ]
    return "\n\n".join("\n".join(lines) for lines in sections if lines) + ("\n" if any(sections) else "")


def _top(sheet: RuleSheet) -> Iterator[str]:
    for index, line in enumerate(sheet.comments):
        if line.gap and index:
            yield ""
        yield _comment(line.text)
    yield from map(_use, sheet.uses)


def _comment(text: str) -> str:
    return f'" {text}'.rstrip()


def _use(use: Use) -> str:
    paths = ", ".join(f'"{path}"' for path in use.paths)
    word = "use python" if use.python else "use"
    return _commented([f"{word} {paths}"], use.comment, 0)[0]


def _commented(lines: list[str], comment: str, column: int) -> list[str]:
    """The lines with a comment after the last, two blanks off or in the given column."""
    if not comment:
        return lines
    *others, last = lines
    return [*others, f"{last.ljust(column)}  {_comment(comment)}"]


# --- units and variables --------------------------------------------------------


def _lines(rows: Iterable[Any], texts: Iterable[list[str]], column: int) -> Iterator[str]:
    """Rows with their texts, comments in a column; comment lines, and single blank lines, between them."""
    shown = iter(texts)
    for index, row in enumerate(rows):
        if row.gap and index:
            yield ""
        if isinstance(row, CommentLine):
            yield _INDENT + _comment(row.text)
        else:
            yield from _commented([_INDENT + line for line in next(shown)], row.comment, column)


def _units(rows: Sequence[UnitRow | CommentLine]) -> Iterator[str]:
    units = (row for row in rows if isinstance(row, UnitRow))
    yield from _lines(rows, ([" = ".join(filter(None, (", ".join(u.names), u.meaning)))] for u in units), 0)


def _variables(rows: Sequence[VariableRow | CommentLine]) -> Iterator[str]:
    cells = [_cells(row) for row in rows if isinstance(row, VariableRow)]
    widths = [max(map(len, column)) for column in zip(*cells, strict=True)]
    texts = (
        [" ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True) if width).rstrip()]
        for row in cells
    )
    yield from _lines(rows, texts, _row_width(widths))


def _row_width(widths: Sequence[int]) -> int:
    present = [width for width in widths if width]
    return len(_INDENT) + sum(present) + len(present) - 1


def _cells(row: VariableRow) -> tuple[str, str, str, str]:
    """Name, value or guess, range, unit."""
    value = ""
    if row.value is not None:
        value = f"= {format_expression(row.value)}{_tolerance(row.tolerance)}"
    elif row.guess is not None:
        value = f"~ {format_expression(row.guess)}"
    return row.name, value, _range(row.range), _unit(row.unit, row.display_unit)


def _tolerance(tolerance: Tolerance | None) -> str:
    if tolerance is None:
        return ""
    return f" ± {format_expression(tolerance.size)}{'%' if tolerance.percent else ''}"


def _unit(unit: str | None, display: str | None) -> str:
    if display is not None:
        return f"[{unit or ''} -> {display}]".replace("[ ", "[")
    return "" if unit is None else f"[{unit}]"


def _range(limits: Range | None) -> str:
    if limits is None:
        return ""
    low, high = _end(limits.low, limits.lower), _end(limits.high, limits.upper)
    if low and high and not (limits.low_open or limits.high_open):
        return f"in [{low}, {high}]"
    lower = low and f">{'' if limits.low_open else '='} {low}"
    upper = high and f"<{'' if limits.high_open else '='} {high}"
    return ", ".join(filter(None, (lower, upper)))


def _end(number: float, expression: Expression | None) -> str:
    """An end of a range, empty where there is none."""
    if expression is not None:
        return format_expression(expression)
    return format_number(number) if math.isfinite(number) else ""


# --- rules and functions --------------------------------------------------------


def _rules(rules: Sequence[Rule | Mark | CommentLine]) -> Iterator[str]:
    said = [rule for rule in rules if not isinstance(rule, CommentLine)]
    texts = [[_mark(rule)] if isinstance(rule, Mark) else rule_lines(rule.body) for rule in said]
    pairs = zip(said, texts, strict=True)
    ends = [len(_INDENT) + len(text[-1]) for rule, text in pairs if rule.comment]
    yield from _lines(rules, texts, max((end for end in ends if end <= _WIDE), default=0))


def _mark(mark: Mark) -> str:
    name = "" if mark.name is None else f"{mark.name} = "
    return f"{mark.kind} {name}({format_list(mark.arguments)})"


def _figure(figure: Figure) -> Iterator[str]:
    for line in figure.above:
        yield _comment(line.text)
    unit = "" if figure.unit is None else f" [{figure.unit}]"
    yield from _commented([f"figure {figure.name}{unit}"], figure.comment, 0)
    yield from _rules(figure.marks)


def _function(function: Function) -> Iterator[str]:
    results = f"; {', '.join(function.results)}" if function.results else ""
    head = f"function {function.name}({', '.join(function.arguments)}{results})"
    for line in function.above:
        yield _comment(line.text)
    yield from _commented([head], function.comment, 0)
    if function.parameters:
        yield from _commented(
            [f"parameters {', '.join(function.parameters)}"], function.parameters_comment, 0
        )
    yield "rules"
    yield from _rules(function.rules)
