"""Results → their figures as a page of matplotlib."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping, Sequence
from importlib.util import find_spec
from typing import TYPE_CHECKING

from rulesheets.diagnosis import RuleSheetError, error, refuse, suggestion
from rulesheets.model import Model
from rulesheets.syntax.nodes import Figure as Declared
from solver.facts import Status, Unsolved
from solver.pictures import View, drawable, lacking
from solver.result import Result

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
    shown = [view for title, result in titled.items() for view in views(result, title, every, figures)]
    require_matplotlib()
    from solver.pictures.page import compose

    return compose(shown)


def views(
    result: Result, title: str = "", every: bool = False, figures: Iterable[str] | None = None
) -> list[View]:
    """One view for each answer (with ``every``; else for the primary one), numbered in their titles.

    Raises as :func:`draw` does.
    """
    declared = chosen(result.model, figures)
    answers = result.solutions if every else result.solutions[:1]
    if not answers:
        raise Unsolved(result.status, result.diagnoses)
    drawn = [drawable(declared, answer) for answer in answers]
    if not any(one for diagrams in drawn for one in diagrams):
        unknown = Status.PARTIAL if result.status is Status.SOLVED else result.status
        raise Unsolved(unknown, result.diagnoses)
    if len(drawn) == 1:
        return [View(title, *drawn)]
    numbers = (f"answer {number} of {len(drawn)}" for number in range(1, len(drawn) + 1))
    titles = (", ".join(filter(None, (title, number))) for number in numbers)
    return [View(*pair) for pair in zip(titles, drawn, strict=True)]


def left_out(result: Result, figures: Iterable[str] | None = None) -> list[str]:
    """What keeps figures of the primary answer from being drawn, a sentence for each."""
    declared = chosen(result.model, figures)
    reasons = ((figure.name, lacking(figure, result.solutions[0])) for figure in declared)
    return [f"the figure {name} is left out: {reason}" for name, reason in reasons if reason]


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


def require_matplotlib() -> None:
    """Raise RuleSheetError (E432) where matplotlib is not installed."""
    if find_spec("matplotlib") is None:
        notes = ("pip install 'backsolve[plot]'",)
        raise RuleSheetError(error("E432", "drawing needs matplotlib", notes=notes))


def picture_kind(path: str, kinds: Sequence[str], what: str = "picture", notes: tuple[str, ...] = ()) -> str:
    """The ending of a file to draw into. Raises RuleSheetError: E433 for another one, E432."""
    kind = os.path.splitext(path)[1].lower()
    if kind not in kinds:
        endings = " or ".join(filter(None, (", ".join(kinds[:-1]), kinds[-1])))
        raise RuleSheetError(error("E433", f"{path}: a {what} ends in {endings}", notes=notes))
    if kind != ".csv":
        require_matplotlib()
    return kind
