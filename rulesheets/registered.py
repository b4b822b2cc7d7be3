"""Functions registered from Python: rows of the table with the facets that are given."""

from __future__ import annotations

import inspect
import math
import os
import re
import runpy
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextvars import ContextVar
from math import inf
from typing import Any

from rulesheets.deadline import setting
from rulesheets.diagnosis import refusal
from rulesheets.functions import PLANNED, TABLE
from rulesheets.functions.row import UNSURE, Function, Inverse, by_differences
from rulesheets.syntax.nodes import Expression, call, calls

PYTHON = "<python>"
"""The source of a function that no file of a sheet has registered."""
_NAME = re.compile(r"[^\W\d]\w*")
_source: ContextVar[str] = ContextVar("source", default=PYTHON)

Value = Callable[..., Any]


def function(
    name: str,
    value: Value,
    *,
    array: Value | None = None,
    derivative: Value | Sequence[Value | None] | None = None,
    inverse: Value | Sequence[Value] | None = None,
    image: tuple[float, float] = (-inf, inf),
    ulps: float = 0.0,
) -> None:
    """Make ``name`` a function of the language for every sheet that is read from now on.

    ``value`` maps floats, one for each of its parameters, to a float. It raises ValueError or an
    ArithmeticError, or returns nan, where it has none. ``ulps`` is by how many units in the last
    place it may differ from what the rules mean: they mean what it returns, unless told otherwise.
    ``array`` does the same for numpy arrays that broadcast; without it sweeps call ``value`` row by
    row. ``derivative`` is the slope, for several parameters a sequence with one for each; those
    that are missing are taken by differences. ``inverse`` maps t to the x with ``value(x) = t``;
    several are given as a sequence. They apply for t in ``image``; without them the equation is
    solved by search. Answers of equations that are solved through such a function are never called
    complete.

    A second registration replaces the first. Raises ValueError for a name that is no word or is
    taken by the language or another file, and for an inverse or derivatives that do not fit the
    parameters.
    """
    name = _checked_name(name)
    parameters = _parameters(value)
    slopes = _sequence(derivative)
    inverses = _sequence(inverse)
    if inverses and (len(parameters) != 1 or _is_endless(parameters)):
        named = ", ".join(parameters)
        raise ValueError(f"an inverse is of a function of one parameter; {name} has {named}")
    if len(slopes) > len(parameters):
        raise ValueError(f"{name} has {len(parameters)} parameters and {len(slopes)} derivatives")
    own, partials, backward = _row(name, value, parameters, ulps), {}, list[Function]()
    for place, slope in enumerate(slopes if not _is_endless(parameters) else ()):
        if slope is not None:
            told = _nth(f"slope_of_{name}", place)
            partials[place] = _row(told, slope, parameters, UNSURE)
    for place, one in enumerate(inverses):
        slope = (partials.get(0) or by_differences(own, 0)).value
        polished = _polished(own.value, slope, one)
        backward.append(_row(_nth(f"inverse_of_{name}", place), polished, ["t"], ulps))
    own = _row(name, value, parameters, ulps, array, partials, backward, image)
    TABLE.update({row.name: row for row in (*partials.values(), *backward, own)})


def _checked_name(name: str) -> str:
    if not _NAME.fullmatch(name):
        raise ValueError(f"{name!r} is not a name for a function: use letters, digits and _")
    name = name.lower()
    known = TABLE.get(name)
    if name in PLANNED or (known is not None and known.source is None):
        raise ValueError(f"{name} is a function of the language")
    if known is not None and known.source not in (_source.get(), PYTHON):
        raise ValueError(f"{known.source} has registered a function {name} already")
    return name


def _parameters(value: Value) -> list[str]:
    """The names of the required parameters; one ``…`` for any number of them."""
    try:
        every = inspect.signature(value).parameters.values()
    except ValueError:
        return ["x"]
    if any(one.kind is one.VAR_POSITIONAL for one in every):
        return ["x, …"]
    positional = (inspect.Parameter.POSITIONAL_ONLY, inspect.Parameter.POSITIONAL_OR_KEYWORD)
    return [one.name for one in every if one.kind in positional and one.default is one.empty]


def _is_endless(parameters: Sequence[str]) -> bool:
    return any(name.endswith("…") for name in parameters[-1:])


def _nth(name: str, place: int) -> str:
    return f"{name}_{place + 1}" if place else name


def _sequence(given: Value | Sequence[Any] | None) -> list[Any]:
    if given is None:
        return []
    return [given] if callable(given) else list(given)


def _row(
    name: str,
    value: Value,
    parameters: list[str],
    ulps: float,
    array: Value | None = None,
    partials: Mapping[int, Function] = {},
    backward: Sequence[Function] = (),
    image: tuple[float, float] = (-inf, inf),
) -> Function:
    def slopes(*arguments: Expression) -> tuple[Expression | None, ...]:
        rows = map(partials.get, range(len(arguments)))
        return tuple(None if row is None else call(row.name, *arguments) for row in rows)

    def branches(target: Expression) -> tuple[Expression, ...]:
        return tuple(call(row.name, target) for row in backward)

    return Function(
        name=name,
        value=_in_floats(name, value),
        arguments=", ".join(parameters),
        meaning=(inspect.getdoc(value) or "a function in Python").partition("\n")[0],
        slopes=slopes,
        inverse=Inverse(branches, *image) if backward else None,
        array=array and (lambda np, *arguments: array(*arguments)),
        ulps=ulps,
        source=_source.get(),
    )


def _in_floats(name: str, value: Value) -> Callable[..., float]:
    """The function as in ``math``: a finite float, or ValueError or an ArithmeticError.

    Raises RuleSheetError (E315) for any other exception, and for a result that is not a number.
    """

    def at(*arguments: float) -> float:
        try:
            found = value(*arguments)
            number = math.nan if isinstance(found, complex) else float(found)
        except (ArithmeticError, ValueError):
            raise
        except Exception as wrong:
            called = f"{name}({', '.join(f'{argument:.6g}' for argument in arguments)})"
            notes = (f"it raised {type(wrong).__name__}: {wrong}", *_line_of(wrong))
            raise refusal("E315", f"{called} failed in Python", None, *notes) from wrong
        if not math.isfinite(number):
            raise ValueError(f"{name} has no value there")
        return number

    return at


def _line_of(wrong: BaseException) -> tuple[str, ...]:
    trace = wrong.__traceback__
    while trace is not None and trace.tb_next is not None:
        trace = trace.tb_next
    return (f"in {trace.tb_frame.f_code.co_filename}, line {trace.tb_lineno}",) if trace else ()


def _polished(value: Value, slope: Value, inverse: Value) -> Value:
    """The inverse to the last digits: two steps of Newton's method from its result."""

    def at(t: float) -> float:
        x = float(inverse(t))
        for _ in range(2):
            try:
                better = x - (value(x) - t) / slope(x)
                x = better if abs(value(better) - t) < abs(value(x) - t) else x
            except (ArithmeticError, ValueError):
                break
        return x

    return at


def in_memory(expressions: Iterable[Expression]) -> bool:
    """Whether these call a function that only this process has, because no file registers it."""
    return any(TABLE[call.function].source == PYTHON for call in calls(*expressions))


# --- files ----------------------------------------------------------------------


def run_python(path: str) -> None:
    """Run a Python file that registers functions. Raises RuleSheetError (E314) where it fails."""
    try:
        with setting(_source, os.path.realpath(path)):
            runpy.run_path(path)
    except (Exception, SystemExit) as wrong:
        notes = (f"{type(wrong).__name__}: {wrong}", *_line_of(wrong))
        raise refusal("E314", f"{path} failed", None, *notes) from wrong
