"""Polynomials with rational coefficients, exactly: arithmetic, resultants and real roots, by sympy.

Lists of coefficients begin with the lowest degree. Real roots are isolated by continued fractions (A. G.
Akritas & A. W. Strzeboński, *Nonlinear Analysis: Modelling and Control* 10 (2005) 297–304).
"""

from __future__ import annotations

import math
import struct
from collections.abc import Sequence
from fractions import Fraction
from typing import Any, TypeAlias

import numpy as np
from sympy import QQ
from sympy.polys.densebasic import dup_strip
from sympy.polys.densetools import dup_diff, dup_eval
from sympy.polys.rings import ring
from sympy.polys.rootisolation import dup_isolate_real_roots_sqf
from sympy.polys.sqfreetools import dup_sqf_p, dup_sqf_part

from rulesheets.deadline import expect_time

Coefficients: TypeAlias = Sequence[Fraction]
LARGEST = 0x7FEF_FFFF_FFFF_FFFF
"""The place of the largest float."""


def generators(*names: str) -> tuple[Any, ...]:
    """The generators of a ring of polynomials. They add, multiply and are raised to whole powers."""
    _, *found = ring(names, QQ)
    return tuple(found)


def exact(number: float | Fraction) -> Any:
    """A number as the ring has it."""
    return QQ(*number.as_integer_ratio())


def coefficients(polynomial: Any) -> list[Fraction]:
    """Of a polynomial in one generator; none of 0."""
    return _fractions(polynomial.to_dense())


def simple_part(polynomial: Coefficients) -> list[Fraction]:
    """The polynomial with the same roots, each of them once: p over the common divisor of p and p'."""
    expect_time()
    return _fractions(dup_sqf_part(_dense(polynomial), QQ))


def real_roots(
    polynomial: Coefficients, low: float = -math.inf, high: float = math.inf, simple: bool = False
) -> tuple[float, ...] | None:
    """The real roots in [low, high], ascending, each the float nearest to where the polynomial changes sign.

    None where there is no such list: the polynomial is 0, or it has a multiple root (real or not), or a root
    beyond the floats or nearer to another one than floats can tell. ``simple``: it has no multiple root.
    """
    expect_time()
    dense = _dense(polynomial)
    if not dense or not (simple or dup_sqf_p(dense, QQ)):
        return None
    every = [_Root(dense, *ends) for ends in dup_isolate_real_roots_sqf(dense, QQ, fast=True)]
    inside = [root for root in every if root.is_within(low, high)]
    guesses = _guesses(dense) if inside else []
    found = [root.nearest(guesses) for root in inside]
    told = len(set(found)) == len(found) and all(map(math.isfinite, found))
    return tuple(found) if told else None


def _guesses(dense: list[Any]) -> list[float]:
    """The real parts of the roots in floats, as far as these can tell; and 0."""
    largest = max(map(abs, dense))
    with np.errstate(all="ignore"):
        try:
            found = np.roots([float(c) for c in reversed(_fractions([c / largest for c in dense]))])
        except np.linalg.LinAlgError:
            return [0.0]
    return [0.0, *found.real[np.isfinite(found.real)].tolist()]


def _dense(polynomial: Coefficients) -> list[Any]:
    stripped: list[Any] = dup_strip([exact(c) for c in reversed(polynomial)])
    return stripped


def _fractions(dense: Sequence[Any]) -> list[Fraction]:
    return [Fraction(int(QQ.numer(c)), int(QQ.denom(c))) for c in reversed(dense)]


class _Root:
    """The only root of a polynomial between two numbers, or the number that both are."""

    def __init__(self, dense: list[Any], low: Any, high: Any) -> None:
        self.dense, self.low, self.high = dense, low, high
        self.slope = dup_diff(dense, 1, QQ)
        self.before = dup_eval(dense, low, QQ) or dup_eval(self.slope, low, QQ)

    def side(self, x: Any) -> int:
        """The sign of x less the root."""
        if not self.low < x < self.high:
            return int(x > self.low) - int(x < self.high)
        at = dup_eval(self.dense, x, QQ)
        return 0 if not at else -1 if (at > 0) == (self.before > 0) else 1

    def is_within(self, low: float, high: float) -> bool:
        above = low == -math.inf or self.side(exact(low)) <= 0
        return above and (high == math.inf or self.side(exact(high)) >= 0)

    def nearest(self, guesses: Sequence[float]) -> float:
        """The nearest float, looked for from the nearest guess; infinite beyond all floats."""
        expect_time()
        middle = (self.low + self.high) / 2
        first = last = _place(self._corrected(min(guesses, key=lambda guess: abs(exact(guess) - middle))))
        stride = 1
        while first >= -LARGEST and self._side_of(first) >= 0:
            first, stride = max(first - stride, -LARGEST - 1), 2 * stride
        stride = 1
        while last <= LARGEST and self._side_of(last) <= 0:
            last, stride = min(last + stride, LARGEST + 1), 2 * stride
        while last - first > 1:
            place = (first + last) // 2
            side = self._side_of(place)
            if not side:
                return _float(place)
            first, last = (place, last) if side < 0 else (first, place)
        if first < -LARGEST or last > LARGEST:
            return math.inf
        middle = (exact(_float(first)) + exact(_float(last))) / 2
        return _float(last) if self.side(middle) < 0 else _float(first)

    def _side_of(self, place: int) -> int:
        return self.side(exact(_float(place)))

    def _corrected(self, guess: float) -> float:
        """The guess with a step of Newton's method."""
        x = exact(guess)
        slope = dup_eval(self.slope, x, QQ)
        try:
            return float(_fractions([x - dup_eval(self.dense, x, QQ) / slope])[0]) if slope else guess
        except OverflowError:
            return guess


def _place(number: float) -> int:
    """The place of a float in the order of all floats; that of 0 is 0."""
    size: int = struct.unpack(">q", struct.pack(">d", abs(number)))[0]
    return size if number > 0.0 else -size


def _float(place: int) -> float:
    """The float at a place."""
    size: float = struct.unpack(">d", struct.pack(">q", abs(place)))[0]
    return math.copysign(size, place)
