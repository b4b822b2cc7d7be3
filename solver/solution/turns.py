"""Whole turns of an answer: the angles of the variable sheet in (-180, 180], their relatives with them."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping

from rulesheets.model import Value, Variable
from solver.accuracy.rule_check import check_rule
from solver.path.graph import ModelGraph, is_angle_sum


def settled(graph: ModelGraph, values: Mapping[str, Value], inputs: Collection[str]) -> dict[str, Value]:
    """The values with every posted angle that lies outside one turn moved into it.

    Angles that are tied to it by a sum (``beta = alpha + 90``) move along; a move that some rule does not
    admit is not made.
    """
    moved = dict(values)
    for name, variable in graph.model.variables.items():
        turn, number = graph.turn(name), moved.get(name)
        if not variable.posted or turn is None or _bounded(variable) or name in inputs:
            continue
        if isinstance(number, float) and not -turn / 2 < number <= turn / 2:
            shift = -turn * math.ceil(number / turn - 0.5)
            moved = _moved(graph, moved, _tied(graph, name, inputs), shift)
    return moved


def within_one_turn(graph: ModelGraph, values: Mapping[str, Value], inputs: Collection[str]) -> bool:
    """Whether every posted angle that rules read in parts (``sind(theta/2)``) is in (-180, 180].

    Other angles are moved there; these have answers in two turns and more, each another one.
    """
    for name, variable in graph.model.variables.items():
        turn, number = graph.single_turn(name), values.get(name)
        apart = variable.posted and name not in inputs and not _bounded(variable)
        if turn is None or not apart or graph.is_turning(name) or not isinstance(number, float):
            continue
        if not -turn / 2 < number <= turn / 2:
            return False
    return True


def _bounded(variable: Variable) -> bool:
    return variable.low > -math.inf or variable.high < math.inf


def _tied(graph: ModelGraph, name: str, inputs: Collection[str]) -> set[str]:
    """The angle and those that sums tie it to, inputs left out."""
    group, waiting = {name}, [name]
    while waiting:
        for index in graph.users(waiting.pop()):
            equation = graph.model.equations[index]
            if is_angle_sum(equation.left) and is_angle_sum(equation.right):
                new = {n for n in equation.names if n not in inputs} - group
                group |= new
                waiting += sorted(new)
    return group


def _moved(graph: ModelGraph, values: dict[str, Value], names: set[str], shift: float) -> dict[str, Value]:
    trial = {n: v + shift if n in names and isinstance(v, float) else v for n, v in values.items()}
    touched = {index for name in names for index in graph.users(name)}
    for index in touched:
        equation = graph.model.equations[index]
        known = all(name in values for name in equation.names)
        if known and check_rule(equation, values).holds and not check_rule(equation, trial).holds:
            return values
    return trial
