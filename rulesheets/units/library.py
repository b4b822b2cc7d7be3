"""Units by name: ``units.txt`` with prefixes, a sheet's own, and pint for names that are in neither."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import replace
from fractions import Fraction
from functools import cache, cached_property
from importlib.metadata import version
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from rulesheets import store
from rulesheets.units.text import UnitError, read
from rulesheets.units.unit import Unit

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

_FILE = Path(__file__).parent / "units.txt"
_NAMES = re.compile(r"~?[^\W\d_](?:\w*[^\W\d])?|[^\w\s\[\]()^*/·⋅=+-]+\w*")
_NUMBER = r"\d[\d.]*(?:[eE][+-]?\d+)?(?:/\d+)?"
_MEANING = re.compile(rf"({_NUMBER})?\s*\*?\s*(pi\b)?\s*(.*?)\s*(/pi)?(?:\s([+-])\s*({_NUMBER})\s*(.*))?")


class Library:
    """Units by name; a definition is read when it is first asked for.

    ``own`` are definitions of a sheet, each ``name, other names = factor unit + offset``; a name without a
    meaning is a unit of a kind of its own.
    """

    def __init__(self, own: tuple[str, ...] = ()) -> None:
        self.own = own
        self._units: dict[str, Unit | None] = {}

    def __reduce__(self) -> tuple[object, ...]:
        return library, (self.own,)

    @cached_property
    def _definitions(self) -> dict[str, tuple[str, str, bool]]:
        """Name → the first of its names, what that means, and whether it takes prefixes."""
        shipped = _FILE.read_text(encoding="utf-8").splitlines()
        lines = (line for line in (*shipped, *self.own) if line.strip() and not line.startswith("#"))
        return {name: found for line in lines for name, found in _defined(line)}

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
            self._units[key] = None  # a unit that is defined by itself is found to be unknown
            self._units[key] = self._known(name) or self._prefixed(name) or _from_pint(name)
        return self._units[key]

    def names(self) -> tuple[str, ...]:
        """What a suggestion may name."""
        return tuple(self._definitions)

    def _known(self, name: str) -> Unit | None:
        if name not in self._definitions:
            return None
        first, meaning, _ = self._definitions[name]
        return self.meant(meaning) if meaning else Unit(bases={first: Fraction(1)})

    def _prefixed(self, name: str) -> Unit | None:
        for length in (1, 2):
            power, rest = PREFIXES.get(name[:length]), name[length:]
            if power is not None and rest in self._definitions and self._definitions[rest][2]:
                unit = self.named(rest)
                return unit and replace(unit, factor=unit.factor * Fraction(10) ** power)
        return None

    def meant(self, text: str) -> Unit:
        """``1/180 pi rad``, ``5/9 K + 255.37``: a factor, perhaps π, a unit, and where its scale begins.

        Raises UnitError.
        """
        found = _MEANING.fullmatch(text.replace("[", " ").replace("]", " ").strip())
        if found is None or Fraction(found[1] or 1) == 0:
            raise UnitError("write a factor and a unit, and perhaps an offset", 0)
        factor, pi, name, under, sign, start, begun = found.groups()
        unit = self.unit(name) if name else Unit()
        offset = Fraction(start or 0) * (self.unit(begun) if begun else unit).factor
        scaled = unit * Unit(Fraction(factor or 1), (1 if pi else 0) - (1 if under else 0))
        return replace(scaled, offset=-offset if sign == "-" else offset)


def _defined(line: str) -> Iterator[tuple[str, tuple[str, str, bool]]]:
    names, _, meaning = line.partition("=")
    first = names.split(",")[0].strip().removeprefix("~")
    for name in map(str.strip, names.split(",")):
        yield name.removeprefix("~"), (first, meaning.strip(), name.startswith("~"))


def _from_pint(name: str) -> Unit | None:
    """A unit that only pint knows, by its name alone; None where pint is absent or knows none.

    Short names are not asked for: pint reads ``cfm`` as centifermi and ``Nm`` as a number of metres. Since
    pint takes longer to load than a sheet, what it said is kept.
    """
    if len(name) < SHORTEST or find_spec("pint") is None:
        return None
    key = store.digest(b"factor and powers", version("pint").encode(), name.encode())
    kept = store.load("unit", key)
    text = _asked(name) if kept is None else kept.decode()
    if kept is None:
        store.save("unit", key, text.encode())
    if not text:
        return None
    factor, *bases = text.split()
    powers = (part.split(":") for part in bases)
    return Unit(Fraction(factor), 0, {base: Fraction(power) for base, power in powers})


def _asked(name: str) -> str:
    """``1/100 m:1``, or nothing, as pint reads a name."""
    registry = _registry()
    if registry is None:
        return ""
    try:
        found = registry.Quantity(1, registry.parse_units(name, as_delta=True)).to_base_units()
    except Exception:  # pint raises errors of its own and of Python for a name that it cannot read
        return ""
    powers = found._units.items()
    if not {base for base, _ in powers} <= _BASES.keys() or not isinstance(found.magnitude, int | Fraction):
        return ""
    return " ".join(
        [str(Fraction(found.magnitude)), *(f"{_BASES[base]}:{Fraction(e)}" for base, e in powers)]
    )


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
def library(own: tuple[str, ...] = ()) -> Library:
    """The units of a sheet: those that every sheet has, and its ``own`` definitions."""
    return Library(own)


__all__ = ["Library", "UnitError", "library"]
