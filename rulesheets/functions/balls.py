"""The built-in functions on balls: rigorous enclosures to any precision, by Arb (the only import of it).

A ball is a middle and a radius that holds the exact value (F. Johansson, IEEE Trans. Computers 66 (2017)
1281–1292). Outside its domain a function gives a ball that is not finite.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction
from functools import reduce
from typing import Any, TypeAlias

from flint import arb, arb_mat, ctx

Ball: TypeAlias = Any
"""An ``arb`` of python-flint (which has no types of its own)."""


def precision(bits: int) -> Any:
    """A context in which balls are computed with so many bits."""
    return ctx.workprec(bits)


def ball(number: Any) -> Ball:
    """The exact number: a float, an int, or an mpmath number."""
    if hasattr(number, "_mpf_"):
        sign, mantissa, exponent, _ = number._mpf_
        return (arb(-int(mantissa)) if sign else arb(int(mantissa))) * arb(2) ** exponent
    return arb(number)


def exact_ball(number: Fraction) -> Ball:
    """A ball around a rational number; without a radius where it has a short binary form."""
    return arb(number.numerator) / arb(number.denominator)


def exact_fraction(number: Ball) -> Fraction | None:
    """The number that a ball without a radius is; None of any other."""
    if not (number.is_exact() and number.is_finite()):
        return None
    mantissa, exponent = number.mid().man_exp()
    return Fraction(int(mantissa)) * Fraction(2) ** int(exponent)


def around(middle: Ball, radius: float) -> Ball:
    """Everything within ``radius`` of a number."""
    return middle + arb(0, radius)


def whole_power(base: Ball, exponent: int) -> Ball:
    """An integral power. (Arb takes logarithms of a ball whose middle is 0, unless it is multiplied out.)"""
    if exponent < 1 or not base.mid().is_zero():
        return base**exponent
    reach = base.abs_upper() ** exponent
    return reach.union(arb(0 if exponent % 2 == 0 else -reach))


def preconditioned(
    jacobian: Sequence[Sequence[Ball]], centre: Sequence[Sequence[Ball]], residual: Sequence[Ball]
) -> tuple[list[list[Ball]], list[Ball]] | None:
    """I − Y J and Y F, for Y next to the inverse of the middle of ``centre``; None where that is singular."""
    n = len(residual)
    try:
        inverse = arb_mat([[a.mid() for a in row] for row in centre]).inv()
    except ZeroDivisionError:
        return None
    rough = arb_mat([[inverse[i, j].mid() for j in range(n)] for i in range(n)])
    product = rough * arb_mat([list(row) for row in jacobian])
    shift = rough * arb_mat([[f] for f in residual])
    rest = [[(1 if i == j else 0) - product[i, j] for j in range(n)] for i in range(n)]
    return rest, [shift[i, 0] for i in range(n)]


def solved(matrix: Sequence[Sequence[Ball]], rhs: Sequence[Ball]) -> list[Ball]:
    """x (n,) with A x = b, for every A (n, n) and b (n,) in the balls.

    Raises ZeroDivisionError where an A may be singular.
    """
    found = arb_mat([list(row) for row in matrix]).solve(arb_mat([[b] for b in rhs]))
    return [found[i, 0] for i in range(len(rhs))]


def _degrees(function: Callable[[Ball], Ball]) -> Callable[[Ball], Ball]:
    return lambda x: function(x) / arb.pi() * 180


def _wave(function: Callable[[Ball], Ball]) -> Callable[[Ball], Ball]:
    """A function of degrees from that of half turns."""
    return lambda x: function(x / 180)


def _direction(y: Ball, x: Ball) -> Ball:
    """In degrees. A direction next to -180 to which no float belongs is a hair beyond 180, as in floats."""
    direction = arb.atan2(y, x) / arb.pi() * 180
    behind = float(direction.lower()) == float(direction.upper()) == -180.0
    return direction + 360 if behind else direction


def _truncated(x: Ball) -> Ball:
    return x.floor() if x >= 0 else x.ceil() if x <= 0 else x.floor().union(x.ceil())


def _rounded(x: Ball) -> Ball:
    return x.sgn() * (abs(x) + arb(0.5)).floor()


def _mod(x: Ball, y: Ball) -> Ball:
    return x - y * _truncated(x / y)


def _step(x: Ball, a: Ball) -> Ball:
    return arb(1) if x >= a else arb(0) if x < a else arb(0).union(arb(1))


def _same(function: Callable[[Ball], Ball]) -> Callable[[Ball], bool]:
    """Whether a monotonic function has one value all over a ball."""
    return lambda x: bool(function(x.lower()) == function(x.upper()))


def _on_one_side(y: Ball, x: Ball) -> bool:
    """Whether a direction stays on one side of its cut, to which the half plane above it belongs."""
    return bool(x > 0 or y < 0 or y >= 0)


def _log_gamma(x: Ball) -> Ball:
    return x.lgamma() if x > 0 else abs(x.gamma()).log()


FUNCTIONS: Mapping[str, Callable[..., Ball]] = {
    "pi": arb.pi,
    "e": arb.const_e,
    **{name: getattr(arb, name) for name in ("sqrt", "exp", "sin", "cos", "tan", "asin", "acos", "atan")},
    **{name: getattr(arb, name) for name in ("sinh", "cosh", "tanh", "asinh", "acosh", "atanh")},
    **{name: getattr(arb, name) for name in ("gamma", "digamma", "erf", "erfc", "sgn")},
    "abs": abs,
    "ln": arb.log,
    "log": lambda x: x.log() / arb.const_log10(),
    "log10": lambda x: x.log() / arb.const_log10(),
    "sind": _wave(arb.sin_pi),
    "cosd": _wave(arb.cos_pi),
    "tand": _wave(arb.tan_pi),
    "asind": _degrees(arb.asin),
    "acosd": _degrees(arb.acos),
    "atand": _degrees(arb.atan),
    "atan2": arb.atan2,
    "atan2d": _direction,
    "int": _truncated,
    "frac": lambda x: x - _truncated(x),
    "round": _rounded,
    "mod": _mod,
    "step": _step,
    "min": lambda *numbers: reduce(lambda a, b: a.min(b), numbers),
    "max": lambda *numbers: reduce(lambda a, b: a.max(b), numbers),
    "lgamma": _log_gamma,
    "beta": lambda a, b: a.gamma() * b.gamma() / (a + b).gamma(),
    "j0": lambda x: x.bessel_j(0),
    "j1": lambda x: x.bessel_j(1),
    "jn": lambda n, x: x.bessel_j(n),
    "y0": lambda x: x.bessel_y(0),
    "y1": lambda x: x.bessel_y(1),
    "yn": lambda n, x: x.bessel_y(n),
    "i0": lambda x: x.bessel_i(0),
    "bessel_i1": lambda x: x.bessel_i(1),
    "k0": lambda x: x.bessel_k(0),
    "bessel_k1": lambda x: x.bessel_k(1),
}

STEADY: Mapping[str, Callable[..., bool]] = {
    "int": _same(_truncated),
    "frac": _same(_truncated),
    "mod": lambda x, y: _same(_truncated)(x / y),
    "round": _same(_rounded),
    "sgn": _same(arb.sgn),
    "step": lambda x, a: bool(x >= a or x < a),
    "atan2": _on_one_side,
    "atan2d": _on_one_side,
}
"""The functions that jump: whether they do not for any arguments in some balls."""
