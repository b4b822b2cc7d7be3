"""Sine and cosine of degrees for blocks of rows: one reduction and two polynomials for both.

The reduction to the nearest right angle is exact. On what is left, within 45 degrees, the polynomials are
near-minimax ones in the square of the angle (Chebyshev fits of degree 5 at 40 digits, error below
1e-17); the sine's is trimmed so that 30 degrees give one half exactly. Right angles are put back by a turn
whose cosine and sine are whole numbers, so nothing is rounded by it and there is no branch.
"""

from __future__ import annotations

from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

Array: TypeAlias = NDArray[Any]

RADIAN = 0.017453292519943295
SINE = (
    1.591805913698281e-10,
    -2.5051130870968297e-08,
    2.755731609787775e-06,
    -0.0001984126983674956,
    0.008333333333330943,
    -0.1666666666666665,
)
COSINE = (
    -1.1382588535352522e-11,
    2.0876145659059344e-09,
    -2.755731726880539e-07,
    2.4801587298760048e-05,
    -0.0013888888888887393,
    0.041666666666666664,
)
FAR = 1e15
"""Beyond this many degrees the number of right angles is no longer exact in the product."""


class SineAndCosine:
    """Buffers for blocks of ``size`` rows, and the function that uses them."""

    def __init__(self, size: int) -> None:
        self.buffers = tuple(np.empty(size) for _ in range(6))

    def __call__(self, degrees: Array | float, sine: Array | None, cosine: Array | None) -> None:
        """Write the sine and the cosine of ``degrees`` (n,) where they are asked for."""
        quarters, rest, square, s, c, spare = self.buffers
        multiply, add, subtract = np.multiply, np.add, np.subtract
        if np.max(degrees) > FAR or np.min(degrees) < -FAR:
            degrees = np.fmod(degrees, 360.0)
        multiply(degrees, 1.0 / 90.0, quarters)
        np.rint(quarters, quarters)
        multiply(quarters, 90.0, rest)
        subtract(degrees, rest, rest)
        multiply(rest, RADIAN, rest)
        multiply(rest, rest, square)
        _horner(SINE, square, s)
        multiply(s, square, s)
        multiply(s, rest, s)
        add(rest, s, s)
        _horner(COSINE, square, c)
        multiply(square, square, spare)
        multiply(c, spare, c)
        multiply(square, 0.5, square)
        subtract(c, square, c)
        add(c, 1.0, c)
        # The turn by m right angles, m from -2 to 2: cosine 1 - |m|, sine m (2 - |m|).
        multiply(quarters, 0.25, spare)
        np.rint(spare, spare)
        multiply(spare, 4.0, spare)
        subtract(quarters, spare, quarters)
        np.absolute(quarters, spare)
        subtract(2.0, spare, rest)
        multiply(quarters, rest, quarters)
        subtract(1.0, spare, spare)
        if sine is not None:
            multiply(s, spare, square)
            multiply(c, quarters, rest)
            add(square, rest, sine)
        if cosine is not None:
            multiply(c, spare, square)
            multiply(s, quarters, rest)
            subtract(square, rest, cosine)


def _horner(coefficients: tuple[float, ...], x: Array, out: Array) -> None:
    np.multiply(x, coefficients[0], out)
    for coefficient in coefficients[1:-1]:
        np.add(out, coefficient, out)
        np.multiply(out, x, out)
    np.add(out, coefficients[-1], out)
