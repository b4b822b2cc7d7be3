"""A logical line → a node, by lark and ``rules.lark``: the one door to lark."""

from __future__ import annotations

import os
import re
import threading
from collections.abc import Callable, Iterable
from functools import cache
from typing import Any

from lark import Lark
from lark.exceptions import UnexpectedCharacters, UnexpectedToken
from lark.lexer import PatternRE, TerminalDef

from rulesheets import store
from rulesheets.diagnosis import RuleSheetError, refuse
from rulesheets.parse import foreign, mistakes
from rulesheets.parse.builder import Builder, Unparsed
from rulesheets.parse.foreign import Stop, Word
from rulesheets.parse.layout import Line
from rulesheets.syntax import Source, forms
from rulesheets.syntax.nodes import Equality, Inequality

KINDS = ["rule", "use", "head", "parameters", "figure", "mark"]
"""Kinds of lines beside rows: start rules of the grammar."""

_ONLY_IN = {"LOCAL": "mark", "PLUS_MINUS": "row", "PERCENT": "row"}
"""Terminals that are words in lines of one kind alone: in a rule ``+-`` is a plus and a sign."""

MOST_FORMS = 10_000
"""Forms of rules that are remembered at a time."""

_GRAMMAR = os.path.join(os.path.dirname(__file__), os.pardir, "rules.lark")


class Grammar(threading.local):
    """Lark with the grammar of a line, one for each thread, as the builder holds the current line.

    Rows have a parser of their own: the lexer of the others does not know the sign of a tolerance.
    """

    def __init__(self) -> None:
        self._builder = Builder()
        self._patterns: dict[str, re.Pattern[str]] = {}
        self.forms: dict[tuple[Any, ...], forms.Form | None] = {}
        self._lark = self._parser("lines", KINDS)
        self._of_rows = self._parser("rows", ["row"], _before_a_unit)

    def _parser(
        self, name: str, start: list[str], edit: Callable[[TerminalDef], object] | None = None
    ) -> Lark:
        """A parser whose tables lark keeps on disk, where there is a folder for that."""
        return Lark.open(
            _GRAMMAR,
            parser="lalr",
            start=start,
            transformer=self._builder,
            maybe_placeholders=True,
            edit_terminals=edit,
            cache=store.place(f"grammar-{name}") or False,
        )

    def read(self, source: Source, line: Line, kind: str) -> Any:
        """The node that a line of this kind (a start rule of the grammar) stands for.

        Raises Unparsed where the grammar rejects it, RuleSheetError for what it accepts but the
        builder does not (a number out of range).
        """
        self._builder.begin(source, line.start, kind)
        try:
            parser = self._of_rows if kind == "row" else self._lark
            return parser.parse(line.code, start=kind)
        except UnexpectedToken as stop:
            ended = stop.token.type == "$END"
            raise Unparsed(len(line.code) if ended else int(stop.token.start_pos or 0)) from None
        except UnexpectedCharacters as stop:
            raise Unparsed(int(stop.pos_in_stream or 0)) from None

    def words(self, line: Line, kind: str) -> tuple[Word, ...]:
        """The words of a line, right or wrong: a character that no terminal matches is an ``UNKNOWN``."""
        if kind not in self._patterns:  # of the terminals, in the order in which lark itself tries them
            parsers = (self._lark, self._of_rows) if kind == "row" else (self._of_rows, self._lark)
            terminals = {terminal.name: terminal for lark in parsers for terminal in lark.terminals}
            for name in ("BLANK", *(name for name, only in _ONLY_IN.items() if only != kind)):
                terminals.pop(name, None)
            ordered = sorted(
                terminals.values(),
                key=lambda terminal: (-terminal.priority, -terminal.pattern.max_width, terminal.name),
            )
            either = "|".join(f"(?P<{terminal.name}>{terminal.pattern.to_regexp()})" for terminal in ordered)
            self._patterns[kind] = re.compile(rf"\s*(?:{either}|(?P<UNKNOWN>\S))")
        return tuple(
            Word(group, found[group], found.start(group), end_pos=found.end(group))
            for found in self._patterns[kind].finditer(line.code)
            if (group := found.lastgroup)
        )


def _before_a_unit(terminal: TerminalDef) -> None:
    """In a row, a number has a unit of its own only where that of the row follows."""
    if terminal.name == "MEASURE":
        terminal.pattern = PatternRE(
            rf"{terminal.pattern.value}(?=[^\n]*\[[^\[\],\n]*\])", terminal.pattern.flags
        )


@cache
def grammar() -> Grammar:
    """The grammar, compiled when it is first needed."""
    return Grammar()


def read_line(source: Source, line: Line, kind: str) -> Any:
    """The node of a line of this kind, a start rule of the grammar; of a rule in a long text, from the third
    of its form on, that of the second with other leaves.

    Raises RuleSheetError with what is wrong. The shape of the line has been found right before.
    """
    leaves = forms.leaves_of(line.code) if kind == "rule" and len(source.text) > forms.LONG else None
    if leaves is None:
        return _read(source, line, kind)
    known = grammar().forms
    if (form := known.get(leaves.key)) is not None:
        return forms.rule_of(form, leaves, line.code, line.start, line.place(source))
    node = _read(source, line, "rule")
    if len(known) >= MOST_FORMS:
        known.clear()
    again = leaves.key in known
    known[leaves.key] = forms.form_of(node, leaves, line.code, line.start) if again else None
    return node


def _read(source: Source, line: Line, kind: str) -> Any:
    refuse(foreign.strange_characters(source, line))
    try:
        node = grammar().read(source, line, kind)
    except Unparsed as stopped:
        words = grammar().words(line, kind)
        index = next((i for i, word in enumerate(words) if word.end_pos > stopped.place), len(words))
        stop = Stop(source, line, words, index)
        explain = mistakes.explain_line if kind in ("rule", "row", "mark") else foreign.explain_head
        raise RuleSheetError(explain(stop, kind)) from None
    wrong = next(filter(None, map(foreign.too_deep, _trees(node, kind))), None)
    if wrong is None and kind == "mark":
        wrong = mistakes.wrong_mark(node)
    elif wrong is None and isinstance(node, Equality | Inequality):
        wrong = mistakes.without_variable(node)
    if wrong is not None:
        raise RuleSheetError(wrong)
    return node


def _trees(node: Any, kind: str) -> Iterable[Any]:
    """What may be deep in a line, but for the ends of ranges, which are evaluated by now."""
    match kind:
        case "rule":
            return (node,)
        case "mark":
            return tuple(node.arguments)
        case "row":
            return filter(None, (node.value, node.guess, node.tolerance and node.tolerance.size))
        case _:
            return ()
