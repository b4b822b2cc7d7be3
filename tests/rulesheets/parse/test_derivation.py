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
from rulesheets.parse.grammar import Grammar, Unparsed
from rulesheets.parse.lalr import Parser, patterns
from rulesheets.parse.layout import logical_lines
from rulesheets.parse.words import Scanner, Word
from rulesheets.source import Source

GRAMMAR = Path(rulesheets.__file__).parent / "rules.lark"

RULES = (
    "a + b*c = 4 - sind(x)^2",
    "f + g*h = 5 - cosd(y)^3",
    "if and(a > 0, (b < 2 or c > 1)) or and(c = 1) then x = 1",
    "(x, y) = f(a, -b/2)",
    "call f(a, b*2; c)",
    "call f(; c)",
    "if a > 0 and not (b = 'open) then x = 1 else if given('y) or c <= 2 then y = 3 else z = pi",
    "a*b*c/d/e = (f + +g) - h^-2^k",
)


class Words(Lexer):
    def __init__(self, conf: LexerConf) -> None:
        self.scanner = Scanner(patterns(conf.terminals, conf.ignore))

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


@pytest.fixture
def parsers(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> list[Parser]:
    """The parsers of lark that were made, with an empty store."""
    made: list[Parser] = []

    class Noted(Parser):
        def __init__(self) -> None:
            super().__init__()
            made.append(self)

    monkeypatch.setenv("BACKSOLVE_CACHE", str(tmp_path / "store"))
    monkeypatch.setattr("rulesheets.parse.lalr.Parser", Noted)
    return made


def test_lines_of_kinds_seen_before_need_no_lark(parsers: list[Parser]) -> None:
    def read(grammar: Grammar, text: str) -> object:
        (line,) = logical_lines(text)
        return grammar.read(Source("", text), line, "rule")

    first, wrong = Grammar(), "a + = 2"
    fresh = [read(first, text) for text in RULES]
    with pytest.raises(Unparsed):
        read(first, wrong)
    first.keep()
    assert len(parsers) == 1
    second = Grammar()
    assert [read(second, text) for text in RULES] == fresh
    with pytest.raises(Unparsed) as stop:
        read(second, "bb + = 3")
    assert stop.value.place == 5
    assert len(parsers) == 1
    read(second, "a*a*a = 1")
    assert len(parsers) == 2


def test_derivations_beyond_the_limit_go(parsers: list[Parser], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("rulesheets.parse.grammar.MAX_DERIVATIONS", 3)
    grammar = Grammar()
    texts = ["a = " + "+".join("b" * n) for n in range(1, 6)]
    for text in texts * 2:
        (line,) = logical_lines(text)
        node = grammar.read(Source("", text), line, "rule")
        assert node.span.text == text
