"""The same solve with other numbers: answered by the compiled way that the earlier ones taught.

A call of ``solve`` that gives the same names and asks for the same ones as two calls before it, and that
decides as they did, comes back in microseconds. Everything in its result that takes longer to know (the
residual of every rule, error bars) is found out when it is asked for.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING

from rulesheets.evaluate import Undefined, holds
from solver.accuracy.witness import testify
from solver.compiled.paths import CompiledPaths
from solver.compiled.way import Pattern
from solver.path.activity import activity
from solver.result import Result, Solution, Status

if TYPE_CHECKING:
    from collections.abc import Hashable, Mapping

    from rulesheets.model import Model, Value
    from solver.accuracy.forward_error import ForwardErrors
    from solver.path.planner import Planner
    from solver.solution.leaves import Leaf

CLEAR = 1e-3
"""Discriminants nearer to zero than this are left to the step-by-step way."""

VAGUE = 5e-13
"""Where rounding may change an answer by more than this share, the step-by-step way has the word, too."""

MAX_PATTERNS = 64


@dataclass
class _Repeat:
    """One pattern: how often it was met, and the ways that were learned, each with what it shares."""

    names: tuple[str, ...]
    paths: CompiledPaths | None = None
    templates: list[Result] | None = None
    met: int = 0


class Repeats:
    """The patterns of one model."""

    def __init__(self, model: Model, planner: Planner) -> None:
        self.model, self.planner = model, planner
        self._patterns: dict[Hashable, _Repeat] = {}

    def answer(
        self, given: Mapping[str, Value], want: tuple[str, ...] | None, guesses: Mapping[str, float]
    ) -> Result | None:
        """The result, where a way is known that tells it."""
        repeat = self._patterns.get(_key(given, want, guesses))
        if repeat is None or repeat.paths is None or repeat.templates is None:
            return None
        numbers = [given[name] for name in repeat.names]
        for way, template in zip(repeat.paths.every, repeat.templates, strict=True):
            rows = way(*numbers)
            if rows is not None and len(rows) == len(template.solutions):
                names = template.solutions[0]
                return self._result(template, given, [dict(zip(names, row, strict=True)) for row in rows])
        return None

    def meet(
        self,
        given: Mapping[str, Value],
        want: tuple[str, ...] | None,
        guesses: Mapping[str, float],
        result: Result,
        leaves: tuple[Leaf, ...],
    ) -> None:
        """Learn from a result that came step by step, the second time that its pattern is met."""
        if result.status is not Status.SOLVED or result.diagnoses or len(self._patterns) > MAX_PATTERNS:
            return
        if any(leaf.branch.facts or leaf.branch.void or leaf.branch.assumed for leaf in leaves):
            return
        repeat = self._patterns.setdefault(_key(given, want, guesses), _Repeat(tuple(given)))
        repeat.met += 1
        if repeat.met < 2:
            return
        if repeat.paths is None or repeat.templates is None:
            names = tuple(leaves[0].branch.values)
            judged = result.wanted, VAGUE
            pattern = Pattern(repeat.names, {}, names, guesses, want, CLEAR, as_written=True, accuracy=judged)
            repeat.paths, repeat.templates = CompiledPaths(self.model, self.planner, pattern), []
        answers = [leaf.branch.values for leaf in leaves]
        numbers = [given[name] for name in repeat.names]
        if all(set(answer) == set(repeat.paths.pattern.want) for answer in answers):
            template = replace(result, solutions=tuple(_named(s, repeat.paths) for s in result.solutions))
            if repeat.paths.learn(numbers, answers) is not None:
                repeat.templates.append(template)

    def _result(self, template: Result, given: Mapping[str, Value], rows: list[dict[str, Value]]) -> Result:
        checked = template.solutions[0].checked
        return replace(
            template,
            inputs=given,
            partial=given,
            solutions=tuple(
                Solution(
                    row,
                    partial(_worst_residual, self.model, row, given),
                    checked,
                    partial(_errors, self.model, row, given, template),
                )
                for row in rows
            ),
        )


def _named(solution: Solution, paths: CompiledPaths) -> Solution:
    """The solution with its names in the order in which the ways give them."""
    return replace(solution, by_name={name: solution[name] for name in paths.pattern.want})


def _key(given: Mapping[str, Value], want: tuple[str, ...] | None, guesses: Mapping[str, float]) -> Hashable:
    return tuple(given), want, tuple(guesses.items())


def _decided(model: Model, values: Mapping[str, Value], given: Mapping[str, Value]) -> dict[int, bool]:
    found = {}
    for index, condition in enumerate(model.conditions):
        try:
            found[index] = holds(condition, values, given)
        except (KeyError, Undefined):
            continue
    return found


def _worst_residual(model: Model, values: Mapping[str, Value], given: Mapping[str, Value]) -> float:
    decided = _decided(model, values, given)
    known = (e for e in model.equations if all(name in values for name in e.names))
    active = (e for e in known if activity(e, decided))
    return max((testify(equation, values).scaled for equation in active), default=0.0)


def _errors(
    model: Model, values: Mapping[str, Value], given: Mapping[str, Value], template: Result
) -> ForwardErrors:
    from solver.accuracy.forward_error import forward_errors

    decided = _decided(model, values, given)
    return forward_errors(model, values, list(template.path.steps), lambda e: activity(e, decided))
