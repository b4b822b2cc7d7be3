"""The slider crank with 50 digits, and errors beside it in units that no solver can be better
than."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import mpmath as mp
from mpmath import mpf

DIGITS = 50
EPSILON = 2.0**-52
AO, AB, OFFSET, OMEGA, ALPHA = (mpf(n) for n in (3, 8, 2, -15, -10))


def exact(direction: str, number: float, near: float | None = None) -> list[Any]:
    """The five outputs; of two backward answers the one whose angle is ``near``."""
    with mp.workdps(DIGITS):
        return _forward(mpf(number)) if direction == "forward" else _backward(mpf(number), near)


def _forward(theta: Any) -> list[Any]:
    t = mp.radians(theta)
    xA, yA = AO * mp.cos(t), AO * mp.sin(t)
    dx = mp.sqrt(AB**2 - (OFFSET - yA) ** 2)
    return [xA + dx, *_rates(xA, yA, dx)]


def _backward(x: Any, near: float | None) -> list[Any]:
    distance = mp.hypot(x, OFFSET)
    swing = mp.acos((AO**2 + distance**2 - AB**2) / (2 * AO * distance))
    angles = [mp.atan2(OFFSET, x) + sign * swing for sign in (-1, 1)]
    t = (
        angles[0]
        if near is None
        else min(angles, key=lambda a: abs(mp.sin((a - mp.radians(near)) / 2)))
    )
    xA, yA = AO * mp.cos(t), AO * mp.sin(t)
    return [mp.degrees(t), *_rates(xA, yA, x - xA)]


def _rates(xA: Any, yA: Any, dx: Any) -> list[Any]:
    dy = OFFSET - yA
    omega = -OMEGA * xA / dx
    xa1, ya1 = -(OMEGA**2) * xA - ALPHA * yA, -(OMEGA**2) * yA + ALPHA * xA
    alpha = (omega**2 * dy - ya1) / dx
    return [-OMEGA * yA - omega * dy, omega, xa1 - omega**2 * dx - alpha * dy, alpha]


def errors(direction: str, number: float, found: Sequence[float]) -> list[float]:
    """Errors of the five outputs in ulp × conditioning: |error| / eps (|y| + |x dy/dx|), x the
    input."""
    near = found[0] if direction == "backward" else None
    with mp.workdps(DIGITS):
        step = mpf(10) ** -20 * max(1, abs(mpf(number)))
        here, above, below = (exact(direction, mpf(number) + k * step, near) for k in (0, 1, -1))
        out = []
        for y, up, down, value in zip(here, above, below, found, strict=True):
            scale = abs(y) + abs(mpf(number) * (up - down) / (2 * step))
            out.append(float(abs(mpf(float(value)) - y) / (EPSILON * scale)))
        return out
