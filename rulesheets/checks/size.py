"""How much there is: calls that multiply, and expressions that nest, before anything is expanded."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from graphlib import TopologicalSorter

from rulesheets.checks import messages
from rulesheets.checks.scope import Scope
from rulesheets.diagnosis import Diagnosis
from rulesheets.nodes import Condition, Expression, children

MAX_EQUATIONS = 200_000
MAX_DEPTH = 100
MAX_NESTING = 300
"""Levels of an expression; what works on expressions recurses, one level by one."""


@dataclass(frozen=True)
class Size:
    """Equations of a scope with those of its calls, and how deep the calls nest in it."""

    equations: int
    depth: int


def check_size(sheet: Scope, functions: Mapping[str, Scope]) -> Iterator[Diagnosis]:
    """At most one diagnosis; the calls of the functions must not go round."""
    callees = {
        name: [function.name.lower() for _, function in functions[name].callees()] for name in functions
    }
    sizes: dict[str, Size] = {}
    for name in TopologicalSorter(callees).static_order():
        sizes[name] = _size(functions[name], sizes)
    size = _size(sheet, sizes)
    place = next((call.span for call, _ in sheet.callees()), None)
    if size.depth > MAX_DEPTH:
        yield messages.too_large(place, f"calls nest {size.depth} deep; {MAX_DEPTH} is the limit")
    elif size.equations > MAX_EQUATIONS:
        yield messages.too_large(place, f"the model has more than {MAX_EQUATIONS:,} equations")


def _size(scope: Scope, sizes: Mapping[str, Size]) -> Size:
    called = [sizes[function.name.lower()] for _, function in scope.callees()]
    return Size(
        equations=len(scope.contents.equalities) + sum(size.equations for size in called),
        depth=max((size.depth + 1 for size in called), default=0),
    )


def check_nesting(scope: Scope) -> Iterator[Diagnosis]:
    """Expressions too deep to work on, such as a product of a thousand factors."""
    for operand in scope.contents.long:
        if _nesting(operand) > MAX_NESTING:
            yield messages.too_deep(operand.span, MAX_NESTING)


def _nesting(node: Expression | Condition) -> int:
    """How many levels a tree has."""
    level, depth = [node], 0
    while level:
        level = [part for item in level for part in children(item)]
        depth += 1
    return depth
