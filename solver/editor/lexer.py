"""A Pygments lexer for sheets: for Sphinx, nbconvert, rich and others."""

from __future__ import annotations

from collections.abc import Iterator
from typing import ClassVar

from pygments import token
from pygments.lexer import Lexer

from solver.editor import words

TOKENS = {
    "number": token.Number,
    "name": token.Name.Variable,
    "symbol": token.String.Symbol,
    "unit": token.Name.Label,
    "path": token.String,
    "operator": token.Operator,
    "punctuation": token.Punctuation,
    "error": token.Error,
    "keyword": token.Keyword,
    "head": token.Keyword.Namespace,
    "mark": token.Keyword.Type,
    "title": token.Name.Entity,
    "constant": token.Name.Constant,
    "builtin": token.Name.Builtin,
    "function": token.Name.Function,
    "comment": token.Comment,
}


class SheetLexer(Lexer):  # type: ignore[misc]
    """Rule sheets, by the words of the language server."""

    name = "Backsolve rule sheet"
    aliases: ClassVar[list[str]] = ["tk", "backsolve"]
    filenames: ClassVar[list[str]] = ["*.tk"]
    url = ""

    def get_tokens_unprocessed(self, text: str) -> Iterator[tuple[int, token._TokenType, str]]:
        """Offset, token and text of every word, and of the blanks between."""
        end = 0
        for word in words(text):
            if end < word.start:
                yield end, token.Text, text[end : word.start]
            yield word.start, TOKENS[word.kind], word.text
            end = word.end
        if end < len(text):
            yield end, token.Text, text[end:]
