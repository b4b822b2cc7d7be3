"""What the checks of names and calls say: the wording of every diagnosis, side by side."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from rulesheets.diagnosis import PROPERTIES, WRITE_IN_PYTHON, Diagnosis, error, labels, plural, suggestion
from rulesheets.functions import TABLE
from rulesheets.syntax.nodes import Call, CallRule, Function
from rulesheets.syntax.source import Span

_ELSEWHERE = {
    "convert": "write the factor as a number; values are converted where they are given: x = 3[in]",
    "converttemp": "temperatures are converted where they are given: --set T=20degC",
    "integral": "integrals are not there yet",
    **dict.fromkeys(PROPERTIES, WRITE_IN_PYTHON),
}
"""What stands in place of functions that people know from EES."""


def head_of(function: Function) -> Span | None:
    """The first line of a function: what it is called and what it takes."""
    span = function.span
    if span is None:
        return None
    end = span.source.text.find("\n", span.start, span.end)
    stop = span.end if end < 0 else end
    head = span.source.text[span.start : stop].split('"')[0].rstrip()
    return Span(span.source, span.start, span.start + len(head))


def name_in(call: Call | CallRule) -> Span | None:
    """The place of the function's name in a call."""
    span = call.span
    if span is None:
        return None
    start = span.text.lower().find(call.function.lower(), 4 if isinstance(call, CallRule) else 0)
    if start < 0:
        return span
    return Span(span.source, span.start + start, span.start + start + len(call.function))


def signature(function: Function) -> str:
    """``position(thetaAO; xA, xB)`` as the head says it."""
    return f"{function.name}({', '.join(function.arguments)}; {', '.join(function.results)})"


def unknown_function(call: Call | CallRule, known: Iterable[str], variables: Iterable[str]) -> Diagnosis:
    name = _as_written(call)
    notes = suggestion(call.function, known) or (
        "a function of your own is defined with `function`, or comes from a file named by `use`",
    )
    if call.function.lower() in _ELSEWHERE:
        notes = (_ELSEWHERE[call.function.lower()],)
    if name in variables:
        notes = (f"for a product with the variable {name} write {name}*(…)",)
    return error(
        "E201",
        f"there is no function {name}",
        *labels((name_in(call), "not known")),
        notes=notes,
    )


def _as_written(call: Call | CallRule) -> str:
    place = name_in(call)
    return place.text if place is not None and place != call.span else call.function


def planned_function(call: Call | CallRule) -> Diagnosis:
    return error(
        "E202",
        f"{call.function} works on lists, which are not there yet",
        *labels((name_in(call), "not there yet")),
        notes=("write the terms out, as in `a + b + c`",),
    )


def argument_count(call: Call | CallRule, expected: str, function: Function | None) -> Diagnosis:
    given = plural(len(call.arguments), "argument")
    place = head_of(function) if function else None
    usual = signature(function) if function else f"{call.function}({TABLE[call.function].arguments})"
    notes = (f"it is called as {usual}",)
    name = function.name if function else call.function
    return error(
        "E203",
        f"{name} takes {expected}, not {len(call.arguments) or 'none'}",
        *labels((call.span, f"{given} given"), (place, "defined here")),
        notes=notes,
    )


def result_count(call: Call | CallRule, function: Function, given: int) -> Diagnosis:
    expected = plural(len(function.results), "result")
    if isinstance(call, Call):
        message = f"{function.name} has {expected}, so it has no single value in an expression"
        notes = (f"call it on a line of its own: call {signature(function)}",)
    else:
        message = f"{function.name} gives {expected}, not {given or 'none'}"
        notes = (f"it is called as {signature(function)}",)
    return error(
        "E204",
        message,
        *labels((call.span, f"{plural(given, 'result')} asked for"), (head_of(function), "defined here")),
        notes=notes,
    )


def builtin_results(call: CallRule) -> Diagnosis:
    return error(
        "E204",
        f"{call.function} gives one result, not {len(call.results) or 'none'}",
        *labels((call.span, "")),
        notes=(f"write it in a rule: y = {call.function}(…)",),
    )


def unknown_parameter(
    call: Call | CallRule, function: Function, parameter: str, caller: str, known: Iterable[str]
) -> Diagnosis:
    cure = (
        f"name {parameter} in the variables section or in a rule of this sheet"
        if caller == "this sheet"
        else f"add {parameter} to the parameters of {caller}"
    )
    return error(
        "E205",
        f"{function.name} has the parameter {parameter}, but {caller} has no variable {parameter}",
        *labels((call.span, "called here"), (head_of(function), f"{parameter} is its parameter")),
        notes=(*suggestion(parameter, known), cure),
    )


def duplicate_function(function: Function, first: Function) -> Diagnosis:
    return error(
        "E206",
        f"the function {function.name} is defined twice",
        *labels((head_of(function), "defined again"), (head_of(first), "first defined here")),
        notes=("give one of the two another name (capitals do not count in function names)",),
    )


def shadows_builtin(function: Function) -> Diagnosis:
    return error(
        "E207",
        f"{function.name} is a built-in function and cannot be defined anew",
        *labels((head_of(function), "")),
        notes=(f"give it a name of its own, such as my_{function.name}",),
    )


def recursion(chain: Sequence[Function], calls: Sequence[Call | CallRule]) -> Diagnosis:
    """``chain[k]`` calls ``chain[k + 1]`` in ``calls[k]``, and the last one the first."""
    ring = " → ".join(function.name for function in (*chain, chain[0]))
    message = (
        f"{chain[0].name} calls itself" if len(chain) == 1 else f"{chain[0].name} calls itself through others"
    )
    targets = (*chain[1:], chain[0])
    places = [
        (call.span, f"{caller.name} calls {target.name}")
        for caller, target, call in zip(chain, targets, calls, strict=True)
    ]
    return error(
        "E208",
        message,
        *labels(*places),
        notes=(f"the calls go round: {ring}; rules of a function cannot lead back to it",),
    )


def repeated_in_head(function: Function, name: str, roles: str) -> Diagnosis:
    return error(
        "E209",
        f"{name} is {roles} of {function.name}",
        *labels((head_of(function), f"{name} has one role too many")),
        notes=("a name is either an argument, a result or a parameter, and is listed once",),
    )


def name_of_function(name: str, place: Span | None, function: Function | None) -> Diagnosis:
    use = f"{function.name}({', '.join(function.arguments)})" if function else f"{name}(x)"
    return error(
        "E210",
        f"{name} is a function, not a variable",
        *labels((place, "the name of a function")),
        notes=(f"call it as {use}, or give the variable another name",),
    )


def symbol_in_arithmetic(symbol: str, place: Span | None) -> Diagnosis:
    return error(
        "E211",
        f"the symbol '{symbol} is no number, so there is no arithmetic with it",
        *labels((place, "a symbol")),
        notes=(
            f"a symbol can be given to a variable (x = '{symbol}) or be compared by = and <>",
            f"if the variable {symbol} is meant, leave out the apostrophe",
        ),
    )


def symbol_by_order(operator: str, symbol: str, place: Span | None) -> Diagnosis:
    return error(
        "E212",
        f"the symbol '{symbol} is neither greater nor smaller than anything",
        *labels((place, f"compared by {operator}")),
        notes=("symbols are compared by = and <> only",),
    )


def unlike_tuples(left: int, right: int, place: Span | None) -> Diagnosis:
    return error(
        "E213",
        f"the two sides differ in length: {left} on the left, {right} on the right",
        *labels((place, "one equation for each pair")),
        notes=("write as many expressions on either side, as in (a, b) = (c, d)",),
    )


def unknown_given(name: str, place: Span | None, known: Iterable[str]) -> Diagnosis:
    return error(
        "E214",
        f"given('{name}) asks for a variable that is not there",
        *labels((place, "")),
        notes=suggestion(name, known) or (f"no rule and no row names {name}",),
    )


def unknown_end(name: str, place: Span | None, known: Iterable[str]) -> Diagnosis:
    return error(
        "E218",
        f"the end of a range names {name}, which is no variable of this sheet",
        *labels((place, "")),
        notes=suggestion(name, known) or (f"no rule and no other row names {name}",),
    )


def duplicate_row(name: str, place: Span | None, first: Span | None) -> Diagnosis:
    return error(
        "E215",
        f"{name} stands twice in the variables section",
        *labels((place, "again"), (first, "first here")),
        notes=("keep one of the two rows",),
    )


def too_large(place: Span | None, reason: str) -> Diagnosis:
    return error(
        "E216", reason, *labels((place, "called here")), notes=("call fewer functions in functions",)
    )


def too_deep(place: Span | None, limit: int) -> Diagnosis:
    return error(
        "E217",
        f"this expression nests more than {limit} levels deep",
        *labels((place, "every factor of a long product is a level")),
        notes=("split it over several rules",),
    )
