"""The nearest known word to one that is not known, and words that are known elsewhere."""

from __future__ import annotations

from collections.abc import Iterable
from difflib import get_close_matches


def closest(word: str, known: Iterable[str]) -> str | None:
    """The known word that ``word`` most likely stands for, or None where none is near.

    The same letters in another case come first, then Ratcliff and Obershelp's
    similarity; among equals the first in the order given.
    """
    candidates = list(dict.fromkeys(known))
    for candidate in candidates:
        if candidate.lower() == word.lower() and candidate != word:
            return candidate
    folded = {candidate.lower(): candidate for candidate in reversed(candidates)}
    near = get_close_matches(word.lower(), list(reversed(folded)), n=1, cutoff=0.6)
    return folded[near[0]] if near else None


def suggestion(word: str, known: Iterable[str]) -> tuple[str, ...]:
    """The note ``did you mean …?`` for a diagnosis, empty where nothing is near."""
    near = closest(word, known)
    return (f"did you mean {near}?",) if near else ()


def meant(name: str, variables: Iterable[str]) -> tuple[str, ...]:
    """The note on a name that no variable has: the full name of a local, or what is spelt alike."""
    known = list(variables)
    locals_ = [full for full in known if full.endswith(f".{name}")]
    if locals_:
        also = f" (also {', '.join(locals_[1:])})" if len(locals_) > 1 else ""
        return (f"its full name is {locals_[0]}{also}",)
    return suggestion(name, known)


def plural(count: int, noun: str) -> str:
    """``1 argument``, ``2 arguments``, ``no argument``."""
    if count == 0:
        return f"no {noun}"
    return f"{count} {noun}" + ("s" if count > 1 else "")


PROPERTIES = (
    *(
        "conductivity",
        "cp",
        "cv",
        "density",
        "dewpoint",
        "enthalpy",
        "entropy",
        "humrat",
        "intenergy",
        "molarmass",
    ),
    *(
        "p_sat",
        "prandtl",
        "pressure",
        "quality",
        "relhum",
        "soundspeed",
        "specheat",
        "surfacetension",
        "t_sat",
    ),
    *("temperature", "viscosity", "volume", "wetbulb"),
)
"""Functions of EES that give a property of a substance."""

WRITE_IN_PYTHON = 'write the function in Python, and name its file by use python "properties.py"'
