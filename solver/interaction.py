"""A sheet to move in a notebook."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from importlib.util import find_spec
from typing import TYPE_CHECKING

from rulesheets.diagnosis import RuleSheetError
from rulesheets.model import Model, Value, expect_model
from solver.files.replacing import missing_extra

if TYPE_CHECKING:
    from solver.page.widget import Cell


def interact(
    model: Model,
    over: Mapping[str, Sequence[Value]],
    inputs: Mapping[str, Value | None] | None = None,
    *,
    guesses: Mapping[str, float] | None = None,
    want: Sequence[str] | None = None,
) -> Cell:
    """A cell of a notebook with sliders, the figures of the sheet and its values.

    ``over`` names up to three inputs with the values that their sliders run through; ``inputs``,
    ``guesses`` and ``want`` are those of :func:`solve`. Every state is solved and checked by a
    prepared plan while a slider moves. Raises RuleSheetError: E441 without the extra ``notebook``,
    E445 for more sliders, and for names that the model does not have.
    """
    expect_model(model)
    if find_spec("anywidget") is None:
        raise RuleSheetError(missing_extra("the widget needs", "anywidget", "notebook"))
    from solver.page.widget import Cell

    axes = {name: list(values) for name, values in over.items()}
    return Cell(model, axes, inputs or {}, guesses or {}, want)
