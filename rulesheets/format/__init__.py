"""RuleSheet → text: the canonical print, which ``parse`` reads back as the same sheet."""

from rulesheets.format.sheet import format_sheet
from rulesheets.format.text import format_condition, format_expression, format_number, format_rule

__all__ = ["format_condition", "format_expression", "format_number", "format_rule", "format_sheet"]
