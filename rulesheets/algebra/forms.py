"""The built-in functions in sympy: as mathematics, and as names to be printed."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, TypeAlias

import sympy
from sympy import pi

Form: TypeAlias = Callable[..., Any]


def _radians(form: Form) -> Form:
    return lambda x: form(pi * x / 180)


def _degrees(form: Form) -> Form:
    return lambda *arguments: form(*arguments) * 180 / pi


def _truncated(x: Any) -> Any:
    return sympy.sign(x) * sympy.floor(sympy.Abs(x))


def _rounded(x: Any) -> Any:
    return sympy.sign(x) * sympy.floor(sympy.Abs(x) + sympy.Rational(1, 2))


def _bessel(kind: Form, order: int) -> Form:
    return lambda x: kind(order, x)


MATHEMATICS: Mapping[str, Form] = {
    "pi": lambda: pi,
    "e": lambda: sympy.E,
    "sqrt": sympy.sqrt,
    "abs": sympy.Abs,
    "sgn": sympy.sign,
    "int": _truncated,
    "frac": lambda x: x - _truncated(x),
    "round": _rounded,
    "mod": lambda x, y: x - y * _truncated(x / y),
    "step": lambda x, a: sympy.Heaviside(x - a, 1),
    "min": sympy.Min,
    "max": sympy.Max,
    "exp": sympy.exp,
    "ln": sympy.log,
    "log": lambda x: sympy.log(x) / sympy.log(10),
    "log10": lambda x: sympy.log(x) / sympy.log(10),
    "sin": sympy.sin,
    "cos": sympy.cos,
    "tan": sympy.tan,
    "asin": sympy.asin,
    "acos": sympy.acos,
    "atan": sympy.atan,
    "atan2": sympy.atan2,
    "sinh": sympy.sinh,
    "cosh": sympy.cosh,
    "tanh": sympy.tanh,
    "asinh": sympy.asinh,
    "acosh": sympy.acosh,
    "atanh": sympy.atanh,
    "sind": _radians(sympy.sin),
    "cosd": _radians(sympy.cos),
    "tand": _radians(sympy.tan),
    "asind": _degrees(sympy.asin),
    "acosd": _degrees(sympy.acos),
    "atand": _degrees(sympy.atan),
    "atan2d": _degrees(sympy.atan2),
    "gamma": sympy.gamma,
    "lgamma": lambda x: sympy.log(sympy.Abs(sympy.gamma(x))),
    "digamma": sympy.digamma,
    "erf": sympy.erf,
    "erfc": sympy.erfc,
    "beta": sympy.beta,
    "j0": _bessel(sympy.besselj, 0),
    "j1": _bessel(sympy.besselj, 1),
    "jn": sympy.besselj,
    "y0": _bessel(sympy.bessely, 0),
    "y1": _bessel(sympy.bessely, 1),
    "yn": sympy.bessely,
    "i0": _bessel(sympy.besseli, 0),
    "bessel_i1": _bessel(sympy.besseli, 1),
    "k0": _bessel(sympy.besselk, 0),
    "bessel_k1": _bessel(sympy.besselk, 1),
}
"""Every built-in function as sympy has it; angles of the degree functions in degrees."""


def _named(name: str) -> Form:
    return lambda *arguments: sympy.Function(name)(*arguments)


PRINTED: Mapping[str, Form] = {name: _named(name) for name in MATHEMATICS} | {
    "pi": lambda: pi,
    "sqrt": lambda x: sympy.sqrt(x, evaluate=False),
    "abs": lambda x: sympy.Abs(x, evaluate=False),
}
"""The same by their names in the language, so that a printed rule reads like the sheet."""
