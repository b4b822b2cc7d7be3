"""Tolerances of the outputs as tables: to first order, and by Monte Carlo beside it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from rulesheets.diagnosis import render
from rulesheets.model import Variable
from rulesheets.spelling import plural
from rulesheets.units.quantity import shown
from solver.derivatives.tolerances import Band, ToleranceBands
from solver.report.numbers import readable
from solver.report.table import table

if TYPE_CHECKING:
    from solver.sampling import Samples

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
