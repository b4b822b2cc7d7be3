"""Sheet → text: the canonical print, which ``parse`` reads back as the same sheet."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import Any

from rulesheets.syntax import nodes

_OR, _AND, _COMPARISON, _NOT, _SUM, _PRODUCT, _FACTOR, _ATOM = range(8)
"""How tightly a node binds: where one stands that binds less, it goes in parentheses."""


def format_number(value: float) -> str:
    """The shortest text that reads back as the same float: ``3``, ``0.1``, ``1e-5``, ``1e22``."""
    digits, mark, exponent = repr(value).partition("e")
    return digits.removesuffix(".0") + (f"e{int(exponent)}" if mark else "")


def format_expression(node: nodes.Expression) -> str:
    """An expression on one line: sums are spaced, products and powers are not."""
    return _within(_SUM, node)


def format_condition(node: nodes.Condition) -> str:
    """A condition on one line, with infix ``and`` and ``or``."""
    return _within(_OR, node)


def _within(place: int, node: nodes.Expression | nodes.Condition) -> str:
    text, binds = _bound(node)
    return text if binds >= place else f"({text})"


def _bound(node: nodes.Expression | nodes.Condition) -> tuple[str, int]:
    """The text of a node without parentheses around it, and how tightly it binds."""
    match node:
        case nodes.Number(value, unit=unit):
            text = format_number(value) + ("" if unit is None else f"[{unit}]")
            return text, _ATOM if value >= 0 else _FACTOR
        case nodes.Name(name):
            return name, _ATOM
        case nodes.Symbol(name):
            return f"'{name}", _ATOM
        case nodes.Call("pi", ()):
            return "pi", _ATOM
        case nodes.Call(function, arguments):
            return f"{function}({format_list(arguments)})", _ATOM
        case nodes.Power(base, exponent):
            return f"{_within(_ATOM, base)}^{_within(_FACTOR, exponent)}", _FACTOR
        case nodes.Negative(operand):
            return f"-{_within(_FACTOR, operand)}", _FACTOR
        case nodes.Product() | nodes.Quotient():
            return _chain(node), _PRODUCT
        case nodes.Sum(terms):
            first, *others = terms
            return _within(_PRODUCT, first) + "".join(map(_added, others)), _SUM
        case nodes.Comparison(operator, left, right):
            return f"{format_expression(left)} {operator} {format_expression(right)}", _COMPARISON
        case nodes.Given(name):
            return f"given('{name})", _ATOM
        case nodes.Not(term):
            return f"not {_within(_NOT, term)}", _NOT
        case nodes.And(terms):
            return " and ".join(_within(_COMPARISON, term) for term in terms), _AND
        case nodes.Or(terms):
            return " or ".join(_within(_AND, term) for term in terms), _OR


def _chain(node: nodes.Expression) -> str:
    """``a*b/c``, by a loop: such a chain may be longer than recursion reaches."""
    parts = []
    while isinstance(node, nodes.Product | nodes.Quotient):
        sign = "*" if isinstance(node, nodes.Product) else "/"
        parts.append(sign + _within(_FACTOR, node.right))
        node = node.left
    return _within(_PRODUCT, node) + "".join(reversed(parts))


def _added(term: nodes.Expression) -> str:
    if isinstance(term, nodes.Negative):
        return f" - {_within(_PRODUCT, term.operand)}"
    if isinstance(term, nodes.Number) and term.value < 0:
        return f" - {_within(_PRODUCT, nodes.Number(-term.value, unit=term.unit))}"
    return f" + {_within(_PRODUCT, term)}"


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


def rule_lines(body: nodes.RuleBody) -> list[str]:
    """The rule as lines: one, or for a long conditional one for each arm, ``else`` below ``then``."""
    whole = format_rule(body)
    if not isinstance(body, nodes.IfRule) or body.otherwise is None or len(whole) <= WIDTH:
        return [whole]
    first, *others = _arms(body)
    below_then = len(f"if {format_condition(body.condition)} ")
    margin = " " * (below_then if len(others) == 1 and below_then <= _INDENTED else 2)
    return [first, *(margin + arm for arm in others)]


def _arms(rule: nodes.IfRule) -> list[str]:
    """``if … then …``, ``else if … then …``, ``else …``. A conditional after ``then`` goes in parentheses, so
    that an ``else`` cannot be taken for its own."""
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
    return "\n\n".join("\n".join(lines) for lines in sections if lines) + ("\n" if any(sections) else "")


def _comment(text: str) -> str:
    return f'" {text}'.rstrip()


def _commented(lines: list[str], comment: str, column: int) -> list[str]:
    """The lines with a comment after the last, two blanks off or in the given column."""
    if not comment:
        return lines
    *others, last = lines
    return [*others, f"{last.ljust(column)}  {_comment(comment)}"]


# --- units and variables --------------------------------------------------------


def _lines(rows: Iterable[Any], written: Callable[[Any], list[str]], column: int) -> Iterator[str]:
    """Rows as they are written, comments in a column; comment lines, and single blank lines, between them."""
    for index, row in enumerate(rows):
        if row.gap and index:
            yield ""
        if isinstance(row, nodes.CommentLine):
            yield _INDENT + _comment(row.text)
        else:
            yield from _commented([_INDENT + line for line in written(row)], row.comment, column)


def _units(rows: Sequence[nodes.UnitRow | nodes.CommentLine]) -> Iterator[str]:
    return _lines(rows, lambda row: [" = ".join(filter(None, (", ".join(row.names), row.meaning)))], 0)


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
            value += f" ± {format_expression(row.tolerance.size)}{'%' if row.tolerance.percent else ''}"
    elif row.guess is not None:
        value = f"~ {format_expression(row.guess)}"
    if row.display_unit is not None:
        unit = f"[{row.unit} -> {row.display_unit}]" if row.unit else f"[-> {row.display_unit}]"
    elif row.unit is not None:
        unit = f"[{row.unit}]"
    return row.name, value, _range(row.range), unit


def _range(limits: nodes.Range | None) -> str:
    if limits is None:
        return ""
    low, high = (end and format_expression(end) for end in (limits.lower, limits.upper))
    if low and high and not (limits.low_open or limits.high_open):
        return f"in [{low}, {high}]"
    lower = low and f">{'' if limits.low_open else '='} {low}"
    upper = high and f"<{'' if limits.high_open else '='} {high}"
    return ", ".join(filter(None, (lower, upper)))


# --- rules and functions --------------------------------------------------------


def _rules(rules: Sequence[nodes.Rule | nodes.Mark | nodes.CommentLine]) -> Iterator[str]:
    remarked = (rule for rule in rules if not isinstance(rule, nodes.CommentLine) and rule.comment)
    ends = [len(_INDENT) + len(_said(rule)[-1]) for rule in remarked]
    return _lines(rules, _said, max((end for end in ends if end <= _WIDE), default=0))


def _said(rule: nodes.Rule | nodes.Mark) -> list[str]:
    if isinstance(rule, nodes.Rule):
        return rule_lines(rule.body)
    name = "" if rule.name is None else f"{rule.name} = "
    return [f"{rule.kind} {name}({format_list(rule.arguments)})"]


def _head(block: nodes.Figure | nodes.Function, head: str) -> list[str]:
    return [*(_comment(line.text) for line in block.above), *_commented([head], block.comment, 0)]


def _figure(figure: nodes.Figure) -> Iterator[str]:
    unit = "" if figure.unit is None else f" [{figure.unit}]"
    yield from _head(figure, f"figure {figure.name}{unit}")
    yield from _rules(figure.marks)


def _function(function: nodes.Function) -> Iterator[str]:
    results = f"; {', '.join(function.results)}" if function.results else ""
    yield from _head(function, f"function {function.name}({', '.join(function.arguments)}{results})")
    if function.parameters:
        line = f"parameters {', '.join(function.parameters)}"
        yield from _commented([line], function.parameters_comment, 0)
    yield "rules"
    yield from _rules(function.rules)
