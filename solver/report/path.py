"""A solution path as text: unknowns and rules of each step; and rules that do not hold."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import cached_property

from rulesheets.diagnosis import few
from rulesheets.evaluate.number import rounded
from rulesheets.format import Latex, Notation, format_condition
from rulesheets.inputs import DIGITS, readable
from rulesheets.model import Equation, Model, Premise, Requirement, Value, Values
from rulesheets.syntax import Span, escaped, nodes
from rulesheets.syntax.nodes import Expression, conjunction, names, substitute
from solver.facts import Method, Status
from solver.kernel.block import kernel_of
from solver.kernel.solve_block import first_methods
from solver.path import (
    Assume,
    Check,
    Decide,
    Evaluate,
    Path,
    Select,
    SolveBlock,
    Step,
    equations_of,
)
from solver.path.planner import PathTree, planner, question
from solver.report import table
from solver.solution.solving import Result

_FIRST = re.compile(r"(^|\(|, )\((-[^()]*)\)(?!\^)")
"""A number below zero in parentheses with nothing to its left: its sign needs none."""


class Plain(Notation):
    """As in a rule sheet, numbers below zero in parentheses after a sign."""

    value = staticmethod(readable)

    def filled(self, node: Expression, values: Values) -> str:
        texts = ((name, readable(values[name])) for name in names(node))
        numbers = {n: nodes.Name(f"({t})" if t[0] == "-" else t) for n, t in texts}
        return _FIRST.sub(r"\1\2", self.written(substitute(node, numbers)))


class Tex(Latex):
    """LaTeX for mathematics mode."""

    def value(self, value: Value) -> str:
        return self.written(_rounded(value))

    def filled(self, node: Expression, values: Values) -> str:
        numbers = {name: _rounded(values[name]) for name in names(node)}
        return self.written(substitute(node, numbers))


def _rounded(value: Value) -> Expression:
    """A value with the digits for a reader."""
    if isinstance(value, str):
        return nodes.Symbol(value)
    return nodes.Number(rounded(value, DIGITS) + 0.0)


def rule_text(span: Span) -> str:
    """The rule as written, on one line, its inner spaces single."""
    return " ".join(span.text.split())


def short_names(files: Iterable[str]) -> Mapping[str, str]:
    """The shortest endings of file names that distinguish them: ``position.tk``."""
    found = {}
    names = tuple(dict.fromkeys(files))
    for name in names:
        parts = name.split("/")
        endings = ("/".join(parts[-length:]) for length in range(1, len(parts)))
        alone = (e for e in endings if sum(f"/{other}".endswith(f"/{e}") for other in names) == 1)
        found[name] = escaped(next(alone, name))
    return found


class Places:
    """``file:line`` of rules, the files by their shortest names; and the texts of rules."""

    def __init__(self, model: Model) -> None:
        self._model = model
        spans = [*(e.rule for e in model.equations), *(r.rule for r in model.requirements)]
        self._short = short_names(span.file for span in spans)

    @cached_property
    def groups(self) -> Mapping[tuple[str, Span], list[Equation]]:
        """The equations of each rule, once a call."""
        found: dict[tuple[str, Span], list[Equation]] = {}
        for equation in self._model.equations:
            found.setdefault((equation.scope, equation.rule), []).append(equation)
        return found

    def of(self, rule: Equation | Requirement) -> str:
        return f"{self._short[rule.rule.file]}:{rule.rule.line}"

    def rule(self, equation: Equation) -> tuple[str, str]:
        """The place of a rule, and its text."""
        return self.of(equation), self.said(equation)

    def said(self, equation: Equation) -> str:
        """The rule of an equation, or the arm of it in which the equation stands."""
        left, right = equation.left.span, equation.right.span
        arms = {one.guard for one in self.groups[equation.scope, equation.rule]}
        if len(arms) == 1 or not equation.guard or left is None or right is None or left == right:
            return rule_text(equation.rule)
        arm = f"{rule_text(left)} = {rule_text(right)}"
        last = equation.guard[-1]
        if not last.holds:
            return f"else {arm}"
        condition = self._model.conditions[last.condition].span
        return f"if {rule_text(condition) if condition else '…'} then {arm}"


def path_table(model: Model, path: Path, first: int = 1) -> str:
    """A line for each step: number, unknowns, number of branches, the rule and its place."""
    places, rows = Places(model), []
    for number, step in enumerate(steps_to_show(path), first):
        for found, ways, *rule in _rows(model, places, step):
            rows.append((str(number or ""), found, "" if ways == 1 else str(ways), *rule))
            number = 0
    return table(("Step", "Finds", "Ways", "Place", "By the rule"), rows)


def steps_to_show(path: Path) -> tuple[Step, ...]:
    """The steps to show: each once, without checks of an equation that was solved with."""
    steps = dict.fromkeys(path.steps)
    solved = {e for step in steps if not isinstance(step, Check) for e in equations_of(step)}
    return tuple(s for s in steps if not (isinstance(s, Check) and s.equation in solved))


def _rows(model: Model, places: Places, step: Step) -> Iterator[tuple[str, int, str, str]]:
    """The unknowns of a step, its number of branches, and its rules with their places."""

    def rule(index: int) -> tuple[str, str]:
        return places.rule(model.equations[index])

    match step:
        case Evaluate(equation, unknown, branches):
            yield unknown, branches, *rule(equation)
        case Select(equations, unknown, branches):
            first, *others = dict.fromkeys(map(rule, equations))
            yield unknown, branches, *first
            yield from (("  or by", 1, *other) for other in others)
        case SolveBlock(unknowns=unknowns, tears=tears):
            told = ", ".join(unknowns)
            if 0 < len(tears) < len(unknowns):
                told += f", iterating on {', '.join(tears)}"
            yield f"block of {len(unknowns)}", 1, "", told
            for one in step.order:
                yield f"  {one.unknown}", one.branches, *rule(one.equation)
            for index in step.residuals or step.equations:
                yield "  (closes)", 1, *rule(index)
            yield "  (tries)", 1, "", _methods(model, step)
        case Decide(conditions):
            for index in conditions:
                yield "(decides)", 1, "", f"whether {format_condition(model.conditions[index])}"
        case Assume(index):
            condition = format_condition(model.conditions[index])
            yield "(case by case)", 1, "", f"assuming {condition}, and not"
        case Check(equation):
            yield "(checks)", 1, *rule(equation)


def _methods(model: Model, block: SolveBlock) -> str:
    """The methods that the structure of a block admits, in the order in which they are tried."""
    kernel = kernel_of(planner(model).graph, block)
    methods = [Method.LINEAR] if kernel.linear else [*first_methods(kernel), Method.TRUST_REGION]
    names = dict.fromkeys(method.short.format(tear=", ".join(block.tears)) for method in methods)
    return ", ".join(names)


def tree_text(model: Model, tree: PathTree, wanted: Sequence[str]) -> str:
    """A table for the path and for each case, then how many answers there can be."""
    parts = list(_parts(model, tree, wanted, (), 1))
    last = "One answer at most." if tree.branches == 1 else f"At most {tree.branches} answers."
    if tree.branches is None:
        last = "Blocks can have any number of answers."
    if any(end.open for end in tree.ends()):
        last = "What follows depends on how the conditions come out, and on how many answers there "
        last += "are then."
    if tree.path.steps:
        parts.append(last)
    return "\n\n".join(parts) if tree.cases else "\n".join(parts)


def reaches(tree: PathTree, wanted: Sequence[str]) -> bool:
    """Whether some end of the tree, as far as it is known, leads to every wanted variable."""
    return any(end.open or not unreached(end.path, wanted) for end in tree.ends())


def unreached(path: Path, wanted: Iterable[str]) -> tuple[str, ...]:
    """The wanted variables that a path does not lead to."""
    beyond = set(path.undetermined)
    return tuple(name for name in wanted if name in beyond)


def _parts(
    model: Model, tree: PathTree, wanted: Sequence[str], outcomes: tuple[Premise, ...], first: int
) -> Iterator[str]:
    lines = []
    if outcomes:
        lines.append(f"Where {format_condition(conjunction(model.outcomes(outcomes)))}:")
    if tree.path.steps:
        lines.append(path_table(model, tree.path, first))
    else:
        lines.append("No rule gives anything more." if outcomes else "No rule gives anything.")
    if not question(tree.path) and (missing := unreached(tree.path, wanted)):
        lines.append(f"Not reached: {', '.join(missing)}.")
    yield "\n".join(lines)
    after = first + len(steps_to_show(tree.path))
    for case in tree.cases:
        yield from _parts(model, case.tree, wanted, (*outcomes, *case.outcomes), after)


WAITING, BLAMED = "*", ">"

LIMIT, NAMED = 12, 4
"""Rows shown, and names in a cell; the rest is counted."""

LONGEST = 72
"""Characters of a rule shown; the rest is found at its place."""


def rule_status_table(result: Result) -> str:
    """The rules that are not satisfied, those blamed first and once, others once a call.

    ``>`` marks a rule that a diagnosis points at, ``*`` one that waits for unknowns. Waiting rules
    are shown only if the inputs do not determine everything.
    """
    places, partial = Places(result.model), result.status is Status.PARTIAL
    blamed = {(label.span.file, label.span.start) for d in result.diagnoses for label in d.labels}
    known = result.solutions[0] if result.solutions else result.partial
    found: dict[tuple[str, Span, str], tuple[Equation | Requirement, tuple[str, ...]]] = {}
    rules: list[Equation | Requirement] = [*result.model.equations]
    for one in (*rules, *result.model.requirements):
        rule, waits_for = one.rule, tuple(name for name in one.names if name not in known)
        if (rule.file, rule.start) in blamed:
            found.setdefault((BLAMED, rule, ""), (one, waits_for))
        elif partial and waits_for:
            found.setdefault((WAITING, rule, one.scope), (one, waits_for))
    if not found:
        return ""
    first, hidden = sorted(found, key=lambda key: key[0] != BLAMED)[:LIMIT], len(found) - LIMIT
    shown = []
    for key in first:  # texts take long: none for the rules that are only counted
        one, waits_for = found[key]
        text = rule_text(one.rule)
        text = text if len(text) <= LONGEST else text[: LONGEST - 2] + " …"
        shown.append((key[0], places.of(one), text, few(waits_for, NAMED)))
    head = ("St", "Place", "Rule", "Waits for" if any(row[-1] for row in shown) else "")
    return table(head, shown, soft=(2, 3)) + (f"\n… and {hidden} more" if hidden > 0 else "")
