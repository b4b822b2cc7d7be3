"""Cells of CSV files: decimal commas, and texts that a spreadsheet would take for formulas."""

from __future__ import annotations

import re

_FORMULA = re.compile(r"'*[=+\-@\t\r]")
_NUMBER = r"(?:\d+(?:[.,]\d*)?|[.,]\d+)(?:[eE][-+]?\d+)?"
_PLAIN = re.compile(rf"[-+]?{_NUMBER}")
_TOLERATED = re.compile(rf"[-+]?{_NUMBER}(?:\s*(?:±|\+-)\s*{_NUMBER}\s*%?)?")


def guarded(text: str) -> str:
    """A cell that no spreadsheet computes: an apostrophe before what would begin a formula.

    Numbers stay as they are; :func:`unguarded` reads the text again.
    """
    return f"'{text}" if _FORMULA.match(text) and not _PLAIN.fullmatch(text) else text


def unguarded(text: str) -> str:
    return text[1:] if text.startswith("'") and _FORMULA.match(text) else text


def delimiter(heading: str) -> str:
    """A comma, or what spreadsheets write instead where commas are decimal: a semicolon or a tab."""
    return max(",;\t", key=heading.count)


def decimal_point(text: str) -> str:
    """A number with a decimal comma (``3,5``, ``3,5 ± 0,1``) with a point; any other cell as it is."""
    if "," not in text or "." in text or not _TOLERATED.fullmatch(text.strip()):
        return text
    return text.replace(",", ".")
