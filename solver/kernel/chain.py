"""A torn block as chains of assignments: from the tear to every other unknown and to the residual.

Every combination of preimages of the explicit steps gives one chain. A chain is evaluated
on floats (compiled) and on arrays of intervals, with its slope by forward accumulation.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator, Mapping
from math import inf
from typing import Any

from rulesheets import nodes
from rulesheets.construct import add, is_number, multiply, substitute, subtract
from rulesheets.evaluate import NotDifferentiable, differentiate
from rulesheets.model import Value, Variable
from rulesheets.nodes import Call, Expression, Name, Number, Quotient
from rulesheets.record import dataclass, replace
from solver.kernel.scalar import Emitter
from solver.path import rational
from solver.path.graph import ModelGraph
from solver.path.isolate import TARGET, Isolation, Stage
from solver.path.steps import SolveBlock

MAX_CHAINS = 256
HORNER_DEGREE = 12
RESIDUAL = "#residual"
_JUMPS = frozenset({"sgn", "int", "frac", "round", "mod", "step", "atan2", "atan2d", "tan", "tand"})


@dataclass(frozen=True, slots=True)
class Assignment:
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


@dataclass(frozen=True, slots=True)
class Chain:
    """Assignments that lead from the tears to the unknowns and to the residuals, in order."""

    tears: tuple[str, ...]
    assignments: tuple[Assignment, ...]
    residuals: tuple[str, ...]


def chains(graph: ModelGraph, block: SolveBlock) -> tuple[Chain, ...]:
    """One chain for every combination of preimages; at most ``MAX_CHAINS``."""
    alternatives: list[tuple[tuple[Assignment, ...], ...]] = []
    for number, step in enumerate(block.order):
        isolation = graph.isolation(step.equation, graph.number[step.unknown])
        assert isolation is not None
        variable = graph.model.variables[step.unknown]
        alternatives.append(tuple(_through(isolation, f"#{number}", variable)))
    residuals = tuple(_residual(graph, equation) for equation in block.residuals)
    found = []
    for combination in itertools.islice(itertools.product(*alternatives), MAX_CHAINS):
        steps = tuple(itertools.chain.from_iterable(combination))
        found.append(Chain(block.tears, (*steps, *residuals), tuple(r.name for r in residuals)))
    return tuple(found)


def exhaustive(graph: ModelGraph, block: SolveBlock) -> bool:
    """Whether the chains cover every preimage: none was cut off, and whole turns make no difference."""
    count = 1
    for step in block.order:
        isolation = graph.isolation(step.equation, graph.number[step.unknown])
        assert isolation is not None
        count *= isolation.branches * (3 if isolation.period else 1)
        if isolation.period and not _covers_turns(graph, step.unknown, isolation.period):
            return False
    return count <= MAX_CHAINS


def _covers_turns(graph: ModelGraph, name: str, period: float) -> bool:
    variable = graph.model.variables[name]
    if variable.low == -inf and variable.high == inf:
        return graph.turn(name) is not None
    return max(abs(variable.low), abs(variable.high)) <= period


def _residual(graph: ModelGraph, equation: int) -> Assignment:
    body = graph.model.equations[equation]
    return Assignment(f"{RESIDUAL}{equation}", subtract(body.left, body.right))


def _through(isolation: Isolation, prefix: str, variable: Variable) -> Iterator[tuple[Assignment, ...]]:
    """The ways from the start of an isolation to its unknown."""

    def last(expression: Expression) -> Assignment:
        ends = variable.low, variable.high, variable.low_open, variable.high_open
        return Assignment(variable.name, expression, *ends)

    if isolation.quadratic is not None or not isolation.stages:
        for form in isolation.forms():
            yield (replace(last(form), relational=isolation.quadratic is not None),)
        return
    bounded_unknown = variable.low > -inf or variable.high < inf
    for forms in itertools.product(*(_turned(stage, bounded_unknown) for stage in isolation.stages)):
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
            if isinstance(form, Quotient) and not isinstance(stage.divisor, Number):
                name = f"{prefix}.{place}q"
                steps.append(Assignment(name, expression, relational=True))
                expression = Name(name)
        if steps and steps[-1].relational and expression == Name(steps[-1].name):
            yield (*steps[:-1], replace(last(steps[-1].expression), relational=True))
        else:
            yield (*steps, last(expression))


def _turned(stage: Stage, bounded: bool) -> tuple[Expression, ...]:
    """The forms of a stage; with a turn more and a turn less where the unknown has a range of its own."""
    if stage.period is None or not bounded:
        return stage.forms
    turns = (0.0, stage.period, -stage.period)
    return tuple(add(form, Number(turn)) for turn in turns for form in stage.forms)


def compile_chain(chain: Chain, known: tuple[str, ...], results: tuple[str, ...]) -> Callable[..., Any]:
    """``f(*tears, *known)`` returns the values called ``results``; raises outside the domain."""
    emitter = Emitter((*chain.tears, *known))
    for assignment in chain.assignments:
        emitter.assign(assignment.name, assignment.expression)
        emitter.require(
            assignment.name, assignment.low, assignment.high, assignment.low_open, assignment.high_open
        )
    tokens = [emitter.argument(name) for name in results]
    return emitter.function("(" + "".join(f"{token}, " for token in tokens) + ")")


class Enclosure:
    """The residual of a chain with one tear, and its slope, on arrays of boxes of the tear."""

    def __init__(self, chain: Chain, known: Mapping[str, Value]) -> None:
        self.chain = chain
        self.constants = {name: (v, v) for name, v in known.items() if isinstance(v, float)}
        self.slopes = _slopes(chain)
        self.nested = tuple(_nested(chain))

    def __call__(self, low: Any, high: Any) -> tuple[Any, Any]:
        import numpy as np

        from rulesheets.evaluate.enclosure import enclose

        boxes, _, empty = self._boxes(low, high)
        lo, hi = boxes[self.chain.residuals[0]]
        for form in self.nested:
            below, above = enclose(form, boxes)
            lo, hi = np.fmax(lo, below), np.fmin(hi, above)
        return np.where(empty, np.nan, lo), np.where(empty, np.nan, hi)

    def _boxes(self, low: Any, high: Any) -> tuple[dict[str, Any], Any, Any]:
        """Boxes of every name, where some value may leave its domain, and where it must."""
        import numpy as np

        boxes: dict[str, Any] = {**self.constants, self.chain.tears[0]: (low, high)}
        doubtful = np.zeros(low.shape, dtype=bool)
        empty = np.zeros(low.shape, dtype=bool)
        for item in self.chain.assignments:
            lo, hi = _enclosed(item, boxes)
            if item.low == -inf and item.high == inf:
                boxes[item.name] = (lo, hi)
                empty |= np.isnan(lo)
                continue
            outside = (hi < item.low) | (lo > item.high)
            doubtful |= (lo < item.low) | (hi > item.high)
            lo, hi = np.maximum(lo, item.low), np.minimum(hi, item.high)
            empty |= outside | np.isnan(lo) | np.isnan(hi)
            boxes[item.name] = (np.where(empty, np.nan, lo), np.where(empty, np.nan, hi))
        return boxes, doubtful, empty

    def slope(self, low: Any, high: Any) -> tuple[Any, Any]:
        """The derivative of the residual by the tear; unbounded where it may be undefined somewhere."""
        import numpy as np

        from rulesheets.evaluate.enclosure import enclose

        boxes, doubtful, _ = self._boxes(low, high)
        assert self.slopes is not None
        for name, expression in self.slopes:
            boxes[name] = enclose(expression, boxes)
        lo, hi = boxes[_slope_name(self.chain.residuals[0])]
        unknown = doubtful | np.isnan(lo) | np.isnan(hi)
        return np.where(unknown, -np.inf, lo), np.where(unknown, np.inf, hi)


def _enclosed(item: Assignment, boxes: dict[str, Any]) -> Any:
    """Bounds of an assignment. A quotient that must not be negative has a divisor of its dividend's sign."""
    # A product x*c = t says nothing about x where both c and t may be 0.
    import numpy as np

    from rulesheets.evaluate.enclosure import enclose
    from rulesheets.functions.intervals import divide

    if not isinstance(item.expression, Quotient) or not (item.relational or item.low >= 0.0):
        return enclose(item.expression, boxes)
    above, below = enclose(item.expression.left, boxes), enclose(item.expression.right, boxes)
    lo, hi = below
    if item.low >= 0.0:
        lo = np.where((above[0] > 0) & (below[0] < 0), np.minimum(0.0, below[1]), below[0])
        hi = np.where((above[1] < 0) & (below[1] > 0), np.maximum(0.0, below[0]), below[1])
    low, high = divide(*above, lo, hi)
    anything = item.relational & (above[0] <= 0) & (above[1] >= 0) & (lo <= 0) & (hi >= 0)
    return np.where(anything, -np.inf, low), np.where(anything, np.inf, high)


def _nested(chain: Chain) -> Iterator[Expression]:
    """Horner forms of the residual: equal to it, and narrower where powers of one variable compete."""
    residual = chain.assignments[-1].expression
    moving = {*chain.tears, *(item.name for item in chain.assignments)}
    for name in dict.fromkeys(n for n in nodes.names(residual) if n in moving):
        found = rational.equation(residual, Number(0.0), name, degree=HORNER_DEGREE)
        if found is None or found[1] or sum(1 for c in found[0] if not is_number(c, 0.0)) < 2:
            continue
        *lower, nested = found[0]
        for coefficient in reversed(lower):
            nested = add(coefficient, multiply(Name(name), nested))
        yield nested


def _slope_name(name: str) -> str:
    return f"d {name}"


def _slopes(chain: Chain) -> tuple[tuple[str, Expression], ...] | None:
    """Forward accumulation: the slope of every assignment by the tear; None where a step may jump."""
    moving: dict[str, Expression] = {chain.tears[0]: Number(1.0)}
    found: list[tuple[str, Expression]] = []
    try:
        for item in chain.assignments:
            used = [name for name in dict.fromkeys(nodes.names(item.expression)) if name in moving]
            if not used:
                continue
            if jumps(item.expression):
                return None
            terms = tuple(multiply(differentiate(item.expression, name), moving[name]) for name in used)
            slope = _slope_name(item.name)
            found.append((slope, terms[0] if len(terms) == 1 else nodes.Sum(terms)))
            moving[item.name] = Name(slope)
    except NotDifferentiable:
        return None
    if chain.residuals[0] not in moving:
        return None
    return tuple(found)


def jumps(expression: Expression) -> bool:
    """Whether an expression holds an operation that is not continuous."""
    stack: list[Any] = [expression]
    while stack:
        node = stack.pop()
        if isinstance(node, Call) and node.function in _JUMPS:
            return True
        stack.extend(nodes.children(node))
    return False
