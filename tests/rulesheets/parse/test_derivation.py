"""Derivations found once against lark calling the builder itself, line by line."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from lark import Lark
from lark.common import LexerConf
from lark.lexer import Lexer

import rulesheets
from rulesheets.parse.builder import Builder
from rulesheets.parse.grammar import Grammar, Unparsed, scanner
from rulesheets.parse.layout import logical_lines
from rulesheets.parse.words import Word
from rulesheets.source import Source

GRAMMAR = Path(rulesheets.__file__).parent / "rules.lark"

RULES = (
    "a + b*c = 4 - sind(x)^2",
    "f + g*h = 5 - cosd(y)^3",
    "(x, y) = f(a, -b/2)",
    "call f(a, b*2; c)",
    "call f(; c)",
    "if a > 0 and not (b = 'open) then x = 1 else if given('y) or c <= 2 then y = 3 else z = pi",
    "a*b*c/d/e = (f + +g) - h^-2^k",
)


class Words(Lexer):
    def __init__(self, conf: LexerConf) -> None:
        self.scanner = scanner(conf.terminals, conf.ignore)

    def lex(self, text: str) -> Iterator[Word]:  # type: ignore[override]
        return self.scanner.words(text)


@pytest.mark.parametrize("text", RULES)
def test_a_derivation_calls_the_builder_as_lark_does(text: str) -> None:
    source = Source("<text>", text)
    builder = Builder()
    builder.source = source
    parser = Lark(
        GRAMMAR.read_text(encoding="utf-8"), parser="lalr", lexer=Words, start="rule", transformer=builder
    )
    (line,) = logical_lines(text)
    found, expected = Grammar().read(source, line, "rule"), parser.parse(text)
    assert found == expected
    assert found.span == expected.span


def test_lines_of_one_kind_keep_their_own_words() -> None:
    grammar, texts = Grammar(), RULES[:2]
    lines = [next(logical_lines(text)) for text in texts]
    nodes = [grammar.read(Source("", text), line, "rule") for text, line in zip(texts, lines, strict=True)]
    assert [node.span.text for node in nodes] == list(texts)
    assert nodes[0] != nodes[1]


@pytest.mark.parametrize(("text", "place"), [("a + = 2", 4), ("a + b =", 7), ("a = b $ c", 6)])
def test_where_a_line_cannot_go_on(text: str, place: int) -> None:
    (line,) = logical_lines(text + " ")
    with pytest.raises(Unparsed) as stop:
        Grammar().read(Source("", text), line, "rule")
    assert stop.value.place == place
