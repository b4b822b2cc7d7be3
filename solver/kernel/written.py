"""The known numbers of a branch with the decimals as written: those that are given, and what
follows from these exactly. They decide where floats leave nothing of a difference but rounding."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction

from rulesheets.evaluate.exact import Inexact, as_written, value_as_written
from rulesheets.model import Value, Values
from rulesheets.syntax.nodes import Expression, substitute
from solver.accuracy.rule_check import check_rule
from solver.numerics.tolerances import CANCELLED
from solver.path import TARGET, Evaluate, Isolation, SolveBlock, Stage, Step
from solver.path.graph import ModelGraph

DEEPEST, LONGEST = 40, 5000
"""Rules in a row that are followed, and binary digits of a number."""
SHORT, ROUGH = 12, 7
"""Digits of a number of a block that is tried as a decimal; of one at a double root."""


class WrittenNumbers:
    """Exact values by name: ``values`` are those of the branch, ``origins`` the steps that some of
    them came from."""

    def __init__(self, graph: ModelGraph, values: Values, origins: Mapping[str, Step]) -> None:
        self.graph, self.values, self.origins = graph, values, origins
        self.kept = dict[str, Fraction]()

    def number(self, name: str, depth: int = DEEPEST) -> Fraction:
        """Raises Inexact if a number does not follow exactly, KeyError for one that is not
        known."""
        if name not in self.kept:
            step, number = self.origins.get(name), self.values[name]
            self.kept[name] = as_written(number) if step is None else self._of(step, name, depth)
        return self.kept[name]

    def _of(self, step: Step, name: str, depth: int) -> Fraction:
        """What a direct step leads to, or a block whose rules hold exactly."""
        if depth and isinstance(step, SolveBlock):
            if not self.satisfy(step, depth - 1):
                raise Inexact(name)
            return as_written(self.values[name])
        if not isinstance(step, Evaluate) or depth == 0:
            raise Inexact(name)
        isolation, names = self.graph.isolated(step.equation, self.graph.number[name])
        own = dict(zip(names, self.graph.model.equations[step.equation].names, strict=True))
        target = None if isolation is None else led_to(isolation, isolation.stages)
        if target is None:
            raise Inexact(name)
        found = value_as_written(target, lambda local: self.number(own[local], depth - 1))
        if found is None or found.denominator.bit_length() + found.numerator.bit_length() > LONGEST:
            raise Inexact(name)
        return found

    def satisfy(self, step: SolveBlock, depth: int = DEEPEST) -> bool:
        """Whether the rules of a block hold exactly with the values of its unknowns as written."""
        unknowns = step.unknowns

        def read(name: str) -> Fraction:
            return as_written(self.values[name]) if name in unknowns else self.number(name, depth)

        rules = (self.graph.model.equations[index] for index in step.equations)
        return all(value_as_written(rule.form, read) == 0 for rule in rules)

    def in_decimals(self, step: SolveBlock, found: Values, double: bool) -> Values:
        """An answer of a block; the decimals next to it if these satisfy its rules exactly: 0 for
        what rounding has left of it."""
        numbers = {name: float(v) for name, v in found.items() if not isinstance(v, str)}
        size, digits = max(map(abs, numbers.values()), default=0.0), ROUGH if double else SHORT
        short: dict[str, Value] = {
            name: 0.0 if abs(v) <= CANCELLED * size else float(f"{v:.{digits}g}")
            for name, v in numbers.items()
        }
        model, there = self.graph.model, {**self.values, **short}
        rules = (model.equations[index] for index in step.equations)
        if len(short) < len(found) or short == found:
            return found
        admitted = all(model.variables[name].admits(float(short[name])) for name in short)
        if not (admitted and all(check_rule(rule, there).holds for rule in rules)):
            return found
        exact = WrittenNumbers(self.graph, there, self.origins).satisfy(step)
        return short if exact else found


def led_to(isolation: Isolation, stages: tuple[Stage, ...]) -> Expression | None:
    """What some stages lead to, None if there may be several values."""
    target: Expression = isolation.start
    if isolation.quadratic is not None:
        return None
    for stage in stages:
        form, *others = stage.forms
        if others or stage.period is not None:
            return None
        target = substitute(form, {TARGET.name: target})
    return target
