"""Details below a variable sheet: rules that are not satisfied, methods, conditions, proofs."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from math import isfinite

from rulesheets.diagnosis import plural
from rulesheets.model import Equation, Requirement
from rulesheets.syntax.source import Span
from solver.attempts import Attempt
from solver.path.steps import SolveBlock
from solver.report.path import Places, rule_text
from solver.report.sheet import answers
from solver.report.table import table
from solver.result import Result, Status
from solver.solution.proof import Beside, Proof

WAITING, BLAMED = "*", ">"

LIMIT = 12
"""Rows shown; the rest is counted."""

LONGEST = 72
"""Characters of a rule shown; its place tells where to read on."""


@dataclass(frozen=True, slots=True)
class RuleStatus:
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
    rows = ((s.mark, places.of(s.equation), _clipped(s.equation), _waiting(s)) for s in shown)
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


def _waiting(status: RuleStatus) -> str:
    names = status.waits_for
    return ", ".join(names[:4]) + (", …" if len(names) > 4 else "")


NAMED = 4
"""Unknowns of a block that name it."""


def attempts_text(result: Result) -> str:
    """A table of blocks and methods; nothing where no block was solved."""
    rows = [row for block, attempts in result.attempts.items() for row in _rows(block, attempts)]
    return "Methods\n" + table(("Block", "Method", "Found"), rows) if rows else ""


def _rows(block: SolveBlock, attempts: tuple[Attempt, ...]) -> Iterator[tuple[str, ...]]:
    names = ", ".join(block.unknowns[:NAMED]) + (", …" if len(block.unknowns) > NAMED else "")
    for place, attempt in enumerate(attempts):
        method = attempt.method.told.format(tear=", ".join(block.tears))
        if attempt.iterations:
            method += f", {plural(attempt.iterations, 'iteration')}"
        yield ("" if place else names, method, _found(attempt))


def _found(attempt: Attempt) -> str:
    found = plural(attempt.found, "answer") if attempt.found else "nothing"
    return f"{found}, proven to be all" if attempt.complete else found


NAMES = 6
"""Unknowns of a block that a row names at most."""


def conditions_text(result: Result) -> Iterator[str]:
    """A table of the blocks of the primary answer, where it has any.

    The condition is that of the Jacobian of the block by its unknowns, rules and unknowns scaled: how
    many times larger a rounding error comes out than it went in.
    """
    if not result.solutions or not (blocks := result.solutions[0].accuracy.blocks):
        return
    rows = []
    for block in blocks.values():
        rest = "" if len(block.unknowns) <= NAMES else ", …"
        names = ", ".join(block.unknowns[:NAMES]) + rest
        condition = f"{block.condition:.1e}" if isfinite(block.condition) else "infinite"
        rows.append((names, f"{block.rank} of {len(block.unknowns)}", condition))
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


def _beside(found: Beside) -> str:
    """What is next to a double root that is not there."""
    if not found.roots:
        return f"there is no answer here for {', '.join(found.unknowns)}, by a hair"
    far = ", ".join(f"{name} {distance:.2g}" for name, distance in found.apart.items() if distance)
    return f"there are two answers, this far apart: {far}"
