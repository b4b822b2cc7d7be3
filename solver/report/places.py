"""Rules as a reader meets them: their text on one line, their file and line."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from rulesheets.model import Equation, Model, Premise, Requirement
from rulesheets.source import Span, escaped


def rule_text(span: Span) -> str:
    """The rule as written, on one line, its inner spaces single."""
    return " ".join(span.text.split())


def short_names(files: Iterable[str]) -> Mapping[str, str]:
    """The shortest endings of file names that tell them apart: ``position.tk``."""
    names = tuple(dict.fromkeys(files))
    return {name: escaped(_ending(name, names)) for name in names}


def _ending(name: str, names: tuple[str, ...]) -> str:
    parts = name.split("/")
    for length in range(1, len(parts)):
        ending = "/".join(parts[-length:])
        if sum(other == ending or other.endswith("/" + ending) for other in names) == 1:
            return ending
    return name


class Places:
    """``file:line`` of the rules of a model, the files by their shortest names; and what the rules say."""

    def __init__(self, model: Model) -> None:
        self._model = model
        spans = [*(e.rule for e in model.equations), *(r.rule for r in model.requirements)]
        self._short = short_names(span.file for span in spans)
        self._guards: dict[tuple[str, Span], set[tuple[Premise, ...]]] = {}
        for equation in model.equations:
            self._guards.setdefault((equation.scope, equation.rule), set()).add(equation.guard)

    def of(self, rule: Equation | Requirement) -> str:
        return f"{self._short[rule.rule.file]}:{rule.rule.line}"

    def said(self, equation: Equation) -> str:
        """The rule of an equation; of a rule with several arms the arm that the equation stands in."""
        left, right = equation.left.span, equation.right.span
        arms = self._guards[equation.scope, equation.rule]
        if len(arms) == 1 or not equation.guard or left is None or right is None or left == right:
            return rule_text(equation.rule)
        arm = f"{rule_text(left)} = {rule_text(right)}"
        last = equation.guard[-1]
        if not last.holds:
            return f"else {arm}"
        condition = self._model.conditions[last.condition].span
        return f"if {_bare(rule_text(condition)) if condition else '…'} then {arm}"


def _bare(text: str) -> str:
    """Without a parenthesis around the whole."""
    depth = 0
    for place, sign in enumerate(text):
        depth += (sign == "(") - (sign == ")")
        if depth == 0:
            return text[1:-1] if place == len(text) - 1 and text[0] == "(" else text
    return text
