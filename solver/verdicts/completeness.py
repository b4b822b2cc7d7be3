"""Why the answers of a solve are not known to be all: notes in the user's names and places."""

from __future__ import annotations

import math
from collections.abc import Sequence

from rulesheets.diagnosis import Diagnosis, Label, Severity
from rulesheets.evaluate.number import number_text
from rulesheets.model import Model
from rulesheets.spelling import plural
from solver.facts import Gap
from solver.verdicts.explain import listed


def gap_notes(model: Model, gaps: Sequence[Gap]) -> tuple[Diagnosis, ...]:
    """A note for each gap, what was cut off first."""
    return tuple(_note(model, gap) for gap in sorted(gaps, key=lambda gap: not gap.cut))


def _note(model: Model, gap: Gap) -> Diagnosis:
    spans = dict.fromkeys(model.equations[e].rule for e in gap.equations)
    if gap.cut:
        code, message, notes = "S593", _cut(gap), _others(gap)
    else:
        code, message, notes = "S594", _unproven(gap), _proofs(model, gap)
    return Diagnosis(code, Severity.NOTE, message, tuple(map(Label, spans)), notes, gap.unknowns)


def _cut(gap: Gap) -> str:
    if not gap.unknowns:
        return f"there are too many answers: {gap.count} are listed"
    first = gap.unknowns[0]
    span = f"from {first} = {number_text(gap.low)} to {number_text(gap.high)}"
    return f"there are too many answers for {listed(gap.unknowns)}: {gap.count} are listed, {span}"


def _others(gap: Gap) -> tuple[str, ...]:
    if not gap.unknowns:
        return ("give ranges to the unknowns, name in [a, b], to list the answers there",)
    first = gap.unknowns[0]
    return (
        f"give {first} a range, {first} in [a, b], to list the answers there",
        f"a guess, {first} ~ {number_text(gap.high)}, lists those nearest to it first",
    )


def _unproven(gap: Gap) -> str:
    if not gap.unknowns:
        return "not every case of the conditions was tried"
    many = plural(gap.count, "answer") if gap.count else "no answer"
    return f"{many} found for {listed(gap.unknowns)}: nothing shows that there are no others"


def _proofs(model: Model, gap: Gap) -> tuple[str, ...]:
    """What would let the search prove that it has found all."""
    variables = [model.variables[name] for name in gap.unknowns]
    endless = [v.name for v in variables if not (math.isfinite(v.low) and math.isfinite(v.high))]
    return (f"ranges may show it: give {listed(endless)} a range, name in [a, b]",) if endless else ()
