"""A sheet as a page in a cell of a notebook. The kernel answers the requests of the page."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from anywidget import AnyWidget
from traitlets import Dict

from rulesheets.deadline import TimeIsUp, time_limit
from rulesheets.model import Model, Value
from solver.lane import SHARE
from solver.page.bench import QUICK, SLOW, Bench

STATIC = Path(__file__).parent / "static"


class Cell(AnyWidget):
    """The widget. ``inputs`` are the given inputs, as changed in the cell since."""

    _esm = STATIC / "widget.js"
    opened = Dict().tag(sync=True)

    def __init__(
        self,
        model: Model,
        over: Mapping[str, Sequence[Value]],
        inputs: Mapping[str, Value | None],
        guesses: Mapping[str, float],
        timeout: float,
    ) -> None:
        self.inputs: dict[str, Value | None] = dict(inputs)
        self.text = _text(model)
        self._bench, self._timeout = Bench(python=bool(model.python)), timeout
        self._base = os.path.dirname(model.files[0]) if model.files else ""
        state = {"text": self.text, "inputs": self.inputs, "guesses": dict(guesses), "near": None}
        sliders = [{"name": name, "values": list(values)} for name, values in over.items()]
        names: dict[str, Any] = {"sheet": model.name, "name": model.name, "text": self.text}
        names |= {"seen": "", "shipped": True}
        described = self._bench.take(model)
        super().__init__(opened={**described, **names, "kept": {"doc": state}, "sliders": sliders})
        self.on_msg(self._heard)

    def _heard(self, _: object, message: Mapping[str, Any], __: object) -> None:
        self.send({**self._answer(message), "id": message.get("id")})

    def _answer(self, message: Mapping[str, Any]) -> dict[str, Any]:
        """The reply to a request of the page. The last text that is a sheet is kept."""
        do = message.get("do")
        try:
            with time_limit(self._timeout):
                if do in ("edit", "check"):
                    text = str(message["text"])
                    sheet = {"text": text, "name": self.opened["name"], "base": self._base}
                    reply = self._bench.answer({**sheet, "do": "load" if do == "edit" else "check"})
                    self.text = text if "variables" in reply else self.text
                    return reply
                # the state of the page is shown again if the cell is displayed again
                if do == "keep":
                    self.inputs = dict(message["state"]["doc"]["inputs"])
                    self.opened = {**self.opened, "kept": dict(message["state"])}
                    return {}
                if do in (*QUICK, *SLOW):
                    return self._bench.answer({**message, "timeout": SHARE * self._timeout})
                return {"failed": "a cell has no such request"}
        except TimeIsUp:
            return {"gave_up": self._timeout}


def _text(model: Model) -> str:
    """The text of the sheet itself, without used files."""
    spans = [variable.span for variable in model.variables.values()]
    spans += [equation.rule for equation in model.equations]
    sources = [span.source for span in spans if span is not None]
    return next((one.text for one in sources if not model.files or one.name == model.files[0]), "")
