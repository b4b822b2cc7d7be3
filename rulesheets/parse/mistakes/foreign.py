"""Forms and signs of other languages, of EES above all, and characters that look like signs of this one."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Iterator

from rulesheets.diagnosis import Diagnosis, Label, error
from rulesheets.parse.layout import Line
from rulesheets.parse.mistakes.stop import Stop
from rulesheets.spelling import PROPERTIES, WRITE_IN_PYTHON
from rulesheets.syntax.source import Source, Span

_NAME = r"(?P<name>[^\W\d]\w*)"
_INDEX = r"(?:\d+|[ijkn])(?:\s*[-+]\s*\d+)?"
_CALL = r"(?P<name>(?!(?i:if|and|or|not|call|function)\b)[^\W\d]\w*)\s*\("
_NOT_BUILT_IN = "functions of substances are not built in"
_ANGLES = "leave it out: a variable has its own unit; sind, cosd and tand take degrees"
_COMMENT = 'a comment begins with " and reaches to the end of its line'
_TOLERANCE = "a tolerance stands after the value of an input, in the variables section"

_FOREIGN: list[tuple[str, str, str | None, str]] = [
    (r"^\s*\$(?i:unitsystem)\b.*", "E129", "$UnitSystem chooses nothing here", _ANGLES),
    (r"^\s*\$(?P<name>\w+).*", "E129", "${name} is a directive of EES", "leave it out"),
    (
        r"^\s*(?i:duplicate)\s+\w+\s*=.*",
        "E190",
        "DUPLICATE is not there yet",
        "write the rules out one by one",
    ),
    (
        rf"{_NAME}\[\s*{_INDEX}\s*\.\.\s*{_INDEX}\s*\]",
        *("E190", "arrays are not there yet", "write the elements out, each under a name such as {name}_1"),
    ),
    (
        rf"{_NAME}\[\s*(?P<index>{_INDEX})(?:\s*,\s*{_INDEX})*\s*\]",
        *("E190", "arrays are not there yet", "give each element a name of its own, such as {name}_{index}"),
    ),
    (rf"(?i:{'|'.join(PROPERTIES)})\s*\([^()]*[=;]", "E190", _NOT_BUILT_IN, WRITE_IN_PYTHON),
    (
        rf"{_CALL}[^()=]*=",
        *("E129", "arguments have no names here", "write {name}(a, b), in the order of its arguments"),
    ),
    (
        r"(?i:call)\s+\w+\s*\([^():]*:",
        *("E118", "a semicolon stands between arguments and results", "write call f(a, b; x, y)"),
    ),
    (rf"{_NAME}\$", "E129", "no name ends in $", "write {name}; its value is a symbol, such as 'water"),
    (rf"{_NAME}#", "E129", "no name ends in #", "write {name}, and give its number as an input"),
    (r"(?<![=~])(?<![=~]\s)\{[^}\n]*\}?", "E129", "braces enclose no comment", _COMMENT),
    (r":=|==+", "E115", "`=` is the only sign of equality", "write `=`"),
    (r"!=|/=|=/=|~=", "E108", None, "write <>"),
    (r"=<", "E108", None, "write <="),
    (r"=>", "E108", None, "write >="),
    (r"\*\*", "E108", None, "write ^ for a power"),
    (r"&&?", "E108", None, "write and"),
    (r"\|\|", "E108", None, "write or"),
    (r"\|", "E108", None, "write abs(x) for an absolute value; between conditions stands the word or"),
    (r"!", "E108", None, "write not"),
    (r"±|\+/-|\+-(?=\s*[\d.]+%?\s*$)", "E120", _TOLERANCE, "write = 3 ± 0.01 there"),
    (r"\{", "E190", "lists are not there yet", "give one value, and solve once for each"),
    (r"%", "E108", None, "write the number as a fraction, 0.05 for 5 %"),
    (r"#|//", "E108", None, 'a comment begins with "'),
    (r"'", "E108", "an apostrophe begins a symbol", "write 'open, with no apostrophe at the end"),
    (r"\.", "E108", None, "names are made of letters, digits and _"),
    (r"\[", "E122", "a unit is never closed", "write it as in [rad/s], on one line"),
]
_FORMS = [(re.compile(pattern), code, message, cure) for pattern, code, message, cure in _FOREIGN]


def foreign_form(stop: Stop) -> Diagnosis | None:
    """A diagnosis if a form of another language stands where reading stops."""
    word = stop.word
    if word is None:
        return None
    for pattern, code, message, cure in _FORMS:
        for found in pattern.finditer(stop.line.code):
            if found.start() <= word.start_pos and found.end() >= word.end_pos:
                return _foreign(stop, found, code, message, cure)
    return None


def _foreign(stop: Stop, found: re.Match[str], code: str, message: str | None, cure: str) -> Diagnosis:
    start = stop.line.start + found.start()
    parts = found.groupdict()
    said = (message or f"`{found.group()}` has no meaning in a rule sheet").format(**parts)
    span = Span(stop.source, start, start + len(found.group().rstrip()))
    return error(code, said, Label(span), notes=(cure.format(**parts),))


def unreadable(stop: Stop) -> Diagnosis:
    """The diagnosis where nothing more can be said."""
    word = stop.word
    if word is None:
        return stop.error("E101", "this line ends too early", stop.here, "")
    if word.type == "UNKNOWN":
        return stop.error("E108", f"`{word}` has no meaning in a rule sheet", stop.here, "", "remove it")
    after = f" after `{stop.before}`" if stop.before is not None else ""
    return stop.error("E101", f"`{word}` cannot stand here", stop.here, f"not{after}", "remove it")


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
