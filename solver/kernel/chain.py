"""A torn block as chains of assignments: from the tear to every other unknown and to the residual.

Every combination of preimages of the explicit steps gives one chain. A chain is evaluated
on floats (compiled) and on arrays of intervals, with its slope by forward accumulation.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator
from dataclasses import replace
from math import inf
from typing import Any, NamedTuple

from rulesheets.evaluate.gradient import signed_root
from rulesheets.evaluate.number import enclose
from rulesheets.functions import TABLE
from rulesheets.model import Variable
from rulesheets.syntax import nodes
from rulesheets.syntax.nodes import Call, Expression, Name, Number, Quotient, add, substitute, subtract
from rulesheets.syntax.program import walk
from solver.kernel.emitter import Emitter
from solver.path.graph import ModelGraph
from solver.path.isolate import TARGET, Isolation, Stage
from solver.path.steps import SolveBlock

MAX_CHAINS = 256
SLACK = 1e-9
"""By how much of a turn an angle may pass the half turn: rounding must not lose one that is there."""
RESIDUAL = "#residual"


class Assignment(NamedTuple):
    """``name := expression``, which must come out between ``low`` and ``high``.

    ``relational``: the expression is a quotient that stands for a product, so that 0/0 may be anything.
    """

    name: str
    expression: Expression
    low: float = -inf
    high: float = inf
    low_open: bool = False
    high_open: bool = False
    relational: bool = False


class Chain(NamedTuple):
    """Assignments that lead from the tears to the unknowns and to the residuals, in order."""

    tears: tuple[str, ...]
    assignments: tuple[Assignment, ...]
    residuals: tuple[str, ...]


def chains(graph: ModelGraph, block: SolveBlock) -> tuple[Chain, ...]:
    """One chain for every combination of preimages; at most ``MAX_CHAINS``."""
    residuals = tuple(_residual(graph, equation) for equation in block.residuals)
    found = []
    for combination in itertools.islice(itertools.product(*_alternatives(graph, block)), MAX_CHAINS):
        steps = tuple(itertools.chain.from_iterable(combination))
        found.append(Chain(block.tears, (*steps, *residuals), tuple(r.name for r in residuals)))
    return tuple(found)


def _alternatives(graph: ModelGraph, block: SolveBlock) -> Iterator[tuple[tuple[Assignment, ...], ...]]:
    """For each step of the order its preimages."""
    for number, step in enumerate(block.order):
        isolation = graph.isolation(step.equation, graph.number[step.unknown])
        assert isolation is not None
        variable = graph.model.variables[step.unknown]
        turn = graph.turn(step.unknown) if isolation.period else None
        if turn is not None and variable.low == -inf and variable.high == inf:
            variable = replace(variable, low=-turn * (0.5 + SLACK), high=turn * (0.5 + SLACK))
        yield tuple(through(isolation, f"#{number}", variable))


def exhaustive(graph: ModelGraph, block: SolveBlock) -> bool:
    """Whether the chains cover every preimage: none was cut off, and whole turns make no difference."""
    for step in block.order:
        isolation = graph.isolation(step.equation, graph.number[step.unknown])
        assert isolation is not None
        if not isolation.proven:
            return False
        if isolation.period and not _covers_turns(graph, isolation):
            return False
    return math.prod(map(len, _alternatives(graph, block))) <= MAX_CHAINS


def _covers_turns(graph: ModelGraph, isolation: Isolation) -> bool:
    """Whether the forms cover every whole turn: the unknown itself, or its negative, is the one angle."""
    operations = [stage.operation for stage in isolation.stages]
    periodic = [place for place, stage in enumerate(isolation.stages) if stage.period]
    if len(periodic) > 1 or any(operation != "negative" for operation in operations[periodic[0] + 1 :]):
        return False
    variable = graph.model.variables[isolation.unknown]
    if variable.low == -inf and variable.high == inf:
        return graph.turn(variable.name) is not None
    return max(abs(variable.low), abs(variable.high)) <= (isolation.period or 0.0)


def _residual(graph: ModelGraph, equation: int) -> Assignment:
    body = graph.model.equations[equation]
    return Assignment(f"{RESIDUAL}{equation}", subtract(body.left, body.right))


def through(isolation: Isolation, prefix: str, variable: Variable) -> Iterator[tuple[Assignment, ...]]:
    """The ways from the start of an isolation to its unknown."""

    def last(expression: Expression) -> Assignment:
        ends = variable.low, variable.high, variable.low_open, variable.high_open
        return Assignment(variable.name, expression, *ends)

    if isolation.quadratic is not None or not isolation.stages:
        for form in isolation.forms():
            yield (last(form)._replace(relational=isolation.quadratic is not None),)
        return
    bounded_unknown = variable.low > -inf or variable.high < inf
    for forms in itertools.product(*(_turned(stage, bounded_unknown) for stage in isolation.stages)):
        if bounded_unknown and isolation.period and _out_of_range(isolation.stages, forms, variable):
            continue
        steps: list[Assignment] = []
        expression = isolation.start
        for place, (stage, form) in enumerate(zip(isolation.stages, forms, strict=True)):
            bounded = stage.low > -inf or stage.high < inf
            target = expression
            if bounded or sum(1 for name in nodes.names(form) if name == TARGET.name) > 1:
                name = f"{prefix}.{place}"
                steps.append(
                    Assignment(name, expression, stage.low, stage.high, stage.low_open, stage.high_open)
                )
                target = Name(name)
            expression = substitute(form, {TARGET.name: target})
            if isinstance(form, Quotient) and stage.divides:
                name = f"{prefix}.{place}q"
                steps.append(Assignment(name, expression, relational=True))
                expression = Name(name)
        if steps and steps[-1].relational and expression == Name(steps[-1].name):
            yield (*steps[:-1], last(steps[-1].expression)._replace(relational=True))
        else:
            yield (*steps, last(expression))


def _turned(stage: Stage, bounded: bool) -> tuple[Expression, ...]:
    """The forms of a stage; with a turn more and a turn less where the unknown has a range of its own."""
    if stage.period is None or not bounded:
        return stage.forms
    turns = (0.0, stage.period, -stage.period)
    return tuple(add(form, Number(turn)) for turn in turns for form in stage.forms)


def _out_of_range(stages: tuple[Stage, ...], forms: tuple[Expression, ...], variable: Variable) -> bool:
    """Whether a preimage of a periodic operation lies outside the range whatever its target is."""
    at = next(i for i, stage in enumerate(stages) if stage.period)
    expression: Expression = TARGET
    for form in forms[at:]:
        expression = substitute(form, {TARGET.name: expression})
    if any(name != TARGET.name for name in nodes.names(expression)):
        return False
    low, high = enclose(expression, {TARGET.name: (stages[at].low, stages[at].high)})
    return high < variable.low or low > variable.high


def compile_chain(chain: Chain, known: tuple[str, ...], results: tuple[str, ...]) -> Callable[..., Any]:
    """``f(*tears, *known)`` returns the values called ``results``; raises outside the domain."""
    emitter = Emitter((*chain.tears, *known))
    for assignment in chain.assignments:
        emitter.assign(assignment.name, assignment.expression)
        emitter.require(
            assignment.name, assignment.low, assignment.high, assignment.low_open, assignment.high_open
        )
    return emitter.function([emitter.argument(name) for name in results])


def jumps(expression: Expression) -> bool:
    """Whether an expression holds an operation that jumps at points that depend on its values."""
    stack: list[Any] = [expression]
    while stack:
        node = stack.pop()
        if isinstance(node, Call) and TABLE[node.function].jumps:
            return True
        inside = signed_root(node)
        stack.extend(nodes.children(node) if inside is None else (inside,))
    return False


def directions(expression: Expression) -> Iterator[Call]:
    """The directions of points (x, y) in an expression: they jump where y changes sign and x is negative."""
    return (part for part in walk(expression) if isinstance(part, Call) and TABLE[part.function].direction)
