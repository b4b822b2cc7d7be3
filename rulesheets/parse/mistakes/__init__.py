"""What is wrong with a line: from the place where reading stops to a diagnosis that helps."""

from rulesheets.parse.mistakes.figure import empty_figure, explain_mark, wrong_mark
from rulesheets.parse.mistakes.foreign import (
    DEEPEST,
    explain_head,
    function_without_rules,
    no_rule,
    not_there_yet,
    second_rules,
    strange_characters,
    stray_parameters,
    too_deep,
    unknown_section,
    wrong_shape,
)
from rulesheets.parse.mistakes.operand import Stop
from rulesheets.parse.mistakes.row import explain_row
from rulesheets.parse.mistakes.rule import explain_rule, without_variable

__all__ = [
    "DEEPEST",
    "Stop",
    "empty_figure",
    "explain_head",
    "explain_mark",
    "explain_row",
    "explain_rule",
    "function_without_rules",
    "no_rule",
    "not_there_yet",
    "second_rules",
    "strange_characters",
    "stray_parameters",
    "too_deep",
    "unknown_section",
    "without_variable",
    "wrong_mark",
    "wrong_shape",
]
