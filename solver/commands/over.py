"""``--over NAME=START:STOP:STEP``: the values of a swept input."""

from __future__ import annotations

import re
from fractions import Fraction
from typing import TYPE_CHECKING

from rulesheets.diagnosis import Diagnosis, Label, RuleSheetError, error
from solver.commands.option import Option

if TYPE_CHECKING:
    from collections.abc import Iterable

    from rulesheets.model import Model, Value
    from solver.commands.inputs import Request

LIMIT = 10_000_000
"""Rows that a sweep may have."""

_DECIMAL = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d{1,3})?", re.ASCII)


def read_over(texts: Iterable[str], model: Model) -> dict[str, list[float]]:
    """The values by name, in the order given. Raises RuleSheetError for what is no range of a variable."""
    from rulesheets.variables import variable_named

    columns: dict[str, list[float]] = {}
    rows = 1
    for text in texts:
        option = Option("over", text)
        name, _, stretch = (part.strip() for part in text.partition("="))
        parts = stretch.split(":")
        if not name or len(parts) != 3:
            raise RuleSheetError(_no_range(option))
        variable_named(name, model, option.place(name))
        if name in columns:
            raise RuleSheetError(option.repeated(name))
        start, stop, step = (_number(option, part.strip()) for part in parts)
        rows *= _count(option, start, stop, step)
        if rows > LIMIT:
            raise RuleSheetError(_too_many(option))
        columns[name] = stretched(start, stop, step)
    return columns


def read_states(
    texts: Iterable[str], request: Request
) -> tuple[dict[str, list[Value]], dict[str, list[float]]]:
    """What ``--over`` says of a drawing: lists of values (``branch=open,crossed``), and one range at most.

    Raises RuleSheetError for what is neither, for names that are given twice, and for a second range.
    """
    from rulesheets.variables import parse_value, variable_named

    texts = tuple(texts)
    ranges = [text for text in texts if ":" in text]
    if len(ranges) > 1:
        raise RuleSheetError(_second_range(Option("over", ranges[1])))
    columns = read_over(ranges, request.model)
    lists: dict[str, list[Value]] = {}
    for text in (text for text in texts if text not in ranges):
        option = Option("over", text)
        name, _, listed = (part.strip() for part in text.partition("="))
        if not name or not listed:
            raise RuleSheetError(_no_list(option))
        variable_named(name, request.model, option.place(name))
        if name in lists or name in columns:
            raise RuleSheetError(option.repeated(name))
        values = [part.strip() for part in listed.split(",")]
        lists[name] = [parse_value(value, option.place(value)) for value in values]
    twice = [name for name in (*lists, *columns) if request.inputs.get(name) is not None]
    if twice:
        raise RuleSheetError(*(Option("over", name).repeated(name) for name in twice))
    return lists, columns


def stretched(start: Fraction, stop: Fraction, step: Fraction) -> list[float]:
    """``start``, ``start + step``, … up to ``stop``, which is there where a step ends on it.

    Each value is the float nearest to the exact one: ``0:1:0.1`` has 0.3, not 0.30000000000000004.
    """
    return [float(start + k * step) for k in range(int((stop - start) / step) + 1)]


def _count(option: Option, start: Fraction, stop: Fraction, step: Fraction) -> int:
    if step == 0 or (stop - start) / step < 0:
        raise RuleSheetError(_no_step(option))
    return int((stop - start) / step) + 1


def _number(option: Option, text: str) -> Fraction:
    """The exact decimal, or the float that an expression of numbers comes to."""
    if _DECIMAL.fullmatch(text):
        return Fraction(text)
    from rulesheets.variables import parse_value

    value = parse_value(text, option.place(text))
    if isinstance(value, str):
        raise RuleSheetError(_no_range(option))
    return Fraction(value)


def _no_range(option: Option) -> Diagnosis:
    return error(
        "E424",
        "--over needs a name and a range of numbers",
        Label(option.place(option.text)),
        notes=("write --over NAME=START:STOP:STEP, such as --over thetaAO=0:360:5",),
    )


def _no_list(option: Option) -> Diagnosis:
    return error(
        "E424",
        "--over needs a name and values",
        Label(option.place(option.text)),
        notes=(
            "write --over branch=open,crossed for states side by side, --over thetaAO=0:360:5 for a film",
        ),
    )


def _second_range(option: Option) -> Diagnosis:
    return error(
        "E424",
        "a film runs over one range",
        Label(option.place(option.text)),
        notes=("list the values of the other variable: they stand side by side",),
    )


def _no_step(option: Option) -> Diagnosis:
    return error(
        "E424",
        "this step never leads from the start to the stop",
        Label(option.place(option.text.rpartition(":")[2])),
        notes=("the step is not 0, and negative where the stop is below the start",),
    )


def _too_many(option: Option) -> Diagnosis:
    return error(
        "E424",
        f"this sweep has more than {LIMIT:,} rows",
        Label(option.place(option.text)),
        notes=("take a larger step",),
    )
