"""The table of functions: a row each, with its values, slopes, inverse, ranges and traits.

A new function of the language is a new row. The table is cheap to import: the forms for arrays
(``arrays``), for many digits and for balls (``evaluate``) are in modules of their own, because each
needs a large library.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial, reduce
from math import inf, pi, tau
from typing import Any

from rulesheets.functions import digits, floats, intervals, row
from rulesheets.functions.intervals import (
    LINE,
    POSITIVE,
    SPECIAL_ULPS,
    UNIT,
    Even,
    Monotone,
    Wave,
    each_end,
    magnitudes,
)
from rulesheets.functions.row import Branches, Function, Inverse, flat
from rulesheets.syntax.nodes import ONE, Expression, Number, call


def _by(name: str) -> Branches:
    return lambda t: (call(name, t),)


def _both_signs(name: str) -> Branches:
    return lambda t: (call(name, t), -call(name, t))


def _row(name: str, meaning: str, example: str, **facets: Any) -> Function:
    """A row; its forms in the libraries have the same name unless given otherwise or defined."""
    named = ("array",) if "definition" in facets else ("array", "digits", "ball", "sympy")
    return Function(
        name=name, meaning=meaning, example=example, **dict.fromkeys(named, name) | facets
    )


_special = partial(_row, ulps=16.0)
_jumping = partial(_row, smooth=False, jumps=True)


def _extreme(choose: Callable[[tuple[Any, ...]], Any], word: str, example: str) -> Function:
    """The row of ``min`` or ``max``, named ``choose`` in Python."""
    name, chosen = choose.__name__, getattr(intervals, word)
    return _row(
        *(name, f"{word} of its arguments", example),
        arguments="a, b, …",
        value=lambda *numbers: choose(numbers),
        array=f"{word}_of",
        slopes=getattr(row, word),
        interval=lambda *ends: (reduce(chosen, ends[::2]), reduce(chosen, ends[1::2])),
        digits=lambda mp, *numbers: choose(numbers),
        ball=lambda arb, *numbers: reduce(lambda a, b: getattr(a, name)(b), numbers),
        sympy=name.title(),
        smooth=False,
        alike=True,
        keeps_unit=True,
    )


_CONSTANTS = (
    _row(
        *("pi", "ratio of a circle's circumference to its diameter", "pi = 3.141592653589793"),
        arguments="",
        array=None,
        value=lambda: math.pi,
        slopes=flat,
        interval=lambda: (math.pi, math.nextafter(math.pi, inf)),
        digits=lambda mp: +mp.pi,
        sympy=lambda s: s.pi,
    ),
    _row(
        *("e", "base of natural logarithms; without parentheses e is a variable", "ln(e()) = 1"),
        arguments="",
        array=None,
        value=lambda: math.e,
        slopes=flat,
        interval=lambda: (math.e, math.nextafter(math.e, inf)),
        digits=lambda mp: +mp.e,
        ball="const_e",
        sympy=lambda s: s.E,
    ),
)

_PARTS = (
    _row(
        *("abs", "absolute value", "abs(-3) = 3"),
        value=abs,
        slopes=lambda x: call("sgn", x),
        inverse=Inverse(lambda t: (t, -t), low=0.0),
        interval=magnitudes,
        digits="fabs",
        ball=lambda arb, x: abs(x),
        sympy="Abs",
        smooth=False,
        alike=True,
        keeps_unit=True,
    ),
    _jumping(
        *("sgn", "sign: -1, 0 or 1", "sgn(-0.2) = -1"),
        value=floats.sgn,
        array="sign",
        slopes=flat,
        interval=each_end(floats.sgn),
        digits="sign",
        sympy="sign",
        steady=lambda x: bool(x.lower().sgn() == x.upper().sgn()),
        alike=True,
    ),
    _jumping(
        *("int", "integer part, rounded towards 0", "int(-2.7) = -2"),
        value=floats.int_,
        array="trunc",
        slopes=flat,
        interval=each_end(floats.int_),
        digits=digits.truncated,
        ball=digits.ball_truncated,
        sympy=lambda s, x: s.sign(x) * s.floor(s.Abs(x)),
        steady=digits.same_whole,
    ),
    _jumping(
        *("frac", "fractional part, x - int(x)", "frac(2.25) = 0.25"),
        value=floats.frac,
        slopes=lambda x: ONE,
        interval=intervals.frac,
        definition=lambda x: x - call("int", x),
        steady=digits.same_whole,
    ),
    _jumping(
        *("round", "nearest integer, halves away from 0", "round(2.5) = 3"),
        value=floats.round_,
        array="round_",
        slopes=flat,
        interval=each_end(floats.round_),
        definition=lambda x: call("sgn", x) * call("int", call("abs", x) + ONE / 2.0),
        steady=lambda x: digits.same_whole(x + x.sgn() / 2),
    ),
    _jumping(
        *("mod", "remainder of x/y, with the sign of x", "mod(-30, 360) = -30"),
        arguments="x, y",
        value=math.fmod,
        array="fmod",
        slopes=lambda x, y: (ONE, -call("int", x / y)),
        interval=intervals.mod,
        definition=lambda x, y: x - y * call("int", x / y),
        steady=lambda x, y: digits.same_whole(x / y),
        alike=True,
        keeps_unit=True,
    ),
    _jumping(
        *("step", "1 if x >= a, else 0", "step(2, 1) = 1"),
        arguments="x, a",
        value=floats.step,
        slopes=flat,
        interval=intervals.step,
        digits=lambda mp, x, a: mp.mpf(x >= a),
        ball=digits.ball_step,
        sympy=lambda s, x, a: s.Heaviside(x - a, 1),
        steady=lambda x, a: bool(x >= a or x < a),
        alike=True,
    ),
    _extreme(min, "least", "min(3, 1, 2) = 1"),
    _extreme(max, "greatest", "max(3, 1, 2) = 3"),
)

_EXPONENTIAL = (
    _row(
        *("sqrt", "square root", "sqrt(16) = 4"),
        value=math.sqrt,
        slopes=lambda x: 0.5 / call("sqrt", x),
        inverse=Inverse(lambda t: (t**2.0,), low=0.0),
        interval=Monotone(math.sqrt, POSITIVE, POSITIVE, ulps=1.0),
        domain=POSITIVE,
    ),
    _row(
        *("exp", "exponential function", "exp(0) = 1"),
        value=math.exp,
        slopes=lambda x: call("exp", x),
        inverse=Inverse(_by("ln"), low=0.0, low_open=True),
        interval=Monotone(math.exp, image=POSITIVE),
        nonzero=True,
    ),
    _row(
        *("ln", "natural logarithm", "ln(e()^2) = 2"),
        value=math.log,
        array="log",
        slopes=lambda x: 1.0 / x,
        inverse=Inverse(_by("exp")),
        interval=Monotone(math.log, POSITIVE),
        ball="log",
        sympy="log",
        domain=POSITIVE,
    ),
    *(
        _row(
            *(name, "logarithm to base 10", example),
            value=math.log10,
            array="log10",
            slopes=lambda x: row.LOG10_E / x,
            inverse=Inverse(lambda t: (Number(10.0) ** t,)),
            interval=Monotone(math.log10, POSITIVE),
            digits="log10",
            definition=lambda x: call("ln", x) / call("ln", Number(10.0)),
            domain=POSITIVE,
        )
        for name, example in (("log", "log(1000) = 3"), ("log10", "log10(0.01) = -2"))
    ),
)


def _angular(end: str, unit: str, half: Expression, turn: float) -> tuple[Function, ...]:
    """The functions of angles in a unit, whose names have this ``end``; ``half`` is half a turn as
    text."""
    degrees = end == "d"
    radian, per_unit = (row.DEGREE, row.RADIAN) if degrees else (ONE, ONE)
    straight, right = ("180", "90") if degrees else ("pi", "pi/2")
    sin, cos, tan, asin, acos, atan, atan2 = (
        f"{name}{end}" for name in ("sin", "cos", "tan", "asin", "acos", "atan", "atan2")
    )

    def takes(name: str, word: str, example: str, **facets: Any) -> Function:
        if degrees:
            facets["digits"] = getattr(digits, f"{name}d")
            facets["ball"] = lambda arb, x: getattr(x / 180, f"{name}_pi")()
            facets["definition"] = lambda x: call(name, call("pi") * x / 180.0)
        value = getattr(floats, name + end)
        return _row(name + end, f"{word} of x {unit}", example, value=value, turn=turn, **facets)

    def gives(name: str, meaning: str, example: str, **facets: Any) -> Function:
        if degrees:
            facets["definition"] = lambda *x: call(name, *x) / call("pi") * 180.0
        elif name != "atan2":
            facets["array"] = f"arc{name[1:]}"
        value = getattr(floats, name + end)
        return _row(name + end, meaning, example, value=value, angle=turn, **facets)

    return (
        takes(
            *("sin", "sine", "sind(30) = 0.5" if degrees else "sin(pi/6) = 0.5"),
            slopes=lambda x: per_unit * call(cos, x),
            inverse=Inverse(
                lambda t: (call(asin, t), half - call(asin, t)), -1.0, 1.0, period=turn
            ),
            interval=Wave(getattr(floats, sin), turn, 0.25),
        ),
        takes(
            *("cos", "cosine", "cosd(90) = 0" if degrees else "cos(pi/3) = 0.5"),
            slopes=lambda x: per_unit * -call(sin, x),
            inverse=Inverse(_both_signs(acos), -1.0, 1.0, period=turn),
            interval=Wave(getattr(floats, cos), turn, 0.0),
        ),
        takes(
            *("tan", "tangent", "tand(45) = 1" if degrees else "tan(pi/4) = 1"),
            slopes=lambda x: per_unit * (1.0 + call(tan, x) ** 2.0),
            inverse=Inverse(lambda t: (call(atan, t), call(atan, t) + half), period=turn),
            interval=getattr(intervals, tan),
            half_turn=True,
        ),
        gives(
            *("asin", f"inverse sine, in {unit} from -{right} to {right}"),
            "asind(0.5) = 30" if degrees else "asin(1) = pi/2",
            slopes=lambda x: radian * row.arc_sine(x),
            inverse=Inverse(_by(sin), -turn / 4, turn / 4),
            interval=Monotone(getattr(floats, asin), UNIT, (-90.0, 90.0) if degrees else LINE),
            domain=UNIT,
        ),
        gives(
            *("acos", f"inverse cosine, in {unit} from 0 to {straight}"),
            "acosd(0.5) = 60" if degrees else "acos(-1) = pi",
            slopes=lambda x: radian * -row.arc_sine(x),
            inverse=Inverse(_by(cos), 0.0, turn / 2),
            interval=Monotone(
                getattr(floats, acos), UNIT, (0.0, 180.0) if degrees else POSITIVE, falling=True
            ),
            domain=UNIT,
        ),
        gives(
            *("atan", f"inverse tangent, in {unit} from -{right} to {right}"),
            "atand(1) = 45" if degrees else "atan(1) = pi/4",
            slopes=lambda x: radian * (1.0 / (1.0 + x**2.0)),
            inverse=Inverse(_by(tan), -turn / 4, turn / 4, True, True),
            interval=Monotone(getattr(floats, atan), image=(-90.0, 90.0) if degrees else LINE),
        ),
        gives(
            *("atan2", f"angle of the point (x, y) in {unit}, to {straight}"),
            "atan2d(1, -1) = 135" if degrees else "atan2(1, -1) = 3*pi/4",
            arguments="y, x",
            slopes=lambda y, x: (radian * x / (x**2.0 + y**2.0), -(radian * y / (x**2.0 + y**2.0))),
            interval=(
                intervals.direction(180.0, 180.0 / pi)
                if degrees
                else intervals.direction(math.nextafter(pi, inf), 1.0)
            ),
            steady=digits.on_one_side,
            alike=True,
            digits=getattr(digits, atan2),
            ball=digits.ball_direction if degrees else "atan2",
        ),
    )


_RADIANS = _angular("", "radians", call("pi"), tau)
_DEGREES = _angular("d", "degrees", Number(180.0), 360.0)

_HYPERBOLIC = (
    _row(
        *("sinh", "hyperbolic sine", "sinh(ln(2)) = 0.75"),
        value=math.sinh,
        slopes=lambda x: call("cosh", x),
        inverse=Inverse(_by("asinh")),
        interval=Monotone(math.sinh),
    ),
    _row(
        *("cosh", "hyperbolic cosine", "cosh(ln(2)) = 1.25"),
        value=math.cosh,
        slopes=lambda x: call("sinh", x),
        inverse=Inverse(_both_signs("acosh"), low=1.0),
        interval=Even(Monotone(math.cosh, POSITIVE, (1.0, inf))),
    ),
    _row(
        *("tanh", "hyperbolic tangent", "tanh(ln(2)) = 0.6"),
        value=math.tanh,
        slopes=lambda x: 1.0 - call("tanh", x) ** 2.0,
        inverse=Inverse(_by("atanh"), -1.0, 1.0, True, True),
        interval=Monotone(math.tanh, image=UNIT),
    ),
    _row(
        *("asinh", "inverse hyperbolic sine", "asinh(0.75) = ln(2)"),
        value=math.asinh,
        array="arcsinh",
        slopes=lambda x: 1.0 / call("sqrt", x**2.0 + 1.0),
        inverse=Inverse(_by("sinh")),
        interval=Monotone(math.asinh),
    ),
    _row(
        *("acosh", "inverse hyperbolic cosine, 0 or positive", "acosh(1.25) = ln(2)"),
        value=math.acosh,
        array="arccosh",
        slopes=lambda x: 1.0 / call("sqrt", (x - 1.0) * (x + 1.0)),
        inverse=Inverse(_by("cosh"), 0.0, inf),
        interval=Monotone(math.acosh, (1.0, inf), POSITIVE),
        domain=(1.0, inf),
    ),
    _row(
        *("atanh", "inverse hyperbolic tangent", "atanh(0.6) = ln(2)"),
        value=math.atanh,
        array="arctanh",
        slopes=lambda x: 1.0 / ((1.0 - x) * (1.0 + x)),
        inverse=Inverse(_by("tanh")),
        interval=Monotone(math.atanh, UNIT),
        domain=UNIT,
    ),
)

_SPECIAL = (
    _special(
        *("gamma", "gamma function", "gamma(5) = 24"),
        value=math.gamma,
        array="special.gamma",
        slopes=lambda x: call("gamma", x) * call("digamma", x),
        nonzero=True,
    ),
    _special(
        *("lgamma", "logarithm of |gamma(x)|", "lgamma(5) = ln(24)"),
        value=math.lgamma,
        array="special.gammaln",
        slopes=lambda x: call("digamma", x),
        digits=digits.lgamma,
        ball=lambda arb, x: x.lgamma() if x > 0 else abs(x.gamma()).log(),
        definition=lambda x: call("ln", call("abs", call("gamma", x))),
    ),
    _special(
        *("digamma", "derivative of ln(gamma(x))", "digamma(2) - digamma(1) = 1"),
        value=floats.digamma,
        array="special.digamma",
    ),
    _row(
        *("beta", "gamma(a)*gamma(b)/gamma(a + b)", "beta(2, 3) = 1/12"),
        arguments="a, b",
        value=floats.beta,
        ulps=64.0,
        array="special.beta",
        slopes=row.beta,
        digits="beta",
        sympy="beta",
        definition=lambda a, b: call("gamma", a) * call("gamma", b) / call("gamma", a + b),
        nonzero=True,
    ),
    _special(
        *("erf", "error function", "erf(0.5) = 0.5204998778130465"),
        value=math.erf,
        array="special.erf",
        slopes=lambda x: row.BELL * call("exp", -(x**2.0)),
        interval=Monotone(math.erf, image=UNIT, ulps=SPECIAL_ULPS),
        image=UNIT,
    ),
    _special(
        *("erfc", "complementary error function, 1 - erf(x)", "erfc(0.5) + erf(0.5) = 1"),
        value=math.erfc,
        array="special.erfc",
        slopes=lambda x: -row.BELL * call("exp", -(x**2.0)),
        interval=Monotone(math.erfc, image=(0.0, 2.0), ulps=SPECIAL_ULPS, falling=True),
        nonzero=True,
        image=(0.0, 2.0),
    ),
)


_KINDS = {
    "j": "Bessel function of the first kind",
    "y": "Bessel function of the second kind",
    "i": "modified Bessel function of the first kind",
    "k": "modified Bessel function of the second kind",
}


def _bessel(kind: str, order: int, example: str, name: str = "", **facets: Any) -> Function:
    """The row of a Bessel function of fixed order."""
    return _row(
        *(name or f"{kind}{order}", f"{_KINDS[kind]}, order {order}", example),
        value=getattr(floats, f"{kind}{order}"),
        array=f"special.{kind}{order}",
        digits=lambda mp, x: getattr(mp, f"bessel{kind}")(order, x),
        ball=lambda arb, x: getattr(x, f"bessel_{kind}")(order),
        sympy=lambda s, x: getattr(s, f"bessel{kind}")(order, x),
        ulps=64.0,
        swings=kind in "jy",
        **facets,
    )


def _bessel_n(kind: str, example: str) -> Function:
    """The row of a Bessel function by its order; its slope by that is not known."""
    name = f"{kind}n"
    return _row(
        *(name, f"{_KINDS[kind]}, order n", example),
        arguments="n, x",
        value=getattr(floats, name),
        slopes=lambda n, x: (None, (call(name, n - 1.0, x) - call(name, n + 1.0, x)) / 2.0),
        digits=lambda mp, n, x: digits.bessel(mp, kind, n, x),
        ball=lambda arb, n, x: getattr(x, f"bessel_{kind}")(n),
        sympy=f"bessel{kind}",
        ulps=64.0,
        swings=True,
    )


# the slopes of order 1 by the recurrence without division by x
_BESSEL = (
    _bessel(*("j", 0, "j0(0) = 1"), slopes=lambda x: -call("j1", x)),
    _bessel(
        *("j", 1, "j1(1) = 0.4400505857449335"),
        slopes=lambda x: (call("j0", x) - call("jn", Number(2.0), x)) / 2.0,
    ),
    _bessel_n("j", "jn(2, 1) = 2*j1(1) - j0(1)"),
    _bessel(
        *("y", 0, "y0(1) = 0.08825696421567696"), slopes=lambda x: -call("y1", x), domain=POSITIVE
    ),
    _bessel(
        *("y", 1, "y1(1) = -0.7812128213002887"),
        slopes=lambda x: (call("y0", x) - call("yn", Number(2.0), x)) / 2.0,
        domain=POSITIVE,
    ),
    _bessel_n("y", "yn(2, 1) = 2*y1(1) - y0(1)"),
    _bessel(
        *("i", 0, "i0(0) = 1"),
        slopes=lambda x: call("bessel_i1", x),
        interval=Even(Monotone(floats.i0, image=(1.0, inf), ulps=SPECIAL_ULPS)),
    ),
    _bessel(
        *("i", 1, "bessel_i1(1) = 0.565159103992485"),
        name="bessel_i1",
        slopes=lambda x: call("i0", x) - call("bessel_i1", x) / x,
        interval=Monotone(floats.i1, ulps=SPECIAL_ULPS),
    ),
    _bessel(
        *("k", 0, "k0(1) = 0.4210244382407083"),
        slopes=lambda x: -call("bessel_k1", x),
        interval=Monotone(floats.k0, POSITIVE, POSITIVE, SPECIAL_ULPS, falling=True),
        domain=POSITIVE,
        nonzero=True,
    ),
    _bessel(
        *("k", 1, "bessel_k1(2) = 0.1398658818165224"),
        name="bessel_k1",
        slopes=lambda x: -(call("k0", x) + call("bessel_k1", x) / x),
        interval=Monotone(floats.k1, POSITIVE, POSITIVE, SPECIAL_ULPS, falling=True),
        domain=POSITIVE,
        nonzero=True,
    ),
)
"""The modified Bessel functions of order 1 serve as derivatives."""

_ROWS = (
    *_CONSTANTS,
    *_PARTS,
    *_EXPONENTIAL,
    *_RADIANS,
    *_DEGREES,
    *_HYPERBOLIC,
    *_SPECIAL,
    *_BESSEL,
)

TABLE: dict[str, Function] = {row.name: row for row in _ROWS}
"""Every function by its name in lower case; functions registered from Python come at the end."""

PLANNED: frozenset[str] = frozenset({"sum", "prod", "count"})
"""Functions over lists, which the language does not have yet."""


LOGARITHMS = frozenset({"ln", "log", "log10"})


def named(trait: Callable[[Function], Any]) -> frozenset[str]:
    """The names of the built-in functions with a trait."""
    return frozenset(row.name for row in _ROWS if trait(row))
