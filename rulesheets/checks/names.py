"""Checks of names and symbols: what may be called what, once, and where a symbol may stand."""

from __future__ import annotations

from collections.abc import Iterator

from rulesheets.checks import messages
from rulesheets.checks.calls import check_builtin
from rulesheets.checks.scope import Scope
from rulesheets.diagnosis import Diagnosis
from rulesheets.functions import PLANNED, TABLE
from rulesheets.syntax.nodes import Call, Comparison, Equality, Expression, Function, Name, Symbol, children
from rulesheets.syntax.program import Program, walk
from rulesheets.syntax.source import Span

FREE = frozenset(PLANNED) | {"e", "gamma", "beta", "step", "j0", "j1", "jn", "y0", "y1", "yn", "i0", "k0"}
"""Functions whose names are free for variables, because sheets about angles, places and
currents need them: a function is always followed by a parenthesis, so nothing is ambiguous."""


def is_reserved(name: str) -> bool:
    """Whether no variable may have this name, as it is that of a built-in function."""
    return name.lower() in TABLE and name.lower() not in FREE


def check_names(scope: Scope) -> Iterator[Diagnosis]:
    declared = set(scope.declared)
    own = {function.name: function for function in scope.program.functions.values()}
    for name, place in scope.contents.names.items():
        if name in declared:
            continue
        if is_reserved(name) or name in own:
            yield messages.name_of_function(name, place, own.get(name))


def check_declared(scope: Scope) -> Iterator[Diagnosis]:
    """Reserved names in the variables section or in the head of a function."""
    for name, place in _declarations(scope):
        if is_reserved(name):
            yield messages.name_of_function(name, place, None)


def _declarations(scope: Scope) -> Iterator[tuple[str, Span | None]]:
    if scope.function is None:
        yield from ((row.name, row_name(row.span, row.name)) for row in scope.program.rows)
    else:
        head = messages.head_of(scope.function)
        yield from ((name, head) for name in scope.declared)


def row_name(row: Span | None, name: str) -> Span | None:
    """The place of the name at the start of its row."""
    return Span(row.source, row.start, row.start + len(name)) if row else None


def check_rows(program: Program) -> Iterator[Diagnosis]:
    first: dict[str, Span | None] = {}
    for row in program.rows:
        place = row_name(row.span, row.name)
        if row.name in first:
            yield messages.duplicate_row(row.name, place, first[row.name])
        else:
            first[row.name] = place


def check_ranges(scope: Scope) -> Iterator[Diagnosis]:
    """Ends of ranges that name variables: these are there, and the functions are built in."""
    ranges = (row.range for row in scope.program.rows if row.range is not None)
    for end in (end for limits in ranges for end in (limits.lower, limits.upper) if end is not None):
        yield from check_constant(end)
        for node in walk(end):
            if isinstance(node, Name) and node.name not in scope.names:
                yield messages.unknown_end(node.name, node.span, scope.names)


def check_givens(scope: Scope) -> Iterator[Diagnosis]:
    for node in scope.contents.givens:
        if node.name not in scope.names:
            yield messages.unknown_given(node.name, node.span, scope.names)


def check_symbols(scope: Scope) -> Iterator[Diagnosis]:
    own = scope.program.functions
    passed = {
        id(argument)
        for call in scope.contents.inner_calls
        if call.function.lower() in own
        for argument in call.arguments
    }
    for symbol in scope.contents.misplaced:
        if id(symbol) not in passed:
            yield messages.symbol_in_arithmetic(symbol.name, symbol.span)
    for comparison in scope.contents.comparisons:
        yield from _check_order(comparison)


def _check_order(comparison: Comparison) -> Iterator[Diagnosis]:
    if comparison.operator in ("=", "<>"):
        return
    for side in (comparison.left, comparison.right):
        if isinstance(side, Symbol):
            yield messages.symbol_by_order(comparison.operator, side.name, comparison.span)
            return


def check_constant(expression: Expression) -> Iterator[Diagnosis]:
    """An input as written: numbers and built-in functions, no arithmetic with symbols."""
    for node in walk(expression):
        if isinstance(node, Call):
            yield from check_builtin(node)
        for part in children(node):
            if isinstance(part, Symbol):
                yield messages.symbol_in_arithmetic(part.name, part.span)


def check_tuples(scope: Scope) -> Iterator[Diagnosis]:
    rule: Equality
    for rule in scope.contents.unlike:
        yield messages.unlike_tuples(len(rule.left), len(rule.right), rule.span)


def check_head(function: Function) -> Iterator[Diagnosis]:
    if function.name.lower() in TABLE or function.name.lower() in PLANNED:
        yield messages.shadows_builtin(function)
    roles: dict[str, list[str]] = {}
    for role, names in (
        ("an argument", function.arguments),
        ("a result", function.results),
        ("a parameter", function.parameters),
    ):
        for name in names:
            roles.setdefault(name, []).append(role)
    for name, held in roles.items():
        if len(held) > 1:
            yield messages.repeated_in_head(function, name, _join(held))


def _join(held: list[str]) -> str:
    """``an argument and a result``, or ``twice an argument``."""
    distinct = list(dict.fromkeys(held))
    return " and ".join(distinct) if len(distinct) > 1 else f"twice {distinct[0]}"
