"""From a path to a straight-line program, along the decisions that one run of it took.

The program computes what the step-by-step way computes, and beside it whether it did: every
condition that chose the way, every domain, every rule that does not hold by the way its unknown was
computed. Where one of these fails the results do not count, and the step-by-step way has the word.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from solver.compiled.finish import Finish
from solver.compiled.flow import NotCompilable
from solver.compiled.program import Ending, Program
from solver.compiled.simultaneous import Simultaneous
from solver.compiled.single import Single
from solver.compiled.way import Way
from solver.path.steps import Check, Decide, Evaluate, Select, SolveBlock

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from rulesheets.model import Model, Value
    from solver.compiled.way import Pattern
    from solver.path.planner import Planner
    from solver.path.steps import Step

MAX_ENDINGS = 8


def translate(
    model: Model,
    planner: Planner,
    pattern: Pattern,
    sample: Mapping[str, Value],
    plain: bool = False,
) -> Program:
    """The program for all rows that decide as ``sample`` does: values of every variable that has one there.

    Raises NotCompilable where a step has no straight-line form.
    """
    return Translation(model, planner, pattern, sample, plain).run()


class Translation(Single, Simultaneous, Finish):
    """Follows a path as the sample did."""

    def __init__(
        self,
        model: Model,
        planner: Planner,
        pattern: Pattern,
        sample: Mapping[str, Value],
        plain: bool = False,
    ) -> None:
        super().__init__(model, planner, pattern, sample, plain)
        pruned = pattern.want if pattern.pruned == () else pattern.pruned
        self.want = None if pruned is None else frozenset(pruned)
        self.endings: list[Ending] = []

    def run(self) -> Program:
        way, told = self._start()
        self._decide(way, range(len(self.model.conditions)))
        self._plan(way)
        return Program(self.flow, len(self.pattern.inputs), tuple(self.endings), told)

    def _start(self) -> tuple[Way, tuple[tuple[int, str], ...]]:
        """A way on which only what is given is known, and the symbols among that, by their places."""
        flow = self.flow
        values: dict[str, int] = {}
        symbols: dict[str, str] = {}
        for name, known in self.pattern.given.items():
            if isinstance(known, str):
                symbols[name] = known
            else:
                values[name] = flow.constant(known)
        told: list[tuple[int, str]] = []
        for place, name in enumerate(self.pattern.inputs):
            if isinstance(said := self.sample[name], str):
                symbols[name] = said
                told.append((place, said))
            else:
                values[name] = flow.input(place)
        way = Way(values, symbols, {}, gone=flow.false)
        flow.checks, flow.finite = way.checks, way.finite
        for name in self.pattern.inputs:
            if name in values:
                flow.bound(values[name])  # a missing one comes out on some side of every comparison
                self._within(way, self.model.variables[name], values[name])
        return way, tuple(told)

    # --- the way ---

    def _plan(self, way: Way) -> None:
        for condition in way.chosen:
            self._pin(way, condition)
        way.chosen.clear()
        known = frozenset((*way.values, *way.symbols))
        path = self.planner.path(known, way.decided, frozenset(), self.want)
        self._follow(way, path.steps)

    def _follow(self, way: Way, steps: Sequence[Step]) -> None:
        for place, step in enumerate(steps):
            self.flow.checks, self.flow.finite = way.checks, way.finite
            if isinstance(step, Decide):
                self._decide(way, step.conditions)
                self._plan(way)
                return
            found = self._taken(way, step)
            if len(found) != 1:
                for fork in found:
                    self._follow(fork, steps[place + 1 :])
                return
            way = found[0]
        self.endings.append(self._finished(way))
        if len(self.endings) > MAX_ENDINGS:
            raise NotCompilable

    def _taken(self, way: Way, step: Step) -> list[Way]:
        """The way after a step, or the ways that it forks into."""
        match step:
            case Evaluate(equation=equation, unknown=unknown):
                return list(self._evaluated(way, equation, unknown))
            case Select():
                return [self._selected(way, step)]
            case SolveBlock():
                return list(self._block(way, step))
            case Check():
                return [way]
            case _:
                raise NotCompilable
