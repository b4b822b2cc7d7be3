"""The words of a line, for messages about one that the grammar rejects."""

from __future__ import annotations


class Word(str):
    """A word with its kind (the terminal's name) and its place ``[start_pos, end_pos)`` in the code."""

    __slots__ = ("end_pos", "start_pos", "type")
    type: str
    start_pos: int
    end_pos: int

    @classmethod
    def at(cls, text: str, kind: str, start: int) -> Word:
        word = cls(text)
        word.type, word.start_pos, word.end_pos = kind, start, start + len(text)
        return word
