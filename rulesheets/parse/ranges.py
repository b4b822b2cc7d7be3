"""Bounds and intervals of the variables section as one range."""

from __future__ import annotations

import math
from collections.abc import Sequence

from rulesheets.diagnosis import Diagnosis, Label, RuleSheetError, error
from rulesheets.evaluate import Undefined, value
from rulesheets.nodes import Expression, Range, names
from rulesheets.record import dataclass
from rulesheets.source import Span


@dataclass(frozen=True, slots=True)
class Bound:
    """``< 5`` and the like, beside a name in the variables section."""

    operator: str
    limit: float
    span: Span


def constant(expression: Expression) -> float:
    """The value of an expression of numbers."""
    try:
        if not any(names(expression)):
            return value(expression, {})
        reason = "a bound is a number, not a variable"
    except Undefined as undefined:
        reason = f"this bound has no value: {undefined}"
    except KeyError as unknown:
        reason = f"a bound is a number: there is no function {unknown.args[0]}"
    raise RuleSheetError(_wrong(reason, expression.span))


def bounded(marks: Sequence[Bound | Range]) -> Range | None:
    """All bounds of a row together; None where there are none."""
    if not marks:
        return None
    low, high, low_open, high_open = -math.inf, math.inf, False, False
    for mark in marks:
        if isinstance(mark, Range):
            low, high = _once(low, -math.inf, mark.low, mark), _once(high, math.inf, mark.high, mark)
        elif mark.operator in (">", ">="):
            low, low_open = _once(low, -math.inf, mark.limit, mark), mark.operator == ">"
        elif mark.operator in ("<", "<="):
            high, high_open = _once(high, math.inf, mark.limit, mark), mark.operator == "<"
        else:
            raise RuleSheetError(_wrong("<> is no bound", mark.span))
    span = Span(marks[0].span.source, marks[0].span.start, marks[-1].span.end)  # type: ignore[union-attr]
    if low > high or (low == high and (low_open or high_open)):
        raise RuleSheetError(_wrong("this range is empty: its lower end is not below its upper end", span))
    return Range(low, high, low_open, high_open, span)


def _once(present: float, default: float, limit: float, mark: Bound | Range) -> float:
    if present != default:
        raise RuleSheetError(_wrong("this end of the range is already set", mark.span))
    return limit


def _wrong(message: str, span: Span | None) -> Diagnosis:
    labels = (Label(span),) if span else ()
    return error("E121", message, *labels, notes=("write a range as in [0, 5], or as > 0, < 5",))
