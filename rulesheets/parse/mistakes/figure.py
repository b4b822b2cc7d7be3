"""What is wrong with a line of a figure."""

from __future__ import annotations

from rulesheets.diagnosis import Diagnosis, Label, closest, error, plural
from rulesheets.marks import KINDS, Kind, Shape
from rulesheets.parse.mistakes.foreign import foreign_form, unreadable
from rulesheets.parse.mistakes.operand import MISSING, Stop, bad_number, broken_line, first_of, two_operands
from rulesheets.syntax.nodes import Mark, Name
from rulesheets.syntax.source import Span

_SHAPE = "a line of a figure reads point A = (x, y), line (O, A) or slider (B, 0)"


def explain_mark(stop: Stop) -> Diagnosis:
    """The most telling diagnosis of a line of a figure that the grammar rejects."""
    before_parenthesis = "(" not in stop.words[: stop.index]
    if before_parenthesis and stop.index < 4:
        return _misshapen(stop)
    explanations = (broken_line, foreign_form, bad_number, two_operands, *MISSING)
    return first_of(explanations, stop) or unreadable(stop)


def _misshapen(stop: Stop) -> Diagnosis:
    """A line that is nothing of a figure, or a mark whose parentheses are not reached."""
    kind = KINDS.get(stop.words[0].lower()) if stop.words else None
    place = stop.whole if stop.word is None else stop.here
    if kind is not None:
        return stop.error("E130", "this line of a figure cannot be read", place, "", f"write {kind.example}")
    if stop.words and (near := closest(stop.words[0], KINDS)) and stop.words[0] != near:
        return stop.error("E130", None, stop.span(stop.words[0]), "", f"did you mean {near}?")
    return stop.error("E130", None, place, "", _SHAPE, "a rule stands under `rules`")


def wrong_mark(mark: Mark) -> Diagnosis | None:
    """What is wrong with a mark that the grammar accepts: its kind, or what it lacks."""
    kind = KINDS.get(mark.kind)
    if kind is None:
        return _unknown_kind(mark)
    if kind.named and mark.name is None:
        return _wrong(mark, kind, f"this {mark.kind} has no name")
    if kind.shape is Shape.DIRECTED and mark.name is not None:
        return _wrong(mark, kind, f"a {mark.kind} has no name of its own")
    count = len(mark.arguments)
    if count < kind.least or (kind.most is not None and count > kind.most):
        return _wrong(mark, kind, f"a {mark.kind} takes {_expected(kind)}, not {count or 'none'}")
    places = {Shape.POINTS: mark.arguments, Shape.DIRECTED: mark.arguments[:1]}.get(kind.shape, ())
    for argument in places:
        if not isinstance(argument, Name) or "." in argument.name:
            label = (Label(argument.span),) if argument.span else ()
            notes = (f"name a point of the figure, as in {kind.example}",)
            return error("E131", "this is not the name of a point", *label, notes=notes)
    return None


def _expected(kind: Kind) -> str:
    if kind.shape is Shape.POINTS:
        return plural(kind.least, "point") + ("" if kind.most else " or more")
    return str(kind.shape.value)


def _wrong(mark: Mark, kind: Kind, message: str) -> Diagnosis:
    labels = (Label(mark.span),) if mark.span else ()
    return error("E131", message, *labels, notes=(f"write {kind.example}",))


def _unknown_kind(mark: Mark) -> Diagnosis:
    near = closest(mark.kind, KINDS)
    note = f"did you mean {near}?" if near else f"the kinds are {', '.join(KINDS)}"
    span = mark.span and Span(mark.span.source, mark.span.start, mark.span.start + len(mark.kind))
    labels = (Label(span),) if span else ()
    return error("E130", f"a figure has no `{mark.kind}`", *labels, notes=(note,))


def empty_figure(name: str, span: Span) -> Diagnosis:
    return error("E126", f"the figure {name} is empty", Label(span, "nothing to draw"), notes=(_SHAPE,))
