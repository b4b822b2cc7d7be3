"""Expressions and conditions of the rule sheet language by mpmath alone: a witness that shares no
code.

The text is turned into Python by rewriting ``^``, ``=`` and numbers, and evaluated with 50 digits.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping
from functools import cache
from types import CodeType
from typing import Any

import mpmath
from mpmath import mpf

DIGITS = 50
MOST_BITS = 100_000
DECADES_A_BIT = math.log10(2.0)
_NUMBER = re.compile(r"(?<![\w.])(\d+\.?\d*(?:[eE][+-]?\d+)?|\.\d+(?:[eE][+-]?\d+)?)")


class Undefined(Exception):
    """There is no real value."""


def evaluated(text: str, values: Mapping[str, Any], digits: int = DIGITS) -> Any:
    """The value with 50 digits (more where numbers are large or small, for whole turns and
    cancellation); floats are the exact numbers that they are. Raises Undefined."""
    code = _code(text)
    read = {name: values[name] for name in code.co_names if name in values}
    decades = max(
        [_decades(text), *(abs(mpmath.mag(v)) * DECADES_A_BIT for v in read.values() if v)]
    )
    with mpmath.workdps(digits + (4 * round(decades) if decades > 12 else 0)):
        numbers = {name: mpf(value) for name, value in read.items()}
        try:
            found = eval(code, dict(FUNCTIONS), numbers)
        except (ArithmeticError, ValueError, mpmath.libmp.ComplexResult) as error:
            raise Undefined(text) from error
        if isinstance(found, bool):
            return found
        if isinstance(found, mpmath.mpc) or not mpmath.isfinite(found):
            raise Undefined(text)
        return found


@cache
def _decades(text: str) -> float:
    """How far the numbers in a text are from 1, in decades."""
    numbers = (float(digits) for digits in _NUMBER.findall(text))
    return max((abs(math.log10(number)) for number in numbers if number), default=0.0)


@cache
def _code(text: str) -> CodeType:
    text = _NUMBER.sub(r"number('\1')", text)
    text = re.sub(r"(?<![<>])=", "==", text).replace("<>", "!=")
    return compile(text.replace("^", "**"), "<rule>", "eval")


def _real(function: Callable[..., Any], known_at_0: bool) -> Callable[..., Any]:
    """The function over the reals: complex and infinite arguments and values are refused.

    ``known_at_0``: nearer to 0 than digits show it is what it is at 0, or goes as its argument
    does.
    """

    def value(*arguments: Any) -> Any:
        if known_at_0:
            tiny = mpf(2) ** -MOST_BITS
            arguments = tuple(mpmath.sign(x) * tiny if 0 < abs(x) < tiny else x for x in arguments)
        if any(number and abs(mpmath.mag(number)) > MOST_BITS for number in arguments):
            raise ValueError("too large or too small a number for mpmath's functions")
        return _checked(function(*map(_checked, arguments)))

    return value


def _checked(number: Any) -> Any:
    if isinstance(number, mpmath.mpc) or not mpmath.isfinite(number):
        raise ValueError("no real value")
    return number


def _truncated(x: Any) -> Any:
    return mpmath.floor(x) if x >= 0 else mpmath.ceil(x)


def _exact_turn(function: Callable[[Any], Any]) -> Callable[[Any], Any]:
    """A function of degrees by that of half turns, which is exact where the answer is."""

    def value(x: Any) -> Any:
        return function(mpmath.sign(x) * mpmath.fmod(abs(x), 360) / 180)

    return value


def _direction(y: Any, x: Any) -> Any:
    """In (-π, π]; the origin has none."""
    if x == y == 0:
        raise ValueError("the origin has no direction")
    return mpmath.atan2(y, x) if y else mpmath.mpf(0) if x > 0 else +mpmath.pi


def _tand(x: Any) -> Any:
    return _exact_turn(mpmath.sinpi)(x) / _exact_turn(mpmath.cospi)(x)


_FUNCTIONS: Mapping[str, Callable[..., Any]] = {
    "sin": mpmath.sin,
    "cos": mpmath.cos,
    "tan": mpmath.tan,
    "asin": mpmath.asin,
    "acos": mpmath.acos,
    "atan": mpmath.atan,
    "exp": mpmath.exp,
    "ln": mpmath.ln,
    "log": mpmath.log10,
    "log10": mpmath.log10,
    "sqrt": mpmath.sqrt,
    "abs": abs,
    "sgn": mpmath.sign,
    "int": _truncated,
    "frac": lambda x: x - _truncated(x),
    "round": lambda x: mpmath.sign(x) * mpmath.floor(abs(x) + mpf(0.5)),
    "tanh": mpmath.tanh,
    "cosh": mpmath.cosh,
    "sind": _exact_turn(mpmath.sinpi),
    "cosd": _exact_turn(mpmath.cospi),
    "tand": _tand,
    "asind": lambda x: mpmath.asin(x) * 180 / mpmath.pi,
    "atand": lambda x: mpmath.atan(x) * 180 / mpmath.pi,
    "atan2": lambda y, x: _direction(y, x),
    "atan2d": lambda y, x: _direction(y, x) * 180 / mpmath.pi,
    "sinh": mpmath.sinh,
    "asinh": mpmath.asinh,
    "acosh": mpmath.acosh,
    "atanh": mpmath.atanh,
    "erf": mpmath.erf,
    "erfc": mpmath.erfc,
    "gamma": mpmath.gamma,
    "j0": mpmath.j0,
    "min": min,
    "max": max,
    "mod": lambda x, y: x - y * _truncated(x / y),
    "acosd": lambda x: mpmath.acos(x) * 180 / mpmath.pi,
}

_UNKNOWN_AT_0 = frozenset(
    {"ln", "log", "sqrt", "gamma", "sgn", "atan2", "atan2d", "min", "max", "mod", "acosh"}
)

FUNCTIONS: Mapping[str, Any] = {
    "__builtins__": {},
    "number": lambda digits: mpf(float(digits)),
    "pi": mpmath.pi,
    **{name: _real(function, name not in _UNKNOWN_AT_0) for name, function in _FUNCTIONS.items()},
}
