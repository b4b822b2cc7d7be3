"""The one door to lark: which words ``rules.lark`` knows, and how it derives a line from their kinds."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator
from pathlib import Path

from lark import Lark
from lark.common import LexerConf
from lark.exceptions import UnexpectedToken
from lark.lexer import Lexer, TerminalDef

from rulesheets.parse.derivation import Derivation, Recorder
from rulesheets.parse.words import Patterns, Word

_KINDS = ["rule", "row", "use", "head", "parameters", "figure", "mark"]
_LOCAL = "LOCAL"
"""The terminal of dotted names, which are words in marks alone: a rule sees no locals of its calls."""

_OF_ROWS = frozenset({"PLUS_MINUS", "PERCENT"})
"""Terminals of tolerances, which are words in rows alone: in a rule ``+-`` is a plus and a sign."""

_GRAMMAR = Path(__file__).parent.parent / "rules.lark"


def patterns(terminals: Iterable[TerminalDef], ignored: Collection[str]) -> Patterns:
    """Lark's terminals with their regular expressions, in the order in which lark itself tries them."""
    ordered = sorted(
        (terminal for terminal in terminals if terminal.name not in ignored),
        key=lambda terminal: (-terminal.priority, -terminal.pattern.max_width, terminal.name),
    )
    return tuple((str(terminal.name), str(terminal.pattern.to_regexp())) for terminal in ordered)


class Kinds(Lexer):
    """What lark reads: the kinds of words, each placed at its number in the line."""

    def __init__(self, conf: LexerConf) -> None:
        pass

    def lex(self, text: str) -> Iterator[Word]:  # type: ignore[override]
        return (Word.of_kind(kind, number) for number, kind in enumerate(text.split()))


class Parser:
    """Lark with the grammar of a line, compiled when this is made."""

    def __init__(self) -> None:
        self._recorder = Recorder()
        self._lark = Lark(
            _GRAMMAR.read_text(encoding="utf-8"),
            parser="lalr",
            lexer=Kinds,
            start=_KINDS,
            transformer=self._recorder,
            maybe_placeholders=True,
        )

    def patterns(self) -> dict[str, Patterns]:
        """The words of marks and of rows, and under no name those of all other lines."""
        ignored = {*self._lark.ignore_tokens}
        left_out = {"": ignored | {_LOCAL} | _OF_ROWS, "mark": ignored | _OF_ROWS, "row": ignored | {_LOCAL}}
        return {kind: patterns(self._lark.terminals, names) for kind, names in left_out.items()}

    def derivation(self, kinds: str, start: str) -> Derivation | int:
        """How words of these kinds are read; the number of the first that cannot be where it stands."""
        self._recorder.steps = []
        try:
            self._lark.parse(kinds, start=start)
        except UnexpectedToken as stop:
            ended = stop.token.type == "$END"
            return len(kinds.split()) if ended else int(stop.token.start_pos)
        return tuple((str(rule), parts) for rule, parts in self._recorder.steps)
