"""Functions registered from Python: rows of the table with the facets that are given."""

from __future__ import annotations

import inspect
import math
import os
import re
import runpy
from collections.abc import Callable, Iterable, Sequence
from contextvars import ContextVar
from math import inf
from typing import Any

from rulesheets.deadline import setting
from rulesheets.diagnosis import refusal
from rulesheets.functions import PLANNED, TABLE
from rulesheets.functions.intervals import EPSILON
from rulesheets.functions.row import Function, Inverse
from rulesheets.syntax.nodes import Expression, call, calls

PYTHON = "<python>"
"""The source of a function that no file of a sheet has registered."""
STEP = 1e-3
"""The relative step of differences: about the fifth root of the rounding of floats."""
TOLD = 1e-3
"""The relative error beyond which a slope by differences is rejected."""
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
    if inverses and (len(parameters) != 1 or parameters[0].endswith("…")):
        named = ", ".join(parameters)
        raise ValueError(f"an inverse is of a function of one parameter; {name} has {named}")
    if len(slopes) > len(parameters):
        raise ValueError(f"{name} has {len(parameters)} parameters and {len(slopes)} derivatives")
    own = _row(name, value, parameters, ulps)
    partials, backward = list[Function](), list[Function]()
    for place in range(0 if parameters[-1:] and parameters[-1].endswith("…") else len(parameters)):
        slope = _slope(own.value, slopes, place)
        partials.append(_row(_nth(f"slope_of_{name}", place), slope, parameters, EPSILON**-0.5))
    for place, one in enumerate(inverses):
        polished = _polished(own.value, partials[0].value, one)
        backward.append(_row(_nth(f"inverse_of_{name}", place), polished, ["t"], ulps))
    own = _row(name, value, parameters, ulps, array, partials, backward, image)
    TABLE.update({row.name: row for row in (*partials, *backward, own)})


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
    partials: Sequence[Function] = (),
    backward: Sequence[Function] = (),
    image: tuple[float, float] = (-inf, inf),
) -> Function:
    def slopes(*arguments: Expression) -> tuple[Expression, ...]:
        return tuple(call(row.name, *arguments) for row in partials)

    def branches(target: Expression) -> tuple[Expression, ...]:
        return tuple(call(row.name, target) for row in backward)

    return Function(
        name=name,
        value=_in_floats(name, value),
        arguments=", ".join(parameters),
        meaning=(inspect.getdoc(value) or "a function in Python").partition("\n")[0],
        slopes=slopes if partials else None,
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


# --- slopes by differences ------------------------------------------------------


def _slope(value: Callable[..., float], slopes: Sequence[Value | None], place: int) -> Value:
    def by_differences(*arguments: float) -> float:
        slope, wrong = slope_by_differences(value, place, arguments)
        scale = abs(value(*arguments)) / (abs(arguments[place]) or 1.0)
        if not wrong <= TOLD * max(abs(slope), scale):
            raise ValueError("finite differences give no slope there")
        return slope

    own = slopes[place] if place < len(slopes) else None
    return by_differences if own is None else own


def slope_by_differences(
    value: Callable[..., float], place: int, arguments: tuple[float, ...]
) -> tuple[float, float]:
    """The partial derivative by the argument at ``place``, and a bound of its error.

    Central differences of two steps, extrapolated (L. F. Richardson 1911), one-sided ones at the
    end of the domain; the error is what the extrapolation changes, and the rounding of ``value``.
    Raises ValueError or an ArithmeticError where the function is not defined on either side.
    """
    x = arguments[place]
    step = STEP * (abs(x) or 1.0)

    def at(shift: float) -> float:
        return value(*arguments[:place], x + shift, *arguments[place + 1 :])

    def central(h: float) -> float:
        return (at(h) - at(-h)) / (2.0 * h)

    def forward(h: float) -> float:
        return (4.0 * at(h) - at(2.0 * h) - 3.0 * at(0.0)) / (2.0 * h)

    rounding = 16.0 * EPSILON * abs(at(0.0)) / step
    for difference, h in ((central, step), (forward, step), (forward, -step)):
        try:
            coarse, fine = difference(h), difference(0.5 * h)
        except (ArithmeticError, ValueError):
            continue
        better = fine + (fine - coarse) / 3.0
        return better, abs(fine - coarse) + rounding
    raise ValueError("the function is not defined beside this point")


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
