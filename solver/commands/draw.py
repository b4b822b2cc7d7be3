"""``backsolve draw`` and ``solver.draw``: figures to scale, as a picture or a film."""

from __future__ import annotations

import sys
from argparse import Namespace
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from itertools import chain, product
from typing import TYPE_CHECKING

import numpy as np

from rulesheets.diagnosis import error, refusal, refuse, render, suggestion
from rulesheets.inputs import override, readable
from rulesheets.model import Model, Values, expect
from rulesheets.syntax import escaped
from rulesheets.syntax.nodes import Figure as Declared
from rulesheets.units import shown
from solver.commands import GIVEN, Command, Request, read_request
from solver.commands.over import read_states
from solver.facts import Status, Unsolved
from solver.files import write_file
from solver.files.tables import free_name
from solver.pictures import (
    PICTURES,
    View,
    diagram,
    drawable,
    picture_kind,
    require_matplotlib,
    variables,
)
from solver.report.sheet import MEANINGS
from solver.solution.solving import Result, solve
from solver.sweeps.sweep import sweep

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def draw(
    results: Result | Mapping[str, Result],
    *,
    every: bool = False,
    figures: Iterable[str] | None = None,
) -> Figure:
    """The figures of a sheet at an answer, to scale, as a matplotlib Figure in its units.

    Several results are drawn side by side with their titles; with ``every``, so are all answers of
    a result. ``figures`` selects figures by name. A figure that lacks a value is left out.

    Raises RuleSheetError if the sheet has no figure (E430) or not that one (E431), or matplotlib is
    not installed (E432), and Unsolved if there is no answer or no figure can be drawn.
    """
    titled = dict(results) if isinstance(results, Mapping) else {"": results}
    names, shown = None if figures is None else tuple(figures), list[View]()
    for title, result in titled.items():
        expect(Result, result, "solver.solve")
        shown += _views(result, chosen(result.model, names), title, every)
    require_matplotlib()
    from solver.pictures.page import compose

    return compose(shown)


def _views(result: Result, figures: Sequence[Declared], title: str, every: bool) -> list[View]:
    """One numbered view for each answer with ``every``, else one for the primary answer.

    Raises Unsolved if there is no answer or no figure can be drawn.
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
    """The figures of a model with these names, all if there are none."""
    if not model.figures:
        note = "a section figure says what is drawn: points, lines and vectors named by variables"
        raise refusal("E430", f"{model.name} has no figure to draw", None, note)
    by_name = {figure.name: figure for figure in model.figures}
    wanted = tuple(by_name if figures is None else figures)
    unknown = []
    for name in (name for name in wanted if name not in by_name):
        near = tuple(suggestion(name, by_name)) or (f"its figures are {', '.join(by_name)}",)
        unknown.append(error("E431", f"{model.name} has no figure {name}", notes=near))
    refuse(unknown)
    return tuple(by_name[name] for name in wanted)


FILMS = (".gif",)
MOVING = ("give --over NAME=START:STOP:STEP to make a film, .gif",)
_SHARP, _FILM = 150.0, 80.0
"""Dots an inch."""
_NAMED = 3
"""States without an answer that are named, beyond which they are counted."""


DRAW = f"""\
{GIVEN}
--over NAME=A,B,…*  a column for each value; NAME=START:STOP:STEP makes a film
--all               draw every answer, side by side
--figure NAME,…*    draw only these figures
--dpi N             dots per inch; {_SHARP:g} for pictures, {_FILM:g} for films
-o --output FILE    the output file: .png, .svg, .pdf, or .gif for a film
"""


def _run(arguments: Namespace) -> int:
    """Solve, draw, write; the exit code is 0 if everything requested is drawn."""
    request = read_request(arguments)
    names = [name.strip() for text in arguments.figure for name in text.split(",")]
    figures = chosen(request.model, names or None)
    side_by_side, motion = read_states(arguments.over, request)
    path = arguments.output or request.model.name + (".gif" if motion else ".png")
    kinds = (FILMS, "film", ("a range makes a film",)) if motion else (PICTURES, "picture", MOVING)
    kind = picture_kind(path, *kinds)
    request.expect_output(path)
    dpi = (_FILM if motion else _SHARP) if arguments.dpi is None else arguments.dpi
    if not 10.0 <= dpi <= 2400.0:
        note = "give 10 to 2400 dots per inch"
        raise refusal("E434", f"--dpi {dpi:g} is not a resolution", None, note)
    every = product(*side_by_side.values())
    states = [dict(zip(side_by_side, values, strict=True)) for values in every]
    studio = _Renderer(request, figures, states, arguments.all)
    data, tally = studio.film(motion, dpi) if motion else studio.picture(kind[1:], dpi)
    print(*studio.complaints, sep="\n\n", end="\n" if studio.complaints else "", file=sys.stderr)
    if data is None:
        return 1
    write_file(path, data)
    print(f"{escaped(path)}: {tally}")
    return 1 if studio.complaints else 0


class _Renderer:
    """Solves and draws states; ``complaints`` lists what was not drawn.

    Each drawing comes with its description.
    """

    def __init__(
        self, request: Request, figures: tuple[Declared, ...], states: Sequence[Values], every: bool
    ) -> None:
        self.request, self.figures, self.states, self.every = request, figures, states, every
        self.complaints: list[str] = []

    def picture(self, form: str, dpi: float) -> tuple[bytes | None, str]:
        """A still picture; None if there is nothing to draw. Problems join the complaints."""
        from solver.pictures.page import compose, encode

        shown: list[View] = []
        for state in self.states:
            title, result = self._named(state), self._solve(state)
            about = f"{title}: " if title else ""
            if result.status is not Status.SOLVED:
                self.complaints.append(f"{about}{result.status}: {MEANINGS[result.status]}")
                self.complaints += map(render, result.diagnoses)
            for figure in self.figures if result.solutions else ():
                try:
                    diagram(figure, result.solutions[0])
                except ValueError as reason:
                    self.complaints.append(f"{about}the figure {figure.name} is left out: {reason}")
            with suppress(Unsolved):
                shown += _views(result, self.figures, title, self.every)
        if not shown:
            return None, ""
        drawn = {d.name: None for view in shown for d in view.diagrams if d}
        tally = ", ".join(drawn) + (f"; {len(shown)} side by side" if len(shown) > 1 else "")
        return encode(compose(shown), form, dpi), tally

    def film(self, motion: Mapping[str, Sequence[float]], dpi: float) -> tuple[bytes | None, str]:
        """A frame for each value of the range; None if none of them has an answer."""
        from solver.pictures.page import gif, images

        ((name, values),) = motion.items()
        missing: dict[str, list[str]] = {}
        states = [self._moving(name, values, state, missing) for state in self.states]
        film = []
        for at, *instants in zip(values, *states, strict=True):
            views = tuple(chain.from_iterable(instants))
            if any(views):
                film.append((self._named({name: at}), views))
        for status, names in missing.items():
            rest = len(names) - _NAMED
            more = f"; and {rest} more" if rest > 0 else ""
            self.complaints.append(f"not drawn, {status}: {'; '.join(names[:_NAMED])}{more}")
        return gif(images(film, dpi)) if film else None, f"{len(film)} frames"

    def _moving(
        self, name: str, values: Sequence[float], state: Values, missing: dict[str, list[str]]
    ) -> list[list[View | None]]:
        """One state of the motion: a view for each branch of answers, None without an answer.

        The states without an answer join ``missing``, by status.
        """
        request, title = self.request, self._named(state)
        results = (self._solve({**state, name: value}) for value in values)
        answer: Values = next((r.solutions[0] for r in results if r.solutions), {})
        given = {n: v for n, v in {**request.inputs, **state}.items() if n != name}
        known = override(request.model, given).values
        pairs = zip(self.figures, drawable(self.figures, answer), strict=True)
        drawn = [figure for figure, there in pairs if there or not answer]
        want = [n for n in variables(drawn) if n not in known and n != name]
        every, guesses = self.every, request.guesses
        table = sweep(request.model, {name: values}, want, all=every, given=given, guesses=guesses)
        numbers, instants = table.solved.astype(int), np.arange(len(values))
        if self.every:
            numbers = table[free_name("answer", (name, *want))]
            instants = np.cumsum(table.begins()) - 1
        views: list[list[View | None]] = [[None] * max(1, numbers.max(initial=0)) for _ in values]
        each = zip(instants.tolist(), numbers.tolist(), strict=True)
        for row, (instant, number) in enumerate(each):
            at = {**known, **{n: table[n][row] for n in table}}
            diagrams = drawable(self.figures, at) if number else ()
            if any(diagrams):
                views[instant][number - 1] = View(title, diagrams)
            else:
                named = self._named({name: values[instant], **state})
                missing.setdefault(table.words()[row], []).append(named)
        return views

    def _solve(self, values: Values) -> Result:
        request, want = self.request, variables(self.figures) or None
        return solve(request.model, {**request.inputs, **values}, want, request.guesses)

    def _named(self, values: Values) -> str:
        """``thetaAO = 30 deg, branch = open``."""
        told = []
        for name, value in values.items():
            variable = self.request.model.variables[name]
            number = value if isinstance(value, str) else readable(shown(value, variable))
            told.append(f"{name} = {number} {variable.shown_unit}".rstrip())
        return ", ".join(told)


COMMANDS = {"draw": Command(DRAW, _run)}
