"""Sensitivities as a table: outputs down, inputs across."""

from __future__ import annotations

from collections.abc import Iterable

from rulesheets.diagnosis import render
from rulesheets.model import Model
from rulesheets.units.quantity import shown
from solver.derivatives.sensitivities import Sensitivities
from solver.report.numbers import readable
from solver.report.table import table

NONE = "none"
"""What stands for a derivative that does not exist, or cannot be told."""

WIDE = 6
"""Inputs side by side; more of them go into further tables."""


def sensitivity_text(found: Sensitivities, *, color: bool = False) -> str:
    """The table, and under it why a derivative is missing."""
    groups = [found.inputs[i : i + WIDE] for i in range(0, len(found.inputs), WIDE)]
    tables = [_table(found, group) for group in groups] if found.outputs else []
    if not tables:
        return "Sensitivities: there is no output with a number, or no input"
    head = "Sensitivities: units of the output for one unit of the input, the other inputs held"
    return "\n\n".join(
        [f"{head}\n{tables[0]}", *tables[1:], *(render(d, color=color) for d in found.diagnoses)]
    )


def cells(found: Sensitivities, inputs: Iterable[str]) -> list[tuple[str, ...]]:
    """The heading and the rows for these inputs."""
    inputs = tuple(inputs)
    rows = (
        (_named(found.model, output), *(_cell(_shown(found, output, given)) for given in inputs))
        for output in found.outputs
    )
    return [("", *(_named(found.model, given) for given in inputs)), *rows]


def _table(found: Sensitivities, inputs: Iterable[str]) -> str:
    header, *rows = cells(found, inputs)
    return table(header, rows)


def _named(model: Model, name: str) -> str:
    unit = model.variables[name].shown_unit
    return f"{name} [{unit}]" if unit else name


def _shown(found: Sensitivities, output: str, given: str) -> float | None:
    """A slope in display units."""
    slope, variables = found[output, given], found.model.variables
    above, below = (shown(1.0, variables[name], difference=True) for name in (output, given))
    return slope if slope is None or above == below else slope * above / below


def _cell(slope: float | None) -> str:
    return NONE if slope is None else readable(slope)


def sensitivity_json(found: Sensitivities) -> list[dict[str, object]]:
    """One object a derivative: ``output``, ``input``, ``value`` (null where there is none), ``unit``."""
    return [
        {"output": output, "input": given, "value": found[output, given], "unit": found.unit(output, given)}
        for output, given in found
    ]
