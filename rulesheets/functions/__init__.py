"""The table of functions: a row each, with its values, slopes, inverse, ranges and traits.

A new function of the language is a new row, with its forms side by side. The table is cheap to
import: a form that needs a large library takes it as its first argument (``np`` is numpy, ``mp`` a
context of mpmath, ``arb`` that of python-flint, ``s`` sympy). The functions of angles are in
``angles``.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache, partial, reduce
from math import inf
from typing import Any

from rulesheets.functions import intervals
from rulesheets.functions.angles import ANGULAR
from rulesheets.functions.intervals import (
    POSITIVE,
    SPECIAL_ULPS,
    UNIT,
    Even,
    Monotone,
    each_end,
    magnitudes,
)
from rulesheets.functions.row import Forms, Function, Functions, Inverse, both_signs, by, entry
from rulesheets.syntax.nodes import ONE, ZERO, Expression, Number, call, multiply

_special = partial(entry, ulps=16.0)
_jumping = partial(entry, smooth=False, jumps=True)


def _flat(*arguments: Expression) -> tuple[Expression, ...]:
    """Partials of a function that is constant between its jumps."""
    return (ZERO,) * len(arguments)


_CONSTANTS = (
    entry(
        *("pi", "ratio of a circle's circumference to its diameter", "pi = 3.141592653589793"),
        arguments="",
        array=None,
        value=lambda: math.pi,
        slopes=_flat,
        interval=lambda: (math.pi, math.nextafter(math.pi, inf)),
        digits=lambda mp: +mp.pi,
        sympy=lambda s: s.pi,
    ),
    entry(
        *("e", "base of natural logarithms; without parentheses e is a variable", "ln(e()) = 1"),
        arguments="",
        array=None,
        value=lambda: math.e,
        slopes=_flat,
        interval=lambda: (math.e, math.nextafter(math.e, inf)),
        digits=lambda mp: +mp.e,
        ball="const_e",
        sympy=lambda s: s.E,
    ),
)


# --- parts of a number, and choices ---


def _sign(x: float) -> float:
    return math.copysign(1.0, x) if x else 0.0


def _whole(x: float) -> float:
    return float(math.trunc(x))


def _nearest(x: float) -> float:
    """The nearest whole number, halves away from zero."""
    whole = math.trunc(x)
    rest = x - whole
    if abs(rest) >= 0.5:
        whole += 1 if rest > 0.0 else -1
    return float(whole)


def _nearest_of_arrays(np: Any, x: Any) -> Any:
    whole = np.trunc(x)
    return whole + np.where(np.abs(x - whole) >= 0.5, np.copysign(1.0, x), 0.0)


def _whole_ball(x: Any) -> Any:
    return x.floor() if x >= 0 else x.ceil() if x <= 0 else x.floor().union(x.ceil())


def _same_whole(x: Any) -> bool:
    """Whether all numbers of a ball have the same integer part."""
    return bool(_whole_ball(x.lower()) == _whole_ball(x.upper()))


def _extreme(
    choose: Callable[[tuple[Any, ...]], Any],
    word: str,
    example: str,
    beats: Callable[[Expression, Expression], Expression],
) -> Function:
    """The row of ``min`` or ``max``, named ``choose`` in Python; ``beats`` is 1 for a winner and a
    loser, or for equals, else 0."""
    name, chosen = choose.__name__, getattr(intervals, word)

    def slopes(*arguments: Expression) -> tuple[Expression, ...]:
        """1 for the selected argument (the first of equals), 0 for the others."""
        found: list[Expression] = []
        for position, argument in enumerate(arguments):
            slope: Expression = ONE
            if later := arguments[position + 1 :]:
                slope = beats(argument, call(name, *later))
            if earlier := arguments[:position]:
                slope = multiply(slope, 1.0 - beats(call(name, *earlier), argument))
            found.append(slope)
        return tuple(found)

    return entry(
        *(name, f"{word} of its arguments", example),
        arguments="a, b, …",
        value=lambda *numbers: choose(numbers),
        array=lambda np, *numbers: reduce(getattr(np, f"{name}imum"), numbers),
        slopes=slopes,
        interval=lambda *ends: (reduce(chosen, ends[::2]), reduce(chosen, ends[1::2])),
        digits=lambda mp, *numbers: choose(numbers),
        ball=lambda arb, *numbers: reduce(lambda a, b: getattr(a, name)(b), numbers),
        sympy=name.title(),
        smooth=False,
        alike=True,
        keeps_unit=True,
    )


_PARTS = (
    entry(
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
        value=_sign,
        array="sign",
        slopes=_flat,
        interval=each_end(_sign),
        digits="sign",
        sympy="sign",
        steady=lambda x: bool(x.lower().sgn() == x.upper().sgn()),
        alike=True,
    ),
    _jumping(
        *("int", "integer part, rounded towards 0", "int(-2.7) = -2"),
        value=_whole,
        array="trunc",
        slopes=_flat,
        interval=each_end(_whole),
        digits=lambda mp, x: mp.floor(x) if x >= 0 else mp.ceil(x),
        ball=lambda arb, x: _whole_ball(x),
        sympy=lambda s, x: s.sign(x) * s.floor(s.Abs(x)),
        steady=_same_whole,
    ),
    _jumping(
        *("frac", "fractional part, x - int(x)", "frac(2.25) = 0.25"),
        value=lambda x: math.fmod(x, 1.0),
        array=lambda np, x: np.fmod(x, 1.0),
        slopes=lambda x: ONE,
        interval=lambda low, high: intervals.mod(low, high, 1.0, 1.0),
        definition=lambda x: x - call("int", x),
        steady=_same_whole,
    ),
    _jumping(
        *("round", "nearest integer, halves away from 0", "round(2.5) = 3"),
        value=_nearest,
        array=_nearest_of_arrays,
        slopes=_flat,
        interval=each_end(_nearest),
        definition=lambda x: call("sgn", x) * call("int", call("abs", x) + ONE / 2.0),
        steady=lambda x: _same_whole(x + x.sgn() / 2),
    ),
    _jumping(
        *("mod", "remainder of x/y, with the sign of x", "mod(-30, 360) = -30"),
        arguments="x, y",
        value=math.fmod,
        array="fmod",
        slopes=lambda x, y: (ONE, -call("int", x / y)),
        interval=intervals.mod,
        definition=lambda x, y: x - y * call("int", x / y),
        steady=lambda x, y: _same_whole(x / y),
        alike=True,
        keeps_unit=True,
    ),
    _jumping(
        *("step", "1 if x >= a, else 0", "step(2, 1) = 1"),
        arguments="x, a",
        value=lambda x, a: 1.0 if x >= a else 0.0,
        array=lambda np, x, a: np.where(x >= a, 1.0, np.where(x < a, 0.0, np.nan)),
        slopes=_flat,
        interval=intervals.step,
        digits=lambda mp, x, a: mp.mpf(x >= a),
        ball=lambda arb, x, a: arb(1) if x >= a else arb(0) if x < a else arb(0).union(arb(1)),
        sympy=lambda s, x, a: s.Heaviside(x - a, 1),
        steady=lambda x, a: bool(x >= a or x < a),
        alike=True,
    ),
    _extreme(min, "least", "min(3, 1, 2) = 1", lambda one, other: call("step", other, one)),
    _extreme(max, "greatest", "max(3, 1, 2) = 3", lambda one, other: call("step", one, other)),
)


def _exp_in_digits(mp: Any, x: Any) -> Any:
    """Of a whole number mpmath takes a power of e: by as many squarings as it has binary digits."""
    if x.exp <= 40:
        return mp.exp(x)
    half = mp.mpf(0.5)
    with mp.workprec(mp.prec + x.exp + x.bc):
        moved = x + half
    return mp.exp(moved) / mp.exp(half)


_EXPONENTIAL = (
    entry(
        *("sqrt", "square root", "sqrt(16) = 4"),
        value=math.sqrt,
        slopes=lambda x: 0.5 / call("sqrt", x),
        inverse=Inverse(lambda t: (t**2.0,), low=0.0),
        interval=Monotone(math.sqrt, POSITIVE, POSITIVE, ulps=1.0),
    ),
    entry(
        *("exp", "exponential function", "exp(0) = 1"),
        value=math.exp,
        slopes=lambda x: call("exp", x),
        inverse=Inverse(by("ln"), low=0.0, low_open=True),
        interval=Monotone(math.exp, image=POSITIVE),
        digits=_exp_in_digits,
        nonzero=True,
    ),
    entry(
        *("ln", "natural logarithm", "ln(e()^2) = 2"),
        value=math.log,
        array="log",
        slopes=lambda x: 1.0 / x,
        inverse=Inverse(by("exp")),
        interval=Monotone(math.log, POSITIVE),
        ball="log",
        sympy="log",
    ),
    *(
        entry(
            *(name, "logarithm to base 10", example),
            value=math.log10,
            array="log10",
            slopes=lambda x: 1.0 / call("ln", Number(10.0)) / x,
            inverse=Inverse(lambda t: (Number(10.0) ** t,)),
            interval=Monotone(math.log10, POSITIVE),
            digits="log10",
            definition=lambda x: call("ln", x) / call("ln", Number(10.0)),
        )
        for name, example in (("log", "log(1000) = 3"), ("log10", "log10(0.01) = -2"))
    ),
)

_HYPERBOLIC = (
    entry(
        *("sinh", "hyperbolic sine", "sinh(ln(2)) = 0.75"),
        value=math.sinh,
        slopes=lambda x: call("cosh", x),
        inverse=Inverse(by("asinh")),
        interval=Monotone(math.sinh),
    ),
    entry(
        *("cosh", "hyperbolic cosine", "cosh(ln(2)) = 1.25"),
        value=math.cosh,
        slopes=lambda x: call("sinh", x),
        inverse=Inverse(both_signs("acosh"), low=1.0),
        interval=Even(Monotone(math.cosh, POSITIVE, (1.0, inf))),
    ),
    entry(
        *("tanh", "hyperbolic tangent", "tanh(ln(2)) = 0.6"),
        value=math.tanh,
        slopes=lambda x: 1.0 - call("tanh", x) ** 2.0,
        inverse=Inverse(by("atanh"), -1.0, 1.0, True, True),
        interval=Monotone(math.tanh, image=UNIT),
    ),
    entry(
        *("asinh", "inverse hyperbolic sine", "asinh(0.75) = ln(2)"),
        value=math.asinh,
        array="arcsinh",
        slopes=lambda x: 1.0 / call("sqrt", x**2.0 + 1.0),
        inverse=Inverse(by("sinh")),
        interval=Monotone(math.asinh),
    ),
    entry(
        *("acosh", "inverse hyperbolic cosine, 0 or positive", "acosh(1.25) = ln(2)"),
        value=math.acosh,
        array="arccosh",
        slopes=lambda x: 1.0 / call("sqrt", (x - 1.0) * (x + 1.0)),
        inverse=Inverse(by("cosh"), 0.0, inf),
        interval=Monotone(math.acosh, (1.0, inf), POSITIVE),
    ),
    entry(
        *("atanh", "inverse hyperbolic tangent", "atanh(0.6) = ln(2)"),
        value=math.atanh,
        array="arctanh",
        slopes=lambda x: 1.0 / ((1.0 - x) * (1.0 + x)),
        inverse=Inverse(by("tanh")),
        interval=Monotone(math.atanh, UNIT),
    ),
)


# --- special functions; those that ``math`` lacks are scipy's, imported at the first call ---


@cache
def _scipy(name: str) -> Callable[..., Any]:
    from scipy import special

    function: Callable[..., Any] = getattr(special, name)
    return function


def _of_scipy(name: str) -> Callable[..., float]:
    def value(*arguments: float) -> float:
        result = float(_scipy(name)(*arguments))
        if not math.isfinite(result):
            raise ValueError(f"{name} is not defined there")
        return result

    return value


def _finite(x: Any) -> Any:
    """A number of mpmath. Raises ValueError for a pole."""
    if x - x != 0:
        raise ValueError("not defined there")
    return x


def _erfcinv_in_digits(mp: Any, x: Any) -> Any:
    """With as many digits more as ``1 - x`` would lose for a small x."""
    if x <= 0:
        raise ValueError("not defined there")
    with mp.extraprec(max(0, -mp.mag(x))):
        return _finite(mp.erfinv(1 - x))


_BELL = 2.0 / call("sqrt", call("pi"))


def _beta_slopes(a: Expression, b: Expression) -> tuple[Expression, ...]:
    whole, both = call("beta", a, b), call("digamma", a + b)
    return tuple(whole * (call("digamma", part) - both) for part in (a, b))


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
        digits=lambda mp, x: mp.ln(abs(mp.gamma(x))) if x < 0 else mp.loggamma(x),
        ball=lambda arb, x: x.lgamma() if x > 0 else abs(x.gamma()).log(),
        definition=lambda x: call("ln", call("abs", call("gamma", x))),
    ),
    _special(
        *("digamma", "derivative of ln(gamma(x))", "digamma(2) - digamma(1) = 1"),
        value=_of_scipy("digamma"),
        array="special.digamma",
    ),
    entry(
        *("beta", "gamma(a)*gamma(b)/gamma(a + b)", "beta(2, 3) = 1/12"),
        arguments="a, b",
        value=_of_scipy("beta"),
        ulps=64.0,
        array="special.beta",
        slopes=_beta_slopes,
        digits="beta",
        sympy="beta",
        definition=lambda a, b: call("gamma", a) * call("gamma", b) / call("gamma", a + b),
        nonzero=True,
    ),
    _special(
        *("erf", "error function", "erf(0.5) = 0.5204998778130465"),
        value=math.erf,
        array="special.erf",
        inverse=Inverse(by("erfinv"), -1.0, 1.0, True, True),
        slopes=lambda x: _BELL * call("exp", -(x**2.0)),
        interval=Monotone(math.erf, image=UNIT, ulps=SPECIAL_ULPS),
    ),
    _special(
        *("erfc", "complementary error function, 1 - erf(x)", "erfc(0.5) + erf(0.5) = 1"),
        value=math.erfc,
        array="special.erfc",
        inverse=Inverse(by("erfcinv"), 0.0, 2.0, True, True),
        slopes=lambda x: -_BELL * call("exp", -(x**2.0)),
        interval=Monotone(math.erfc, image=(0.0, 2.0), ulps=SPECIAL_ULPS, falling=True),
        nonzero=True,
    ),
    _special(
        *("erfinv", "inverse error function", "erf(erfinv(0.5)) = 0.5"),
        value=_of_scipy("erfinv"),
        array="special.erfinv",
        inverse=Inverse(by("erf")),
        slopes=lambda x: call("exp", call("erfinv", x) ** 2.0) / _BELL,
        interval=Monotone(_of_scipy("erfinv"), UNIT, ulps=SPECIAL_ULPS),
        digits=lambda mp, x: _finite(mp.erfinv(x)),
    ),
    _special(
        *("erfcinv", "inverse complementary error function", "erfc(erfcinv(0.5)) = 0.5"),
        value=_of_scipy("erfcinv"),
        array="special.erfcinv",
        inverse=Inverse(by("erfc")),
        slopes=lambda x: -call("exp", call("erfcinv", x) ** 2.0) / _BELL,
        interval=Monotone(_of_scipy("erfcinv"), (0.0, 2.0), ulps=SPECIAL_ULPS, falling=True),
        digits=_erfcinv_in_digits,
        ball="erfcinv",
        sympy=lambda s, x: s.erfinv(1 - x),
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
    return entry(
        *(name or f"{kind}{order}", f"{_KINDS[kind]}, order {order}", example),
        value=_of_scipy(f"{kind}{order}"),
        array=f"special.{kind}{order}",
        digits=lambda mp, x: getattr(mp, f"bessel{kind}")(order, x),
        ball=lambda arb, x: getattr(x, f"bessel_{kind}")(order),
        sympy=lambda s, x: getattr(s, f"bessel{kind}")(order, x),
        ulps=64.0,
        swings=kind in "jy",
        **facets,
    )


MOST_ORDER = 1_000
"""The largest order of a Bessel function in many digits: larger ones take too long."""


def _bessel_n(kind: str, example: str) -> Function:
    """The row of a Bessel function by its order; its slope by that is not known."""
    name, of_scipy = f"{kind}n", _of_scipy(f"{kind}v")

    def value(order: float, x: float) -> float:
        if order != math.trunc(order):
            raise ValueError("the order of a Bessel function is a whole number")
        return of_scipy(int(order), x)

    def digits(mp: Any, order: Any, x: Any) -> Any:
        if not mp.isint(order) or abs(order) > MOST_ORDER:
            raise ValueError("the order is no whole number of ordinary size")
        return getattr(mp, f"bessel{kind}")(order, x)

    return entry(
        *(name, f"{_KINDS[kind]}, order n", example),
        arguments="n, x",
        value=value,
        array=lambda np, n, x: np.where(n == np.trunc(n), _scipy(f"{kind}v")(n, x), np.nan),
        slopes=lambda n, x: (None, (call(name, n - 1.0, x) - call(name, n + 1.0, x)) / 2.0),
        digits=digits,
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
        interval=Even(Monotone(_of_scipy("i0"), image=(1.0, inf), ulps=SPECIAL_ULPS)),
    ),
    _bessel(
        *("i", 1, "bessel_i1(1) = 0.565159103992485"),
        name="bessel_i1",
        slopes=lambda x: call("i0", x) - call("bessel_i1", x) / x,
        interval=Monotone(_of_scipy("i1"), ulps=SPECIAL_ULPS),
    ),
    _bessel(
        *("k", 0, "k0(1) = 0.4210244382407083"),
        slopes=lambda x: -call("bessel_k1", x),
        interval=Monotone(_of_scipy("k0"), POSITIVE, POSITIVE, SPECIAL_ULPS, falling=True),
        nonzero=True,
    ),
    _bessel(
        *("k", 1, "bessel_k1(2) = 0.1398658818165224"),
        name="bessel_k1",
        slopes=lambda x: -(call("k0", x) + call("bessel_k1", x) / x),
        interval=Monotone(_of_scipy("k1"), POSITIVE, POSITIVE, SPECIAL_ULPS, falling=True),
        nonzero=True,
    ),
)
"""The modified Bessel functions of order 1 serve as derivatives."""

_ROWS = (*_CONSTANTS, *_PARTS, *_EXPONENTIAL, *ANGULAR, *_HYPERBOLIC, *_SPECIAL, *_BESSEL)

TABLE = Functions((row.name, row) for row in _ROWS)
"""Every function by its name in lower case; functions registered from Python come at the end."""

PLANNED: frozenset[str] = frozenset({"sum", "prod", "count"})
"""Functions over lists, which the language does not have yet."""


LOGARITHMS = frozenset({"ln", "log", "log10"})


def one_by_one(function: Callable[..., float]) -> Callable[..., Any]:
    """A function of floats on arrays that broadcast: nan where it has no value."""
    import numpy as np  # a solve without arrays does without

    def at(*numbers: float) -> float:
        try:
            return function(*numbers)
        except (ArithmeticError, ValueError):
            return math.nan

    return np.vectorize(at, otypes=[float])


def _on_arrays(row: Function) -> Callable[..., Any]:
    """The form on numpy arrays; callers silence what numpy warns of (``numpy.errstate``)."""
    import numpy as np

    found = one_by_one(row.value)
    if callable(row.array):
        found = partial(row.array, np)
    elif row.array is not None:
        module, _, name = row.array.rpartition(".")
        found = _scipy(name) if module else getattr(np, name, found)
    return found


ARRAYS = Forms(TABLE, _on_arrays)
"""Every function on numpy arrays, by name; outside its domain it gives nan or an infinity."""


INTERVALS = Forms(TABLE, lambda row: row.interval or intervals.unknown)
"""Every function on intervals, each given by its two ends, by name."""


def named(trait: Callable[[Function], Any]) -> frozenset[str]:
    """The names of the built-in functions with a trait."""
    return frozenset(row.name for row in _ROWS if trait(row))
