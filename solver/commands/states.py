"""``--over`` of a drawing: states side by side, and a motion."""

from __future__ import annotations

from collections.abc import Iterable

from rulesheets.diagnosis import Diagnosis, Label, RuleSheetError, error
from rulesheets.model import Value
from solver.commands.inputs import Request
from solver.commands.option import Option
from solver.commands.over import read_axes

FRAMES = 100_000
"""Values that a range may have: a film of an hour and a half."""


def read_states(
    texts: Iterable[str], request: Request
) -> tuple[dict[str, list[Value]], dict[str, list[float]]]:
    """What ``--over`` says of a drawing: lists of values (``branch=open,crossed``), and one range at most.

    Raises RuleSheetError for what is neither, for names that are given twice, and for a second range.
    """
    texts = tuple(texts)
    ranges = [text for text in texts if ":" in text]
    if len(ranges) > 1:
        raise RuleSheetError(_second_range(Option("over", ranges[1])))
    axes = read_axes(texts, request.model)
    request.swept(axes)
    moving = ranges[0].partition("=")[0].strip() if ranges else None
    if moving is not None and len(axes[moving]) > FRAMES:
        raise RuleSheetError(_too_long(Option("over", ranges[0])))
    values = {name: axis.cut(0, len(axis)).tolist() for name, axis in axes.items()}
    lists = {name: column for name, column in values.items() if name != moving}
    return lists, {name: column for name, column in values.items() if name == moving}


def _second_range(option: Option) -> Diagnosis:
    return error(
        "E424",
        "a film runs over one range",
        Label(option.place(option.text)),
        notes=("list the values of the other variable: they stand side by side",),
    )


def _too_long(option: Option) -> Diagnosis:
    return error(
        "E424",
        f"a film has at most {FRAMES:,} frames",
        Label(option.place(option.text)),
        notes=("take a larger step",),
    )
