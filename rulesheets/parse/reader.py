"""One logical line → what it says, or a diagnosis of what is wrong with it."""

from __future__ import annotations

from typing import Any

from rulesheets.diagnosis import RuleSheetError
from rulesheets.parse import mistakes
from rulesheets.parse.grammar import Unparsed, grammar
from rulesheets.parse.layout import Line
from rulesheets.source import Source


def read_line(source: Source, line: Line, kind: str) -> Any:
    """The node of a ``rule``, ``row``, ``use``, ``head`` or ``parameters`` line.

    Raises RuleSheetError.
    """
    wrong = mistakes.before_reading(source, line)
    if wrong:
        raise RuleSheetError(*wrong)
    try:
        node = grammar().read(source, line, kind)
    except Unparsed as stop:
        raise RuleSheetError(mistakes.explain(source, line, kind, stop.place)) from None
    return node
