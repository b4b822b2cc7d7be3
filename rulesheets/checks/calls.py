"""Checks of calls: the function exists, takes and gives that many, and never leads back to itself; sizes."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from graphlib import TopologicalSorter

from rulesheets.checks import messages
from rulesheets.checks.scope import Scope
from rulesheets.diagnosis import Diagnosis
from rulesheets.functions import PLANNED, TABLE
from rulesheets.spelling import plural
from rulesheets.syntax.nodes import Call, CallRule, Condition, Expression, Function, children


def check_calls(scope: Scope) -> Iterator[Diagnosis]:
    calls: tuple[Call | CallRule, ...] = (*scope.contents.calls, *scope.contents.inner_calls)
    for call in calls:
        function = scope.program.functions.get(call.function.lower())
        if function is not None:
            yield from _check_rule_function(call, function, scope)
        else:
            yield from check_builtin(call, scope.program.functions, scope.names)


def _check_rule_function(call: Call | CallRule, function: Function, scope: Scope) -> Iterator[Diagnosis]:
    if len(call.arguments) != len(function.arguments):
        yield messages.argument_count(call, plural(len(function.arguments), "argument"), function)
    results = len(call.results) if isinstance(call, CallRule) else 1
    if results != len(function.results):
        yield messages.result_count(call, function, results)
    for parameter in function.parameters:
        if parameter not in scope.names:
            yield messages.unknown_parameter(call, function, parameter, scope.title, scope.names)


def check_builtin(
    call: Call | CallRule, own: Iterable[str] = (), variables: Iterable[str] = ()
) -> Iterator[Diagnosis]:
    """A call of no function of one's own; ``own`` and ``variables`` are what may be meant instead."""
    name = call.function.lower()
    if name in PLANNED:
        yield messages.planned_function(call)
    elif name not in TABLE:
        yield messages.unknown_function(call, (*own, *TABLE), variables)
    else:
        if not TABLE[name].accepts(len(call.arguments)):
            yield messages.argument_count(call, _arity(*TABLE[name].arity), None)
        if isinstance(call, CallRule) and len(call.results) != 1:
            yield messages.builtin_results(call)


def _arity(least: int, most: int | None) -> str:
    if most == least:
        return plural(least, "argument")
    return f"at least {plural(least, 'argument')}" if most is None else f"{least} to {most} arguments"


def check_recursion(scopes: Mapping[str, Scope]) -> Iterator[Diagnosis]:
    """One diagnosis for each ring of calls; ``scopes`` are those of the functions.

    Depth-first search with an explicit stack: the edge that closes a ring points at a function that is still
    open (Tarjan 1972).
    """
    finished: set[str] = set()
    for start in scopes:
        if start not in finished:
            yield from _search(start, scopes, finished)


def _search(start: str, scopes: Mapping[str, Scope], finished: set[str]) -> Iterator[Diagnosis]:
    trail = [start]
    calls: list[Call | CallRule] = []
    pending = [_edges(scopes[start])]
    while trail:
        edge = next(pending[-1], None)
        if edge is None:
            finished.add(trail.pop())
            pending.pop()
            if calls:
                calls.pop()
            continue
        call, target = edge
        if target in trail:
            at = trail.index(target)
            ring = [_function(scopes[name]) for name in trail[at:]]
            yield messages.recursion(ring, [*calls[at:], call])
        elif target not in finished:
            trail.append(target)
            calls.append(call)
            pending.append(_edges(scopes[target]))


def _edges(scope: Scope) -> Iterator[tuple[Call | CallRule, str]]:
    seen: set[str] = set()
    for call, function in scope.callees():
        target = function.name.lower()
        if target not in seen:
            seen.add(target)
            yield call, target


def _function(scope: Scope) -> Function:
    assert scope.function is not None
    return scope.function


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
