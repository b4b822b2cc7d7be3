"""A result as text: its variable sheet, how it was found, and what is wrong with it."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator, Sequence
from math import isfinite
from typing import NamedTuple

from rulesheets.diagnosis import plural, render
from rulesheets.format import readable
from rulesheets.model import Equation, Requirement
from rulesheets.syntax import Span, escaped
from solver.facts import Attempt, Proof, ProvedRoots, Status
from solver.path import Evaluate, Path, Select, SolveBlock
from solver.report import SCREEN, fits, table
from solver.report.path import Places, path_text, rule_text
from solver.report.sheet import (
    SheetRow,
    answers,
    certain,
    displayed,
    local_rows,
    magnitude,
    pruned,
    sheet_heads,
    sheet_rows,
    tolerated,
)
from solver.result import Result

WAITING, BLAMED = "*", ">"

LIMIT = 12
"""Rows shown; the rest is counted."""

LONGEST = 72
"""Characters of a rule shown; its place tells where to read on."""


class RuleStatus(NamedTuple):
    """``mark`` is ``>`` for a rule that a diagnosis points at, ``*`` for one that waits for unknowns.

    Rules wait where the inputs do not determine everything; where a solve has ended otherwise,
    what comes after it is not worth telling.
    """

    mark: str
    equation: Equation | Requirement
    waits_for: tuple[str, ...]


def rule_statuses(result: Result) -> tuple[RuleStatus, ...]:
    """The rules that are not satisfied, those blamed first and once, others once a call."""
    if result.status is Status.SOLVED:
        return ()
    found: dict[tuple[Span, str], RuleStatus] = {}
    for status in _statuses(result):
        scope = "" if status.mark == BLAMED else status.equation.scope
        found.setdefault((status.equation.rule, scope), status)
    return tuple(sorted(found.values(), key=lambda status: status.mark != BLAMED))


def rule_status_table(result: Result) -> str:
    """The statuses as a table, empty where every rule is satisfied."""
    statuses = rule_statuses(result)
    if not statuses:
        return ""
    places = Places(result.model)
    shown = statuses[:LIMIT]
    rows = ((s.mark, places.of(s.equation), _clipped(s.equation), _few(s.waits_for, NAMED)) for s in shown)
    head = ("St", "Place", "Rule", "Waits for" if any(s.waits_for for s in shown) else "")
    text = table(head, rows, soft=(2, 3))
    hidden = len(statuses) - len(shown)
    return f"{text}\n… and {hidden} more" if hidden else text


def _statuses(result: Result) -> Iterator[RuleStatus]:
    blamed = {(label.span.file, label.span.start) for d in result.diagnoses for label in d.labels}
    (known,) = answers(result, every=False)
    partial = result.status is Status.PARTIAL
    rules: tuple[Equation | Requirement, ...] = (*result.model.equations, *result.model.requirements)
    for equation in rules:
        waits_for = tuple(name for name in equation.names if name not in known)
        if (equation.rule.file, equation.rule.start) in blamed:
            yield RuleStatus(BLAMED, equation, waits_for)
        elif partial and waits_for:
            yield RuleStatus(WAITING, equation, waits_for)


def _clipped(equation: Equation | Requirement) -> str:
    text = rule_text(equation.rule)
    return text if len(text) <= LONGEST else text[: LONGEST - 2] + " …"


NAMED, NAMES = 4, 6
"""Names that a cell, and that a sentence lists at most."""


def _few(names: Sequence[str], most: int) -> str:
    return ", ".join([*names[:most], "…"] if len(names) > most else names)


def attempts_text(result: Result) -> str:
    """A table of blocks and methods; nothing where no block was solved."""
    rows = [row for block, attempts in result.attempts.items() for row in _rows(block, attempts)]
    return "Methods\n" + table(("Block", "Method", "Found"), rows) if rows else ""


def _rows(block: SolveBlock, attempts: tuple[Attempt, ...]) -> Iterator[tuple[str, ...]]:
    names = _few(block.unknowns, NAMED)
    for place, attempt in enumerate(attempts):
        method = attempt.method.told.format(tear=", ".join(block.tears))
        if attempt.iterations:
            method += f", {plural(attempt.iterations, 'iteration')}"
        yield ("" if place else names, method, _found(attempt))


def _found(attempt: Attempt) -> str:
    found = plural(attempt.found, "answer") if attempt.found else "nothing"
    return f"{found}, proven to be all" if attempt.complete else found


def conditions_text(result: Result) -> Iterator[str]:
    """A table of the blocks of the primary answer, where it has any.

    The condition is that of the Jacobian of the block by its unknowns, rules and unknowns scaled: how
    many times larger a rounding error comes out than it went in.
    """
    if not result.solutions or not (blocks := result.solutions[0].accuracy.blocks):
        return
    rows = []
    for block in blocks.values():
        condition = f"{block.condition:.1e}" if isfinite(block.condition) else "infinite"
        rows.append((_few(block.unknowns, NAMES), f"{block.rank} of {len(block.unknowns)}", condition))
    yield "Blocks\n" + table(("Unknowns", "Rank", "Condition"), rows)


def proof_lines(result: Result) -> Iterator[str]:
    """Whether each answer is proved, how far the numbers may be off at most, and whether these are all."""
    proofs = [solution.proof for solution in result.solutions if solution.proof is not None]
    if proofs and result.status is Status.SINGULAR:
        yield from _singular(proofs)
    if not proofs or result.status is not Status.SOLVED:
        return
    proved = [proof for proof in proofs if proof.proved]
    if len(proved) < len(proofs):
        yield f"not proved: {next(p.obstacle for p in proofs if not p.proved)}"
    if proved:
        worst = max(max(proof.radius.values(), default=0.0) for proof in proved)
        nearest = "every number the float nearest to the exact one" if all(p.nearest for p in proved) else ""
        radius = nearest or f"every number within {worst:.0e}"
        yield f"proved: {plural(len(proved), 'answer')}, {radius}"
    if result.complete and len(proved) == len(proofs):
        yield "proved: there is no other answer" if len(proofs) == 1 else "proved: there are no others"


def _singular(proofs: list[Proof]) -> Iterator[str]:
    """Whether a double root is exactly there, or a hair decides: which way, where that is proved."""
    for proof in proofs:
        if proof.double:
            names = ", ".join(proof.double)
            yield f"proved: the rules of {names} hold exactly, with a singular Jacobian: a double root"
        elif proof.beside is not None:
            yield f"proved: for the numbers exactly as they are {_beside(proof.beside)}"
    if not any(proof.double or proof.beside for proof in proofs):
        yield "not proved: a hair decides whether there are two answers, one or none"


def _beside(found: ProvedRoots) -> str:
    """What is next to a double root that is not there."""
    if not found.roots:
        return f"there is no answer here for {', '.join(found.unknowns)}, but only just"
    far = ", ".join(f"{name} {distance:.2g}" for name, distance in found.apart.items() if distance)
    return f"there are two answers, this far apart: {far}"


def work_line(result: Result) -> str:
    """``29 rules: 27 direct, 1 block of 2; all satisfied, worst residual 1e-16``.

    Rules are counted by equation: a tuple counts for each of its halves, a rule function
    once a call. The last part is there where there is an answer, or a part of one.
    """
    rules = plural(len(result.model.equations), "rule")
    line = f"{rules}: {', '.join(_parts(result))}"
    if not result.solutions or not result.solutions[0].checked:
        return line
    answer = result.solutions[0]
    satisfied = "all" if result.status is Status.SOLVED else str(answer.checked)
    return f"{line}; {satisfied} satisfied, worst residual {magnitude(answer.worst_residual)}"


def used(path: Path) -> int:
    """How many equations the path solves with."""
    return direct(path) + sum(block_sizes(path))


def direct(path: Path) -> int:
    return sum(isinstance(step, Evaluate | Select) for step in path.steps)


def block_sizes(path: Path) -> tuple[int, ...]:
    """Number of unknowns of each simultaneous block, in order."""
    return tuple(len(step.unknowns) for step in path.steps if isinstance(step, SolveBlock))


def _parts(result: Result) -> list[str]:
    path, total = result.path, len(result.model.equations)
    sizes = block_sizes(path)
    parts = [f"{direct(path)} direct"] if direct(path) or not sizes else []
    if sizes:
        parts.append(_blocks(sizes))
    if not result.solutions:
        return parts
    active = result.solutions[0].checked
    checks, idle = active - used(path), total - max(active, used(path))
    if checks > 0:
        parts.append(plural(checks, "check"))
    if idle > 0:
        parts.append(f"{idle} idle")
    return parts


def _blocks(sizes: Sequence[int]) -> str:
    low, high = min(sizes), max(sizes)
    size = f"{low}" if low == high else f"{low} to {high}"
    return f"{plural(len(sizes), 'block')} of {size}"


NUMBER_WIDTH = 16
"""Cells of an output: a number with ten digits, a sign and an exponent."""

INPUT_WIDTH = 10
ANSWER = "bold"
STATUSES = {
    Status.PARTIAL: "bold yellow",
    Status.SINGULAR: "bold yellow",
    Status.INCONSISTENT: "bold red",
    Status.INFEASIBLE: "bold red",
    Status.FAILED: "bold red",
}
"""How the word of a status is set off on a terminal."""

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

    ``every`` puts all answers side by side; ``explain`` adds the locals, the path, and how
    many rules were needed; ``digits`` prints every number with the digits that are right.
    """
    rows = displayed(result, sheet_rows(result, every=every, digits=digits))
    parts = [sheet_table(rows)]
    if explain:
        parts.extend(_explanation(result, every, digits))
    parts.append("\n".join(_verdict(result, every)))
    if result.status is not Status.SOLVED or result.diagnoses:
        parts.extend(_complaints(result, color))
    return "\n\n".join(part for part in parts if part)


def _complaints(result: Result, color: bool) -> Iterator[str]:
    yield rule_status_table(result)
    width = SCREEN.get().width
    yield from (render(diagnosis, color=color, width=width) for diagnosis in result.diagnoses)


def sheet_table(rows: Iterable[SheetRow]) -> str:
    """The variable sheet as in print, one output column an answer."""
    rows = tuple(rows)
    header = sheet_heads(rows)
    count = len(header) - 5
    names = max((len(row.name) for row in rows), default=0)
    least = (0, INPUT_WIDTH, names, *(NUMBER_WIDTH,) * count)
    cells = [_cells(row) for row in rows]
    if count > 1 and not fits(header, cells):
        return _turned(rows)
    return table(header, cells, least, styles=("", "", "", *(ANSWER,) * count, "", "dim"))


def _turned(rows: Sequence[SheetRow]) -> str:
    """Many answers on a narrow screen: what is given, then a line for each answer."""
    given = [row for row in rows if not any(v is not None for v in row.outputs)]
    found = [row for row in rows if row not in given]
    parts = [sheet_table(row._replace(outputs=(None,), errors=()) for row in given)] if given else []
    parts += [_answers(group) for group in _groups(found)]
    return "\n\n".join(parts)


def _groups(rows: Sequence[SheetRow]) -> Iterator[list[SheetRow]]:
    """Variables in groups that fit side by side, one at least."""
    group: list[SheetRow] = []
    for row in rows:
        if group and not fits(*_lines([*group, row])):
            yield group
            group = []
        group.append(row)
    if group:
        yield group


def _answers(rows: Sequence[SheetRow]) -> str:
    return table(*_lines(rows), styles=("dim", *(ANSWER,) * len(rows)), soft=())


def _lines(rows: Sequence[SheetRow]) -> tuple[tuple[str, ...], list[tuple[str, ...]]]:
    """A table of answers: names across, answers down. Its last column is empty, for nothing is cut."""
    head = (f"{row.name} [{row.unit}]" if row.unit else row.name for row in rows)
    values = zip(*(_outputs(row) for row in rows), strict=True)
    return ("Answer", *head, ""), [(str(k), *line, "") for k, line in enumerate(values, 1)]


def _outputs(row: SheetRow) -> tuple[str, ...]:
    return tuple(map(certain, row.outputs, row.errors) if row.errors else map(readable, row.outputs))


def _cells(row: SheetRow) -> tuple[str, ...]:
    given = tolerated(readable(row.input), row.tolerance)
    return (row.status, given, row.name, *_outputs(row), row.unit, row.comment)


def _explanation(result: Result, every: bool, digits: bool) -> Iterator[str]:
    rows = displayed(result, local_rows(result, every=every, digits=digits))
    if rows:
        yield "Locals\n" + sheet_table(rows)
    yield "Path\n" + path_text(result)
    yield attempts_text(result)
    yield from conditions_text(result)
    yield from (render(gap) for gap in result.gaps if gap not in result.diagnoses)
    yield _used(result)


def _used(result: Result) -> str:
    """How many of the rules were used, and what for where not everything was asked for."""
    count, whole = used(result.path), len(result.model.equations)
    said = f"Used {count} of {plural(whole, 'rule')}"
    if result.status is not Status.SOLVED or not pruned(result) or count == whole:
        return f"{said}."
    return f"{said}: no more is needed for {_few(result.wanted, NAMES)}."


def _verdict(result: Result, every: bool) -> Iterator[str]:
    if result.status is not Status.SOLVED:
        word = SCREEN.get().paint(str(result.status), STATUSES[result.status])
        yield f"{word}: {MEANINGS[result.status]}"
    yield work_line(result)
    if any(solution.proof for solution in result.solutions):
        yield from proof_lines(result)
    yield from _others(result, every)
    yield from _unlikely(result, every)


def _unlikely(result: Result, every: bool) -> Iterator[str]:
    """Which of the answers shown have numbers far from anything that the inputs suggest."""
    for number, answer in enumerate(result.solutions if every else result.solutions[:1], start=1):
        if answer.unlikely:
            which = f"answer {number}" if every and len(result.solutions) > 1 else "this answer"
            yield f"{which} is of unlikely size: {', '.join(answer.unlikely[:NAMES])}"


def _others(result: Result, every: bool) -> Iterator[str]:
    """How many other answers there are, and whether these are all; if not, for which unknowns, and why."""
    others = len(result.solutions) - 1
    if others > 0 and not every:
        more = "" if result.complete else ", maybe more"
        yield f"{plural(others, 'other answer')}{more}: --all shows {'it' if others == 1 else 'them'}"
    if result.status is not Status.SOLVED or result.complete:
        return
    if others <= 0 or every:
        some = "these are not known to be all the answers" if others else "there may be other answers"
        yield f"{some}{_open_block(result)}"


def _open_block(result: Result) -> str:
    """Of which unknowns, by which rule, there may be more values than were found."""
    gap = next((gap for gap in result.gaps if gap.labels), None)
    if gap is None:
        return next((f": {note.message}" for note in result.diagnoses if note.code == "S597"), "")
    span = gap.labels[0].span
    place = f"{escaped(os.path.basename(span.file))}:{span.line}"
    return f": {_few(gap.variables, NAMES)} by {place}, which could not be searched whole (--explain)"
