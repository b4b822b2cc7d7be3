"""A whole sheet as text: use, variables in columns, rules, figures, functions."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence

from rulesheets.format.text import format_expression, format_list, format_number, rule_lines
from rulesheets.syntax.nodes import (
    CommentLine,
    Expression,
    Figure,
    Function,
    Mark,
    Range,
    Rule,
    RuleSheet,
    Tolerance,
    UnitRow,
    Use,
    VariableRow,
)

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


def _units(rows: Sequence[UnitRow | CommentLine]) -> Iterator[str]:
    for index, row in enumerate(rows):
        if row.gap and index:
            yield ""
        if isinstance(row, CommentLine):
            yield _INDENT + _comment(row.text)
        else:
            meaning = f" = {row.meaning}" if row.meaning else ""
            yield from _commented([f"{_INDENT}{', '.join(row.names)}{meaning}"], row.comment, 0)


def _variables(rows: Sequence[VariableRow | CommentLine]) -> Iterator[str]:
    cells = [_cells(row) for row in rows if isinstance(row, VariableRow)]
    widths = [max(map(len, column)) for column in zip(*cells, strict=True)]
    shown = iter(cells)
    for index, row in enumerate(rows):
        if row.gap and index:
            yield ""
        if isinstance(row, CommentLine):
            yield _INDENT + _comment(row.text)
        else:
            parts = [cell.ljust(width) for cell, width in zip(next(shown), widths, strict=True) if width]
            yield from _commented([_INDENT + " ".join(parts).rstrip()], row.comment, _row_width(widths))


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


def _rules(rules: Iterable[Rule | Mark | CommentLine]) -> Iterator[str]:
    lines = [(rule, _rule(rule)) for rule in rules]
    ends = [len(text[-1]) for rule, text in lines if not isinstance(rule, CommentLine) and rule.comment]
    column = max((end for end in ends if end <= _WIDE), default=0)
    for index, (rule, text) in enumerate(lines):
        if rule.gap and index:
            yield ""
        yield from text if isinstance(rule, CommentLine) else _commented(text, rule.comment, column)


def _rule(rule: Rule | Mark | CommentLine) -> list[str]:
    if isinstance(rule, CommentLine):
        lines = [_comment(rule.text)]
    else:
        lines = [_mark(rule)] if isinstance(rule, Mark) else rule_lines(rule.body)
    return [_INDENT + line for line in lines]


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
