"""What a range of a row may be: its ends, read together."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

from rulesheets.diagnosis import Diagnosis, RuleSheetError, said
from rulesheets.evaluate import Undefined, value
from rulesheets.syntax import Span
from rulesheets.syntax.nodes import Expression, Range, measured, names, units_of


class Bound(NamedTuple):
    """``< 5`` and the like, beside a name in the variables section; ``limit`` may name variables."""

    operator: str
    limit: float | Expression
    span: Span


def limit(expression: Expression) -> float | Expression:
    """The value of an expression of numbers; ``3[in]`` and one that names variables as it is."""
    if measured(expression) is not None:
        return expression
    if (unit := next(units_of(expression), None)) is not None:
        reason = f"a bound is one number with its unit, and {unit} stands in an expression"
        raise RuleSheetError(_wrong(reason, expression.span))
    if any(names(expression)):
        return expression
    try:
        return value(expression, {})
    except Undefined as undefined:
        reason = f"this bound has no value: {undefined}"
    except KeyError as unknown:
        reason = f"a bound is a number: there is no function {unknown.args[0]}"
    raise RuleSheetError(_wrong(reason, expression.span))


def bounded(bounds: Sequence[Bound]) -> Range | None:
    """All bounds of a row together; None where there are none."""
    if not bounds:
        return None
    found = Range()
    for bound in bounds:
        found = _narrowed(found, bound)
    span = Span(bounds[0].span.source, bounds[0].span.start, bounds[-1].span.end)
    if found.low > found.high or (found.low == found.high and (found.low_open or found.high_open)):
        raise RuleSheetError(empty_range(span))
    return replace(found, span=span)


def _narrowed(limits: Range, bound: Bound) -> Range:
    """The range with one of its ends, which must not be there yet."""
    if bound.operator == "<>":
        raise RuleSheetError(_wrong("<> is no bound", bound.span))
    is_lower, is_open = bound.operator[0] == ">", len(bound.operator) == 1
    number, expression = (bound.limit, None) if isinstance(bound.limit, float) else (None, bound.limit)
    present = (limits.low, limits.lower) if is_lower else (limits.high, limits.upper)
    if present != ((-math.inf if is_lower else math.inf), None):
        raise RuleSheetError(_wrong("this end of the range is already set", bound.span))
    if is_lower:
        low = limits.low if number is None else number
        return replace(limits, low=low, lower=expression, low_open=is_open)
    high = limits.high if number is None else number
    return replace(limits, high=high, upper=expression, high_open=is_open)


def empty_range(span: Span | None) -> Diagnosis:
    return _wrong("this range is empty: its lower end is not below its upper end", span)


def _wrong(message: str, span: Span | None) -> Diagnosis:
    return said("E121", message, span, "write a range as in [0, 5], or as > 0, < 5")
