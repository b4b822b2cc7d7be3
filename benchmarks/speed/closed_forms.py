"""The slider crank by hand: the reference kernels that compiled paths are measured against.

Nothing here is generated and nothing here checks anything: these are the formulas that somebody
would write who has solved the linkage on paper, for the five outputs of the paper's sheet.
"""

from __future__ import annotations

from math import acos, atan2, cos, degrees, hypot, radians, sin, sqrt
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

Array: TypeAlias = NDArray[Any]
Five: TypeAlias = tuple[float, float, float, float, float]

AO, AB, OFFSET, OMEGA, ALPHA = 3.0, 8.0, 2.0, -15.0, -10.0
BLOCK = 4096


def forward(theta: float) -> Five:
    """xB, vB, omegaAB, aB, alphaAB of the open configuration from the crank angle in degrees."""
    t = radians(theta)
    s, c = sin(t), cos(t)
    xA, yA = AO * c, AO * s
    dy = OFFSET - yA
    dx = sqrt(AB * AB - dy * dy)
    xa, ya = -OMEGA * yA, OMEGA * xA
    omegaAB = -ya / dx
    vB = xa - omegaAB * dy
    xa1 = -OMEGA * OMEGA * xA - ALPHA * yA
    ya1 = -OMEGA * OMEGA * yA + ALPHA * xA
    alphaAB = (omegaAB * omegaAB * dy - ya1) / dx
    aB = xa1 - omegaAB * omegaAB * dx - alphaAB * dy
    return xA + dx, vB, omegaAB, aB, alphaAB


def backward(xB: float) -> list[Five]:
    """thetaAO, vB, omegaAB, aB, alphaAB for both crank angles of a slider position."""
    distance = hypot(xB, OFFSET)
    psi = atan2(OFFSET, xB)
    swing = acos((AO * AO + distance * distance - AB * AB) / (2.0 * AO * distance))
    found = []
    for t in (psi - swing, psi + swing):
        s, c = sin(t), cos(t)
        xA, yA = AO * c, AO * s
        dx, dy = xB - xA, OFFSET - yA
        xa, ya = -OMEGA * yA, OMEGA * xA
        omegaAB = -ya / dx
        vB = xa - omegaAB * dy
        xa1 = -OMEGA * OMEGA * xA - ALPHA * yA
        ya1 = -OMEGA * OMEGA * yA + ALPHA * xA
        alphaAB = (omegaAB * omegaAB * dy - ya1) / dx
        aB = xa1 - omegaAB * omegaAB * dx - alphaAB * dy
        found.append((degrees(t), vB, omegaAB, aB, alphaAB))
    return found


def forward_rows(theta: Array, out: list[Array]) -> None:
    """The forward form on arrays, in blocks that stay in the cache."""
    for start in range(0, len(theta), BLOCK):
        rows = slice(start, start + BLOCK)
        t = np.radians(theta[rows])
        s, c = np.sin(t), np.cos(t)
        xA, yA = AO * c, AO * s
        dy = OFFSET - yA
        dx = np.sqrt(AB * AB - dy * dy)
        _rates(xA, yA, dx, dy, [column[rows] for column in out[1:]])
        out[0][rows] = xA + dx


def backward_rows(xB: Array, out: list[Array]) -> None:
    """The backward form on arrays, for the smaller of the two angles."""
    for start in range(0, len(xB), BLOCK):
        rows = slice(start, start + BLOCK)
        x = xB[rows]
        distance = np.hypot(x, OFFSET)
        psi = np.arctan2(OFFSET, x)
        swing = np.arccos((AO * AO + distance * distance - AB * AB) / (2.0 * AO * distance))
        t = psi - swing
        xA, yA = AO * np.cos(t), AO * np.sin(t)
        _rates(xA, yA, x - xA, OFFSET - yA, [column[rows] for column in out[1:]])
        out[0][rows] = np.degrees(t)


def _rates(xA: Array, yA: Array, dx: Array, dy: Array, out: list[Array]) -> None:
    xa, ya = -OMEGA * yA, OMEGA * xA
    omegaAB = -ya / dx
    out[0][:] = xa - omegaAB * dy
    out[1][:] = omegaAB
    xa1 = -OMEGA * OMEGA * xA - ALPHA * yA
    ya1 = -OMEGA * OMEGA * yA + ALPHA * xA
    square = omegaAB * omegaAB
    alphaAB = (square * dy - ya1) / dx
    out[2][:] = xa1 - square * dx - alphaAB * dy
    out[3][:] = alphaAB
