"""No function may lead back to itself: the calls form a graph without rings.

Depth-first search with an explicit stack; the edge that closes a ring is found when
it points at a function that is still open (Tarjan 1972).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from rulesheets.checks import messages
from rulesheets.checks.scope import Scope
from rulesheets.diagnosis import Diagnosis
from rulesheets.nodes import Call, CallRule, Function


def check_recursion(scopes: Mapping[str, Scope]) -> Iterator[Diagnosis]:
    """One diagnosis for each ring that the search closes; ``scopes`` are those of the functions."""
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
