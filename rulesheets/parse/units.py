"""A line of the units section: ``smoot, smoots = 1.7018 m``."""

from __future__ import annotations

import re

from rulesheets.diagnosis import Label, RuleSheetError, error
from rulesheets.syntax.nodes import UnitRow
from rulesheets.syntax.source import Span

_NAME = re.compile(r"(?:[^\W\d_]|[°%‰$€£¥℃℉])(?:[\w°%]*[^\W\d])?")


def unit_row(code: str, span: Span) -> UnitRow:
    """The row of a line. Raises RuleSheetError (E128) for one that defines no unit."""
    left, equals, right = code.partition("=")
    names = tuple(map(str.strip, left.split(",")))
    if not all(map(_NAME.fullmatch, names)) or bool(equals) is not bool(right.strip()):
        notes = ("write smoot = 1.7018 m, or widget alone for a unit of a kind of its own",)
        raise RuleSheetError(error("E128", "this line defines no unit", Label(span), notes=notes))
    return UnitRow(names, " ".join(right.split()), span=span)
