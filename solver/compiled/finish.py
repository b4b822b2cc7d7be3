"""The end of a way: every rule that does not hold by construction is checked, and the results are named."""

from __future__ import annotations

import math
from contextlib import suppress
from dataclasses import replace
from typing import TYPE_CHECKING

from solver.compiled.flow import NotCompilable
from solver.compiled.magnitude import vanishing, whole
from solver.compiled.preimages import Preimages
from solver.compiled.program import Ending
from solver.compiled.rounding import apart_from_edges
from solver.compiled.schedule import LEAVES, schedule
from solver.compiled.testimony import Testimony
from solver.compiled.trim import trimmed
from solver.path.activity import activity

if TYPE_CHECKING:
    from collections.abc import Iterable

    from rulesheets.model import Variable
    from solver.compiled.flow import Flow
    from solver.compiled.way import Way

DIGITS = 1e-10
"""Share of a result that rounding may change where numbers of the rules can drown their variables."""
_DIRECTIONS = frozenset({"atan2", "atan2d", "acosd", "asind", "atand", "acos", "asin", "atan"})


class Finish(Preimages, Testimony):
    """The witness of a way and its ending."""

    def _finished(self, way: Way) -> Ending:
        flow = self.flow
        flow.checks, flow.finite = way.checks, way.finite
        for equation in self.model.equations:
            known = all(name in way.values or name in way.symbols for name in equation.names)
            if not known or equation.index in way.settled or activity(equation, way.decided) is False:
                continue
            active = self._active(way, equation.guard)
            if active is None or active == flow.false:
                continue
            holds = self._witness(way, equation, active)
            with flow.only_if(active):
                flow.require(holds)
        self._required(way)
        for name, variable in self.model.variables.items():
            self._turned(way, name, variable)
        results = tuple(self._result(way, name) for name in self.pattern.want)
        for told in apart_from_edges(flow, [node for node in results if isinstance(node, int)]):
            flow.require(told)
        if way.drowned:
            self._known_to_some_digits(results)
        for node in results:
            if isinstance(node, int):
                flow.bound(node)
        order = (*self._guessed(way), *way.order) if way.order else ()
        ending = Ending(results, tuple(way.checks), tuple(way.finite), way.gone, order)
        return trimmed(flow, self._with_all_digits(way, ending))

    def _required(self, way: Way) -> None:
        """An ending that breaks a requirement is no answer; one next to an edge is left to the other way."""
        flow = self.flow
        for requirement in self.model.requirements:
            if not all(name in way.values for name in requirement.names):
                if all(name in way.values or name in way.symbols for name in requirement.names):
                    raise NotCompilable
                continue
            active = self._active(way, requirement.guard)
            if active is None or active == flow.false:
                continue
            sides = requirement.comparison.left, requirement.comparison.right
            one, other = (self._expression(way, side) for side in sides)
            meets = flow.compare(requirement.comparison.operator, one, other)
            with flow.only_if(active):
                flow.require(flow.add("not", flow.compare("=", one, other)))
            broken = flow.add("and", active, flow.add("not", meets))
            way.gone = flow.add("or", way.gone, broken)

    def _with_all_digits(self, way: Way, ending: Ending) -> Ending:
        """The same ending where no number that it reads was lost below what floats hold."""
        flow = self.flow
        results = [node for node in ending.results if isinstance(node, int)]
        read = set(schedule(flow, [*results, *ending.holds, *ending.order, ending.gone]).order)
        rooted = (flow.nodes[node][1] for node in schedule(flow, results).order if _is_root(flow, node))
        vanishing_ones = (node for node in results if vanishing(flow, node))
        flow.checks = list(ending.holds)
        for node in dict.fromkeys((*way.undone, *map(int, rooted), *vanishing_ones)):
            if node in read:
                flow.require(whole(flow, node))
        return replace(ending, holds=tuple(flow.checks))

    def _guessed(self, way: Way) -> list[int]:
        """How far an answer is from the guesses, which orders it before all else."""
        flow, total = self.flow, None
        for name, guess in self.pattern.guesses.items():
            if name not in way.values:
                continue
            apart = flow.add("abs", flow.add("sub", way.values[name], flow.constant(guess)))
            turn = self.graph.turn(name)
            if turn:
                whole = flow.constant(turn)
                turns = flow.add("mul", whole, flow.add("rint", flow.add("div", apart, whole)))
                apart = flow.add("abs", flow.add("sub", apart, turns))
            share = flow.add("div", apart, flow.constant(max(abs(guess), 1.0)))
            square = flow.add("mul", share, share)
            total = square if total is None else flow.add("add", total, square)
        return [] if total is None else [total]

    def _known_to_some_digits(self, results: Iterable[int | str]) -> None:
        for node in results:
            if isinstance(node, int) and self.flow.nodes[node][0] not in LEAVES:
                with suppress(NotCompilable):
                    self.flow.require(self.rounding.within(node, DIGITS))

    def _result(self, way: Way, name: str) -> int | str:
        if name in way.symbols:
            return way.symbols[name]
        if name not in way.values:
            raise NotCompilable
        return way.values[name]

    def _turned(self, way: Way, name: str, variable: Variable) -> None:
        """An angle outside of one turn is for the step-by-step way to move."""
        turn, node = self.graph.single_turn(name), way.values.get(name)
        bounded = variable.low > -math.inf or variable.high < math.inf
        if node is None or turn is None or bounded or not variable.posted or name in self.given:
            return
        flow = self.flow
        if self._is_direction(node):
            return
        half = flow.constant(turn / 2)
        flow.require(flow.add("lt", flow.add("neg", half), node))
        flow.require(flow.add("le", node, half))

    def _is_direction(self, node: int) -> bool:
        kind = self.flow.nodes[node]
        return (kind[0] == "call" and kind[1] in _DIRECTIONS) or kind[0] in ("direction", "directiond")


def _is_root(flow: Flow, node: int) -> bool:
    """Whether an operation finds large numbers in small ones, of which digits may have been lost."""
    operation, *parts = flow.nodes[node]
    power = flow.value_of(int(parts[1])) if operation == "pow" else None
    return operation == "sqrt" or (power is not None and -1.0 < power < 1.0)
