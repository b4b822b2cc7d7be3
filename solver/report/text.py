"""A result as text: its variable sheet, how it was found, and what is wrong with it."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from math import isfinite

from rulesheets.diagnosis import plural, render
from rulesheets.syntax import escaped
from solver.facts import Status
from solver.path import Evaluate, Path, Select, SolveBlock
from solver.report import SCREEN, few, fits, table
from solver.report.sheet import SheetRow, magnitude, sheet_heads, sheet_rows
from solver.solution.solving import Result

NAMED, NAMES = 4, 6
"""Names that a cell, and that a sentence lists at most."""


def attempts_text(result: Result) -> str:
    """A table of blocks and methods; nothing where no block was solved."""
    rows = []
    for block, attempts in result.attempts.items():
        names = few(block.unknowns, NAMED)
        for place, attempt in enumerate(attempts):
            method = attempt.method.told.format(tear=", ".join(block.tears))
            if attempt.iterations:
                method += f", {plural(attempt.iterations, 'iteration')}"
            found = plural(attempt.found, "answer") if attempt.found else "nothing"
            found += ", proven to be all" * attempt.complete
            rows.append(("" if place else names, method, found))
    return "Methods\n" + table(("Block", "Method", "Found"), rows) if rows else ""


def conditions_text(result: Result) -> str:
    """A table of the blocks of the primary answer, where it has any.

    The condition is that of the Jacobian of the block by its unknowns, rules and unknowns scaled: how
    many times larger a rounding error comes out than it went in.
    """
    if not result.solutions or not (blocks := result.solutions[0].accuracy.blocks):
        return ""
    rows = []
    for block in blocks.values():
        condition = f"{block.condition:.1e}" if isfinite(block.condition) else "infinite"
        rows.append((few(block.unknowns, NAMES), f"{block.rank} of {len(block.unknowns)}", condition))
    return "Blocks\n" + table(("Unknowns", "Rank", "Condition"), rows)


def proof_lines(result: Result) -> Iterator[str]:
    """Whether each answer with a proof is proved, how far its numbers may be off, and whether these are all.

    Of a double root: whether it is exactly there, or a hair decides; which way, where that is proved.
    """
    proofs = [solution.proof for solution in result.solutions if solution.proof is not None]
    proved = [proof for proof in proofs if proof.proved]
    if result.status is Status.SINGULAR:
        for proof in proofs:
            if proof.double:
                names = ", ".join(proof.double)
                yield f"proved: the rules of {names} hold exactly, with a singular Jacobian: a double root"
            elif proof.beside is not None:
                apart = (
                    f"{name} {distance:.2g}" for name, distance in proof.beside.apart.items() if distance
                )
                said = f"there is no answer here for {', '.join(proof.beside.unknowns)}, but only just"
                if proof.beside.roots:
                    said = f"there are two answers, this far apart: {', '.join(apart)}"
                yield f"proved: for the numbers exactly as they are {said}"
        if not any(proof.double or proof.beside for proof in proofs):
            yield "not proved: a hair decides whether there are two answers, one or none"
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
        yield "proved: there is no other answer" if len(proofs) == 1 else "proved: there are no others"


def work_line(result: Result) -> str:
    """``29 rules: 27 direct, 1 block of 2; all satisfied, worst residual 1e-16``.

    Rules are counted by equation: a tuple counts for each of its halves, a rule function
    once a call. The last part is there where there is an answer, or a part of one.
    """
    direct, sizes = _counted(result.path)
    used, total = direct + sum(sizes), len(result.model.equations)
    parts = [f"{direct} direct"] if direct or not sizes else []
    if sizes:
        low, high = min(sizes), max(sizes)
        parts.append(f"{plural(len(sizes), 'block')} of {low}" + f" to {high}" * (low < high))
    if not result.solutions:
        return f"{plural(total, 'rule')}: {', '.join(parts)}"
    checked, worst = result.solutions[0].checked, magnitude(result.solutions[0].worst_residual)
    parts += [plural(checked - used, "check")] * (checked > used)
    parts += [f"{total - max(checked, used)} idle"] * (total > max(checked, used))
    satisfied = "all" if result.status is Status.SOLVED else str(checked)
    held = f"; {satisfied} satisfied, worst residual {worst}" * bool(checked)
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
    result: Result, *, every: bool = False, explain: bool = False, digits: bool = False, color: bool = False
) -> str:
    """Everything that ``backsolve solve`` prints, without the last line end.

    ``every`` puts all answers side by side; ``explain`` adds the locals, the path, and
    the methods of its blocks; ``digits`` prints every number with the digits that are right.
    """
    parts = [sheet_table(sheet_rows(result, every=every, digits=digits))]
    if explain:
        parts.extend(_explanation(result, every, digits))
    parts.append("\n".join(_verdict(result, every)))
    if result.status is not Status.SOLVED:
        from solver.report.path import rule_status_table  # a sheet that is solved does without

        parts.append(rule_status_table(result))
    width = SCREEN.get().width
    parts.extend(render(diagnosis, color=color, width=width) for diagnosis in result.diagnoses)
    return "\n\n".join(part for part in parts if part)


def sheet_table(rows: Sequence[SheetRow]) -> str:
    """The variable sheet as in print, one output column an answer."""
    header = sheet_heads(rows)
    count = len(header) - 5
    names = max((len(row.name) for row in rows), default=0)
    least = (0, INPUT_WIDTH, names, *(NUMBER_WIDTH,) * count)
    cells = [row.cells() for row in rows]
    if count > 1 and not fits(header, cells):
        return _turned(rows)
    return table(header, cells, least, styles=("", "", "", *(ANSWER,) * count, "", "dim"))


def _turned(rows: Sequence[SheetRow]) -> str:
    """Many answers on a narrow screen: what is given, then tables of variables that fit side by side, a line
    for each answer."""
    given = [row for row in rows if not any(v is not None for v in row.outputs)]
    parts = [sheet_table([row._replace(outputs=(None,), errors=()) for row in given])] if given else []
    groups: list[list[SheetRow]] = [[]]
    for row in (row for row in rows if row not in given):
        if groups[-1] and not fits(*_lines([*groups[-1], row])):
            groups.append([])
        groups[-1].append(row)
    styles = ("dim", *(ANSWER,) * len(rows))
    parts += (table(*_lines(group), styles=styles[: len(group) + 1], soft=()) for group in groups if group)
    return "\n\n".join(parts)


def _lines(rows: Sequence[SheetRow]) -> tuple[tuple[str, ...], list[tuple[str, ...]]]:
    """A table of answers: names across, answers down. Its last column is empty, for nothing is cut."""
    head = (f"{row.name} [{row.unit}]" if row.unit else row.name for row in rows)
    values = zip(*(row.cells()[3:-2] for row in rows), strict=True)
    return ("Answer", *head, ""), [(str(k), *line, "") for k, line in enumerate(values, 1)]


def _explanation(result: Result, every: bool, digits: bool) -> Iterator[str]:
    from solver.report.path import path_text

    rows = sheet_rows(result, every=every, digits=digits, others=True)
    if rows:
        yield "Locals\n" + sheet_table(rows)
    yield "Path\n" + path_text(result)
    yield attempts_text(result)
    yield conditions_text(result)
    yield from (render(gap) for gap in result.gaps if gap not in result.diagnoses)


def _verdict(result: Result, every: bool) -> Iterator[str]:
    """The status, the work and its proofs, whether there are other answers, and which are unlikely."""
    if result.status is not Status.SOLVED:
        color = "yellow" if result.status in (Status.PARTIAL, Status.SINGULAR) else "red"
        yield f"{SCREEN.get().paint(str(result.status), f'bold {color}')}: {MEANINGS[result.status]}"
    yield work_line(result)
    if any(solution.proof for solution in result.solutions):
        yield from proof_lines(result)
    others = len(result.solutions) - 1
    hidden = others > 0 and not every
    if hidden:
        more = "" if result.complete else ", maybe more"
        yield f"{plural(others, 'other answer')}{more}: --all shows {'it' if others == 1 else 'them'}"
    elif result.status is Status.SOLVED and not result.complete:
        some = "these are not known to be all the answers" if others else "there may be other answers"
        why = next((f": {note.message}" for note in result.diagnoses if note.code == "S597"), "")
        if gap := next((gap for gap in result.gaps if gap.labels), None):  # of which unknowns, by which rule
            place = f"{escaped(os.path.basename(gap.labels[0].span.file))}:{gap.labels[0].span.line}"
            names = few(gap.variables, NAMES)
            why = f": {names} by {place}, which could not be searched whole (--explain)"
        yield some + why
    shown = result.solutions if every else result.solutions[:1]
    for number, answer in enumerate(shown, start=1):
        if answer.unlikely:
            which = f"answer {number}" if len(shown) > 1 else "this answer"
            yield f"{which} is of unlikely size: {', '.join(answer.unlikely[:NAMES])}"
