"""A logical line → a node, by ``rules.lark``.

Lines whose words are of the same kinds are derived in the same way. A derivation is found once, followed
for every such line, and kept on disk with the words of the grammar: a sheet whose lines are
all shaped like lines seen before is read without lark.
"""

from __future__ import annotations

import marshal
import threading
from functools import cache, cached_property
from typing import TYPE_CHECKING, Any

from rulesheets import store
from rulesheets.parse.builder import Builder
from rulesheets.parse.derivation import Derivation, follow
from rulesheets.parse.layout import Line
from rulesheets.parse.words import Patterns, Scanner, Word
from rulesheets.source import Source

if TYPE_CHECKING:
    from rulesheets.parse.lalr import Parser

KIND = "grammar"

MAX_DERIVATIONS = 1024
"""Derivations at hand; beyond that the oldest goes."""


class Unparsed(Exception):
    """A line that the grammar rejects; ``place`` is where, as an offset into the line's code."""

    def __init__(self, place: int) -> None:
        super().__init__(f"not parsed beyond {place}")
        self.place = place


class Grammar(threading.local):
    """The words and derivations of lines, and the callbacks that follow them.

    There is one for each thread, as the callbacks hold the current line.
    """

    def __init__(self) -> None:
        self.builder = Builder()
        self._derivations: dict[tuple[str, str], Derivation | int | bytes] = {}
        self._changed = False
        data = store.load(KIND, b"")
        if data is None:
            self._patterns: dict[str, Patterns] = self._parser.patterns()
        else:
            self._patterns, self._derivations = marshal.loads(data)
        self._scanners = {kind: Scanner(patterns) for kind, patterns in self._patterns.items()}

    @cached_property
    def _parser(self) -> Parser:
        from rulesheets.parse.lalr import Parser

        return Parser()

    def words(self, line: Line, kind: str) -> tuple[Word, ...]:
        """The words of a line of this kind."""
        return tuple(self._scanners.get(kind, self._scanners[""]).words(line.code))

    def read(self, source: Source, line: Line, kind: str) -> Any:
        """The node that a line of this kind (a start rule of the grammar) stands for.

        Raises Unparsed where the grammar rejects it, RuleSheetError for what it accepts but the
        builder does not (a number out of range).
        """
        words = self.words(line, kind)
        derivation = self._derivation(" ".join([word.type for word in words]), kind)
        if isinstance(derivation, int):
            raise Unparsed(words[derivation].start_pos if derivation < len(words) else len(line.code))
        self.builder.source = source
        self.builder.offset = line.start
        return follow(derivation, words, self.builder)

    def keep(self) -> None:
        """Keep what was derived anew on disk, each derivation by itself, so that reading it can wait."""
        if not self._changed:
            return
        self._changed = False
        packed = {
            key: found if isinstance(found, bytes) else marshal.dumps(found)
            for key, found in self._derivations.items()
        }
        store.save(KIND, b"", marshal.dumps((self._patterns, packed)))

    def _derivation(self, kinds: str, start: str) -> Derivation | int:
        """How words of these kinds are read; the number of the first that cannot be where it stands."""
        key = kinds, start
        found = self._derivations.get(key)
        if isinstance(found, bytes):
            found = self._derivations[key] = marshal.loads(found)
        elif found is None:
            found = self._derivations[key] = self._parser.derivation(kinds, start)
            self._changed = True
            if len(self._derivations) > MAX_DERIVATIONS:
                del self._derivations[next(iter(self._derivations))]
        return found


@cache
def grammar() -> Grammar:
    return Grammar()
