"""The one door to lark: a logical line → a node, by ``rules.lark``."""

from __future__ import annotations

import threading
from collections.abc import Collection, Iterable, Iterator
from functools import cache
from pathlib import Path
from typing import Any

from lark import Lark
from lark.common import LexerConf
from lark.exceptions import UnexpectedToken
from lark.lexer import Lexer, TerminalDef

from rulesheets.parse.builder import Builder
from rulesheets.parse.layout import Line
from rulesheets.parse.words import Scanner, Word
from rulesheets.source import Source

_KINDS = ["rule", "row", "use", "head", "parameters"]
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


class Words(Lexer):
    """The scanner as lark wants it; lark's own lexers count lines, which takes them longer."""

    def __init__(self, conf: LexerConf) -> None:
        self.scanner = scanner(conf.terminals, conf.ignore)

    def lex(self, text: str) -> Iterator[Word]:  # type: ignore[override]
        return self.scanner.words(text)


class Grammar(threading.local):
    """The parser with its callbacks, one for each thread (the callbacks hold the current line)."""

    def __init__(self) -> None:
        self.builder = Builder()
        self.lark = Lark(
            _GRAMMAR.read_text(encoding="utf-8"),
            parser="lalr",
            lexer=Words,
            start=_KINDS,
            transformer=self.builder,
            maybe_placeholders=True,
        )
        self.scanner = scanner(self.lark.terminals, self.lark.ignore_tokens)

    def read(self, source: Source, line: Line, kind: str) -> Any:
        """The node that a line stands for as a ``rule``, ``row``, ``use``, ``head`` or ``parameters``.

        Raises Unparsed where the grammar rejects it, RuleSheetError for what it accepts but the
        builder does not (a number out of range).
        """
        self.builder.source = source
        self.builder.offset = line.start
        try:
            return self.lark.parse(line.code, start=kind)
        except UnexpectedToken as stop:
            ended = stop.token.type == "$END"
            raise Unparsed(len(line.code) if ended else stop.token.start_pos) from None


@cache
def grammar() -> Grammar:
    return Grammar()
