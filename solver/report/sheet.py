"""The variable sheet: a result as rows, and as text, CSV and JSON."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from decimal import Context, Decimal
from math import ceil, inf, isfinite, log10
from typing import NamedTuple

from rulesheets.diagnosis import Diagnosis, few, plural, render
from rulesheets.inputs import COLUMNS, exact, guarded, readable
from rulesheets.model import Model, Tolerance, Value, Values
from rulesheets.syntax import Span, escaped
from rulesheets.units import shown
from solver.facts import Status
from solver.path import Assume, Decide, Evaluate, Path, Select, SolveBlock, Step, equations_of
from solver.report import SCREEN, fits, table
from solver.solution.solving import CUT, Result


def tolerated(text: str, tolerance: Tolerance | None) -> str:
    """``3 ± 0.01``: an input with its tolerance, in the syntax of a sheet."""
    if tolerance is None:
        return text
    return f"{text} ± {exact(tolerance.size)}{'%' if tolerance.percent else ''}"


def certain(value: Value | None, error: float) -> str:
    """A value with the digits that its error leaves: the last one may be off by one.

    All digits of the float if the error is 0; ``±1e-16`` if no digit is right.
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


GUESS = "G"


class SheetRow(NamedTuple):
    """A variable with its input or guess (``status`` is ``G``) and an output for each answer.

    ``errors``: the error bar of every output, on request. ``tolerance``: that of the input.
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
        """Its texts, one for each column."""
        outputs = map(tell, self.outputs)
        if self.errors:
            outputs = map(certain, self.outputs, self.errors)
        given = tolerated(tell(self.input), self.tolerance)
        return (self.status, given, self.name, *outputs, self.unit, self.comment)


def sheet_rows(
    result: Result,
    *,
    every: bool = False,
    digits: bool = False,
    others: bool = False,
    display: bool = True,
) -> tuple[SheetRow, ...]:
    """Rows in the order of the sheet, locals only if they are given or wanted.

    A variable that was not wanted and has no value is left out. ``digits`` adds the error bars.
    ``others`` are the rows that are left out instead; for a pruned solve those with a value. Values
    are in the units of ``display``, or in those of the rules.
    """
    answers = result.solutions if every else result.solutions[:1]
    found = [answer.by_name for answer in answers] or [result.partial]
    (posted, whole), rows = named(result), []
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
        errors = ([answer.error.get(name, 0.0) for answer in answers] or [inf]) if digits else []
        tolerance = variable.tolerance if isinstance(given, float) else None
        unit = variable.unit
        if display and variable.display_unit:
            unit = variable.display_unit
            values = [shown(v, variable) if isinstance(v, float) else v for v in values]
            errors = [abs(shown(error, variable, difference=True)) for error in errors]
            if tolerance is not None and not tolerance.percent:
                tolerance = Tolerance(abs(shown(tolerance.size, variable, difference=True)))
        status, (first, *outputs) = "" if guess is None else GUESS, values
        told = unit or "", variable.comment, tuple(errors), tolerance
        rows.append(SheetRow(status, first, name, tuple(outputs), *told))
    return tuple(rows)


def named(result: Result) -> tuple[dict[str, bool], bool]:
    """The variables that have a row, each with whether it has one even without a value; and whether
    all variables of the sheet were wanted. If not, those that calls only pass on have no row."""
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
    """The variable sheet as a text; ``every`` gives each answer a column ``Output 1``, …

    Numbers read back as the same floats. Read as a variable sheet, the text of the primary answer
    gives the same inputs and guesses again: outputs are not inputs.
    """
    from solver.files import csv_text

    rows = sheet_rows(result, every=every, display=False)
    return csv_text([sheet_heads(rows), *(map(guarded, row.cells(exact)) for row in rows)])


Json = dict[str, object]


def result_json(
    result: Result,
    *,
    explain: bool = False,
    digits: bool = False,
    also: Mapping[str, object] | None = None,
) -> str:
    """The object of a solve; ``explain`` adds locals (dotted names), ``digits`` the errors.

    ``also`` are further members, put at its end.
    """
    from solver.report.path import steps_to_show

    variables, (rows, _) = result.model.variables, named(result)
    names = [name for name in variables if explain or name in rows]
    known = ({n: answer[n] for n in names if n in answer} for answer in result.solutions)
    solutions = list(map(finite, known))
    both = list(zip(result.solutions, solutions, strict=True))
    # the units in which the rules compute, whatever a table shows
    valued = {name for some in solutions for name in some}
    units = {n: v.unit for n, v in variables.items() if v.unit and n in valued}
    document: Json = {"status": str(result.status), "solutions": solutions}
    if digits:  # null where nothing can be said
        bars = ({n: answer.error[n] for n in some if n in answer.error} for answer, some in both)
        document["errors"] = [{**dict.fromkeys(some), **finite(some)} for some in bars]
    proofs = list[Json]()
    for answer, some in both:
        if answer.proof is not None:
            radius = {name: answer.radius[name] for name in some if name in answer.radius}
            proofs.append({"proved": answer.proof.proved, "radius": radius})
    if proofs:
        document["proofs"] = proofs
    if any(answer.unlikely for answer in result.solutions):
        document["unlikely"] = [list(answer.unlikely) for answer in result.solutions]
    document |= {
        "complete": result.complete,
        "undetermined": list(result.undetermined),
        "diagnoses": list(map(diagnosis_json, result.diagnoses)),
        "path": [_step(result.model, step) for step in steps_to_show(result.path)],
        **({"units": units} if units else {}),
        **(also or {}),
    }
    return _dump(document)


def error_json(diagnoses: Iterable[Diagnosis]) -> str:
    """The object of a sheet or a command that is wrong: status ``error`` and the diagnoses."""
    return _dump({"status": "error", "diagnoses": list(map(diagnosis_json, diagnoses))})


def _dump(document: Json) -> str:
    return json.dumps(document, indent=2, ensure_ascii=False, allow_nan=False)


def finite(values: Values) -> dict[str, Value]:
    """The values that JSON can carry."""
    return {name: v for name, v in values.items() if isinstance(v, str) or isfinite(v)}


MOST_WARNINGS = 3
"""Warnings of units beside an answer."""


def with_warnings(result: Result, most: int = MOST_WARNINGS) -> Result:
    """The result with the warnings of units among its messages, the first ones where there are
    more; its status does not depend on them."""
    warnings = result.model.unit_warnings
    if len(warnings) > most:
        last = warnings[most - 1]
        rest = f"{len(warnings) - most} more such warnings: see backsolve check"
        warnings = (*warnings[: most - 1], last._replace(notes=(*last.notes, rest)))
    every = (*result.diagnoses, *warnings)
    return replace(result, explain=lambda: every) if warnings else result


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
            from rulesheets.format import format_condition

            told = [format_condition(model.conditions[index]) for index in step.conditions]
            return found | {"conditions": told}
    return found | {"rules": [_place(model.equations[index].rule) for index in equations_of(step)]}


NAMED, NAMES = 4, 6
"""Names that a cell, and that a sentence lists at most."""


def attempts_text(result: Result) -> str:
    """A table of blocks and methods; empty if no block was solved."""
    rows = []
    for block, attempts in result.attempts.items():
        names = few(block.unknowns, NAMED)
        for place, attempt in enumerate(attempts):
            method = attempt.method.description.format(tear=", ".join(block.tears))
            found = plural(attempt.found, "answer") if attempt.found else "nothing"
            found += ", proven to be all" * attempt.complete
            rows.append(("" if place else names, method, found))
    return "Methods\n" + table(("Block", "Method", "Found"), rows) if rows else ""


def conditions_text(result: Result) -> str:
    """A table of the blocks of the primary answer, if it has any.

    The condition is that of the Jacobian of the block by its unknowns, rules and unknowns scaled:
    the factor by which it amplifies rounding errors.
    """
    if not result.solutions or not (blocks := result.solutions[0].accuracy.blocks):
        return ""
    rows = []
    for block in blocks.values():
        condition = f"{block.condition:.1e}" if isfinite(block.condition) else "infinite"
        rank = f"{block.rank} of {len(block.unknowns)}"
        rows.append((few(block.unknowns, NAMES), rank, condition))
    return "Blocks\n" + table(("Unknowns", "Rank", "Condition"), rows)


def proof_lines(result: Result) -> Iterator[str]:
    """Whether answers with a proof are proved, how exactly, and whether these are all.

    For a double root: whether it is exact.
    """
    proofs = [solution.proof for solution in result.solutions if solution.proof is not None]
    proved = [proof for proof in proofs if proof.proved]
    if result.status is Status.SINGULAR:
        for proof in proofs:
            if proof.double:
                names = ", ".join(proof.double)
                exactly = "hold exactly, with a singular Jacobian: a double root"
                yield f"proved: the rules of {names} {exactly}"
        if not any(proof.double for proof in proofs):
            yield "not proved: rounding decides whether there are two answers, one or none"
    if result.status is not Status.SOLVED:
        return
    if len(proved) < len(proofs):
        yield f"not proved: {next(p.obstacle for p in proofs if not p.proved)}"
    if proved:
        worst = max(max(proof.radius.values(), default=0.0) for proof in proved)
        radius = f"every number within {worst:.0e}"
        if all(proof.nearest for proof in proved):
            radius = "every number the float nearest to the exact one"
        yield f"proved: {plural(len(proved), 'answer')}, {radius}"
    if result.complete and len(proved) == len(proofs):
        yield f"proved: there {'is no other answer' if len(proofs) == 1 else 'are no others'}"


def work_line(result: Result) -> str:
    """``29 rules: 27 direct, 1 block of 2; all satisfied, worst residual 1e-16``.

    Rules are counted by equation: a tuple counts for each of its halves, a rule function once a
    call. The last part appears if there is an answer, or a part of one.
    """
    direct, sizes = _counted(result.path)
    used, total = direct + sum(sizes), len(result.model.equations)
    parts = [f"{direct} direct"] if direct or not sizes else []
    if sizes:
        low, high = min(sizes), max(sizes)
        parts.append(f"{plural(len(sizes), 'block')} of {low}" + f" to {high}" * (low < high))
    if not result.solutions:
        return f"{plural(total, 'rule')}: {', '.join(parts)}"
    checked, worst = result.solutions[0].checked, result.solutions[0].worst_residual
    parts += [plural(checked - used, "check")] * (checked > used)
    parts += [f"{total - max(checked, used)} idle"] * (total > max(checked, used))
    undefined = {label.span for d in result.diagnoses if d.code == "S545" for label in d.labels}
    refused = sum(equation.rule in undefined for equation in result.model.equations)
    held = ""
    if checked > refused:
        satisfied = "all" if result.status is Status.SOLVED else str(checked - refused)
        held = f"; {satisfied} satisfied, worst residual {f'{worst:.0e}' if worst else '0'}"
    return f"{plural(total, 'rule')}: {', '.join(parts)}{held}"


def _counted(path: Path) -> tuple[int, list[int]]:
    """The direct steps of a path, and the number of unknowns of each of its blocks, in order."""
    direct = sum(isinstance(step, Evaluate | Select) for step in path.steps)
    return direct, [len(step.unknowns) for step in path.steps if isinstance(step, SolveBlock)]


NUMBER_WIDTH = 16
"""Cells of an output: a number with ten digits, a sign and an exponent."""

INPUT_WIDTH = 10
ANSWER = "bold"
MEANINGS = {
    Status.PARTIAL: "the inputs do not determine every variable",
    Status.INCONSISTENT: "rules contradict each other at these inputs",
    Status.INFEASIBLE: "there is no real solution",
    Status.SINGULAR: "an answer is not isolated, or not determined there",
    Status.FAILED: "no answer was found within the limits",
}


def result_text(
    result: Result, *, every: bool = False, explain: bool = False, digits: bool = False
) -> str:
    """Everything that ``backsolve solve`` prints, without the last line end.

    ``every`` puts all answers side by side; ``explain`` adds the locals, the path, and the number
    of rules used; ``digits`` prints every number with the digits that are right.
    """
    parts = [sheet_table(sheet_rows(result, every=every, digits=digits))]
    if explain:
        parts.extend(_explanation(result, every, digits))
    parts.append("\n".join(_verdict(result, every)))
    if result.status is not Status.SOLVED:
        from solver.report.path import rule_status_table

        parts.append(rule_status_table(result))
    parts.extend(SCREEN.get().said(result.diagnoses))
    return "\n\n".join(part for part in parts if part)


def sheet_table(rows: Sequence[SheetRow]) -> str:
    """The variable sheet as printed, one output column for each answer."""
    header = sheet_heads(rows)
    count = len(header) - 5
    names = max((len(row.name) for row in rows), default=0)
    least = (0, INPUT_WIDTH, names, *(NUMBER_WIDTH,) * count)
    cells = [row.cells() for row in rows]
    if count > 1 and not fits(header, cells):
        return _turned(rows)
    return table(header, cells, least, styles=("", "", "", *(ANSWER,) * count, "", "dim"))


def _turned(rows: Sequence[SheetRow]) -> str:
    """Many answers on a narrow screen: inputs, then tables that fit, a line for each answer."""
    given = [row for row in rows if not any(v is not None for v in row.outputs)]
    parts = []
    if given:
        parts.append(sheet_table([row._replace(outputs=(None,), errors=()) for row in given]))
    groups: list[list[SheetRow]] = [[]]
    for row in (row for row in rows if row not in given):
        if groups[-1] and not fits(*_lines([*groups[-1], row])):
            groups.append([])
        groups[-1].append(row)
    styles = ("dim", *(ANSWER,) * len(rows))
    for group in filter(None, groups):
        parts.append(table(*_lines(group), styles=styles[: len(group) + 1], soft=()))
    return "\n\n".join(parts)


def _lines(rows: Sequence[SheetRow]) -> tuple[tuple[str, ...], list[tuple[str, ...]]]:
    """A table with names across and answers down; an empty last column, so none is cut."""
    head = (f"{row.name} [{row.unit}]" if row.unit else row.name for row in rows)
    values = zip(*(row.cells()[3:-2] for row in rows), strict=True)
    return ("Answer", *head, ""), [(str(k), *line, "") for k, line in enumerate(values, 1)]


def _explanation(result: Result, every: bool, digits: bool) -> Iterator[str]:
    from solver.path.planner import PathTree
    from solver.report.path import tree_text

    rows = sheet_rows(result, every=every, digits=digits, others=True)
    if rows:
        yield "Locals\n" + sheet_table(rows)
    yield "Path\n" + tree_text(result.model, PathTree(result.path), result.wanted)
    yield attempts_text(result)
    yield conditions_text(result)
    yield from (render(gap) for gap in result.gaps if gap not in result.diagnoses)
    direct, sizes = _counted(result.path)
    yield f"Used {direct + sum(sizes)} of {plural(len(result.model.equations), 'rule')}."


def _verdict(result: Result, every: bool) -> Iterator[str]:
    """The status, the work, its proofs, other answers, and which are unlikely."""
    if result.status is not Status.SOLVED:
        color = "yellow" if result.status in (Status.PARTIAL, Status.SINGULAR) else "red"
        status = SCREEN.get().paint(str(result.status), f"bold {color}")
        yield f"{status}: {MEANINGS[result.status]}"
    yield work_line(result)
    if any(solution.proof for solution in result.solutions):
        yield from proof_lines(result)
    others = len(result.solutions) - 1
    hidden = others > 0 and not every
    if hidden:
        more = "" if result.complete else ", maybe more"
        them = "it" if others == 1 else "them"
        yield f"{plural(others, 'other answer')}{more}: --all shows {them}"
    elif result.status is Status.SOLVED and not result.complete:
        some = "there may be other answers"
        if others:
            some = "these are not known to be all the answers"
        why = next((f": {note.message}" for note in result.diagnoses if note.code == "S597"), "")
        # of which unknowns, by which rule
        if gap := next((gap for gap in result.gaps if gap.labels), None):
            span = gap.labels[0].span
            place = f"{escaped(os.path.basename(span.file))}:{span.line}"
            names = few(gap.variables, NAMES)
            lack = "has more than are listed" if gap.code == CUT else "could not be searched whole"
            why = f": {names} by {place}, which {lack} (--explain)"
        yield some + why
    shown = result.solutions if every else result.solutions[:1]
    for number, answer in enumerate(shown, start=1):
        if answer.unlikely:
            which = f"answer {number}" if len(shown) > 1 else "this answer"
            yield f"{which} is of unlikely size: {', '.join(answer.unlikely[:NAMES])}"
