"""Results as HTML and LaTeX, and what is derived from them: sensitivities, tolerances, samples."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from functools import singledispatch
from html import escape
from typing import Any, NamedTuple

from rulesheets.algebra import ROWS, html_table, more
from rulesheets.diagnosis import Diagnosis, plural, render
from rulesheets.format import readable
from rulesheets.syntax.nodes import Name
from rulesheets.units import shown
from solver.derivatives import Band, Sensitivities, ToleranceBands
from solver.facts import Status
from solver.files.tables import Table
from solver.path import Check, Path, SolveBlock, equations_of
from solver.path.planner import given_by
from solver.report import table
from solver.report.derivation import Derivation
from solver.report.path import Plain, Tex, told
from solver.report.sheet import displayed, sheet_heads, sheet_rows
from solver.report.why import ESCAPED, Page, why_latex
from solver.result import Result, Samples

NONE = "none"
"""What stands for a derivative that does not exist, or cannot be told."""

WIDE = 6
"""Inputs side by side; more of them go into further tables."""


def sensitivity_text(found: Sensitivities, *, color: bool = False) -> str:
    """The table, and under it why a derivative is missing."""
    groups = [found.inputs[i : i + WIDE] for i in range(0, len(found.inputs), WIDE)]
    if not groups or not found.outputs:
        return "Sensitivities: there is no output with a number, or no input"
    head = "Sensitivities: units of the output for one unit of the input, the other inputs held\n"
    tables = (table(header, rows) for header, *rows in (cells(found, group) for group in groups))
    return head + "\n\n".join([*tables, *(render(d, color=color) for d in found.diagnoses)])


def cells(found: Sensitivities, inputs: Sequence[str]) -> list[tuple[str, ...]]:
    """The heading and the rows for these inputs, in display units."""
    variables = found.model.variables

    def told(name: str) -> str:
        unit = variables[name].shown_unit
        return f"{name} [{unit}]" if unit else name

    def cell(output: str, given: str) -> str:
        slope = found[output, given]
        above, below = (shown(1.0, variables[name], difference=True) for name in (output, given))
        if slope is None:
            return NONE
        return readable(slope if above == below else slope * above / below)

    rows = ((told(output), *(cell(output, given) for given in inputs)) for output in found.outputs)
    return [("", *map(told, inputs)), *rows]


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
    heads = ("Name", "Value", "Worst case", "Root sum square", "Unit", "Contributions")
    text = table(heads, (_row(bands, name) for name in bands))
    said = (render(diagnosis, color=color) for diagnosis in bands.diagnoses)
    return "\n\n".join([f"Tolerances, to first order\n{text}", *said])


def _row(bands: ToleranceBands, name: str) -> tuple[str, ...]:
    band, unit = _displayed(bands, name), bands.sensitivities.model.variables[name].shown_unit
    if band is None:
        return name, "", "not known", "not known", unit, ""
    worst, rss = (f"± {size:.{DIGITS}g}" for size in (band.worst, band.rss))
    named = [one for one in band.contributions if one.amount][:NAMED]
    shares = [f"{one.input} {100 * one.share:.3g} %" for one in named]
    rest = sum(one.share for one in band.contributions) - sum(one.share for one in named)
    if rest > 1e-9:
        shares.append(f"others {100 * rest:.3g} %")
    return name, readable(band.value), worst, rss, unit, ", ".join(shares)


def _displayed(bands: ToleranceBands, name: str) -> Band | None:
    band, variable = bands[name], bands.sensitivities.model.variables[name]
    if band is None:
        return None
    worst, rss = (abs(shown(size, variable, difference=True)) for size in (band.worst, band.rss))
    return band._replace(value=shown(band.value, variable), worst=worst, rss=rss)


def samples_text(samples: Samples, bands: ToleranceBands) -> str:
    """What the samples did, beside what first order says of the standard deviation and the range."""
    counts = ", ".join(f"{n} {status}" for status, n in samples.counts.items())
    how = f"{samples.distribution} within the tolerances"
    if samples.distribution == "normal":
        how = "normal, tolerances are three standard deviations"
    count = plural(len(samples.table.status), "sample")
    heads = ("Name", "Mean", "Std dev", "first order", "Least", "Greatest", "worst case")
    text = table(heads, (_sampled(samples, bands, name) for name in samples.outputs))
    return f"Monte Carlo: {count} ({counts}), {how}, seed {samples.seed}\n{text}"


def _sampled(samples: Samples, bands: ToleranceBands, name: str) -> tuple[str, ...]:
    variable, band, rss, worst = bands.sensitivities.model.variables[name], _displayed(bands, name), "", ""
    if band is not None:
        rss = f"{band.rss * samples.spread:.{DIGITS}g}"
        worst = f"{band.value - band.worst:.{SAMPLED}g} to {band.value + band.worst:.{SAMPLED}g}"
    if (found := samples.statistics(name)) is None:
        return name, "", "", rss, "", "", worst
    average, deviation, *ends = found
    mean, least, greatest = (f"{shown(value, variable):.{SAMPLED}g}" for value in (average, *ends))
    spread = abs(shown(deviation, variable, difference=True))
    return name, mean, f"{spread:.{DIGITS}g}", rss, least, greatest, worst


def tolerances_json(bands: ToleranceBands) -> list[dict[str, object]]:
    """One object an output; ``value``, ``worst`` and ``rss`` are null where they are not known."""
    unknown: dict[str, object] = {"value": None, "worst": None, "rss": None, "contributions": []}
    found: list[dict[str, object]] = []
    for name, band in bands.items():
        if band is None:
            found.append({"output": name, **unknown})
        else:
            parts = [one._asdict() for one in band.contributions]
            sizes = {"value": band.value, "worst": band.worst, "rss": band.rss}
            found.append({"output": name, **sizes, "contributions": parts})
    return found


def samples_json(samples: Samples) -> dict[str, object]:
    """How the samples were drawn, their statuses counted, and mean, deviation and range of the outputs."""
    names = ("mean", "deviation", "least", "greatest")
    found = ((name, samples.statistics(name) or (None,) * 4) for name in samples.outputs)
    return {
        "samples": len(samples.table.status),
        "seed": samples.seed,
        "distribution": samples.distribution,
        "statuses": {str(status): n for status, n in samples.counts.items()},
        "outputs": [{"output": name, **dict(zip(names, four, strict=True))} for name, four in found],
    }


class Grid(NamedTuple):
    """What a notebook shows: texts in rows, ``numeric`` columns to the right, HTML before and after them."""

    heads: Sequence[str]
    rows: Iterable[Sequence[str]]
    numeric: Collection[int] = ()
    before: str = ""
    after: str = ""


def html(shown: Any) -> str:
    """What a notebook shows of a result, a table, a path, a derivation, or sensitivities."""
    grid = grid_of(shown)
    rows = tuple(grid.rows)
    table = html_table(grid.heads, rows, grid.numeric) if rows or not grid.before else ""
    return f"<div>{grid.before}{table}{grid.after}</div>"


def latex(shown: Any) -> str:
    """The same as LaTeX: equations of a result and of a derivation, else an array."""
    if isinstance(shown, Derivation):
        return "" if shown.value is None else why_latex(shown)
    if isinstance(shown, Result):
        return _result_latex(shown)
    grid = grid_of(shown)
    rows = [grid.heads, *grid.rows]
    lines = [" & ".join(rf"\text{{{cell.translate(ESCAPED)}}}" for cell in row) for row in rows]
    body = " \\\\\n".join([lines[0] + r" \\ \hline " + lines[1], *lines[2:]] if lines[1:] else lines)
    return f"\\begin{{array}}{{{'r' * len(grid.heads)}}}\n{body}\n\\end{{array}}"


def _result_latex(result: Result) -> str:
    """The outputs of the primary answer, a row each."""
    known = result.solutions[0] if result.solutions else result.partial
    rows = []
    for name in result.wanted:
        if name in known and name not in result.inputs:
            unit = (result.model.variables[name].unit or "").translate(ESCAPED)
            label, value = Tex().expression(Name(name)), Tex().value(known[name])
            rows.append(rf"  {label} &= {value}" + (rf"\ \text{{{unit}}}" if unit else ""))
    return "\\begin{align*}\n" + " \\\\\n".join(rows) + "\n\\end{align*}"


@singledispatch
def grid_of(shown: Any) -> Grid:
    raise TypeError(type(shown))


def _notes(diagnoses: Iterable[Diagnosis]) -> str:
    return "".join(f"<pre>{escape(render(diagnosis))}</pre>" for diagnosis in diagnoses)


ANSWERS = 4
"""Answers side by side at most; of more the first alone is shown."""


@grid_of.register
def _result_grid(result: Result) -> Grid:
    """The variable sheet of a result and what there is to say of it."""
    rows = displayed(result, sheet_rows(result, every=len(result.solutions) <= ANSWERS))
    heads = sheet_heads(rows)
    cells = (
        (row.status, readable(row.input), row.name, *map(readable, row.outputs), row.unit, row.comment)
        for row in rows
    )
    said = "" if result.status is Status.SOLVED else f"<p><b>{escape(str(result.status))}</b></p>"
    hidden = len(result.solutions) - 1 if len(result.solutions) > ANSWERS else 0
    others = f"<p>{hidden} other answers</p>" if hidden else ""
    after = f"{said}{others}{_notes(result.diagnoses)}"
    return Grid(heads, cells, {1, *range(3, len(heads) - 2)}, after=after)


@grid_of.register
def _table_grid(table: Table) -> Grid:
    """The first rows of a table, and how many more there are."""
    shown = [column[:ROWS].tolist() for column in table.values()]
    words = table.words()[:ROWS]
    rows = ((*map(readable, row), said) for *row, said in zip(*shown, words, strict=True))
    return Grid((*table, "status"), rows, range(len(table)), after=more(len(table.status)))


@grid_of.register
def _derivation_grid(derivation: Derivation) -> Grid:
    """The inputs, then the steps with their rules."""
    page = Page(derivation, Plain())
    known = (*derivation.inputs, *derivation.assumed)
    rows = [(page.known(one), "", "given") for one in known if one.name != derivation.name]
    for line in (line for link in derivation.links for line in page.lines(link)):
        said = f"{'such that ' * line.closing}{line.formula}{line.unit}"
        place, rule = ("by iteration", "") if line.equation is None else page.places.rule(line.equation)
        rows.append((said, rule, place))
    before = f"<b>{escape(page.head())}</b>"
    return Grid(("", "Rule", "Place"), rows, (), before, _notes(derivation.diagnoses))


@grid_of.register
def _path_grid(path: Path) -> Grid:
    """The steps in order, rules by their numbers in the model."""
    rows = []
    for number, step in enumerate(told(path), 1):
        found = ", ".join(given_by(step)) or ("(checks)" if isinstance(step, Check) else "(case by case)")
        together = " together" * isinstance(step, SolveBlock)
        rules = ", ".join(str(index + 1) for index in equations_of(step))
        rows.append((str(number), found + together, rules))
    return Grid(("Step", "Finds", "By rules"), rows)


@grid_of.register
def _sensitivities_grid(found: Sensitivities) -> Grid:
    """Outputs down, inputs across, in the units that are shown."""
    heads, *rows = cells(found, found.inputs)
    return Grid(heads, rows, range(1, len(heads)), after=_notes(found.diagnoses))
