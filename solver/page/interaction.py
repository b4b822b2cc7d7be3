"""A sheet to move in a notebook."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from importlib.util import find_spec
from typing import TYPE_CHECKING

from rulesheets.diagnosis import RuleSheetError
from rulesheets.inputs import override
from rulesheets.model import Model, Value, expect_model
from solver.files.replacing import missing_extra

if TYPE_CHECKING:
    from solver.page.widget import Cell


def interact(
    model: Model,
    over: Mapping[str, Sequence[Value]] | None = None,
    inputs: Mapping[str, Value | None] | None = None,
    *,
    guesses: Mapping[str, float] | None = None,
    timeout: float = 10.0,
) -> Cell:
    """The page of a sheet in a cell of a notebook.

    ``over`` names inputs with the values that a slider runs through; ``inputs`` and ``guesses`` are
    those of :func:`solve` to begin with, ``timeout`` the seconds that a solve may take. The attribute
    ``inputs`` of the cell holds the inputs as they are now. Values are in the units of the rules.
    Raises RuleSheetError: E441 without the extra ``notebook``, and for names and values that
    :func:`solve` refuses.
    """
    expect_model(model)
    if find_spec("anywidget") is None:
        raise RuleSheetError(missing_extra("the widget needs", "anywidget", "notebook"))
    from solver.page.widget import Cell

    begin = override(model, inputs, guesses)
    given = {name: begin.values.get(name) for name in inputs or {}}
    sliders = {
        name: [override(model, {name: value}).values[name] for value in values]
        for name, values in (over or {}).items()
    }
    for name, values in sliders.items():
        if name not in begin.values:
            given[name] = values[len(values) // 2]
    return Cell(model, sliders, given, {name: begin.guesses[name] for name in guesses or {}}, timeout)
