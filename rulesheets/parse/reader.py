"""One logical line → what it says, or a diagnosis of what is wrong with it."""

from __future__ import annotations

from typing import Any

from rulesheets.diagnosis import Diagnosis, RuleSheetError
from rulesheets.parse import mistakes
from rulesheets.parse.grammar import Unparsed, grammar
from rulesheets.parse.layout import Line
from rulesheets.syntax.nodes import Equality, Inequality
from rulesheets.syntax.source import Source


def read_line(source: Source, line: Line, kind: str) -> Any:
    """The node of a line of this kind, a start rule of the grammar.

    Raises RuleSheetError with what is wrong. The shape of the line has been found right before.
    """
    if strange := tuple(mistakes.strange_characters(source, line)):
        raise RuleSheetError(*strange)
    try:
        node = grammar().read(source, line, kind)
    except Unparsed as stop:
        raise RuleSheetError(_explain(source, line, kind, stop.place)) from None
    wrong = _sense(node, line, kind)
    if wrong is not None:
        raise RuleSheetError(wrong)
    return node


def _explain(source: Source, line: Line, kind: str, place: int) -> Diagnosis:
    words = grammar().words(line, kind)
    index = next((i for i, word in enumerate(words) if word.end_pos > place), len(words))
    stop = mistakes.Stop(source, line, words, index)
    match kind:
        case "rule":
            return mistakes.explain_rule(stop)
        case "row":
            return mistakes.explain_row(stop)
        case "mark":
            return mistakes.explain_mark(stop)
        case _:
            return mistakes.explain_head(stop, kind)


def _sense(node: Any, line: Line, kind: str) -> Diagnosis | None:
    """What is wrong with a rule that the grammar accepts.

    A tree has no more levels than its text has characters, so short lines need no measuring.
    """
    if kind == "rule" and line.end - line.start > mistakes.DEEPEST:
        deep = mistakes.too_deep(node)
        if deep is not None:
            return deep
    if kind == "row" and node.value is not None and line.end - line.start > mistakes.DEEPEST:
        sides = (node.value, *(() if node.tolerance is None else (node.tolerance.size,)))
        return next(filter(None, map(mistakes.too_deep, sides)), None)
    if kind == "mark" and line.end - line.start > mistakes.DEEPEST:
        return next(filter(None, map(mistakes.too_deep, node.arguments)), mistakes.wrong_mark(node))
    if kind == "mark":
        return mistakes.wrong_mark(node)
    return mistakes.without_variable(node) if isinstance(node, Equality | Inequality) else None
