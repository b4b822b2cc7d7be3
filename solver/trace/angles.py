"""Sine and cosine of degrees, and directions in degrees, as straight-line code on floats has them.

The angle is reduced to the nearest right angle, exactly, and what is left is taken to radians with one
rounding: a change of the angle by no more than its last digit. Multiples of 30 degrees are exact where the
exact answer is a float, as in ``rulesheets.functions.degrees``, which is more accurate and takes longer.
"""

from __future__ import annotations

from math import atan2, cos, fmod, sin

RADIAN = 0.017453292519943295
DEGREE = 57.29577951308232
NEAR = 45.0
"""Angles up to this need no reduction."""
FAR = 1e15
"""Beyond this many degrees the number of right angles is no longer exact."""


def sine_and_cosine(degrees: float) -> tuple[float, float]:
    """Of any angle. Raises ValueError for one that is no number."""
    if not -FAR <= degrees <= FAR:
        degrees = fmod(degrees, 360.0)
    quarters = round(degrees / 90.0)
    rest = degrees - 90.0 * quarters
    angle = rest * RADIAN
    sine, cosine = sin(angle), cos(angle)
    if rest * rest == 900.0:
        sine = rest / 60.0
    turn = quarters & 3
    if turn == 0:
        return sine, cosine
    if turn == 1:
        return cosine, 0.0 - sine
    return (0.0 - sine, 0.0 - cosine) if turn == 2 else (0.0 - cosine, sine)


def sine_and_cosine_lines(angle: str, sine: str | None, cosine: str | None) -> list[str]:
    """Statements that assign what is asked for, without a call where the angle needs no reduction."""
    lines = [f"if -{NEAR} <= {angle} <= {NEAR}:", f"    r = {angle} * {RADIAN!r}"]
    if sine:
        lines += [f"    {sine} = sin(r)", f"    if {angle} * {angle} == 900.0: {sine} = {angle} / 60.0"]
    if cosine:
        lines.append(f"    {cosine} = cos(r)")
    return [*lines, "else:", f"    {sine or '_'}, {cosine or '_'} = sine_and_cosine({angle})"]


def direction_lines(name: str, y: str, x: str) -> list[str]:
    """Statements that assign the direction of a point, in (-180, 180] degrees, to a name."""
    # A negative zero counts as zero.
    return [f"{name} = atan2({y} + 0.0, {x}) * {DEGREE!r}", f"if {name} == -180.0: {name} = 180.0"]


NAMES = {"sin": sin, "cos": cos, "atan2": atan2, "sine_and_cosine": sine_and_cosine}
"""What the statements call."""
