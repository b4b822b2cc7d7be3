"""The one door to lark: a logical line → a node, by ``rules.lark``."""

from __future__ import annotations

import threading
from functools import cache
from pathlib import Path
from typing import Any

from lark import Lark
from lark.exceptions import UnexpectedCharacters, UnexpectedInput

from rulesheets.parse.builder import Builder
from rulesheets.parse.layout import Line
from rulesheets.source import Source

_KINDS = ["rule", "row", "use", "head", "parameters"]
_GRAMMAR = Path(__file__).parent.parent / "rules.lark"


class Unparsed(Exception):
    """A line that the grammar rejects; ``place`` is where, as an offset into the line's code."""

    def __init__(self, place: int) -> None:
        super().__init__(f"not parsed beyond {place}")
        self.place = place


class Grammar(threading.local):
    """The parser with its callbacks, one for each thread (the callbacks hold the current line)."""

    def __init__(self) -> None:
        self.builder = Builder()
        self.lark = Lark(
            _GRAMMAR.read_text(encoding="utf-8"),
            parser="lalr",
            lexer="contextual",
            start=_KINDS,
            transformer=self.builder,
            maybe_placeholders=True,
        )

    def read(self, source: Source, line: Line, kind: str) -> Any:
        """The node that a line stands for as a ``rule``, ``row``, ``use``, ``head`` or ``parameters``.

        Raises Unparsed where the grammar rejects it, RuleSheetError for what it accepts but the
        builder does not (a number out of range).
        """
        self.builder.source = source
        self.builder.offset = line.start
        try:
            return self.lark.parse(line.code, start=kind)
        except UnexpectedCharacters as stop:
            raise Unparsed(stop.pos_in_stream) from None
        except UnexpectedInput as stop:
            place = getattr(stop.token, "start_pos", None) if hasattr(stop, "token") else None
            at_end = place is None or stop.token.type == "$END"
            raise Unparsed(len(line.code) if at_end else place) from None


@cache
def grammar() -> Grammar:
    return Grammar()
