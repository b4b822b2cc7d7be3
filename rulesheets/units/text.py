"""The text of a unit → a :class:`Unit`: ``W/m^2-K``, ``kJ/kg·K``, ``m3``, ``s^-1``, ``N m``, ``(m/s)^2``.

As in EES, a blank, ``-`` and ``·`` multiply, and everything right of a ``/`` is divided by until ``*`` or a
parenthesis says otherwise: ``W/m^2-K`` is W/(m²·K), ``W/m^2*K`` is W·K/m². A digit behind a name is its
exponent. ``-`` alone, and nothing, are numbers without a unit; braces hold comments.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from fractions import Fraction
from functools import reduce
from operator import mul

from rulesheets.units.unit import Unit

_COMMENT = re.compile(r"\{[^}]*\}|\\\w+")
_SUPERSCRIPTS = str.maketrans("⁰¹²³⁴⁵⁶⁷⁸⁹⁻", "0123456789-")
_WORD = re.compile(
    r"\s*(?:(?P<number>\d+(?:\.\d+)?(?:[eE][+-]?\d+)?(?:/\d+)?)|(?P<raise>\^|\*\*|(?=[⁰¹²³⁴⁵⁶⁷⁸⁹⁻]))"
    r"|(?P<sign>[-·⋅*/()])|(?P<name>(?:[^\W\d_]|[°%‰$€£¥'℃℉])(?:(?![⁰¹²³⁴⁵⁶⁷⁸⁹])[\w°%])*))"
)
_EXPONENT = re.compile(r"\s*(?:\(\s*(-?\d+(?:/\d+|\.\d+)?)\s*\)|(-?\d+(?:\.\d+)?)|([⁻]?[⁰¹²³⁴⁵⁶⁷⁸⁹]+))")
_TRAILING = re.compile(r"(\D*[^\W\d])(\d+)")


class UnitError(ValueError):
    """A text that is no unit: ``place`` is where it goes wrong, ``name`` the unknown name if that is why."""

    def __init__(self, message: str, place: int, name: str = "") -> None:
        super().__init__(message)
        self.place, self.name = place, name


def read(text: str, lookup: Callable[[str], Unit | None]) -> Unit:
    """The unit of a text; ``lookup`` gives that of a name. Raises UnitError."""
    blanked = _COMMENT.sub(lambda found: " " * len(found.group()), text)
    if blanked.strip() in ("", "-", "–"):
        return Unit()
    reader = _Reader(blanked, lookup)
    unit = reader.product()
    if reader.place < len(blanked.rstrip()):
        raise UnitError(f"`{blanked[reader.place :].strip()}` is not read", reader.place)
    return unit


class _Reader:
    def __init__(self, text: str, lookup: Callable[[str], Unit | None]) -> None:
        self.text, self.lookup, self.place = text, lookup, 0

    def product(self) -> Unit:
        """Factors up to the end or a closing parenthesis."""
        factors: list[Unit] = []
        below = divided = False
        while (word := _WORD.match(self.text, self.place)) and word["sign"] != ")":
            sign = word["sign"]
            if sign in ("/", "*"):
                below, self.place = sign == "/", word.end()
                divided = divided or below
            elif sign in ("-", "·", "⋅"):
                self.place = word.end()
            else:
                factor = self.factor(word)
                factors.append(Unit() / factor if below else factor)
        if not factors:
            raise UnitError("a unit is missing", self.place)
        return factors[0] if len(factors) == 1 and not divided else reduce(mul, factors, Unit())

    def factor(self, word: re.Match[str]) -> Unit:
        start, self.place = word.start(), word.end()
        if word["number"]:
            unit = Unit(Fraction(word["number"]))
        elif word["sign"] == "(":
            unit = self.product()
            closing = _WORD.match(self.text, self.place)
            if closing is None or closing["sign"] != ")":
                raise UnitError("a parenthesis is not closed", start)
            self.place = closing.end()
        elif word["name"]:
            unit = self.named(word["name"], self.text.index(word["name"], start))
        else:
            raise UnitError("an exponent has nothing before it", start)
        return self.raised(unit)

    def named(self, name: str, place: int) -> Unit:
        """A name, or one with its exponent behind it: ``m3``."""
        found = self.lookup(name)
        if found is not None:
            return found
        parts = _TRAILING.fullmatch(name)
        base = self.lookup(parts[1]) if parts else None
        if parts is None or base is None:
            raise UnitError(f"no unit is called {name}", place, name)
        return base ** Fraction(parts[2])

    def raised(self, unit: Unit) -> Unit:
        word = _WORD.match(self.text, self.place)
        if word is None or word["raise"] is None:
            return unit
        exponent = _EXPONENT.match(self.text, word.end())
        if exponent is None:
            raise UnitError("an exponent is missing", word.start())
        self.place = exponent.end()
        number = exponent[1] or exponent[2] or exponent[3].translate(_SUPERSCRIPTS)
        try:
            return unit ** Fraction(number)
        except ValueError as wrong:
            raise UnitError(str(wrong), word.start()) from None
