"""Text → RuleSheet: logical lines (layout), sections, and the content of each line (grammar)."""

from __future__ import annotations

from rulesheets.syntax import Source
from rulesheets.syntax.nodes import RuleSheet


def parse(source: Source) -> RuleSheet:
    """The rule sheet of a text. Raises RuleSheetError with the mistakes, line by line."""
    from rulesheets.parse.sections import read  # with it comes lark

    return read(source)
