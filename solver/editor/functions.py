"""The built-in functions in words: what each is, and an example with its value."""

from __future__ import annotations

from typing import NamedTuple


class Entry(NamedTuple):
    """``usage`` is how it is written; ``example`` is a rule that holds."""

    usage: str
    meaning: str
    example: str


def _row(usage: str, meaning: str, example: str) -> tuple[str, Entry]:
    return usage.partition("(")[0], Entry(usage, meaning, example)


ENTRIES = dict(
    (
        _row("pi", "ratio of a circle's circumference to its diameter", "pi = 3.141592653589793"),
        _row("e()", "base of natural logarithms; without parentheses e is a variable", "ln(e()) = 1"),
        _row("abs(x)", "absolute value", "abs(-3) = 3"),
        _row("sgn(x)", "sign: -1, 0 or 1", "sgn(-0.2) = -1"),
        _row("int(x)", "integer part, rounded towards 0", "int(-2.7) = -2"),
        _row("frac(x)", "fractional part, x - int(x)", "frac(2.25) = 0.25"),
        _row("round(x)", "nearest integer, halves away from 0", "round(2.5) = 3"),
        _row("mod(x, y)", "remainder of x/y, with the sign of x", "mod(-30, 360) = -30"),
        _row("step(x, a)", "1 if x >= a, else 0", "step(2, 1) = 1"),
        _row("min(a, b, …)", "least of its arguments", "min(3, 1, 2) = 1"),
        _row("max(a, b, …)", "greatest of its arguments", "max(3, 1, 2) = 3"),
        _row("sqrt(x)", "square root", "sqrt(16) = 4"),
        _row("exp(x)", "exponential function", "exp(0) = 1"),
        _row("ln(x)", "natural logarithm", "ln(e()^2) = 2"),
        _row("log(x)", "logarithm to base 10", "log(1000) = 3"),
        _row("log10(x)", "logarithm to base 10", "log10(0.01) = -2"),
        _row("sin(x)", "sine of x radians", "sin(pi/6) = 0.5"),
        _row("cos(x)", "cosine of x radians", "cos(pi/3) = 0.5"),
        _row("tan(x)", "tangent of x radians", "tan(pi/4) = 1"),
        _row("asin(x)", "inverse sine, in radians from -pi/2 to pi/2", "asin(1) = pi/2"),
        _row("acos(x)", "inverse cosine, in radians from 0 to pi", "acos(-1) = pi"),
        _row("atan(x)", "inverse tangent, in radians from -pi/2 to pi/2", "atan(1) = pi/4"),
        _row("atan2(y, x)", "angle of the point (x, y) in radians, to pi", "atan2(1, -1) = 3*pi/4"),
        _row("sind(x)", "sine of x degrees", "sind(30) = 0.5"),
        _row("cosd(x)", "cosine of x degrees", "cosd(90) = 0"),
        _row("tand(x)", "tangent of x degrees", "tand(45) = 1"),
        _row("asind(x)", "inverse sine, in degrees from -90 to 90", "asind(0.5) = 30"),
        _row("acosd(x)", "inverse cosine, in degrees from 0 to 180", "acosd(0.5) = 60"),
        _row("atand(x)", "inverse tangent, in degrees from -90 to 90", "atand(1) = 45"),
        _row("atan2d(y, x)", "angle of the point (x, y) in degrees, to 180", "atan2d(1, -1) = 135"),
        _row("sinh(x)", "hyperbolic sine", "sinh(ln(2)) = 0.75"),
        _row("cosh(x)", "hyperbolic cosine", "cosh(ln(2)) = 1.25"),
        _row("tanh(x)", "hyperbolic tangent", "tanh(ln(2)) = 0.6"),
        _row("asinh(x)", "inverse hyperbolic sine", "asinh(0.75) = ln(2)"),
        _row("acosh(x)", "inverse hyperbolic cosine, 0 or positive", "acosh(1.25) = ln(2)"),
        _row("atanh(x)", "inverse hyperbolic tangent", "atanh(0.6) = ln(2)"),
        _row("gamma(x)", "gamma function", "gamma(5) = 24"),
        _row("lgamma(x)", "logarithm of |gamma(x)|", "lgamma(5) = ln(24)"),
        _row("digamma(x)", "derivative of ln(gamma(x))", "digamma(2) - digamma(1) = 1"),
        _row("beta(a, b)", "gamma(a)*gamma(b)/gamma(a + b)", "beta(2, 3) = 1/12"),
        _row("erf(x)", "error function", "erf(0.5) = 0.5204998778130465"),
        _row("erfc(x)", "complementary error function, 1 - erf(x)", "erfc(0.5) + erf(0.5) = 1"),
        _row("j0(x)", "Bessel function of the first kind, order 0", "j0(0) = 1"),
        _row("j1(x)", "Bessel function of the first kind, order 1", "j1(1) = 0.4400505857449335"),
        _row("jn(n, x)", "Bessel function of the first kind, order n", "jn(2, 1) = 2*j1(1) - j0(1)"),
        _row("y0(x)", "Bessel function of the second kind, order 0", "y0(1) = 0.08825696421567696"),
        _row("y1(x)", "Bessel function of the second kind, order 1", "y1(1) = -0.7812128213002887"),
        _row("yn(n, x)", "Bessel function of the second kind, order n", "yn(2, 1) = 2*y1(1) - y0(1)"),
        _row("i0(x)", "modified Bessel function of the first kind, order 0", "i0(0) = 1"),
        _row(
            "bessel_i1(x)",
            "modified Bessel function, 1st kind, order 1",
            "bessel_i1(1) = 0.565159103992485",
        ),
        _row("k0(x)", "modified Bessel function of the second kind, order 0", "k0(1) = 0.4210244382407083"),
        _row(
            "bessel_k1(x)",
            "modified Bessel function, 2nd kind, order 1",
            "bessel_k1(2) = 0.1398658818165224",
        ),
    )
)
