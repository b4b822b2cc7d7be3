"""The table of functions. A new function of the language is a new row."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial, reduce
from math import inf, pi, tau
from typing import Any

from rulesheets.functions import digits, floats, slopes
from rulesheets.functions.intervals import forms, magnitudes
from rulesheets.functions.intervals.forms import (
    POSITIVE,
    SPECIAL_ULPS,
    UNIT,
    Direction,
    Even,
    Monotone,
    SecondKind,
    Slow,
    Valley,
    Wave,
    each_end,
)
from rulesheets.functions.row import Branches, Function, Inverse
from rulesheets.syntax.nodes import Expression, Number, add, call, negative, power, subtract

_HALF, _TURN = 180.0, 360.0


def _by(name: str) -> Branches:
    return lambda t: (call(name, t),)


def _both_signs(name: str) -> Branches:
    return lambda t: (call(name, t), negative(call(name, t)))


def _supplement(name: str, half_turn: Expression) -> Branches:
    return lambda t: (call(name, t), subtract(half_turn, call(name, t)))


def _opposite(name: str, half_turn: Expression) -> Branches:
    return lambda t: (call(name, t), add(call(name, t), half_turn))


_PI, _HALF_TURN = call("pi"), Number(_HALF)
_power_of_ten = Inverse(lambda t: (power(Number(10.0), t),))


def _row(*, name: str, **facets: Any) -> Function:
    """A row whose forms in the libraries have the name of the function, unless it says otherwise."""
    return Function(name=name, **{"array": name, "digits": name, "ball": name, "sympy": name} | facets)


_special = partial(_row, ulps=16.0)
_bessel = partial(_row, ulps=64.0)


def _circular(function: Callable[..., Any]) -> Callable[..., Any]:
    """A function of an angle in degrees, in sympy."""
    return lambda s, x: function(s)(s.pi * x / 180)


def _in_degrees(name: str) -> Callable[..., Any]:
    """An angle in degrees, in sympy."""
    return lambda s, *x: getattr(s, name)(*x) * 180 / s.pi


def _truncated(s: Any, x: Any) -> Any:
    return s.sign(x) * s.floor(s.Abs(x))


def _least(*numbers: float) -> float:
    return min(numbers)


def _greatest(*numbers: float) -> float:
    return max(numbers)


_CONSTANTS = (
    _row(
        name="pi",
        meaning="ratio of a circle's circumference to its diameter",
        example="pi = 3.141592653589793",
        arguments="",
        array=None,
        value=lambda: math.pi,
        slopes=slopes.flat,
        interval=forms.constant(math.pi),
        digits=lambda mp: +mp.pi,
        sympy=lambda s: s.pi,
    ),
    _row(
        name="e",
        meaning="base of natural logarithms; without parentheses e is a variable",
        example="ln(e()) = 1",
        arguments="",
        array=None,
        value=lambda: math.e,
        slopes=slopes.flat,
        interval=forms.constant(math.e),
        digits=lambda mp: +mp.e,
        ball="const_e",
        sympy=lambda s: s.E,
    ),
)

_PARTS = (
    _row(
        name="abs",
        meaning="absolute value",
        example="abs(-3) = 3",
        value=abs,
        slopes=slopes.of("sgn"),
        inverse=Inverse(lambda t: (t, negative(t)), low=0.0),
        interval=magnitudes,
        digits="fabs",
        ball=lambda arb, x: abs(x),
        sympy="Abs",
        smooth=False,
        alike=True,
        keeps_unit=True,
    ),
    _row(
        name="sgn",
        meaning="sign: -1, 0 or 1",
        example="sgn(-0.2) = -1",
        value=floats.sgn,
        array="sign",
        slopes=slopes.flat,
        interval=each_end(floats.sgn),
        digits="sign",
        sympy="sign",
        smooth=False,
        jumps=True,
        steady=lambda x: bool(x.lower().sgn() == x.upper().sgn()),
        alike=True,
    ),
    _row(
        name="int",
        meaning="integer part, rounded towards 0",
        example="int(-2.7) = -2",
        value=floats.int_,
        array="trunc",
        slopes=slopes.flat,
        interval=each_end(floats.int_),
        digits=digits.truncated,
        ball=digits.ball_truncated,
        sympy=_truncated,
        smooth=False,
        jumps=True,
        steady=digits.same_whole,
    ),
    _row(
        name="frac",
        meaning="fractional part, x - int(x)",
        example="frac(2.25) = 0.25",
        value=floats.frac,
        slopes=slopes.one(lambda _: Number(1.0)),
        interval=forms.frac,
        digits=digits.frac,
        ball=lambda arb, x: x - digits.ball_truncated(arb, x),
        sympy=lambda s, x: x - _truncated(s, x),
        smooth=False,
        jumps=True,
        steady=digits.same_whole,
    ),
    _row(
        name="round",
        meaning="nearest integer, halves away from 0",
        example="round(2.5) = 3",
        value=floats.round_,
        array="round_",
        slopes=slopes.flat,
        interval=each_end(floats.round_),
        digits=digits.rounded,
        ball=digits.ball_rounded,
        sympy=lambda s, x: s.sign(x) * s.floor(s.Abs(x) + s.Rational(1, 2)),
        smooth=False,
        jumps=True,
        steady=lambda x: digits.same_whole(x + x.sgn() / 2),
    ),
    _row(
        name="mod",
        meaning="remainder of x/y, with the sign of x",
        example="mod(-30, 360) = -30",
        arguments="x, y",
        value=floats.mod,
        array="fmod",
        slopes=slopes.mod,
        interval=forms.mod,
        digits=digits.mod,
        ball=digits.ball_mod,
        sympy=lambda s, x, y: x - y * _truncated(s, x / y),
        smooth=False,
        jumps=True,
        steady=lambda x, y: digits.same_whole(x / y),
        alike=True,
        keeps_unit=True,
    ),
    _row(
        name="step",
        meaning="1 if x >= a, else 0",
        example="step(2, 1) = 1",
        arguments="x, a",
        value=floats.step,
        slopes=slopes.flat,
        interval=forms.step,
        digits=lambda mp, x, a: mp.mpf(x >= a),
        ball=digits.ball_step,
        sympy=lambda s, x, a: s.Heaviside(x - a, 1),
        smooth=False,
        jumps=True,
        steady=lambda x, a: bool(x >= a or x < a),
        alike=True,
    ),
    _row(
        name="min",
        meaning="least of its arguments",
        example="min(3, 1, 2) = 1",
        arguments="a, b, …",
        value=_least,
        array="smallest",
        slopes=slopes.least,
        interval=forms.smallest,
        digits=lambda mp, *numbers: min(numbers),
        ball=lambda arb, *numbers: reduce(lambda a, b: a.min(b), numbers),
        sympy="Min",
        smooth=False,
        alike=True,
        keeps_unit=True,
    ),
    _row(
        name="max",
        meaning="greatest of its arguments",
        example="max(3, 1, 2) = 3",
        arguments="a, b, …",
        value=_greatest,
        array="largest",
        slopes=slopes.greatest,
        interval=forms.largest,
        digits=lambda mp, *numbers: max(numbers),
        ball=lambda arb, *numbers: reduce(lambda a, b: a.max(b), numbers),
        sympy="Max",
        smooth=False,
        alike=True,
        keeps_unit=True,
    ),
)

_EXPONENTIAL = (
    _row(
        name="sqrt",
        meaning="square root",
        example="sqrt(16) = 4",
        value=math.sqrt,
        slopes=slopes.one(slopes.sqrt),
        inverse=Inverse(lambda t: (power(t, Number(2.0)),), low=0.0),
        interval=Monotone(math.sqrt, POSITIVE, POSITIVE, ulps=1.0),
        domain=POSITIVE,
    ),
    _row(
        name="exp",
        meaning="exponential function",
        example="exp(0) = 1",
        value=math.exp,
        slopes=slopes.of("exp"),
        inverse=Inverse(_by("ln"), low=0.0, low_open=True),
        interval=Monotone(math.exp, image=POSITIVE),
        digits=digits.exp,
        nonzero=True,
    ),
    _row(
        name="ln",
        meaning="natural logarithm",
        example="ln(e()^2) = 2",
        value=math.log,
        array="log",
        slopes=slopes.one(slopes.over(1.0)),
        inverse=Inverse(_by("exp")),
        interval=Monotone(math.log, POSITIVE),
        ball="log",
        sympy="log",
        domain=POSITIVE,
    ),
    *(
        _row(
            name=name,
            meaning="logarithm to base 10",
            example=example,
            value=math.log10,
            array="log10",
            slopes=slopes.one(slopes.over(slopes.LOG10_E)),
            inverse=_power_of_ten,
            interval=Monotone(math.log10, POSITIVE),
            digits="log10",
            ball=lambda arb, x: x.log() / arb.const_log10(),
            sympy=lambda s, x: s.log(x) / s.log(10),
            domain=POSITIVE,
        )
        for name, example in (("log", "log(1000) = 3"), ("log10", "log10(0.01) = -2"))
    ),
)

_RADIANS = (
    _row(
        name="sin",
        meaning="sine of x radians",
        example="sin(pi/6) = 0.5",
        value=math.sin,
        slopes=slopes.of("cos"),
        inverse=Inverse(_supplement("asin", _PI), -1.0, 1.0, period=tau),
        interval=Wave(math.sin, tau, 0.25),
        turn=tau,
    ),
    _row(
        name="cos",
        meaning="cosine of x radians",
        example="cos(pi/3) = 0.5",
        value=math.cos,
        slopes=slopes.minus("sin"),
        inverse=Inverse(_both_signs("acos"), -1.0, 1.0, period=tau),
        interval=Wave(math.cos, tau, 0.0),
        turn=tau,
    ),
    _row(
        name="tan",
        meaning="tangent of x radians",
        example="tan(pi/4) = 1",
        value=math.tan,
        slopes=slopes.one(slopes.secant_squared("tan")),
        inverse=Inverse(_opposite("atan", _PI), period=tau),
        interval=forms.tan,
        turn=tau,
        half_turn=True,
    ),
    _row(
        name="asin",
        meaning="inverse sine, in radians from -pi/2 to pi/2",
        example="asin(1) = pi/2",
        value=math.asin,
        array="arcsin",
        slopes=slopes.one(slopes.arc_sine),
        inverse=Inverse(_by("sin"), -pi / 2, pi / 2),
        interval=Monotone(math.asin, UNIT),
        domain=UNIT,
        angle=tau,
    ),
    _row(
        name="acos",
        meaning="inverse cosine, in radians from 0 to pi",
        example="acos(-1) = pi",
        value=math.acos,
        array="arccos",
        slopes=slopes.one(lambda x: negative(slopes.arc_sine(x))),
        inverse=Inverse(_by("cos"), 0.0, pi),
        interval=Monotone(math.acos, UNIT, POSITIVE, falling=True),
        domain=UNIT,
        angle=tau,
    ),
    _row(
        name="atan",
        meaning="inverse tangent, in radians from -pi/2 to pi/2",
        example="atan(1) = pi/4",
        value=math.atan,
        array="arctan",
        slopes=slopes.one(slopes.arc_tangent),
        inverse=Inverse(_by("tan"), -pi / 2, pi / 2, True, True),
        interval=Monotone(math.atan),
        angle=tau,
    ),
    _row(
        name="atan2",
        meaning="angle of the point (x, y) in radians, to pi",
        example="atan2(1, -1) = 3*pi/4",
        arguments="y, x",
        value=floats.atan2,
        slopes=slopes.radians,
        interval=Direction(math.nextafter(pi, inf), 1.0),
        digits=digits.atan2,
        angle=tau,
        steady=digits.on_one_side,
        alike=True,
    ),
)

_DEGREES = (
    _row(
        name="sind",
        meaning="sine of x degrees",
        example="sind(30) = 0.5",
        value=floats.sind,
        slopes=slopes.per_degree(lambda x: call("cosd", x)),
        inverse=Inverse(_supplement("asind", _HALF_TURN), -1.0, 1.0, period=_TURN),
        interval=Wave(floats.sind, _TURN, 0.25),
        digits=digits.sind,
        ball=lambda arb, x: (x / 180).sin_pi(),
        sympy=_circular(lambda s: s.sin),
        turn=_TURN,
    ),
    _row(
        name="cosd",
        meaning="cosine of x degrees",
        example="cosd(90) = 0",
        value=floats.cosd,
        slopes=slopes.per_degree(lambda x: negative(call("sind", x))),
        inverse=Inverse(_both_signs("acosd"), -1.0, 1.0, period=_TURN),
        interval=Wave(floats.cosd, _TURN, 0.0),
        digits=digits.cosd,
        ball=lambda arb, x: (x / 180).cos_pi(),
        sympy=_circular(lambda s: s.cos),
        turn=_TURN,
    ),
    _row(
        name="tand",
        meaning="tangent of x degrees",
        example="tand(45) = 1",
        value=floats.tand,
        slopes=slopes.per_degree(slopes.secant_squared("tand")),
        inverse=Inverse(_opposite("atand", _HALF_TURN), period=_TURN),
        interval=forms.tand,
        digits=digits.tand,
        ball=lambda arb, x: (x / 180).tan_pi(),
        sympy=_circular(lambda s: s.tan),
        turn=_TURN,
        half_turn=True,
    ),
    _row(
        name="asind",
        meaning="inverse sine, in degrees from -90 to 90",
        example="asind(0.5) = 30",
        value=floats.asind,
        slopes=slopes.to_degrees(slopes.arc_sine),
        inverse=Inverse(_by("sind"), -90.0, 90.0),
        interval=Monotone(floats.asind, UNIT, (-90.0, 90.0)),
        digits=digits.in_degrees("asin"),
        ball=lambda arb, x: x.asin() / arb.pi() * 180,
        sympy=_in_degrees("asin"),
        domain=UNIT,
        angle=_TURN,
    ),
    _row(
        name="acosd",
        meaning="inverse cosine, in degrees from 0 to 180",
        example="acosd(0.5) = 60",
        value=floats.acosd,
        slopes=slopes.to_degrees(lambda x: negative(slopes.arc_sine(x))),
        inverse=Inverse(_by("cosd"), 0.0, _HALF),
        interval=Monotone(floats.acosd, UNIT, (0.0, _HALF), falling=True),
        digits=digits.in_degrees("acos"),
        ball=lambda arb, x: x.acos() / arb.pi() * 180,
        sympy=_in_degrees("acos"),
        domain=UNIT,
        angle=_TURN,
    ),
    _row(
        name="atand",
        meaning="inverse tangent, in degrees from -90 to 90",
        example="atand(1) = 45",
        value=floats.atand,
        slopes=slopes.to_degrees(slopes.arc_tangent),
        inverse=Inverse(_by("tand"), -90.0, 90.0, True, True),
        interval=Monotone(floats.atand, image=(-90.0, 90.0)),
        digits=digits.in_degrees("atan"),
        ball=lambda arb, x: x.atan() / arb.pi() * 180,
        sympy=_in_degrees("atan"),
        angle=_TURN,
    ),
    _row(
        name="atan2d",
        meaning="angle of the point (x, y) in degrees, to 180",
        example="atan2d(1, -1) = 135",
        arguments="y, x",
        value=floats.atan2d,
        slopes=slopes.degrees,
        interval=Direction(_HALF, _HALF / pi),
        digits=digits.atan2d,
        ball=digits.ball_direction,
        sympy=_in_degrees("atan2"),
        angle=_TURN,
        steady=digits.on_one_side,
        alike=True,
    ),
)

_HYPERBOLIC = (
    _row(
        name="sinh",
        meaning="hyperbolic sine",
        example="sinh(ln(2)) = 0.75",
        value=math.sinh,
        slopes=slopes.of("cosh"),
        inverse=Inverse(_by("asinh")),
        interval=Monotone(math.sinh),
        digits=digits.sinh,
    ),
    _row(
        name="cosh",
        meaning="hyperbolic cosine",
        example="cosh(ln(2)) = 1.25",
        value=math.cosh,
        slopes=slopes.of("sinh"),
        inverse=Inverse(_both_signs("acosh"), low=1.0),
        interval=Even(Monotone(math.cosh, POSITIVE, (1.0, inf))),
        digits=digits.cosh,
    ),
    _row(
        name="tanh",
        meaning="hyperbolic tangent",
        example="tanh(ln(2)) = 0.6",
        value=math.tanh,
        slopes=slopes.one(lambda x: subtract(Number(1.0), slopes.square(call("tanh", x)))),
        inverse=Inverse(_by("atanh"), -1.0, 1.0, True, True),
        interval=Monotone(math.tanh, image=UNIT),
    ),
    _row(
        name="asinh",
        meaning="inverse hyperbolic sine",
        example="asinh(0.75) = ln(2)",
        value=math.asinh,
        array="arcsinh",
        slopes=slopes.one(slopes.area_sine),
        inverse=Inverse(_by("sinh")),
        interval=Monotone(math.asinh),
    ),
    _row(
        name="acosh",
        meaning="inverse hyperbolic cosine, 0 or positive",
        example="acosh(1.25) = ln(2)",
        value=math.acosh,
        array="arccosh",
        slopes=slopes.one(slopes.area_cosine),
        inverse=Inverse(_by("cosh"), 0.0, inf),
        interval=Monotone(math.acosh, (1.0, inf), POSITIVE),
        domain=(1.0, inf),
    ),
    _row(
        name="atanh",
        meaning="inverse hyperbolic tangent",
        example="atanh(0.6) = ln(2)",
        value=math.atanh,
        array="arctanh",
        slopes=slopes.one(slopes.area_tangent),
        inverse=Inverse(_by("tanh")),
        interval=Monotone(math.atanh, UNIT),
        domain=UNIT,
    ),
)

_SPECIAL = (
    _special(
        name="gamma",
        meaning="gamma function",
        example="gamma(5) = 24",
        value=math.gamma,
        array="special.gamma",
        slopes=slopes.one(slopes.gamma),
        interval=Valley(math.gamma, forms.GAMMA_LEAST),
        nonzero=True,
    ),
    _special(
        name="lgamma",
        meaning="logarithm of |gamma(x)|",
        example="lgamma(5) = ln(24)",
        value=math.lgamma,
        array="special.gammaln",
        slopes=slopes.of("digamma"),
        interval=Valley(math.lgamma, forms.LGAMMA_LEAST),
        digits=digits.lgamma,
        ball=lambda arb, x: x.lgamma() if x > 0 else abs(x.gamma()).log(),
        sympy=lambda s, x: s.log(s.Abs(s.gamma(x))),
    ),
    _special(
        name="digamma",
        meaning="derivative of ln(gamma(x))",
        example="digamma(2) - digamma(1) = 1",
        value=floats.digamma,
        array="special.digamma",
        interval=forms.digamma,
    ),
    _bessel(
        name="beta",
        meaning="gamma(a)*gamma(b)/gamma(a + b)",
        example="beta(2, 3) = 1/12",
        arguments="a, b",
        value=floats.beta,
        array="special.beta",
        slopes=slopes.beta,
        interval=forms.beta,
        ball=lambda arb, a, b: a.gamma() * b.gamma() / (a + b).gamma(),
        nonzero=True,
    ),
    _special(
        name="erf",
        meaning="error function",
        example="erf(0.5) = 0.5204998778130465",
        value=math.erf,
        array="special.erf",
        slopes=slopes.one(slopes.error_function(1.0)),
        interval=Monotone(math.erf, image=UNIT, ulps=SPECIAL_ULPS),
        image=UNIT,
    ),
    _special(
        name="erfc",
        meaning="complementary error function, 1 - erf(x)",
        example="erfc(0.5) + erf(0.5) = 1",
        value=math.erfc,
        array="special.erfc",
        slopes=slopes.one(slopes.error_function(-1.0)),
        interval=Monotone(math.erfc, image=(0.0, 2.0), ulps=SPECIAL_ULPS, falling=True),
        nonzero=True,
        image=(0.0, 2.0),
    ),
)

_BESSEL = (
    _bessel(
        name="j0",
        meaning="Bessel function of the first kind, order 0",
        example="j0(0) = 1",
        value=floats.j0,
        array="special.j0",
        slopes=slopes.minus("j1"),
        interval=Slow(floats.j0, 0.5819, (-0.4028, 1.0)),
        digits=digits.at_order("besselj", 0),
        ball=lambda arb, x: x.bessel_j(0),
        sympy=lambda s, x: s.besselj(0, x),
    ),
    _bessel(
        name="j1",
        meaning="Bessel function of the first kind, order 1",
        example="j1(1) = 0.4400505857449335",
        value=floats.j1,
        array="special.j1",
        slopes=slopes.one(slopes.bessel_first("j1")),
        interval=Slow(floats.j1, 0.5, (-0.5819, 0.5819)),
        digits=digits.at_order("besselj", 1),
        ball=lambda arb, x: x.bessel_j(1),
        sympy=lambda s, x: s.besselj(1, x),
    ),
    _bessel(
        name="jn",
        meaning="Bessel function of the first kind, order n",
        example="jn(2, 1) = 2*j1(1) - j0(1)",
        arguments="n, x",
        value=floats.jn,
        slopes=slopes.bessel_order("jn"),
        interval=forms.jn,
        digits=digits.of_order("besselj"),
        ball=lambda arb, n, x: x.bessel_j(n),
        sympy="besselj",
    ),
    _bessel(
        name="y0",
        meaning="Bessel function of the second kind, order 0",
        example="y0(1) = 0.08825696421567696",
        value=floats.y0,
        array="special.y0",
        slopes=slopes.minus("y1"),
        interval=SecondKind(floats.y0, 2.19, -0.3404, 0.5209),
        digits=digits.at_order("bessely", 0),
        ball=lambda arb, x: x.bessel_y(0),
        sympy=lambda s, x: s.bessely(0, x),
        domain=POSITIVE,
    ),
    _bessel(
        name="y1",
        meaning="Bessel function of the second kind, order 1",
        example="y1(1) = -0.7812128213002887",
        value=floats.y1,
        array="special.y1",
        slopes=slopes.one(slopes.bessel_first("y1")),
        interval=SecondKind(floats.y1, 3.68, -0.3033, 0.4168),
        digits=digits.at_order("bessely", 1),
        ball=lambda arb, x: x.bessel_y(1),
        sympy=lambda s, x: s.bessely(1, x),
        domain=POSITIVE,
    ),
    _bessel(
        name="yn",
        meaning="Bessel function of the second kind, order n",
        example="yn(2, 1) = 2*y1(1) - y0(1)",
        arguments="n, x",
        value=floats.yn,
        slopes=slopes.bessel_order("yn"),
        digits=digits.of_order("bessely"),
        ball=lambda arb, n, x: x.bessel_y(n),
        sympy="bessely",
    ),
    _bessel(
        name="i0",
        meaning="modified Bessel function of the first kind, order 0",
        example="i0(0) = 1",
        value=floats.i0,
        array="special.i0",
        slopes=slopes.of("bessel_i1"),
        interval=forms.i0,
        digits=digits.at_order("besseli", 0),
        ball=lambda arb, x: x.bessel_i(0),
        sympy=lambda s, x: s.besseli(0, x),
    ),
    _row(
        name="bessel_i1",
        meaning="modified Bessel function, 1st kind, order 1",
        example="bessel_i1(1) = 0.565159103992485",
        value=floats.i1,
        array="special.i1",
        slopes=slopes.one(slopes.bessel_i1),
        interval=forms.i1,
        digits=digits.at_order("besseli", 1),
        ball=lambda arb, x: x.bessel_i(1),
        sympy=lambda s, x: s.besseli(1, x),
    ),
    _bessel(
        name="k0",
        meaning="modified Bessel function of the second kind, order 0",
        example="k0(1) = 0.4210244382407083",
        value=floats.k0,
        array="special.k0",
        slopes=slopes.minus("bessel_k1"),
        interval=Monotone(floats.k0, POSITIVE, POSITIVE, SPECIAL_ULPS, falling=True),
        digits=digits.at_order("besselk", 0),
        ball=lambda arb, x: x.bessel_k(0),
        sympy=lambda s, x: s.besselk(0, x),
        domain=POSITIVE,
        nonzero=True,
    ),
    _row(
        name="bessel_k1",
        meaning="modified Bessel function, 2nd kind, order 1",
        example="bessel_k1(2) = 0.1398658818165224",
        value=floats.k1,
        array="special.k1",
        slopes=slopes.one(slopes.bessel_k1),
        interval=Monotone(floats.k1, POSITIVE, POSITIVE, SPECIAL_ULPS, falling=True),
        digits=digits.at_order("besselk", 1),
        ball=lambda arb, x: x.bessel_k(1),
        sympy=lambda s, x: s.besselk(1, x),
        domain=POSITIVE,
        nonzero=True,
    ),
)
"""The modified Bessel functions of order 1 serve as derivatives."""

_ROWS = (*_CONSTANTS, *_PARTS, *_EXPONENTIAL, *_RADIANS, *_DEGREES, *_HYPERBOLIC, *_SPECIAL, *_BESSEL)

TABLE: dict[str, Function] = {row.name: row for row in _ROWS}
"""Every function by its name in lower case; functions registered from Python come at the end."""

PLANNED: frozenset[str] = frozenset({"sum", "prod", "count"})
"""Functions over lists, which the language does not have yet."""


def named(trait: Callable[[Function], Any]) -> frozenset[str]:
    """The names of the built-in functions that have a trait."""
    return frozenset(row.name for row in _ROWS if trait(row))
