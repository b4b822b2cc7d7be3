"""Sensitivities, tolerances and Monte Carlo samples as tables and as JSON."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace

import numpy as np

from rulesheets.diagnosis import plural, render
from rulesheets.format import readable
from rulesheets.model import Model, Variable
from rulesheets.units.quantity import shown
from solver.derivatives.sensitivities import Sensitivities
from solver.derivatives.tolerances import Band, ToleranceBands
from solver.report.table import table
from solver.sampling import Samples

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


NAMED = 4
"""Contributions that a row names."""

DIGITS, SAMPLED = 4, 6
"""Significant digits of a tolerance, and of a value drawn at random."""


def tolerances_text(bands: ToleranceBands, *, color: bool = False) -> str:
    """The bands to first order, contributions ranked; and why one is missing."""
    if not bands.tolerances:
        return "Tolerances: no input has one; write it as in --set AO='3 ± 0.01'"
    if not len(bands):
        return "Tolerances: there is no output with a number"
    head = "Tolerances, to first order"
    rows = (_row(bands, name) for name in bands)
    text = table(("Name", "Value", "Worst case", "Root sum square", "Unit", "Contributions"), rows)
    return "\n\n".join([f"{head}\n{text}", *(render(d, color=color) for d in bands.diagnoses)])


def _row(bands: ToleranceBands, name: str) -> tuple[str, ...]:
    band = bands[name]
    variable = bands.sensitivities.model.variables[name]
    unit = variable.shown_unit
    if band is None:
        return name, "", "not known", "not known", unit, ""
    band = _displayed(band, variable)
    return name, readable(band.value), _bar(band.worst), _bar(band.rss), unit, ", ".join(_shares(band))


def _displayed(band: Band, variable: Variable) -> Band:
    worst, rss = (abs(shown(size, variable, difference=True)) for size in (band.worst, band.rss))
    return replace(band, value=shown(band.value, variable), worst=worst, rss=rss)


def _bar(size: float) -> str:
    return f"± {size:.{DIGITS}g}"


def _shares(band: Band) -> Iterator[str]:
    named = [one for one in band.contributions if one.amount][:NAMED]
    for one in named:
        yield f"{one.input} {100 * one.share:.3g} %"
    rest = sum(one.share for one in band.contributions) - sum(one.share for one in named)
    if rest > 1e-9:
        yield f"others {100 * rest:.3g} %"


def samples_text(samples: Samples, bands: ToleranceBands) -> str:
    """What the samples did, beside what first order says of the standard deviation and the range."""
    counts = ", ".join(f"{n} {status}" for status, n in samples.counts.items())
    how = f"{samples.distribution} within the tolerances"
    if samples.distribution == "normal":
        how = "normal, tolerances are three standard deviations"
    head = (
        f"Monte Carlo: {plural(len(samples.table.status), 'sample')} ({counts}), {how}, seed {samples.seed}"
    )
    rows = (_sampled(samples, bands, name) for name in samples.outputs)
    columns = ("Name", "Mean", "Std dev", "first order", "Least", "Greatest", "worst case")
    return f"{head}\n{table(columns, rows)}"


def _sampled(samples: Samples, bands: ToleranceBands, name: str) -> tuple[str, ...]:
    variable, band = bands.sensitivities.model.variables[name], bands[name]
    column = np.array([shown(value, variable) for value in samples.solved(name).tolist()])
    band = None if band is None else _displayed(band, variable)
    rss, worst = ("", "") if band is None else (f"{band.rss * samples.spread:.{DIGITS}g}", _around(band))
    if len(column) < 2:
        return name, "", "", rss, "", "", worst
    mean, least, greatest = (f"{v:.{SAMPLED}g}" for v in (column.mean(), column.min(), column.max()))
    return name, mean, f"{column.std(ddof=1):.{DIGITS}g}", rss, least, greatest, worst


def _around(band: Band) -> str:
    return f"{band.value - band.worst:.{SAMPLED}g} to {band.value + band.worst:.{SAMPLED}g}"


def tolerances_json(bands: ToleranceBands) -> list[dict[str, object]]:
    """One object an output; ``value``, ``worst`` and ``rss`` are null where they are not known."""
    return [_object(name, bands[name]) for name in bands]


def _object(name: str, band: Band | None) -> dict[str, object]:
    if band is None:
        return {"output": name, "value": None, "worst": None, "rss": None, "contributions": []}
    parts = [{"input": c.input, "amount": c.amount, "share": c.share} for c in band.contributions]
    return {"output": name, "value": band.value, "worst": band.worst, "rss": band.rss, "contributions": parts}


def samples_json(samples: Samples) -> dict[str, object]:
    """How the samples were drawn, their statuses counted, and mean, deviation and range of the outputs."""
    return {
        "samples": len(samples.table.status),
        "seed": samples.seed,
        "distribution": samples.distribution,
        "statuses": {str(status): n for status, n in samples.counts.items()},
        "outputs": [_statistics(samples, name) for name in samples.outputs],
    }


def _statistics(samples: Samples, name: str) -> dict[str, object]:
    column = samples.solved(name)
    if len(column) < 2:
        return {"output": name, "mean": None, "deviation": None, "least": None, "greatest": None}
    return {
        "output": name,
        "mean": float(column.mean()),
        "deviation": float(column.std(ddof=1)),
        "least": float(column.min()),
        "greatest": float(column.max()),
    }
