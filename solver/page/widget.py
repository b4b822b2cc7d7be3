"""A sheet in a cell of a notebook: sliders, figures and values, each state solved as a slider moves."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from anywidget import AnyWidget
from traitlets import Dict

from rulesheets.model import Model, Value
from solver.page.export import STATIC, Axes, Grid, document, expect_few

OUTLINED = 400
"""States from which the room for the figures is found."""


class Cell(AnyWidget):
    """The widget; ``data`` is what it shows at first."""

    _esm = STATIC / "widget.js"
    data = Dict().tag(sync=True)

    def __init__(
        self,
        model: Model,
        over: Axes,
        inputs: Mapping[str, Value | None],
        guesses: Mapping[str, float],
        want: Sequence[str] | None,
    ) -> None:
        expect_few(over)
        self._axes, self._grid = over, Grid(model, inputs, guesses, over, want)
        each = max(2, round(OUTLINED ** (1 / max(1, len(over)))))
        few = {name: values[:: -(-len(values) // each)] for name, values in over.items()}
        data = document(model, inputs, over, self._grid.rows(few))
        self._shown = data["variables"]
        state = self._state([axis["at"] for axis in data["axes"]])
        super().__init__(data={**data, "state": state, "said": "Solved while you move a slider."})
        self.on_msg(self._moved)

    def _moved(self, _: object, message: Mapping[str, Any], __: object) -> None:
        self.send({"state": self._state(message["places"])})

    def _state(self, places: Sequence[int]) -> dict[str, Any] | None:
        """The state at these positions of the sliders, None where there is no answer."""
        at = {name: [values[k]] for (name, values), k in zip(self._axes.items(), places, strict=True)}
        (row,) = self._grid.rows(at)
        return None if row is None else self._grid.state(row, self._shown)
