"""The variable sheet: a result as rows, and the same as JSON."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Mapping, Sequence
from decimal import Context, Decimal
from io import StringIO
from math import ceil, inf, isfinite, log10
from typing import NamedTuple

from rulesheets.diagnosis import Diagnosis
from rulesheets.format import exact, format_condition, readable
from rulesheets.inputs import guarded
from rulesheets.model import Model, Tolerance, Value
from rulesheets.syntax import Span
from rulesheets.units import shown
from solver.path import Assume, Decide, Evaluate, Select, SolveBlock, Step, equations_of
from solver.solution.solving import Result, Solution


def tolerated(text: str, tolerance: Tolerance | None) -> str:
    """``3 ± 0.01``: the text of an input with its tolerance, as a sheet reads it."""
    if tolerance is None:
        return text
    return f"{text} ± {exact(tolerance.size)}{'%' if tolerance.percent else ''}"


def certain(value: Value | None, error: float) -> str:
    """A value with the digits that its error leaves: the last one may be off by one, zeros included.

    All that a float has where the error is 0; ``±1e-16`` where not one digit is right.
    """
    if not isinstance(value, float) or error == 0.0:
        return exact(value)
    if not isfinite(error):
        return "±?"
    place = ceil(log10(2.0 * error))
    if abs(value) < 0.5 * 10.0**place:
        return f"±{error:.0e}"
    wide = Context(prec=1100, Emin=-2000, Emax=2000)
    rounded = Decimal(value).quantize(Decimal((0, (1,), place)), context=wide)
    if place <= 0 and -5 <= rounded.adjusted() < 16:
        return f"{rounded:f}"
    return f"{rounded:.{rounded.adjusted() - place}e}".replace("e+", "e")


def magnitude(value: float) -> str:
    """The size of a residual: ``1e-16``, ``0``."""
    return f"{value:.0e}" if value else "0"


COLUMNS = ("St", "Input", "Name", "Output", "Unit", "Comment")

GUESS = "G"


class SheetRow(NamedTuple):
    """A variable with its input or its guess (then ``status`` is ``G``) and one output an answer.

    ``errors``: the error bar of every output, where they are asked for. ``tolerance``: that of the input.
    """

    status: str
    input: Value | None
    name: str
    outputs: tuple[Value | None, ...]
    unit: str
    comment: str
    errors: tuple[float, ...] = ()
    tolerance: Tolerance | None = None

    def cells(self, tell: Callable[[Value | None], str] = readable) -> tuple[str, ...]:
        """Its texts, one a column."""
        outputs = map(certain, self.outputs, self.errors) if self.errors else map(tell, self.outputs)
        given = tolerated(tell(self.input), self.tolerance)
        return (self.status, given, self.name, *outputs, self.unit, self.comment)


def answers(result: Result, *, every: bool) -> tuple[Mapping[str, Value], ...]:
    """The answers to show, the primary one first; what is determined where there is none."""
    if not result.solutions:
        return (result.partial,)
    return result.solutions if every else result.solutions[:1]


def sheet_rows(
    result: Result, *, every: bool = False, digits: bool = False, others: bool = False, display: bool = True
) -> tuple[SheetRow, ...]:
    """Rows in the order of the sheet, locals only where they are given or wanted.

    A variable that was not asked for and has no value is left out. ``digits`` adds the error bars. ``others``
    are the rows that are left out instead; of a pruned solve those that have a value. Values are in the units
    of ``display``, or in those of the rules.
    """
    found, (posted, whole) = answers(result, every=every), named(result)
    rows = []
    for name, variable in result.model.variables.items():
        there = any(name in answer for answer in found)
        own = name in posted and (posted[name] or there)
        if own is others or (others and not (whole or there)):
            continue
        given = result.inputs.get(name)
        guess = None if given is not None else result.guesses.get(name)
        values = [given if given is not None else guess]
        values += [None if given is not None else answer.get(name) for answer in found]
        # the error bar of a part of an answer is not known
        errors = [a.error.get(name, 0.0) if isinstance(a, Solution) else inf for a in found if digits]
        tolerance = variable.tolerance if isinstance(given, float) else None
        unit = variable.unit
        if display and variable.display_unit:
            unit = variable.display_unit
            values = [shown(v, variable) if isinstance(v, float) else v for v in values]
            errors = [abs(shown(error, variable, difference=True)) for error in errors]
            if tolerance is not None and not tolerance.percent:
                tolerance = Tolerance(abs(shown(tolerance.size, variable, difference=True)))
        status, outputs = "" if guess is None else GUESS, tuple(values[1:])
        row = status, values[0], name, outputs, unit or "", variable.comment, tuple(errors), tolerance
        rows.append(SheetRow(*row))
    return tuple(rows)


def named(result: Result) -> tuple[dict[str, bool], bool]:
    """The variables that have a row, each with whether it has one even where it has no value.

    And whether all that the sheet has was asked for. Of fewer, those that calls only pass on to one another
    have no row.
    """
    wanted = set(result.wanted)
    posted = [v for v in result.model.variables.values() if v.posted]
    whole = all(v.passed or v.name in wanted for v in posted)
    rows = {v.name: whole for v in posted if whole or not v.passed}
    return rows | dict.fromkeys({*result.inputs, *wanted}, True), whole


def sheet_heads(rows: Sequence[SheetRow]) -> tuple[str, ...]:
    """The columns of the rows: ``Output`` once, or ``Output 1``, ``Output 2``, … side by side."""
    count = len(rows[0].outputs) if rows else 1
    outputs = ["Output"] if count == 1 else [f"Output {k}" for k in range(1, count + 1)]
    return (*COLUMNS[:3], *outputs, *COLUMNS[4:])


def result_csv(result: Result, *, every: bool = False) -> str:
    """The variable sheet as a text; ``every`` gives each answer a column ``Output 1``, ``Output 2``, …

    Numbers read back as the same floats. Read as a variable sheet, the text of the primary answer gives the
    same inputs and guesses again: outputs are not inputs.
    """
    import csv  # which a table on the screen need not wait for

    rows = sheet_rows(result, every=every, display=False)
    text = StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(sheet_heads(rows))
    writer.writerows(map(guarded, row.cells(exact)) for row in rows)
    return text.getvalue()


Json = dict[str, object]


def result_json(
    result: Result, *, explain: bool = False, digits: bool = False, also: Mapping[str, object] | None = None
) -> str:
    """The object of a solve; ``explain`` adds the locals under their dotted names, ``digits`` the errors.

    ``also`` are further members, put at its end.
    """
    from solver.report.path import told  # a table does without

    variables, (rows, _) = result.model.variables, named(result)
    names = [name for name in variables if explain or name in rows]
    solutions = [finite({n: answer[n] for n in names if n in answer}) for answer in result.solutions]
    both = list(zip(result.solutions, solutions, strict=True))
    # the units in which the rules compute, whatever a table shows
    units = {n: v.unit for n, v in variables.items() if v.unit and any(n in some for some in solutions)}
    document: Json = {"status": str(result.status), "solutions": solutions}
    if digits:  # null where nothing can be said
        bars = ({n: answer.error[n] for n in some if n in answer.error} for answer, some in both)
        document["errors"] = [{**dict.fromkeys(known), **finite(known)} for known in bars]
    if proofs := [_proof(answer, some) for answer, some in both if answer.proof is not None]:
        document["proofs"] = proofs
    if any(answer.unlikely for answer in result.solutions):
        document["unlikely"] = [list(answer.unlikely) for answer in result.solutions]
    document |= {
        "complete": result.complete,
        "undetermined": list(result.undetermined),
        "diagnoses": [diagnosis_json(diagnosis) for diagnosis in result.diagnoses],
        "path": [_step(result.model, step) for step in told(result.path)],
        **({"units": units} if units else {}),
        **(also or {}),
    }
    return _dump(document)


def error_json(diagnoses: Iterable[Diagnosis]) -> str:
    """The object of a sheet or a command that is wrong: status ``error`` and the diagnoses."""
    return _dump({"status": "error", "diagnoses": [diagnosis_json(diagnosis) for diagnosis in diagnoses]})


def _dump(document: Json) -> str:
    return json.dumps(document, indent=2, ensure_ascii=False, allow_nan=False)


def finite(values: Mapping[str, Value]) -> dict[str, Value]:
    """The values that JSON can carry."""
    return {name: value for name, value in values.items() if isinstance(value, str) or isfinite(value)}


def _proof(answer: Solution, shown: Mapping[str, Value]) -> Json:
    """What was proved of an answer, and what is next to a double root that is not there."""
    assert answer.proof is not None
    radius = {name: answer.radius[name] for name in shown if name in answer.radius}
    found: Json = {"proved": answer.proof.proved, "radius": radius}
    if (beside := answer.proof.beside) is not None:
        apart = {name: distance for name, distance in beside.apart.items() if name in shown}
        found["beside"] = {"roots": beside.roots, "apart": apart}
    return found


def diagnosis_json(diagnosis: Diagnosis) -> Json:
    return {
        "code": diagnosis.code,
        "severity": str(diagnosis.severity),
        "message": diagnosis.message,
        "notes": list(diagnosis.notes),
        "rules": [_place(label.span) for label in diagnosis.labels],
        "variables": list(diagnosis.variables),
    }


def _place(span: Span) -> Json:
    return {"file": span.file, "line": span.line, "text": " ".join(span.text.split())}


def _step(model: Model, step: Step) -> Json:
    found: Json = {"step": type(step).__name__.lower()}
    match step:
        case Evaluate(_, unknown, branches) | Select(_, unknown, branches):
            found |= {"unknowns": [unknown], "branches": branches}
        case SolveBlock(_, unknowns, tears):
            found |= {"step": "block", "unknowns": list(unknowns), "tears": list(tears)}
        case Decide() | Assume():
            asked = step.conditions if isinstance(step, Decide) else (step.condition,)
            return found | {"conditions": [format_condition(model.conditions[index]) for index in asked]}
    return found | {"rules": [_place(model.equations[index].rule) for index in equations_of(step)]}
