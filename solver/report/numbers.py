"""Values as text: short for people, exact for files."""

from __future__ import annotations

from rulesheets.model import Value

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


def magnitude(value: float) -> str:
    """The size of a residual: ``1e-16``, ``0``."""
    return f"{value:.0e}" if value else "0"
