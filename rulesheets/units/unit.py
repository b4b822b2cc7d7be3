"""A unit as a number: an exact factor to SI, exponents of base units, and where its scale begins."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from fractions import Fraction

ANGLE = "rad"
"""The base unit that is a number of its own dimension: kept apart in conversions, ignored by dimensions."""


@dataclass(frozen=True)
class Unit:
    """``reading · factor · π^pi + offset`` is the quantity in base units, whose exponents are ``bases``.

    ``offset`` is not 0 for temperatures in °C and gauge pressures; such a unit inside a product is that of a
    difference.
    """

    factor: Fraction = Fraction(1)
    pi: int = 0
    bases: Mapping[str, Fraction] = field(default_factory=dict)
    offset: Fraction = Fraction(0)

    def __mul__(self, other: Unit) -> Unit:
        bases = dict(self.bases)
        for base, exponent in other.bases.items():
            bases[base] = bases.get(base, Fraction(0)) + exponent
        kept = {base: exponent for base, exponent in bases.items() if exponent}
        return Unit(self.factor * other.factor, self.pi + other.pi, kept)

    def __pow__(self, exponent: Fraction) -> Unit:
        """Raises ValueError for a root of a factor that is no power of integers or holds π."""
        bases = {base: one * exponent for base, one in self.bases.items() if exponent}
        power = self.pi * exponent
        if power.denominator != 1:
            raise ValueError("a root of an angle in turns or degrees")
        return Unit(_rational_power(self.factor, exponent), int(power), bases)

    def __truediv__(self, other: Unit) -> Unit:
        return self * other ** Fraction(-1)

    @property
    def scale(self) -> float:
        """One of this unit in base units."""
        return float(self.factor) * math.pi**self.pi

    @property
    def dimension(self) -> dict[str, Fraction]:
        """The exponents of base units; angles and decibels are numbers."""
        return {base: exponent for base, exponent in self.bases.items() if base not in (ANGLE, "dB")}


def _rational_power(number: Fraction, exponent: Fraction) -> Fraction:
    if exponent.denominator == 1:
        return number**exponent.numerator
    parts = [round(part ** (1 / exponent.denominator)) for part in number.as_integer_ratio()]
    root = Fraction(*parts)
    if root**exponent.denominator != number:
        raise ValueError(f"no exact root of {number}")
    return root**exponent.numerator


def ratio(source: Unit, target: Unit) -> float:
    """How many of ``target`` one of ``source`` is, correctly rounded but for a power of π."""
    return float(source.factor / target.factor) * math.pi ** (source.pi - target.pi)


def affine(source: Unit, target: Unit, difference: bool = False) -> tuple[float, float]:
    """The factor and the number that turn readings in ``source`` into readings in ``target``."""
    shift = Fraction(0) if difference else source.offset - target.offset
    return ratio(source, target), float(shift / target.factor) / math.pi**target.pi


def convert(number: float, source: Unit, target: Unit, difference: bool = False) -> float:
    """A reading in ``source`` as a reading in ``target``; of a ``difference`` no scale begins anywhere."""
    if source.pi == target.pi:
        shift = Fraction(0) if difference else source.offset - target.offset
        return float((Fraction(number) * source.factor + shift) / target.factor)
    factor, start = affine(source, target, difference)
    return number * factor + start
