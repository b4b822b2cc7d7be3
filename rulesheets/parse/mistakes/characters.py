"""Characters that look like signs of the language but are not."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Iterator

from rulesheets.diagnosis import Diagnosis, Label, error
from rulesheets.parse.layout import Line
from rulesheets.source import Source, Span

_SIGNS = {
    **dict.fromkeys("−–—‐‑‒―", "-"),
    **dict.fromkeys("×·⋅∙•∗✕", "*"),
    **dict.fromkeys("÷∕⁄", "/"),
    **dict.fromkeys("“”„‟«»″", '"'),
    **dict.fromkeys("‘’‚‛′´", "'"),
    **dict.fromkeys("≈≃≅", "~"),
    **dict.fromkeys("≡≔", "="),
    **dict.fromkeys("∧", "and"),
    **dict.fromkeys("∨", "or"),
    "¬": "not",
    "√": "sqrt(…)",
    "π": "pi",
    "°": "sind, cosd, … for angles in degrees",
    "½": "0.5",
    "¼": "0.25",
    "¾": "0.75",
    "∞": "no bound at all, which is the same",
}
_POWERS = {character: f"^{digit}" for digit, character in enumerate("⁰¹²³⁴⁵⁶⁷⁸⁹")}
_ALLOWED = frozenset("≤≥≠±")
_STRANGE = re.compile(r"[^\t\n\v\f\r -~]")
_QUOTED = re.compile(r'\[[^\[\]\n]*\]|"[^"\n]*"')


def strange_characters(source: Source, line: Line) -> Iterator[Diagnosis]:
    """One diagnosis for each kind of character that has no meaning in the code of a line.

    Units in brackets and quoted file names may hold any.
    """
    if not _STRANGE.search(line.code):
        return
    code = _QUOTED.sub(lambda found: " " * len(found.group()), line.code)
    told = set()
    for offset, character in enumerate(code):
        if not _STRANGE.match(character) or character in _ALLOWED or _is_letter(character):
            continue
        cure = _replacement(character)
        if cure not in told:
            told.add(cure)
            place = line.start + offset
            yield _strange(character, cure, Span(source, place, place + 1))


def _is_letter(character: str) -> bool:
    """Whether it may stand in a name: a letter with no other spelling (π is taken for pi)."""
    return (
        character not in _SIGNS
        and f"a{character}".isidentifier()
        and not unicodedata.combining(character)
        and unicodedata.normalize("NFKC", character) == character
    )


def _replacement(character: str) -> str:
    if character in _SIGNS:
        return _SIGNS[character]
    if character in _POWERS:
        return _POWERS[character]
    category = unicodedata.category(character)
    if category.startswith("Z"):
        return "a plain blank"
    if category == "Cf":
        return "nothing: it is invisible"
    plain = unicodedata.normalize("NFKC", character)
    return plain if plain != character and plain.isprintable() else ""


def _strange(character: str, cure: str, span: Span) -> Diagnosis:
    name = unicodedata.name(character, "").lower() or f"U+{ord(character):04X}"
    shown = f"{character} ({name})" if character.isprintable() else name
    help_line = f"write {cure}" if cure else "remove it, or put it into a comment"
    return error("E108", f"{shown} has no meaning in a rule sheet", Label(span, ""), notes=(help_line,))
