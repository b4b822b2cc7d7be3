"""``--approach NAME=LIMIT:FIRST..LAST``: values of an input ever nearer to a limit."""

from __future__ import annotations

import math
import re

from rulesheets.diagnosis import Diagnosis, Label, RuleSheetError, error
from rulesheets.model import Model
from rulesheets.variables import parse_value, variable_named
from solver.commands.option import Option

A_DECADE = 2
"""Points a decade."""

_NUMBER = r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?"
_FORM = re.compile(rf"\s*([^=]+?)\s*=\s*(.+?)\s*:\s*({_NUMBER})\s*\.\.\s*({_NUMBER})\s*")


def read_approach(text: str, model: Model) -> tuple[str, list[float], list[float]]:
    """The input, its values, and their distances from the limit, the farthest first.

    Distances are relative to the limit (absolute where that is 0), and counted towards 0; negative ones
    lie beyond. Raises RuleSheetError for what is none of this.
    """
    option = Option("approach", text)
    form = _FORM.fullmatch(text)
    if form is None:
        raise RuleSheetError(_unread(option))
    name, limit_text, first_text, last_text = form.groups()
    variable_named(name, model, option.place(name))
    limit = parse_value(limit_text, option.place(limit_text))
    first, last = float(first_text), float(last_text)
    if isinstance(limit, str) or not first * last > 0 or not math.isfinite(first * last):
        raise RuleSheetError(_unread(option))
    decades = math.log10(last / first)
    count = round(abs(decades) * A_DECADE) + 1
    if count > 100 * A_DECADE:
        raise RuleSheetError(_unread(option))
    distances = [first * 10.0 ** (decades * k / max(count - 1, 1)) for k in range(count)]
    numbers = [limit * (1.0 - d) if limit else d for d in distances]
    found = {number: abs(d) for number, d in zip(numbers, distances, strict=True) if number != limit}
    return name, list(found), list(found.values())


def _unread(option: Option) -> Diagnosis:
    return error(
        "E424",
        "--approach needs a name, a limit, and the relative distances of the first and the last value",
        Label(option.place(option.text)),
        notes=("write --approach NAME=LIMIT:1e-1..1e-15, with the limit as a number",),
    )
