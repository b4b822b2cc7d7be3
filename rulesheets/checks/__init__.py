"""What a parsed program must satisfy before its calls are expanded."""

from __future__ import annotations

from collections.abc import Iterator

from rulesheets.checks.figures import check_figures
from rulesheets.checks.names import (
    Scope,
    check_calls,
    check_declared,
    check_givens,
    check_head,
    check_names,
    check_nesting,
    check_ranges,
    check_recursion,
    check_rows,
    check_size,
    check_symbols,
    check_tuples,
)
from rulesheets.diagnosis import Diagnosis, RuleSheetError
from rulesheets.syntax.program import Program

__all__ = ["check", "check_figures"]


def check(program: Program) -> None:
    """Raise RuleSheetError with every complaint about names, symbols and calls, scope by scope."""
    complaints = tuple(_complaints(program))
    if complaints:
        raise RuleSheetError(*complaints)


def _complaints(program: Program) -> Iterator[Diagnosis]:
    sheet = Scope(program)
    functions = {name: Scope(program, function) for name, function in program.functions.items()}
    yield from check_rows(program)
    yield from check_ranges(sheet)
    yield from _check_scope(sheet)
    for function, scope in zip(program.functions.values(), functions.values(), strict=True):
        yield from check_head(function)
        yield from _check_scope(scope)
    rings = tuple(check_recursion(functions))
    yield from rings or check_size(sheet, functions)


def _check_scope(scope: Scope) -> Iterator[Diagnosis]:
    yield from check_declared(scope)
    yield from check_names(scope)
    yield from check_nesting(scope)
    yield from check_tuples(scope)
    yield from check_symbols(scope)
    yield from check_givens(scope)
    yield from check_calls(scope)
