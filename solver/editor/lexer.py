"""Colours for sheets in whatever uses Pygments: sphinx, nbconvert, rich."""

from __future__ import annotations

from collections.abc import Iterator
from typing import ClassVar

from pygments.lexer import Lexer
from pygments.token import (
    Comment,
    Error,
    Keyword,
    Name,
    Number,
    Operator,
    Punctuation,
    String,
    Text,
    _TokenType,
)

from solver.editor import words

TOKENS = {
    "number": Number,
    "name": Name.Variable,
    "symbol": String.Symbol,
    "unit": Name.Label,
    "path": String,
    "operator": Operator,
    "punctuation": Punctuation,
    "error": Error,
    "keyword": Keyword,
    "head": Keyword.Namespace,
    "mark": Keyword.Type,
    "title": Name.Entity,
    "constant": Name.Constant,
    "builtin": Name.Builtin,
    "function": Name.Function,
    "comment": Comment,
}


class SheetLexer(Lexer):  # type: ignore[misc]
    """Rule sheets, by the words that the language server knows."""

    name = "Backsolve rule sheet"
    aliases: ClassVar[list[str]] = ["tk", "backsolve"]
    filenames: ClassVar[list[str]] = ["*.tk"]
    url = ""

    def get_tokens_unprocessed(self, text: str) -> Iterator[tuple[int, _TokenType, str]]:
        """Offset, token and text of every word, and of the blanks between."""
        end = 0
        for word in words(text):
            if end < word.start:
                yield end, Text, text[end : word.start]
            yield word.start, TOKENS[word.kind], word.text
            end = word.end
        if end < len(text):
            yield end, Text, text[end:]
