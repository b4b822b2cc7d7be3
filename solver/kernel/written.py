"""The known numbers of a branch with the decimals as written: those that are given, and what
follows from these exactly. They decide where floats leave nothing of a difference but rounding."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction

from rulesheets.evaluate.exact import Inexact, as_written, value_as_written
from rulesheets.evaluate.number import rounded
from rulesheets.model import Values
from rulesheets.syntax.nodes import Expression
from solver.path import (
    Evaluate,
    Isolation,
    SolveBlock,
    Stage,
    Step,
    equations_of,
    given_by,
)
from solver.path.graph import ModelGraph

DEEPEST, LONGEST = 40, 5000
"""Rules in a row that are followed, and binary digits of a number."""


class WrittenNumbers:
    """Exact values by name: ``values`` are those of the branch, ``origins`` the steps that some of
    them came from."""

    def __init__(self, graph: ModelGraph, values: Values, origins: Mapping[str, Step]) -> None:
        self.graph, self.values, self.origins = graph, values, origins
        self.kept = dict[str, Fraction | None]()

    def number(self, name: str, depth: int = DEEPEST) -> Fraction:
        """Raises Inexact if a number does not follow exactly, KeyError for one that is not
        known."""
        if name not in self.kept:
            self.kept[name] = None  # unless it turns out to be known: chains are followed once
            step, number = self.origins.get(name), self.values[name]
            self.kept[name] = as_written(number) if step is None else self._of(step, name, depth)
        if (found := self.kept[name]) is None:
            raise Inexact(name)
        return found

    def _of(self, step: Step, name: str, depth: int) -> Fraction:
        """What a direct step leads to, or a decimal with which the rules of a step hold exactly."""
        if depth and isinstance(step, Evaluate):
            isolation, names = self.graph.isolated(step.equation, self.graph.number[name])
            own = dict(zip(names, self.graph.model.equations[step.equation].names, strict=True))
            target = None if isolation is None else led_to(isolation, isolation.stages)
            if target is not None:
                found = value_as_written(target, lambda local: self.number(own[local], depth - 1))
                size = found.denominator.bit_length() + found.numerator.bit_length() if found else 0
                if found is not None and size <= LONGEST:
                    return found
        if not (
            depth and isinstance(step, Evaluate | SolveBlock) and self.satisfy(step, depth - 1)
        ):
            raise Inexact(name)
        return self._short(name)

    def _short(self, name: str) -> Fraction:
        number = self.values[name]
        return as_written(number if isinstance(number, str) else rounded(float(number), 12))

    def satisfy(self, step: Evaluate | SolveBlock, depth: int = DEEPEST) -> bool:
        """Whether the rules of a step hold exactly with its unknowns as decimals."""
        unknowns = given_by(step)

        def read(name: str) -> Fraction:
            return self._short(name) if name in unknowns else self.number(name, depth)

        rules = (self.graph.model.equations[index] for index in equations_of(step))
        return all(value_as_written(rule.form, read) == 0 for rule in rules)


def led_to(isolation: Isolation, stages: tuple[Stage, ...]) -> Expression | None:
    """What some stages lead to, None if there may be several values."""
    if any(stage.period is not None for stage in stages):
        return None
    found = isolation._replace(stages=stages).forms()
    return found[0] if len(found) == 1 else None
