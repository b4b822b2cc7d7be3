"""Signs and words of other languages, and what is written here in their place."""

from __future__ import annotations

import re

from rulesheets.diagnosis import Diagnosis, Label, error
from rulesheets.parse.mistakes.stop import Stop
from rulesheets.source import Span

_TOLERANCE = "a tolerance stands after the value of an input, in the variables section"

_FOREIGN: list[tuple[str, str, str | None, str]] = [
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
_SIGNS = [(re.compile(pattern), code, message, cure) for pattern, code, message, cure in _FOREIGN]


def foreign_sign(stop: Stop) -> Diagnosis | None:
    """A diagnosis if a sign of another language stands where reading stops, or reaches up to there."""
    word = stop.word
    if word is None or (word == "{" and stop.before not in ("=", "~")):
        return None
    first = stop.before if stop.before is not None and stop.adjacent else word
    for start in dict.fromkeys((first.start_pos, word.start_pos)):
        for pattern, code, message, cure in _SIGNS:
            found = pattern.match(stop.line.code, start)
            if found and found.end() >= word.end_pos:
                return _foreign(stop, found.group(), start, code, message, cure)
    return None


def _foreign(stop: Stop, sign: str, start: int, code: str, message: str | None, cure: str) -> Diagnosis:
    place = stop.line.start + start
    message = message or f"`{sign}` has no meaning in a rule sheet"
    return error(code, message, Label(Span(stop.source, place, place + len(sign))), notes=(cure,))


def unreadable(stop: Stop) -> Diagnosis:
    """The diagnosis where nothing more can be said."""
    word = stop.word
    if word is None:
        return stop.error("E101", "this line ends too early", stop.here, "")
    if word.type == "UNKNOWN":
        return stop.error("E108", f"`{word}` has no meaning in a rule sheet", stop.here, "", "remove it")
    after = f" after `{stop.before}`" if stop.before is not None else ""
    return stop.error("E101", f"`{word}` cannot stand here", stop.here, f"not{after}", "remove it")
