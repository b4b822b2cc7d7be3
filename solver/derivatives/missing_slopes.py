"""Why a derivative is missing, as a reason and as a sentence."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from rulesheets.diagnosis import Diagnosis, Label, Severity
from rulesheets.format import format_expression
from rulesheets.model import Model
from solver.path.cases import Pair


@dataclass(frozen=True)
class Reason:
    """Why one is missing: ``tied``, ``rough`` (a rule), ``kink``, ``edges`` (pairs), ``free`` or ``blank``.

    ``sides`` are the derivatives on both sides of a kink.
    """

    kind: str
    rule: int = -1
    pairs: tuple[Pair, ...] = ()
    sides: tuple[float, float] = (0.0, 0.0)


def diagnosis(model: Model, reason: Reason, group: Sequence[tuple[str, str]]) -> Diagnosis:
    """One reason for a group of (output, input) pairs, as a note."""
    outputs = tuple(dict.fromkeys(output for output, _ in group))
    givens = tuple(dict.fromkeys(given for _, given in group))
    what = f"the derivative of {_listed(outputs)} by {_listed(givens)}"
    labels = () if reason.rule < 0 else (Label(model.equations[reason.rule].rule),)
    match reason.kind:
        case "tied":
            text = f"{what} does not exist: moved alone, {_either(givens)} would break this rule"
            note = "clear an input that the others determine"
        case "rough":
            text = f"{what} can't be told here: this rule has no slope at these values"
            note = "it has a corner or a vertical tangent there; move an input a little and ask again"
        case "kink":
            after, before = reason.sides
            where = f"the rules change at {_comparisons(reason.pairs)}" if reason.pairs else "it has a corner"
            text = f"{what} does not exist: {where}"
            note = f"it is {after:.10g} upwards and {before:.10g} downwards"
        case "blank":
            text = f"{what} does not exist: {_listed(outputs)} has no number here"
            note = "take it out of the list, or solve for it"
        case "edges":
            text = f"{what} can't be told here: the rules change at {_comparisons(reason.pairs)}"
            note = "move an input a little and ask again"
        case _:
            text = f"{what} does not exist: the answer is singular there"
            note = "it can move while every input stays: a double root, a fold or a dead centre"
    return Diagnosis("S592", Severity.NOTE, text, labels, (note,), outputs)


def _listed(names: Sequence[str]) -> str:
    shown = names if len(names) <= 6 else (*names[:6], f"{len(names) - 6} more")
    return " and ".join(filter(None, (", ".join(shown[:-1]), shown[-1])))


def _either(names: Sequence[str]) -> str:
    return names[0] if len(names) == 1 else "each of them"


def _comparisons(pairs: Iterable[Pair]) -> str:
    return _listed([f"{format_expression(left)} = {format_expression(right)}" for left, right in pairs])
