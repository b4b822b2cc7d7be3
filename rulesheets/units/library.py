"""Units by name: ``units.txt`` with prefixes, a sheet's own, and pint for names that are in neither."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import replace
from fractions import Fraction
from functools import cache
from pathlib import Path
from typing import Any

from rulesheets.units.text import UnitError, read
from rulesheets.units.unit import Unit

PREFIXES = {
    "q": -30,
    "r": -27,
    "y": -24,
    "z": -21,
    "a": -18,
    "f": -15,
    "p": -12,
    "n": -9,
    "u": -6,
    "µ": -6,
    "μ": -6,
    "m": -3,
    "c": -2,
    "d": -1,
    "da": 1,
    "h": 2,
    "k": 3,
    "M": 6,
    "G": 9,
    "T": 12,
    "P": 15,
    "E": 18,
    "Z": 21,
    "Y": 24,
    "R": 27,
    "Q": 30,
}
SHORTEST = 4
"""Letters of the shortest name that pint is asked for."""

_FILE = Path(__file__).parent / "units.txt"
_FACTOR = re.compile(r"\s*(\d[\d.]*(?:[eE][+-]?\d+)?(?:/\d+)?)?\s*(pi\b)?\s*(.*?)\s*(/pi)?\s*")


class Library:
    """Definitions by name; a definition is read when it is first asked for.

    ``own`` are definitions of a sheet, each ``name = factor unit`` or ``name @ offset unit = unit``.
    """

    def __init__(self, own: Iterator[str] | tuple[str, ...] = ()) -> None:
        self._definitions = dict(_shipped()) if not own else {**_shipped(), **dict(_lines(own))}
        self._units: dict[str, Unit | None] = {}

    def unit(self, text: str) -> Unit:
        """The unit of a text. Raises UnitError."""
        found = self._units.get(text)
        if found is None:
            found = read(text, self.named)
            self._units[text] = found
        return found

    def named(self, name: str) -> Unit | None:
        """The unit of one name, prefix and all; None where there is none of that name."""
        key = f"\0{name}"
        if key not in self._units:
            self._units[key] = self._defined(name) or self._prefixed(name) or _from_pint(name)
        return self._units[key]

    def names(self) -> tuple[str, ...]:
        """What a suggestion may name."""
        return tuple(self._definitions)

    def _defined(self, name: str) -> Unit | None:
        found = self._definitions.get(name)
        if found is None:
            return None
        text, offset, _ = found
        if text == "base":
            return Unit(bases={name: Fraction(1)})
        unit = self._reading(text)
        return replace(unit, offset=self._reading(offset).factor) if offset else unit

    def _prefixed(self, name: str) -> Unit | None:
        for length in (1, 2):
            power, rest = PREFIXES.get(name[:length]), name[length:]
            found = self._definitions.get(rest)
            if power is not None and found is not None and found[2]:
                unit = self.named(rest)
                assert unit is not None
                return replace(unit, factor=unit.factor * Fraction(10) ** power)
        return None

    def _reading(self, text: str) -> Unit:
        """``1/180 pi rad``: a factor, perhaps π, and the text of a unit."""
        parts = _FACTOR.fullmatch(text)
        assert parts is not None
        factor, pi, rest, under = parts.groups()
        number = Unit(Fraction(factor or 1), (1 if pi else 0) - (1 if under else 0))
        return number * self.unit(rest) if rest else number


@cache
def _shipped() -> dict[str, tuple[str, str, bool]]:
    return dict(_lines(tuple(_FILE.read_text(encoding="utf-8").splitlines())))


def _lines(lines: Iterator[str] | tuple[str, ...]) -> Iterator[tuple[str, tuple[str, str, bool]]]:
    """Name → what it is defined as, where its scale begins, and whether it takes prefixes."""
    for line in lines:
        said = line.strip()
        if not said or said.startswith("#"):
            continue
        names, _, meaning = said.partition("=")
        names, _, offset = names.partition("@")
        first = names.split(",")[0].strip().removeprefix("~")
        for name in names.split(","):
            plain = name.strip().removeprefix("~")
            known = meaning.strip() if plain == first or meaning.strip() != "base" else first
            yield plain, (known, offset.strip(), name.strip().startswith("~"))


def _from_pint(name: str) -> Unit | None:
    """A unit that only pint knows, by its name alone; None where pint is absent or knows none.

    Short names are not asked for: pint reads ``cfm`` as centifermi and ``Nm`` as a number of metres.
    """
    if len(name) < SHORTEST:
        return None
    registry = _registry()
    if registry is None:
        return None
    try:
        found = registry.Quantity(1, registry.parse_units(name, as_delta=True)).to_base_units()
    except Exception:  # pint raises errors of its own and of Python for a name that it cannot read
        return None
    powers = {base: Fraction(power) for base, power in found._units.items()}
    if not powers.keys() <= _BASES.keys() or not isinstance(found.magnitude, int | Fraction):
        return None
    bases = {_BASES[base]: power for base, power in powers.items()}
    return Unit(Fraction(found.magnitude), 0, bases)


_BASES = {
    "meter": "m",
    "kilogram": "kg",
    "second": "s",
    "ampere": "A",
    "kelvin": "K",
    "mole": "mol",
    "candela": "cd",
    "radian": "rad",
    "bit": "bit",
}


@cache
def _registry() -> Any:
    try:
        from pint import UnitRegistry
    except ImportError:
        return None
    return UnitRegistry(non_int_type=Fraction)


@cache
def library() -> Library:
    """The units that every sheet has."""
    return Library()


__all__ = ["Library", "UnitError", "library"]
