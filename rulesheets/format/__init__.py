"""RuleSheet → text: the canonical print, which ``parse`` reads back as the same sheet."""

from rulesheets.format.expressions import format_condition, format_expression, format_number
from rulesheets.format.rules import format_rule
from rulesheets.format.sheet import format_sheet

__all__ = ["format_condition", "format_expression", "format_number", "format_rule", "format_sheet"]
