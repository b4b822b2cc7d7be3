"""The words of a line: numbers, names, signs, as the terminals of the grammar define them."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import TypeAlias

Patterns: TypeAlias = tuple[tuple[str, str], ...]
"""Terminals by name with their regular expressions, in order of precedence."""


class Word(str):
    """A word with its kind (the terminal's name) and its place ``[start_pos, end_pos)`` in the code.

    The attribute names are those of lark's tokens, whose part it plays; lines and columns,
    which it would have too, are told from offsets where a message needs them.
    """

    __slots__ = ("end_pos", "start_pos", "type")
    line = column = end_line = end_column = None
    type: str
    start_pos: int
    end_pos: int

    @property
    def value(self) -> str:
        return str(self)

    @classmethod
    def of_kind(cls, kind: str, place: int) -> Word:
        """A word of which no more is known than its kind."""
        word = cls()
        word.type, word.start_pos, word.end_pos = kind, place, place
        return word


class Scanner:
    """Cuts code into words by one regular expression.

    What no terminal matches becomes
    a word of the kind ``UNKNOWN``, one character long, which no rule of the grammar accepts.
    """

    def __init__(self, terminals: Patterns) -> None:
        alternatives = "|".join(f"(?P<{name}>{pattern})" for name, pattern in terminals)
        self._word = re.compile(rf"\s*(?:{alternatives}|(?P<UNKNOWN>\S))")

    def words(self, code: str) -> Iterator[Word]:
        for found in self._word.finditer(code):
            kind = found.lastgroup
            word = Word(found[kind])  # type: ignore[index]
            word.type = kind  # type: ignore[assignment]
            word.end_pos = found.end()
            word.start_pos = word.end_pos - len(word)
            yield word
