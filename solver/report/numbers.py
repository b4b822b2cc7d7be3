"""Values as text: short for people, exact for files."""

from __future__ import annotations

from math import ceil, isfinite, log10

from rulesheets.model import Tolerance, Value

DIGITS = 10
"""Significant digits that a person reads: all that a sheet is judged by, none of the rounding noise."""


def readable(value: Value | None) -> str:
    """A value for the variable sheet: ``'open``, ``-41.46077186``, blank where there is none."""
    if value is None:
        return ""
    if isinstance(value, str):
        return f"'{value}"
    return f"{value + 0.0:.{DIGITS}g}"


def exact(value: Value | None) -> str:
    """A value for a file: reading it back gives the same float."""
    if value is None:
        return ""
    if isinstance(value, str):
        return f"'{value}"
    text = repr(float(value) + 0.0)
    return text.removesuffix(".0")


def tolerated(text: str, tolerance: Tolerance | None) -> str:
    """``3 ± 0.01``: the text of an input with its tolerance, as a sheet reads it."""
    if tolerance is None:
        return text
    return f"{text} ± {exact(tolerance.size)}{'%' if tolerance.percent else ''}"


def certain(value: Value | None, error: float) -> str:
    """A value with the digits that its error leaves: the last one may be off by one, zeros included.

    All that a float has where the error is 0; ``±1e-16`` where not one digit is right.
    """
    if not isinstance(value, float) or error == 0.0:
        return exact(value)
    if not isfinite(error):
        return "±?"
    place = ceil(log10(2.0 * error))
    if abs(value) < 0.5 * 10.0**place:
        return f"±{error:.0e}"
    return _to_place(value, place)


def _to_place(value: float, place: int) -> str:
    """Rounded to a multiple of ten to the ``place``, in plain digits where that is readable."""
    from decimal import Context, Decimal

    wide = Context(prec=1100, Emin=-2000, Emax=2000)
    number = Decimal(value)
    rounded = number.quantize(Decimal((0, (1,), place)), context=wide)
    if place <= 0 and -5 <= rounded.adjusted() < 16:
        return f"{rounded:f}"
    text = f"{rounded:.{rounded.adjusted() - place}e}"
    return text.replace("e+", "e")


def magnitude(value: float) -> str:
    """The size of a residual: ``1e-16``, ``0``."""
    return f"{value:.0e}" if value else "0"
