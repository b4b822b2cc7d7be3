"""``backsolve draw`` and ``solver.draw``: the figures of a sheet to scale, as a picture."""

from __future__ import annotations

import sys
from argparse import ArgumentParser, Namespace
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from itertools import product
from math import prod
from typing import TYPE_CHECKING, TypeAlias

from rulesheets.diagnosis import RuleSheetError, error, refuse, render, suggestion
from rulesheets.format import readable
from rulesheets.model import Model, Value
from rulesheets.syntax import escaped
from rulesheets.syntax.nodes import Figure as Declared
from rulesheets.units import shown
from solver.commands import Command, Option, Request, add_input_options, read_request
from solver.commands.over import read_axes
from solver.facts import Status, Unsolved
from solver.files import write_file
from solver.pictures import View, drawable, lacking, picture_kind, require_matplotlib, variables
from solver.report.sheet import MEANINGS
from solver.solution.solving import Result, solve

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def draw(
    results: Result | Mapping[str, Result], *, every: bool = False, figures: Iterable[str] | None = None
) -> Figure:
    """The figures of a sheet at an answer, to scale, as a matplotlib Figure whose axes have its units.

    Several results stand side by side under their titles, and so do, with ``every``, the answers of a
    result. ``figures`` names those that are drawn. A figure that lacks a value is left out.

    Raises RuleSheetError where the sheet has no figure (E430) or not that one (E431), or matplotlib is not
    installed (E432), and Unsolved where there is no answer or not one figure can be drawn.
    """
    titled = {"": results} if isinstance(results, Result) else dict(results)
    names, shown = None if figures is None else tuple(figures), list[View]()
    for title, result in titled.items():
        shown += _views(result, chosen(result.model, names), title, every)
    require_matplotlib()
    from solver.pictures.page import compose

    return compose(shown)


def _views(result: Result, figures: Sequence[Declared], title: str, every: bool) -> list[View]:
    """One view for each answer (with ``every``; else for the primary one), numbered in their titles.

    Raises Unsolved where there is no answer or not one figure can be drawn.
    """
    answers = result.solutions if every else result.solutions[:1]
    if not answers:
        raise Unsolved(result.status, result.diagnoses)
    drawn = [drawable(figures, answer) for answer in answers]
    if not any(one for diagrams in drawn for one in diagrams):
        unknown = Status.PARTIAL if result.status is Status.SOLVED else result.status
        raise Unsolved(unknown, result.diagnoses)
    if len(drawn) == 1:
        return [View(title, *drawn)]
    numbers = (f"answer {number} of {len(drawn)}" for number in range(1, len(drawn) + 1))
    titles = (", ".join(filter(None, (title, number))) for number in numbers)
    return [View(*pair) for pair in zip(titles, drawn, strict=True)]


def chosen(model: Model, figures: Iterable[str] | None = None) -> tuple[Declared, ...]:
    """The figures of a model by these names, all where there are none."""
    if not model.figures:
        notes = ("a section figure says what is drawn: points, lines and vectors named by variables",)
        raise RuleSheetError(error("E430", f"{model.name} has no figure to draw", notes=notes))
    by_name = {figure.name: figure for figure in model.figures}
    wanted = tuple(by_name if figures is None else figures)
    unknown = []
    for name in (name for name in wanted if name not in by_name):
        near = tuple(suggestion(name, by_name)) or (f"its figures are {', '.join(by_name)}",)
        unknown.append(error("E431", f"{model.name} has no figure {name}", notes=near))
    refuse(unknown)
    return tuple(by_name[name] for name in wanted)


State: TypeAlias = Mapping[str, Value]

PICTURES = (".png", ".svg", ".pdf")
MOST = 24
"""States side by side."""


def _arguments(parser: ArgumentParser) -> None:
    add_input_options(parser, want=False)
    add = parser.add_argument
    over = "NAME=A,B,… or NAME=START:STOP:STEP"
    add("--over", metavar=over, action="append", default=[], help="states side by side")
    add("--all", action="store_true", help="draw every answer, side by side")
    add("--figure", metavar="NAME,…", action="append", default=[], help="draw these figures alone")
    add("--dpi", type=float, default=150.0, help="dots an inch; 150")
    add("-o", "--output", metavar="FILE", help="a file that ends in .png, .svg or .pdf")


def _run(arguments: Namespace) -> int:
    """Solve, draw, write; the exit code is 0 where everything that was asked for is drawn."""
    request = read_request(arguments)
    names = [name.strip() for text in arguments.figure for name in text.split(",")]
    figures = chosen(request.model, names or None)
    axes = read_axes(arguments.over, request)
    if prod(map(len, axes.values())) > MOST:
        message = f"a drawing shows at most {MOST} states side by side"
        raise RuleSheetError(Option("over", arguments.over[-1]).wrong("E424", message, "take a larger step"))
    path, dpi = arguments.output or f"{request.model.name}.png", arguments.dpi
    kind = picture_kind(path, PICTURES)
    request.expect_output(path)
    if not 10.0 <= dpi <= 2400.0:
        notes = ("give 10 to 2400 dots an inch",)
        raise RuleSheetError(error("E434", f"--dpi {dpi:g} is no resolution", notes=notes))
    values = product(*(axis[:].tolist() for axis in axes.values()))
    states = [dict(zip(axes, one, strict=True)) for one in values]
    views, complaints = _solved(request, figures, states, arguments.all)
    print(*complaints, sep="\n\n", end="\n" if complaints else "", file=sys.stderr)
    if not views:
        return 1
    from solver.pictures.page import compose, encode

    write_file(path, encode(compose(views), kind[1:], dpi))
    drawn = ", ".join({diagram.name: None for view in views for diagram in view.diagrams if diagram})
    print(f"{escaped(path)}: {drawn}" + (f"; {len(views)} side by side" if len(views) > 1 else ""))
    return 1 if complaints else 0


def _solved(
    request: Request, figures: tuple[Declared, ...], states: Iterable[State], every: bool
) -> tuple[list[View], list[str]]:
    """What there is to draw of every state, and what is wrong."""
    views, complaints = list[View](), list[str]()
    for state in states:
        inputs, title = {**request.inputs, **state}, _named(request.model, state)
        result = solve(request.model, inputs, variables(figures) or None, request.guesses)
        about = f"{title}: " if title else ""
        if result.status is not Status.SOLVED:
            complaints.append(f"{about}{result.status}: {MEANINGS[result.status]}")
            complaints += map(render, result.diagnoses)
        for figure in figures if result.solutions else ():
            if reason := lacking(figure, result.solutions[0]):
                complaints.append(f"{about}the figure {figure.name} is left out: {reason}")
        with suppress(Unsolved):
            views += _views(result, figures, title, every)
    return views, complaints


def _named(model: Model, state: State) -> str:
    """``thetaAO = 30 deg, branch = open``."""
    told = []
    for name, value in state.items():
        variable = model.variables[name]
        number = value if isinstance(value, str) else readable(shown(value, variable))
        told.append(f"{name} = {number} {variable.shown_unit}".rstrip())
    return ", ".join(told)


COMMANDS = {"draw": Command(_arguments, _run)}
