"""The one door to lark: a logical line → a node, by ``rules.lark``."""

from __future__ import annotations

import threading
from collections.abc import Collection, Iterable, Iterator
from functools import cache, lru_cache
from pathlib import Path
from typing import Any

from lark import Lark
from lark.common import LexerConf
from lark.exceptions import UnexpectedToken
from lark.lexer import Lexer, TerminalDef

from rulesheets.parse.builder import Builder
from rulesheets.parse.derivation import Derivation, Recorder, follow
from rulesheets.parse.layout import Line
from rulesheets.parse.words import Scanner, Word
from rulesheets.source import Source

_KINDS = ["rule", "row", "use", "head", "parameters", "figure", "mark"]
_LOCAL = "LOCAL"
"""The terminal of dotted names, which are words in marks alone: a rule sees no locals of its calls."""

_OF_ROWS = frozenset({"PLUS_MINUS", "PERCENT"})
"""Terminals of tolerances, which are words in rows alone: in a rule ``+-`` is a plus and a sign."""

_DERIVATIONS = 1024
_GRAMMAR = Path(__file__).parent.parent / "rules.lark"


class Unparsed(Exception):
    """A line that the grammar rejects; ``place`` is where, as an offset into the line's code."""

    def __init__(self, place: int) -> None:
        super().__init__(f"not parsed beyond {place}")
        self.place = place


def scanner(terminals: Iterable[TerminalDef], ignored: Collection[str]) -> Scanner:
    """Lark's terminals in one regular expression, in the order in which lark itself tries them."""
    ordered = sorted(
        (terminal for terminal in terminals if terminal.name not in ignored),
        key=lambda terminal: (-terminal.priority, -terminal.pattern.max_width, terminal.name),
    )
    return Scanner([(terminal.name, terminal.pattern.to_regexp()) for terminal in ordered])


class Kinds(Lexer):
    """What lark reads: the kinds of words, each placed at its number in the line."""

    def __init__(self, conf: LexerConf) -> None:
        pass

    def lex(self, text: str) -> Iterator[Word]:  # type: ignore[override]
        return (Word.of_kind(kind, number) for number, kind in enumerate(text.split()))


class Grammar(threading.local):
    """The parser with its callbacks, one for each thread (the callbacks hold the current line).

    Lines whose words are of the same kinds are derived in the same way, so a derivation is found once
    and followed for every such line.
    """

    def __init__(self) -> None:
        self.builder = Builder()
        self.recorder = Recorder()
        self.lark = Lark(
            _GRAMMAR.read_text(encoding="utf-8"),
            parser="lalr",
            lexer=Kinds,
            start=_KINDS,
            transformer=self.recorder,
            maybe_placeholders=True,
        )
        ignored = {*self.lark.ignore_tokens}
        self.plain = scanner(self.lark.terminals, ignored | {_LOCAL} | _OF_ROWS)
        self.special = {
            "mark": scanner(self.lark.terminals, ignored | _OF_ROWS),
            "row": scanner(self.lark.terminals, ignored | {_LOCAL}),
        }
        self.derivation = lru_cache(maxsize=_DERIVATIONS)(self._derivation)

    def words(self, line: Line, kind: str) -> tuple[Word, ...]:
        """The words of a line of this kind."""
        return tuple(self.special.get(kind, self.plain).words(line.code))

    def read(self, source: Source, line: Line, kind: str) -> Any:
        """The node that a line of this kind (a start rule of the grammar) stands for.

        Raises Unparsed where the grammar rejects it, RuleSheetError for what it accepts but the
        builder does not (a number out of range).
        """
        words = self.words(line, kind)
        derivation = self.derivation(" ".join([word.type for word in words]), kind)
        if isinstance(derivation, int):
            raise Unparsed(words[derivation].start_pos if derivation < len(words) else len(line.code))
        self.builder.source = source
        self.builder.offset = line.start
        return follow(derivation, words, self.builder)

    def _derivation(self, kinds: str, start: str) -> Derivation | int:
        """How words of these kinds are read; the number of the first that cannot be where it stands."""
        self.recorder.steps = []
        try:
            self.lark.parse(kinds, start=start)
        except UnexpectedToken as stop:
            ended = stop.token.type == "$END"
            return len(kinds.split()) if ended else int(stop.token.start_pos)
        return tuple(self.recorder.steps)


@cache
def grammar() -> Grammar:
    return Grammar()
