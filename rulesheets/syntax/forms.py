"""Rules that differ in names and numbers only: what they share, and what is each one's own."""

from __future__ import annotations

import re
from collections.abc import Callable
from functools import cached_property
from typing import Any, NamedTuple, TypeAlias

from rulesheets.syntax import Source, Span, nodes
from rulesheets.syntax.nodes import Equality, Expression

NUMBER = r"(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?"
_WORD = re.compile(rf"\s*([^\W\d]\w*|{NUMBER}|\S)")
Sides: TypeAlias = tuple[tuple[Expression], tuple[Expression]]


class Form:
    """What rules share: ``text`` is Python that makes the two sides of one, ``exponents`` are the numbers, by
    their order, that stand as exponents. ``kept`` is for what is found out about rules of this form."""

    def __init__(self, text: str, exponents: tuple[int, ...]) -> None:
        self.text, self.exponents = text, exponents
        self.kept: dict[Any, Any] = {}

    def __reduce__(self) -> tuple[type, tuple[Any, ...]]:
        return Form, (self.text, self.exponents)

    @cached_property
    def build(self) -> Callable[..., Sides]:
        """The sides of a rule from its source, the places of its words, its names and its numbers."""
        found: Callable[..., Sides] = eval(self.text, {"S": Span, **vars(nodes)})  # of our own words only
        return found


class Like(NamedTuple):
    """One of these rules: its ``names`` in order of first appearance, the ``pattern`` by which they repeat
    (empty where none does), its ``numbers``, and the line that begins at ``start`` and says it (``code``)."""

    form: Form
    names: tuple[str, ...]
    pattern: tuple[int, ...]
    numbers: tuple[float, ...]
    start: int
    code: str

    def sides(self, source: Source) -> Sides:
        every = [self.names[k] for k in self.pattern] if self.pattern else self.names
        return self.form.build(source, words(self.code, self.start), every, self.numbers)

    def rule(self, span: Span) -> Equality:
        """The rule, whose sides are made when they are asked for."""
        made = Equality.__new__(Equality)
        made.span, made.like = span, self
        return made


def words(code: str, start: int) -> list[tuple[int, int]]:
    """Where each word of a line begins and ends in the text, in which the line begins at ``start``."""
    spans = (found.span(1) for found in _WORD.finditer(code))
    return [(start + begin, start + end) for begin, end in spans]
