"""Derivations: in which order, and of which parts, the rules of the grammar make up a line.

A derivation depends on the kinds of the words alone, so that it serves all lines alike.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, TypeAlias

from rulesheets.parse.words import Word

Derivation: TypeAlias = tuple[tuple[str, tuple[int | None, ...]], ...]
"""Rules by name with their parts: a word by its number from 0 up, what an earlier rule made by its number
from -1 down, None for an optional part that is not there. The last rule makes the whole."""


class Recorder:
    """Stands in for the callbacks of the parser and keeps in ``steps`` what would be called with what."""

    def __init__(self) -> None:
        self.steps: list[tuple[str, tuple[int | None, ...]]] = []

    def __getattr__(self, rule: str) -> Callable[[Sequence[Word | int | None]], int]:
        """The callback of a rule; terminals and nameless rules (``__sum_plus_0``) have none."""
        if rule.startswith("_") or rule.isupper():
            raise AttributeError(rule)

        def record(parts: Sequence[Word | int | None]) -> int:
            numbers = (part.start_pos if isinstance(part, Word) else part for part in parts)
            self.steps.append((rule, tuple(numbers)))
            return -len(self.steps)

        return record


def follow(derivation: Derivation, words: Sequence[Word], callbacks: Any) -> Any:
    """What the callbacks, called by the names of the rules, make of the words."""
    made: list[Any] = []
    for rule, parts in derivation:
        children = [None if i is None else words[i] if i >= 0 else made[-i - 1] for i in parts]
        made.append(getattr(callbacks, rule)(children))
    return made[-1]
