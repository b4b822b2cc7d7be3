"""Results as HTML and LaTeX, and what is derived from them: sensitivities, tolerances, samples."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Sequence
from functools import singledispatch
from html import escape
from typing import Any, NamedTuple

from rulesheets.algebra import ROWS, html_table, more
from rulesheets.diagnosis import Diagnosis, plural, render
from rulesheets.format import readable
from rulesheets.model import Model, Variable
from rulesheets.syntax.nodes import Name
from rulesheets.units import shown
from solver.derivatives import Band, Sensitivities, ToleranceBands
from solver.facts import Status
from solver.files.tables import Table
from solver.path import Check, Path, SolveBlock, Step, equations_of
from solver.path.planner import given_by
from solver.report import table
from solver.report.derivation import Derivation
from solver.report.path import Plain, Tex, told
from solver.report.sheet import displayed, sheet_heads, sheet_rows
from solver.report.why import ESCAPED, Line, Page, why_latex
from solver.result import Result, Samples

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
    return band._replace(value=shown(band.value, variable), worst=worst, rss=rss)


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
    band = None if band is None else _displayed(band, variable)
    rss, worst = ("", "") if band is None else (f"{band.rss * samples.spread:.{DIGITS}g}", _around(band))
    if (found := samples.statistics(name)) is None:
        return name, "", "", rss, "", "", worst
    average, deviation, *ends = found
    mean, least, greatest = (f"{shown(value, variable):.{SAMPLED}g}" for value in (average, *ends))
    spread = abs(shown(deviation, variable, difference=True))
    return name, mean, f"{spread:.{DIGITS}g}", rss, least, greatest, worst


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
    names = ("mean", "deviation", "least", "greatest")
    return {"output": name, **dict(zip(names, samples.statistics(name) or (None,) * 4, strict=True))}


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
    return _result_latex(shown) if isinstance(shown, Result) else _array(grid_of(shown))


def _array(grid: Grid) -> str:
    """Texts in the columns of an array, aligned to the right."""
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
    given = [(page.known(one), "", "given") for one in known if one.name != derivation.name]
    steps = [_row_of(page, line) for link in derivation.links for line in page.lines(link)]
    before = f"<b>{escape(page.head())}</b>"
    return Grid(("", "Rule", "Place"), (*given, *steps), (), before, _notes(derivation.diagnoses))


def _row_of(page: Page, line: Line) -> tuple[str, str, str]:
    said = f"{'such that ' * line.closing}{line.formula}{line.unit}"
    place, rule = ("by iteration", "") if line.equation is None else page.places.rule(line.equation)
    return said, rule, place


@grid_of.register
def _path_grid(path: Path) -> Grid:
    """The steps in order, rules by their numbers in the model."""
    steps = (
        (str(number), _found(step), ", ".join(str(index + 1) for index in equations_of(step)))
        for number, step in enumerate(told(path), 1)
    )
    return Grid(("Step", "Finds", "By rules"), steps)


def _found(step: Step) -> str:
    if isinstance(step, SolveBlock):
        return f"{', '.join(step.unknowns)} together"
    return ", ".join(given_by(step)) or ("(checks)" if isinstance(step, Check) else "(case by case)")


@grid_of.register
def _sensitivities_grid(found: Sensitivities) -> Grid:
    """Outputs down, inputs across, in the units that are shown."""
    heads, *rows = cells(found, found.inputs)
    return Grid(heads, rows, range(1, len(heads)), after=_notes(found.diagnoses))
