"""Text → RuleSheet: lines (layout), sections, and what each line says (grammar, builder)."""

from __future__ import annotations

from rulesheets.syntax import Source
from rulesheets.syntax.nodes import RuleSheet


def parse(source: Source) -> RuleSheet:
    """The rule sheet that a text says. Raises RuleSheetError with what is wrong, line by line."""
    from rulesheets.parse.sections import read  # with it comes lark

    return read(source)
