"""Results, tables, derivations and paths as self-contained HTML and LaTeX, for notebooks: no script."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from html import escape

import numpy as np
from numpy.typing import NDArray

from rulesheets.algebra.printing import ROWS, html_table, more
from rulesheets.diagnosis import render
from rulesheets.format import readable
from rulesheets.syntax.nodes import Name
from solver.derivation import Derivation, Direct, Together
from solver.derivatives.sensitivities import Sensitivities
from solver.path.steps import Check, Evaluate, Path, Select, SolveBlock, Step, equations_of
from solver.report.derived import cells
from solver.report.notation import Plain, Tex, equation
from solver.report.path import told
from solver.report.sheet import COLUMNS, displayed, output_heads, sheet_rows
from solver.report.why import ESCAPED, Page, iterated
from solver.result import Result, Status

ANSWERS = 4
"""Answers side by side at most; of more the first alone is shown."""


def result_html(result: Result) -> str:
    """The variable sheet of a result and what there is to say of it."""
    rows = displayed(result, sheet_rows(result, every=len(result.solutions) <= ANSWERS))
    status, given, name, _, unit, comment = COLUMNS
    heads = (
        status,
        given,
        name,
        *output_heads(max((len(r.outputs) for r in rows), default=1)),
        unit,
        comment,
    )
    cells = (
        (row.status, readable(row.input), row.name, *map(readable, row.outputs), row.unit, row.comment)
        for row in rows
    )
    numeric = {1, *range(3, len(heads) - 2)}
    said = "" if result.status is Status.SOLVED else f"<p><b>{escape(str(result.status))}</b></p>"
    notes = "".join(f"<pre>{escape(render(diagnosis))}</pre>" for diagnosis in result.diagnoses)
    hidden = len(result.solutions) - 1 if len(result.solutions) > ANSWERS else 0
    others = f"<p>{hidden} other answers</p>" if hidden else ""
    return f"<div>{html_table(heads, cells, numeric)}{said}{others}{notes}</div>"


def result_latex(result: Result) -> str:
    """The outputs of the primary answer, a row each."""
    known = result.solutions[0] if result.solutions else result.partial
    rows = []
    for name in result.wanted:
        if name in known and name not in result.inputs:
            unit = (result.model.variables[name].unit or "").translate(ESCAPED)
            label, value = Tex().expression(Name(name)), Tex().value(known[name])
            rows.append(rf"  {label} &= {value}" + (rf"\ \text{{{unit}}}" if unit else ""))
    return "\\begin{align*}\n" + " \\\\\n".join(rows) + "\n\\end{align*}"


def table_latex(columns: Mapping[str, NDArray[np.generic]], status: Sequence[str]) -> str:
    """The first rows of a table as an array."""
    return _array((*columns, "status"), _rows(columns, status))


def _array(heads: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Texts in the columns of an array, aligned to the right."""
    lines = [" & ".join(rf"\text{{{cell.translate(ESCAPED)}}}" for cell in row) for row in (heads, *rows)]
    body = " \\\\\n".join([lines[0] + r" \\ \hline " + lines[1], *lines[2:]] if lines[1:] else lines)
    return f"\\begin{{array}}{{{'r' * len(heads)}}}\n{body}\n\\end{{array}}"


def _rows(columns: Mapping[str, NDArray[np.generic]], status: Sequence[str]) -> Iterator[tuple[str, ...]]:
    shown = [column[:ROWS].tolist() for column in columns.values()]
    return ((*map(readable, row), said) for *row, said in zip(*shown, status[:ROWS], strict=True))


def table_html(columns: Mapping[str, NDArray[np.generic]], status: Sequence[str]) -> str:
    """The first rows of a table, and how many more there are."""
    heads = (*columns, "status")
    return f"<div>{html_table(heads, _rows(columns, status), range(len(heads) - 1))}{more(len(status))}</div>"


def derivation_html(derivation: Derivation) -> str:
    """The inputs, then the steps with their rules."""
    page = Page(derivation, Plain())
    known = (*derivation.inputs, *derivation.assumed)
    given = [(page.known(one), "", "given") for one in known if one.name != derivation.name]
    steps = [row for link in derivation.links for row in _steps(page, link)]
    notes = "".join(f"<pre>{escape(render(diagnosis))}</pre>" for diagnosis in derivation.diagnoses)
    table = html_table(("", "Rule", "Place"), (*given, *steps)) if given or steps else ""
    return f"<div><b>{escape(page.head())}</b>{table}{notes}</div>"


def _steps(page: Page, link: Direct | Together) -> Iterator[tuple[str, str, str]]:
    if isinstance(link, Direct):
        chain = " = ".join((page.name(link.found.name), *page.chain(link)))
        yield chain + page.unit(link.found), *page.rule(link.equation)[::-1]
        return
    for inner in link.order:
        yield from _steps(page, inner)
    for closing in link.closing:
        yield f"such that {equation(page.notation, closing.equation)}", *page.rule(closing.equation)[::-1]
    for known in iterated(link):
        yield page.known(known), "", "by iteration"


PATH_HEADS = ("Step", "Finds", "By rules")


def path_html(path: Path) -> str:
    """The steps in order, rules by their numbers in the model."""
    return f"<div>{html_table(PATH_HEADS, _steps_of(path))}</div>"


def path_latex(path: Path) -> str:
    return _array(PATH_HEADS, _steps_of(path))


def _steps_of(path: Path) -> Iterator[tuple[str, str, str]]:
    return (
        (str(number), _found(step), ", ".join(str(index + 1) for index in equations_of(step)))
        for number, step in enumerate(told(path), 1)
    )


def _found(step: Step) -> str:
    match step:
        case Evaluate(unknown=unknown) | Select(unknown=unknown):
            return unknown
        case SolveBlock(unknowns=unknowns):
            return f"{', '.join(unknowns)} together"
        case Check():
            return "(checks)"
        case _:
            return "(case by case)"


def sensitivities_html(found: Sensitivities) -> str:
    """Outputs down, inputs across, in the units that are shown."""
    heads, *rows = cells(found, found.inputs)
    notes = "".join(f"<pre>{escape(render(diagnosis))}</pre>" for diagnosis in found.diagnoses)
    return f"<div>{html_table(heads, rows, range(1, len(heads)))}{notes}</div>"


def sensitivities_latex(found: Sensitivities) -> str:
    heads, *rows = cells(found, found.inputs)
    return _array(heads, rows)
