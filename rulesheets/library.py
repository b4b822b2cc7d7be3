"""Units: texts like ``kJ/kg-K``, the meaning of names, exact conversion."""

from __future__ import annotations

import math
import os
import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from decimal import Decimal
from fractions import Fraction
from functools import cache, cached_property, reduce
from operator import mul
from typing import Any

ANGLE = "rad"
"""The base unit that is a number: kept apart in conversions, ignored by dimensions."""


class UnitError(ValueError):
    """A text is not a unit; ``name`` is the unknown name, if that is why."""

    def __init__(self, message: str, name: str = "") -> None:
        super().__init__(message)
        self.name = name


@dataclass(frozen=True)
class Unit:
    """Base units are ``reading · factor · π^pi + offset``; ``bases`` are their exponents.

    ``offset`` is not 0 for temperatures in °C and gauge pressures; inside a product such a unit is
    that of a difference.
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
        """Raises UnitError for a root of a factor that is not a power of integers or holds π."""
        bases = {base: one * exponent for base, one in self.bases.items() if exponent}
        power = self.pi * exponent
        if power.denominator != 1:
            raise UnitError("a root of an angle in turns or degrees")
        if self.decades * abs(exponent) > MOST:
            raise UnitError(BEYOND)
        degree = exponent.denominator
        parts = [round(part ** (1 / degree)) for part in self.factor.as_integer_ratio()]
        root = Fraction(*parts) if exponent.denominator > 1 else self.factor
        if root**exponent.denominator != self.factor:
            raise UnitError(f"no exact root of {self.factor}")
        return Unit(root**exponent.numerator, int(power), bases)

    @property
    def decades(self) -> float:
        """Its approximate size in base units, as a power of ten."""
        above, below = map(int.bit_length, self.factor.as_integer_ratio())
        return abs(above - below) * math.log10(2.0)

    @property
    def scale(self) -> float:
        """One of this unit in base units."""
        return float(self.factor) * math.pi**self.pi

    @property
    def dimension(self) -> dict[str, Fraction]:
        """The exponents of base units; angles and decibels are numbers."""
        return {base: e for base, e in self.bases.items() if base not in (ANGLE, "dB")}


def affine(source: Unit, target: Unit, difference: bool = False) -> tuple[float, float]:
    """The factor and the offset that convert readings in ``source`` to readings in ``target``.

    The factor is correctly rounded except for a power of π.
    """
    shift = Fraction(0) if difference else source.offset - target.offset
    factor = float(source.factor / target.factor) * math.pi ** (source.pi - target.pi)
    return factor, float(shift / target.factor) / math.pi**target.pi


def convert(number: float, source: Unit, target: Unit, difference: bool = False) -> float:
    """A reading in ``source`` as a reading in ``target``; without offsets for a ``difference``."""
    if source.pi != target.pi:
        factor, start = affine(source, target, difference)
        return number * factor + start
    shift = Fraction(0) if difference else source.offset - target.offset
    return float((Fraction(number) * source.factor + shift) / target.factor)


_COMMENT = re.compile(r"\{[^}]*\}|\\\w+")
_ALIKE = str.maketrans("−–×", "--*")
_SUPERSCRIPTS = str.maketrans("⁰¹²³⁴⁵⁶⁷⁸⁹⁻", "0123456789-")
_WORD = re.compile(
    r"\s*(?:(?P<number>\d+(?:\.\d+)?(?:[eE][+-]?\d+)?(?:/0*[1-9]\d*)?)"
    r"|(?P<raise>\^|\*\*|[⁰¹²³⁴⁵⁶⁷⁸⁹⁻])"
    r"|(?P<sign>[-·⋅*/()]|\.(?![\d.]))|(?P<name>(?:[^\W\d_]|[°%‰$€£¥'℃℉])(?:(?![⁰¹²³⁴⁵⁶⁷⁸⁹])[\w°%])*))"
)
_POWER = re.compile(
    r"\s*(?:\^|\*\*|(?=[⁰¹²³⁴⁵⁶⁷⁸⁹⁻]))\s*(?:\(\s*(-?\d+(?:/0*[1-9]\d*|\.\d+)?)\s*\)"
    r"|(-?\d+(?:\.\d+)?)|([⁻]?[⁰¹²³⁴⁵⁶⁷⁸⁹]+))"
)
_TRAILING = re.compile(r"(\D*[^\W\d])(\d+)")


MOST = 150
"""Powers of ten between a unit and its base units: floats hold the ratio of any two."""
BEYOND = f"a unit is at most 1e{MOST} of its base units, and at least 1e-{MOST}"


def _number(text: str) -> Fraction:
    """``5/9``, ``1.5`` or ``1.5/9``. Raises UnitError."""
    above, _, below = text.partition("/")
    if abs(Decimal(above).adjusted()) > MOST:
        raise UnitError(BEYOND)
    return Fraction(above) / Fraction(below or 1)


def _in_range(unit: Unit) -> Unit:
    """The unit. Raises UnitError."""
    if unit.decades > MOST:
        raise UnitError(BEYOND)
    return unit


class _Reader:
    def __init__(self, text: str, lookup: Callable[[str], Unit | None]) -> None:
        self.text, self.lookup, self.place = text, lookup, 0

    def product(self) -> Unit:
        """Factors up to the end or a closing parenthesis."""
        factors: list[Unit] = []
        below = divided = False
        while (word := _WORD.match(self.text, self.place)) and word["sign"] != ")":
            self.place = word.end()
            if word["sign"] in ("/", "*"):
                below = word["sign"] == "/"
                divided = divided or below
            elif word["raise"]:
                whole = _POWER.match(self.text, word.start())
                raise UnitError(f"an exponent {'has nothing before it' if whole else 'is missing'}")
            elif word["sign"] in (None, "("):
                factor = self.raised(self.factor(word))
                factors.append(factor ** Fraction(-1) if below else factor)
        if not factors:
            raise UnitError("a unit is missing")
        return factors[0] if len(factors) == 1 and not divided else reduce(mul, factors, Unit())

    def factor(self, word: re.Match[str]) -> Unit:
        if word["name"]:
            return self.named(word["name"])
        if word["number"]:
            unit = Unit(_number(word["number"]))
            if not unit.factor:
                raise UnitError("a unit has no factor 0")
            return unit
        unit, closing = self.product(), _WORD.match(self.text, self.place)
        if closing is None:
            raise UnitError("a parenthesis is not closed")
        self.place = closing.end()
        return unit

    def raised(self, unit: Unit) -> Unit:
        """The unit to the power that follows it."""
        power = _POWER.match(self.text, self.place)
        if power is None:
            return unit
        self.place = power.end()
        return unit ** Fraction(power[1] or power[2] or power[3].translate(_SUPERSCRIPTS))

    def named(self, name: str) -> Unit:
        """A name, or one followed by its exponent: ``m3``."""
        found, parts = self.lookup(name), _TRAILING.fullmatch(name)
        if found is None and parts and (base := self.lookup(parts[1])):
            return base ** Fraction(parts[2])
        if found is None:
            raise UnitError(f"no unit is called {name}", name)
        return found


_SMALL, _LARGE = "m u n p f a z y r q", "k M G T P E Z Y R Q"
PREFIXES = {"c": -2, "d": -1, "da": 1, "h": 2, "µ": -6, "μ": -6} | {
    prefix: sign * 3 * (place + 1)
    for sign, prefixes in ((-1, _SMALL), (1, _LARGE))
    for place, prefix in enumerate(prefixes.split())
}
"""Powers of ten by the names of SI prefixes."""
SHORTEST = 4
"""Letters of the shortest name that pint is asked for."""
MONEY = frozenset({"USD", "EUR", "GBP", "JPY", "CHF", "$", "€", "£", "¥"})

_BASES = frozenset({"m", "kg", "s", "A", "K", "mol", "cd", ANGLE, "bit"})
"""Base units that a unit of pint may have."""

_FILE = os.path.join(os.path.dirname(__file__), "units", "units.txt")
_NUMBER = r"\d+\.?\d*(?:[eE][+-]?\d+)?(?:/0*[1-9]\d*)?"
_MEANING = re.compile(
    rf"({_NUMBER})?\s*\*?\s*(pi\b)?\s*(.*?)\s*(/pi)?(?:\s([+-])\s*({_NUMBER})\s*(.*))?"
)


class Library:
    """Units by name; a definition is read on first use.

    ``own`` are definitions of a sheet, each ``name, other names = factor unit + offset``; a name
    without a meaning is a unit with a dimension of its own.
    """

    def __init__(self, own: tuple[str, ...] = ()) -> None:
        self.own = own
        self._units: dict[str, Unit | None] = {}

    def __reduce__(self) -> tuple[object, ...]:
        return library, self.own

    @cached_property
    def _definitions(self) -> dict[str, tuple[str, str, bool]]:
        """The first of its names, the meaning, and whether it takes prefixes, by name."""
        with open(_FILE, encoding="utf-8") as file:
            shipped = file.read().splitlines()
        found = {}
        for line in (*shipped, *self.own):
            if line.strip() and not line.startswith("#"):
                left, _, meaning = line.partition("=")
                names = [name.strip() for name in left.split(",")]
                for name in names:
                    bare, first = name.removeprefix("~"), names[0].removeprefix("~")
                    found[bare] = first, meaning.strip(), name.startswith("~")
        return found

    def unit(self, text: str) -> Unit:
        """The unit of a text, ``W/m^2-K``, ``m3`` or ``(m/s)^2``. Raises UnitError.

        As in EES, a space, ``-``, ``.`` and ``·`` multiply, and everything to the right of a ``/``
        divides, up to a ``*`` or a parenthesis: ``W/m^2-K`` is W/(m²·K), ``W/m^2*K`` is W·K/m². A
        digit after a name is its exponent. ``-`` alone, and an empty text, are numbers without a
        unit; braces hold comments.
        """
        found = self._units.get(text)
        if found is not None:
            return found
        plain = _COMMENT.sub(" ", text.translate(_ALIKE)).strip()
        reader, found = _Reader(plain, self.named), Unit()
        if plain not in ("", "-"):
            found = reader.product()
            if rest := plain[reader.place :].strip():
                raise UnitError(f"`{rest}` is not read")
        self._units[text] = _in_range(found)
        return found

    def named(self, name: str) -> Unit | None:
        """The unit of one name, with its prefix; None if there is none of that name."""
        key = f"\0{name}"
        if key not in self._units:
            self._units[key] = None  # a unit that is defined by itself is found to be unknown
            self._units[key] = self._defined(name) or _from_pint(name)
        return self._units[key]

    def names(self) -> tuple[str, ...]:
        """The names that a suggestion may use."""
        return tuple(self._definitions)

    def prefixed(self) -> Iterator[str]:
        """The names that take SI prefixes, with each of them."""
        for name, (_, _, takes) in self._definitions.items():
            yield from (prefix + name for prefix in PREFIXES if takes)

    def _defined(self, name: str) -> Unit | None:
        if name in self._definitions:
            first, meaning, _ = self._definitions[name]
            return self.meant(meaning) if meaning else Unit(bases={first: Fraction(1)})
        for length in (1, 2):
            power, rest = PREFIXES.get(name[:length]), name[length:]
            if power is not None and rest in self._definitions and self._definitions[rest][2]:
                unit = self.named(rest)
                return unit and replace(unit, factor=unit.factor * Fraction(10) ** power)
        return None

    def meant(self, text: str) -> Unit:
        """``1/180 pi rad``, ``5/9 K + 255.37``: a factor, perhaps π, a unit, and its zero.

        Raises UnitError.
        """
        found = _MEANING.fullmatch(text.replace("[", " ").replace("]", " ").strip())
        if found is None or _number(found[1] or "1") == 0:
            raise UnitError("write a factor and a unit, and perhaps an offset")
        factor, pi, name, under, sign, start, begun = found.groups()
        unit = self.unit(name) if name else Unit()
        offset = _number(start or "0") * (self.unit(begun) if begun else unit).factor
        scaled = unit * Unit(_number(factor or "1"), (1 if pi else 0) - (1 if under else 0))
        return _in_range(replace(scaled, offset=-offset if sign == "-" else offset))


def _from_pint(name: str) -> Unit | None:
    """A unit that only pint knows, by a single name; None without pint or if pint does not know it.

    Short names are excluded: pint reads ``cfm`` as centifermi and ``Nm`` as a number of metres.
    """
    registry = _registry() if len(name) >= SHORTEST else None
    if registry is None:
        return None
    try:
        found = registry.Quantity(1, registry.parse_units(name, as_delta=True)).to_base_units()
    except Exception:  # pint raises errors of its own and of Python for a name that it cannot read
        return None
    bases = {registry.get_symbol(base): Fraction(e) for base, e in found._units.items()}
    if not bases.keys() <= _BASES or not isinstance(found.magnitude, int | Fraction):
        return None
    return Unit(Fraction(found.magnitude), 0, bases)


@cache
def _registry() -> Any:
    try:
        from pint import UnitRegistry
    except ImportError:
        return None
    return UnitRegistry(non_int_type=Fraction)


@cache
def library(*own: str) -> Library:
    """The units of a sheet: the common ones and its ``own`` definitions."""
    return Library(own)
