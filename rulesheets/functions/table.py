"""The table of built-in functions. A new function of the language is a new row."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from math import inf

from rulesheets.construct import call, negative, subtract
from rulesheets.functions import degrees, special
from rulesheets.functions import derivatives as slope
from rulesheets.functions.builtin import Builtin, Partials
from rulesheets.functions.preimages import PREIMAGES
from rulesheets.nodes import Expression, Number


def _least(*numbers: float) -> float:
    return min(numbers)


def _greatest(*numbers: float) -> float:
    return max(numbers)


def _row(
    name: str,
    value: Callable[..., float],
    derivatives: Partials,
    arity: tuple[int, int | None] = (1, 1),
    domain: tuple[float, float] = (-inf, inf),
) -> Builtin:
    return Builtin(name, arity, value, derivatives, PREIMAGES.get(name), domain)


def _of(name: str) -> Callable[[Expression], Expression]:
    return lambda x: call(name, x)


def _minus(name: str) -> Callable[[Expression], Expression]:
    return lambda x: negative(call(name, x))


_one, _per_degree, _to_degrees = slope.one, slope.per_degree, slope.to_degrees
_TWO_ARGUMENTS = (2, 2)
_ANY_NUMBER = (1, None)

_ROWS = (
    # constants
    _row("pi", lambda: math.pi, slope.flat, (0, 0)),
    _row("e", lambda: math.e, slope.flat, (0, 0)),
    # parts of a number
    _row("abs", abs, _one(_of("sgn"))),
    _row("sgn", special.sgn, slope.flat),
    _row("int", special.int_, slope.flat),
    _row("frac", special.frac, _one(lambda _: Number(1.0))),
    _row("round", special.round_, slope.flat),
    _row("mod", special.mod, slope.mod, _TWO_ARGUMENTS),
    _row("step", special.step, slope.flat, _TWO_ARGUMENTS),
    _row("min", _least, slope.least, _ANY_NUMBER),
    _row("max", _greatest, slope.greatest, _ANY_NUMBER),
    # roots, exponentials, logarithms
    _row("sqrt", math.sqrt, _one(slope.sqrt), domain=(0.0, inf)),
    _row("exp", math.exp, _one(_of("exp"))),
    _row("ln", math.log, _one(slope.over(1.0)), domain=(0.0, inf)),
    _row("log", math.log10, _one(slope.over(slope.LOG10_E)), domain=(0.0, inf)),
    _row("log10", math.log10, _one(slope.over(slope.LOG10_E)), domain=(0.0, inf)),
    # angles in radians
    _row("sin", math.sin, _one(_of("cos"))),
    _row("cos", math.cos, _one(_minus("sin"))),
    _row("tan", math.tan, _one(slope.secant_squared("tan"))),
    _row("asin", math.asin, _one(slope.arc_sine), domain=(-1.0, 1.0)),
    _row("acos", math.acos, _one(lambda x: negative(slope.arc_sine(x))), domain=(-1.0, 1.0)),
    _row("atan", math.atan, _one(slope.arc_tangent)),
    _row("atan2", special.atan2, slope.radians, _TWO_ARGUMENTS),
    # angles in degrees
    _row("sind", degrees.sind, _per_degree(_of("cosd"))),
    _row("cosd", degrees.cosd, _per_degree(_minus("sind"))),
    _row("tand", degrees.tand, _per_degree(slope.secant_squared("tand"))),
    _row("asind", degrees.asind, _to_degrees(slope.arc_sine), domain=(-1.0, 1.0)),
    _row("acosd", degrees.acosd, _to_degrees(lambda x: negative(slope.arc_sine(x))), domain=(-1.0, 1.0)),
    _row("atand", degrees.atand, _to_degrees(slope.arc_tangent)),
    _row("atan2d", degrees.atan2d, slope.degrees, _TWO_ARGUMENTS),
    # hyperbolic
    _row("sinh", math.sinh, _one(_of("cosh"))),
    _row("cosh", math.cosh, _one(_of("sinh"))),
    _row("tanh", math.tanh, _one(lambda x: subtract(Number(1.0), slope.square(call("tanh", x))))),
    _row("asinh", math.asinh, _one(slope.area_sine)),
    _row("acosh", math.acosh, _one(slope.area_cosine), domain=(1.0, inf)),
    _row("atanh", math.atanh, _one(slope.area_tangent), domain=(-1.0, 1.0)),
    # gamma and error functions
    _row("gamma", math.gamma, _one(slope.gamma)),
    _row("lgamma", math.lgamma, _one(_of("digamma"))),
    _row("digamma", special.digamma, slope.unknown),
    _row("beta", special.beta, slope.beta, _TWO_ARGUMENTS),
    _row("erf", math.erf, _one(slope.error_function(1.0))),
    _row("erfc", math.erfc, _one(slope.error_function(-1.0))),
    # Bessel functions; the modified ones of order 1 serve as derivatives
    _row("j0", special.j0, _one(_minus("j1"))),
    _row("j1", special.j1, _one(slope.bessel_first("j1"))),
    _row("jn", special.jn, slope.bessel_order("jn"), _TWO_ARGUMENTS),
    _row("y0", special.y0, _one(_minus("y1")), domain=(0.0, inf)),
    _row("y1", special.y1, _one(slope.bessel_first("y1")), domain=(0.0, inf)),
    _row("yn", special.yn, slope.bessel_order("yn"), _TWO_ARGUMENTS),
    _row("i0", special.i0, _one(_of("bessel_i1"))),
    _row("bessel_i1", special.i1, _one(slope.bessel_i1)),
    _row("k0", special.k0, _one(_minus("bessel_k1")), domain=(0.0, inf)),
    _row("bessel_k1", special.k1, _one(slope.bessel_k1), domain=(0.0, inf)),
)

TABLE: Mapping[str, Builtin] = {row.name: row for row in _ROWS}
"""Every built-in function by its name in lower case."""

PLANNED: frozenset[str] = frozenset({"sum", "prod", "count"})
"""Functions over lists, which the language does not have yet."""
