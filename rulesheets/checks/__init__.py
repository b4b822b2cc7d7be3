"""What a parsed program must satisfy before its calls are expanded."""

from __future__ import annotations

from collections.abc import Collection, Iterator

from rulesheets.checks.names import (
    Scope,
    check_builtin,
    check_calls,
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
    name_in,
)
from rulesheets.diagnosis import Diagnosis, RuleSheetError, error, labels, meant, said, suggestion
from rulesheets.marks import PLACES, marks_of, parts
from rulesheets.syntax.nodes import Call, Expression, Figure, Mark, Name, Symbol
from rulesheets.syntax.program import Program, walk
from rulesheets.syntax.source import Span


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
    yield from check_names(scope)
    yield from check_nesting(scope)
    yield from check_tuples(scope)
    yield from check_symbols(scope)
    yield from check_givens(scope)
    yield from check_calls(scope)


def check_figures(program: Program, variables: Collection[str]) -> Iterator[Diagnosis]:
    """Names in figures are those of variables, or of points beside them.

    ``variables`` are all of the model by their full names, locals of calls among them.
    """
    first: dict[str, Figure] = {}
    for figure in program.sheet.figures:
        earlier = first.setdefault(figure.name, figure)
        if earlier is not figure:
            yield _twice("figure", figure.name, _head(figure), _head(earlier))
        yield from _check_figure(figure, variables, program.functions)


def _check_figure(
    figure: Figure, variables: Collection[str], functions: Collection[str]
) -> Iterator[Diagnosis]:
    points: dict[str, Mark] = {}
    for mark in marks_of(figure):
        if mark.kind in PLACES and mark.name is not None:
            earlier = points.setdefault(mark.name, mark)
            if earlier is not mark:
                yield _twice("point", mark.name, mark.span, earlier.span)
    for mark in marks_of(figure):
        named, reckoned = parts(mark)
        for name in named:
            if name.name not in points:
                notes = suggestion(name.name, points) or (f"add point {name.name} = (x, y)",)
                message = f"the figure {figure.name} has no point {name.name}"
                yield said("E231", message, name.span, *notes)
        for expression in reckoned:
            yield from _check_expression(expression, variables, functions)


def _check_expression(
    expression: Expression, variables: Collection[str], functions: Collection[str]
) -> Iterator[Diagnosis]:
    for node in walk(expression):
        if isinstance(node, Name) and node.name not in variables:
            notes = meant(node.name, variables) or ("a figure names variables of the rules",)
            yield said("E230", f"there is no variable {node.name}", node.span, *notes)
        elif isinstance(node, Call) and node.function in functions:
            message = f"a figure cannot call {node.function}, which is a function of rules"
            yield said("E201", message, name_in(node), "call it in a rule, and name its results here")
        elif isinstance(node, Call):
            yield from check_builtin(node, (), variables)
        elif isinstance(node, Symbol):
            message = f"the symbol '{node.name} is no coordinate"
            yield said("E233", message, node.span, "a figure is drawn from numbers")


def _head(figure: Figure) -> Span | None:
    span = figure.span
    return span and Span(span.source, span.start, span.start + len("figure"))


def _twice(what: str, name: str, again: Span | None, first: Span | None) -> Diagnosis:
    return error(
        "E232",
        f"the {what} {name} is there twice",
        *labels((again, "again"), (first, "first here")),
        notes=("give one of the two another name",),
    )
