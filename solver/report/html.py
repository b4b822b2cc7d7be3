"""Results as HTML and LaTeX, and derived results: sensitivities, tolerances, samples."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from html import escape
from typing import Any, NamedTuple

from rulesheets.diagnosis import Diagnosis, plural, render
from rulesheets.format import ROWS, html_table, more
from rulesheets.inputs import readable
from rulesheets.units import shown
from solver.derivatives import Band, Sensitivities, ToleranceBands
from solver.facts import Status
from solver.files.tables import Samples, Table
from solver.path import Check, Path, SolveBlock, equations_of, given_by
from solver.report import SCREEN, table
from solver.report.derivation import Derivation, Line, Page, aligned, why_latex, why_text
from solver.report.path import Plain, steps_to_show
from solver.report.sheet import diagnosis_json, result_text, sheet_heads, sheet_rows, with_warnings
from solver.solution.solving import Result

NONE = "none"
"""The text for a derivative that does not exist or is unknown."""

WIDE = 6
"""Inputs side by side; more of them go into further tables."""


class Derived(NamedTuple):
    """Derived results, None for each that was not requested: ``samples`` come with ``bands``."""

    sensitivities: Sensitivities | None
    bands: ToleranceBands | None
    samples: Samples | None

    def text(self) -> str:
        """Blocks of text: tables, each followed by the reasons for missing entries."""
        blocks: list[str] = []
        if (slopes := self.sensitivities) is not None:
            groups = (slopes.inputs[i : i + WIDE] for i in range(0, len(slopes.inputs), WIDE))
            texts = (cells(slopes, group) for group in groups)
            tables = [table(header, rows) for header, *rows in texts]
            head = "Sensitivities: units of output for one unit of input, the other inputs held\n"
            if not tables or not slopes.outputs:
                head, tables = "Sensitivities: there is no output with a number, or no input", [""]
            blocks += [head + tables[0], *tables[1:]]
            blocks += SCREEN.get().said(slopes.diagnoses if tables[0] else ())
        if self.bands is not None:
            blocks += _tolerances_text(self.bands)
        if self.samples is not None and self.bands is not None:
            blocks.append(_samples_text(self.samples, self.bands))
        return "\n\n".join(blocks)

    def json(self) -> dict[str, object]:
        """Members of a JSON object; null for unknown values."""
        members: dict[str, object] = {}
        if (slopes := self.sensitivities) is not None:
            keys = ("output", "input", "value", "unit")
            rows = ((*pair, slopes[pair], slopes.unit(*pair)) for pair in slopes)
            members["sensitivities"] = [dict(zip(keys, row, strict=True)) for row in rows]
            members["sensitivity_diagnoses"] = [diagnosis_json(one) for one in slopes.diagnoses]
        if self.bands is not None:
            told = members["tolerances"] = list[dict[str, object]]()
            for name, band in self.bands.items():
                sizes = {size: getattr(band, size, None) for size in ("value", "worst", "rss")}
                parts = [one._asdict() for one in band.contributions] if band else []
                told.append({"output": name, **sizes, "contributions": parts})
            members["tolerance_diagnoses"] = [diagnosis_json(one) for one in self.bands.diagnoses]
        if (samples := self.samples) is not None:
            names = ("output", "mean", "deviation", "least", "greatest")
            found = ((name, *(samples.statistics(name) or (None,) * 4)) for name in samples.outputs)
            members["monte_carlo"] = {
                "samples": len(samples.table.status),
                "seed": samples.seed,
                "distribution": samples.distribution,
                "statuses": {str(status): n for status, n in samples.counts.items()},
                "outputs": [dict(zip(names, row, strict=True)) for row in found],
            }
        return members


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


NAMED = 4
"""Contributions that a row names."""

DIGITS, SAMPLED = 4, 6
"""Significant digits of a tolerance, and of a value drawn at random."""


def _displayed(bands: ToleranceBands, name: str) -> Band | None:
    band, variable = bands[name], bands.model.variables[name]
    if band is None:
        return None
    worst, rss = (abs(shown(size, variable, difference=True)) for size in (band.worst, band.rss))
    return band._replace(value=shown(band.value, variable), worst=worst, rss=rss)


def _tolerances_text(bands: ToleranceBands) -> list[str]:
    """The bands to first order, contributions ranked; and why one is missing."""
    if not bands.tolerances:
        return ["Tolerances: no input has one; write it as in --set AO='3 ± 0.01'"]
    if not len(bands):
        return ["Tolerances: there is no output with a number"]
    text = f"Tolerances, to first order\n{table(BAND, _band_rows(bands))}"
    return [text, *SCREEN.get().said(bands.diagnoses)]


BAND = "Name", "Value", "Worst case", "Root sum square", "Unit", "Contributions"


def _band_rows(bands: ToleranceBands) -> list[tuple[str, ...]]:
    rows: list[tuple[str, ...]] = []
    for name in bands:
        band, unit = _displayed(bands, name), bands.model.variables[name].shown_unit
        if band is None:
            rows.append((name, "", "not known", "not known", unit, ""))
            continue
        named = [one for one in band.contributions if one.amount][:NAMED]
        shares = [f"{one.input} {100 * one.share:.3g} %" for one in named]
        rest = sum(one.share for one in band.contributions) - sum(one.share for one in named)
        if rest > 1e-9:
            shares.append(f"others {100 * rest:.3g} %")
        sizes = (f"± {size:.{DIGITS}g}" for size in (band.worst, band.rss))
        rows.append((name, readable(band.value), *sizes, unit, ", ".join(shares)))
    return rows


def _samples_text(samples: Samples, bands: ToleranceBands) -> str:
    """Statistics of the samples, with the first-order estimates of standard deviation and range."""
    rows = []
    for name in samples.outputs:
        variable, band = bands.model.variables[name], _displayed(bands, name)
        rss = worst = ""
        if band is not None:
            rss = f"{band.rss * samples.spread:.{DIGITS}g}"
            ends = (band.value - band.worst, band.value + band.worst)
            worst = " to ".join(f"{end:.{SAMPLED}g}" for end in ends)
        mean = spread = least = greatest = ""
        if (found := samples.statistics(name)) is not None:
            average, deviation, low, high = found
            sizes = (average, low, high)
            mean, least, greatest = (f"{shown(size, variable):.{SAMPLED}g}" for size in sizes)
            spread = f"{abs(shown(deviation, variable, difference=True)):.{DIGITS}g}"
        rows.append((name, mean, spread, rss, least, greatest, worst))
    how = f"{samples.distribution} within the tolerances"
    if samples.distribution == "normal":
        how = "normal, tolerances are three standard deviations"
    counts = ", ".join(f"{n} {status}" for status, n in samples.counts.items())
    told = f"{plural(len(samples.table.status), 'sample')} ({counts}), {how}, seed {samples.seed}"
    heads = ("Name", "Mean", "Std dev", "first order", "Least", "Greatest", "worst case")
    return f"Monte Carlo: {told}\n{table(heads, rows)}"


class Grid(NamedTuple):
    """A table for a notebook: rows of texts, ``numeric`` columns, HTML before and after."""

    heads: Sequence[str]
    rows: Iterable[Sequence[str]]
    numeric: Collection[int] = ()
    before: str = ""
    after: str = ""


def html(shown: Any) -> str:
    """The HTML of a result, a table, a path, a derivation, or sensitivities for a notebook."""
    grid = grid_of(shown)
    rows = tuple(grid.rows)
    table = html_table(grid.heads, rows, grid.numeric) if rows or not grid.before else ""
    return f"<div>{grid.before}{table}{grid.after}</div>"


def text(shown: Any) -> str:
    """What ``print`` shows of them: the same as the command."""
    match shown:
        case Result():
            return result_text(with_warnings(shown))
        case Derivation():
            return why_text(shown)
        case Sensitivities():
            return Derived(shown, None, None).text()
        case ToleranceBands():
            return Derived(None, shown, None).text()
    grid = grid_of(shown)
    rest = len(shown.status) - ROWS if isinstance(shown, Table) else 0
    return table(grid.heads, tuple(grid.rows)) + (f"\n… {rest:,} more rows" if rest > 0 else "")


def latex(shown: Any) -> str:
    """LaTeX of a derivation, or of the outputs of a result; of other things none."""
    match shown:
        case Derivation(value=value):
            return "" if value is None else why_latex(shown)
        case Result():  # the outputs of the primary answer, a row each
            known = shown.solutions[0] if shown.solutions else shown.partial
            outputs = (name for name in shown.wanted if name in known and name not in shown.inputs)
            return aligned(Derivation(shown.model, "", known), map(Line, outputs))
    return ""


def grid_of(shown: Any) -> Grid:
    match shown:
        case Result():
            return _result_grid(shown)
        case Derivation():
            return _derivation_grid(shown)
        case Path():
            return _path_grid(shown)
        case Sensitivities():
            heads, *rows = cells(shown, shown.inputs)
            return Grid(heads, rows, range(1, len(heads)), after=_notes(shown.diagnoses))
        case ToleranceBands():
            return Grid(BAND, _band_rows(shown), {1, 2, 3}, after=_notes(shown.diagnoses))
    rows = shown.rows(0, ROWS).lines()
    return Grid((*shown, "status"), rows, range(len(shown)), after=more(len(shown.status)))


def _notes(diagnoses: Iterable[Diagnosis]) -> str:
    return "".join(f"<pre>{escape(render(diagnosis))}</pre>" for diagnosis in diagnoses)


ANSWERS = 4
"""Answers side by side at most; of more the first alone is shown."""


def _result_grid(result: Result) -> Grid:
    """The variable sheet of a result and its messages."""
    rows = sheet_rows(result, every=len(result.solutions) <= ANSWERS)
    heads, cells = sheet_heads(rows), (row.cells() for row in rows)
    said = "" if result.status is Status.SOLVED else f"<p><b>{escape(str(result.status))}</b></p>"
    hidden = len(result.solutions) - 1 if len(result.solutions) > ANSWERS else 0
    others = f"<p>{hidden} other answers</p>" if hidden else ""
    after = f"{said}{others}{_notes(with_warnings(result).diagnoses)}"
    return Grid(heads, cells, {1, *range(3, len(heads) - 2)}, after=after)


def _derivation_grid(derivation: Derivation) -> Grid:
    """The inputs, then the steps with their rules."""
    page = Page(derivation, Plain())
    given = (name for name in (*derivation.inputs, *derivation.assumed) if name != derivation.name)
    rows = [(page.known(name), "", "given") for name in given]
    for line in (line for link in derivation.links for line in link.lines):
        place, rule = page.places.rule(line.equation) if line.equation else ("by iteration", "")
        rows.append((f"{'' if line.unknown else 'such that '}{page.formula(line)}", rule, place))
    before = f"<b>{escape(page.head())}</b>"
    return Grid(("", "Rule", "Place"), rows, (), before, _notes(derivation.diagnoses))


def _path_grid(path: Path) -> Grid:
    """The steps in order, rules by their numbers in the model."""
    rows = []
    for number, step in enumerate(steps_to_show(path), 1):
        kind = "(checks)" if isinstance(step, Check) else "(case by case)"
        found = ", ".join(given_by(step)) or kind
        together = " together" * isinstance(step, SolveBlock)
        rules = ", ".join(str(index + 1) for index in equations_of(step))
        rows.append((str(number), found + together, rules))
    return Grid(("Step", "Finds", "By rules"), rows)
