"""Tables of a sweep in the units in which variables are shown."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

from rulesheets.diagnosis import RuleSheetError, error
from rulesheets.model import Model
from rulesheets.units.quantity import displays
from solver.files.columns import Columns
from solver.sweeps.sinks import Sink
from solver.sweeps.work import Solved


def heads(names: Iterable[str], model: Model) -> tuple[str, ...]:
    """The headings of a table: ``v``, and ``v [km/h]`` for what is not in the unit of the rules."""
    found = displays(model, names)
    return tuple(
        f"{name} [{model.variables[name].display_unit}]" if name in found else name for name in names
    )


def shown_columns(table: Columns, model: Model) -> Columns:
    """The columns in display units, by their names."""
    values = dict(table.values)
    for name, (factor, shift) in displays(model, values).items():
        values[name] = values[name].astype(float) * factor + shift
    return replace(table, values=values)


class ShownSink:
    """Hands the pieces on to another sink in display units."""

    def __init__(self, sink: Sink, model: Model) -> None:
        self._sink, self._model = sink, model
        self.close, self.discard = sink.close, sink.discard

    def add(self, piece: Solved) -> None:
        assert piece.table is not None
        table = shown_columns(piece.table, self._model)
        named = dict(zip(heads(table.values, self._model), table.values.values(), strict=True))
        self._sink.add(replace(piece, table=replace(table, values=named), text=None))


def expect_plain(model: Model, names: Iterable[str]) -> None:
    """Raise RuleSheetError (E448) where a table that is gone on with has other units than the rules."""
    if found := next(iter(displays(model, names)), None):
        notes = (f"{found} is shown in {model.variables[found].display_unit}; start anew, or show none so",)
        raise RuleSheetError(error("E448", "--resume goes on in the units of the rules", notes=notes))
