"""Checks of calls: the function exists, takes and gives that many, finds its parameters."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from rulesheets.checks import messages
from rulesheets.checks.scope import Scope
from rulesheets.diagnosis import Diagnosis
from rulesheets.functions import PLANNED, TABLE
from rulesheets.nodes import Call, CallRule, Function
from rulesheets.spelling import plural


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
