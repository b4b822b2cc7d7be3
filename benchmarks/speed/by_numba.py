"""The slider crank by hand in numba: one solve, and loops over rows on one core and on all.

The formulas are those of ``closed_forms`` and of ``crank.c``, written out again where numba has to
see them whole.
"""

from __future__ import annotations

from collections.abc import Callable
from math import acos, atan2, cos, hypot, sin, sqrt
from typing import Any

import numba
import numpy as np

from benchmarks.speed.closed_forms import AB, ALPHA, AO, OFFSET, OMEGA, Array

RADIAN, DEGREE = 0.017453292519943295, 57.29577951308232
MAGIC = 6755399441055744.0
"""1.5 × 2^52: what is added to it and taken away again is rounded to a whole number."""

BLOCK = 512


@numba.njit(inline="always")
def _rates(xA: float, yA: float, dx: float, dy: float) -> Any:
    xa, ya = -OMEGA * yA, OMEGA * xA
    omega = -ya / dx
    xa1 = -OMEGA * OMEGA * xA - ALPHA * yA
    ya1 = -OMEGA * OMEGA * yA + ALPHA * xA
    alpha = (omega * omega * dy - ya1) / dx
    return xa - omega * dy, omega, xa1 - omega * omega * dx - alpha * dy, alpha


@numba.njit(inline="always")
def _forward(s: float, c: float) -> Any:
    xA, yA = AO * c, AO * s
    dy = OFFSET - yA
    dx = sqrt(AB * AB - dy * dy)
    v, omega, a, alpha = _rates(xA, yA, dx, dy)
    return xA + dx, v, omega, a, alpha


@numba.njit(inline="always")
def _own(degrees: float) -> Any:
    """Sine and cosine of degrees, reduced exactly; the polynomials of fdlibm."""
    quarters = (degrees * (1.0 / 90.0) + MAGIC) - MAGIC
    r = (degrees - 90.0 * quarters) * RADIAN
    z = r * r
    s = 1.58969099521155010221e-10
    s = s * z - 2.50507602534068634195e-08
    s = s * z + 2.75573137070700676789e-06
    s = s * z - 1.98412698298579493134e-04
    s = s * z + 8.33333333332248946124e-03
    s = s * z - 1.66666666666666324348e-01
    s = r + r * (z * s)
    c = -1.13596475577881948265e-11
    c = c * z + 2.08757232129817482790e-09
    c = c * z - 2.75573143513906633035e-07
    c = c * z + 2.48015872894767294178e-05
    c = c * z - 1.38888888888741095749e-03
    c = c * z + 4.16666666666666019037e-02
    c = 1.0 - (0.5 * z - z * (z * c))
    turn = quarters - 4.0 * ((quarters * 0.25 + MAGIC) - MAGIC)
    across, along = turn * (2.0 - abs(turn)), 1.0 - abs(turn)
    return s * along + c * across, c * along - s * across


@numba.njit(inline="always")
def _backward(x: float, sign: float) -> Any:
    distance = hypot(x, OFFSET)
    psi = atan2(OFFSET, x)
    swing = acos((AO * AO + distance * distance - AB * AB) / (2.0 * AO * distance))
    t = psi + sign * swing
    xA, yA = AO * cos(t), AO * sin(t)
    v, omega, a, alpha = _rates(xA, yA, x - xA, OFFSET - yA)
    return t * DEGREE, v, omega, a, alpha


@numba.njit
def forward(theta: float) -> Any:
    t = theta * RADIAN
    return _forward(sin(t), cos(t))


@numba.njit
def backward(x: float) -> Any:
    """Both answers."""
    return _backward(x, -1.0), _backward(x, 1.0)


def _forward_library(theta: Any, a: Any, b: Any, c: Any, d: Any, e: Any) -> None:
    for i in numba.prange(len(theta)):
        t = theta[i] * RADIAN
        a[i], b[i], c[i], d[i], e[i] = _forward(sin(t), cos(t))


@numba.njit(error_model="numpy", fastmath={"contract"})
def _forward_block(theta: Any, a: Any, b: Any, c: Any, d: Any, e: Any) -> None:
    """At most BLOCK rows, by way of an array whose parts are seen not to overlap: several rows go
    at once."""
    room = np.empty(5 * BLOCK)
    n = len(theta)
    for i in range(n):
        sine, cosine = _own(theta[i])
        five = _forward(sine, cosine)
        room[i] = five[0]
        room[BLOCK + i] = five[1]
        room[2 * BLOCK + i] = five[2]
        room[3 * BLOCK + i] = five[3]
        room[4 * BLOCK + i] = five[4]
    a[:] = room[:n]
    b[:] = room[BLOCK : BLOCK + n]
    c[:] = room[2 * BLOCK : 2 * BLOCK + n]
    d[:] = room[3 * BLOCK : 3 * BLOCK + n]
    e[:] = room[4 * BLOCK : 4 * BLOCK + n]


def _forward_own(theta: Any, a: Any, b: Any, c: Any, d: Any, e: Any) -> None:
    for block in numba.prange((len(theta) + BLOCK - 1) // BLOCK):
        k = slice(block * BLOCK, min((block + 1) * BLOCK, len(theta)))
        _forward_block(theta[k], a[k], b[k], c[k], d[k], e[k])


def _backward_library(x: Any, a: Any, b: Any, c: Any, d: Any, e: Any) -> None:
    for i in numba.prange(len(x)):
        a[i], b[i], c[i], d[i], e[i] = _backward(x[i], -1.0)


LOOPS = {
    "forward, library": _forward_library,
    "forward, own": _forward_own,
    "backward, library": _backward_library,
}


def rows(name: str, parallel: bool = False) -> Callable[[Array], list[Array]]:
    """A loop over rows. As in C a division by zero is infinite, and products may be added
    unrounded."""
    loop = numba.njit(parallel=parallel, error_model="numpy", fastmath={"contract"})(LOOPS[name])

    def run(column: Array) -> list[Array]:
        out = [np.empty(len(column)) for _ in range(5)]
        loop(column, *out)
        return out

    return run
