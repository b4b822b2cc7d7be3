"""Rules of one form, made like the first of them that was read: for sheets of thousands of rules.

The rules of a network differ in names and numbers only. Where two lines are the same but for these, the
grammar makes the same tree of both: the tree of the second is that of the first with its own leaves and
places. Lines with anything but names, numbers, operators, parentheses and built-in functions go through the
grammar.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from typing import Any, NamedTuple, TypeAlias

from rulesheets.functions import PLANNED, TABLE
from rulesheets.syntax import Source, Span
from rulesheets.syntax.nodes import Call, Equality, Expression, Name, Number, Power, Symbol, children, rebuilt
from rulesheets.syntax.program import walk

LONG = 20_000
"""Characters of a text from which on its rules are compared with one another."""
LONGEST = 3_000
"""Characters of a rule that is compared: ten thousand forms of so many are remembered."""

_NUMBER = r"(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?"
_WORD = re.compile(rf"\s*([^\W\d]\w*|{_NUMBER}|\S)")
_NAME = r"(?!(?=[iteconapITECONAP])(?i:if|then|else|call|and|or|not|pi)\b)[a-zA-Z_][a-zA-Z_0-9]*+(?!\w|\s*\()"
_LEAF = re.compile(rf"(?<![\w.])(?:({_NAME})|({_NUMBER}))")
_BETWEEN = re.compile(r"(?:[a-z_]\w*(?=\s*\()|pi\b|[-+*/^(),=\s])*", re.ASCII | re.IGNORECASE)
_INDICES = Source("<form>", "")
"""The source of places that count words."""

Sides: TypeAlias = tuple[tuple[Expression], tuple[Expression]]


class Leaves(NamedTuple):
    """A line: what its tree depends on (``key``), its names and its numbers in the order of the text."""

    key: str
    names: list[str]
    numbers: tuple[float, ...]


class Form:
    """What rules share: the ``sides`` of the first, whose places are indices of words, and which numbers, by
    their order, stand as ``exponents``. ``kept`` is for what is found out about rules of this form."""

    def __init__(self, sides: Sides, exponents: tuple[int, ...]) -> None:
        self.sides, self.exponents = sides, exponents
        self.kept: dict[Any, Any] = {}

    def __reduce__(self) -> tuple[type, tuple[Any, ...]]:
        return Form, (self.sides, self.exponents)


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
        places = words(self.code, self.start)

        def place(span: Span) -> Span:
            return Span(source, places[span.start][0], places[span.end][1])

        return _sides(self.form.sides, Leaves("", [*every], self.numbers), place)

    def rule(self, span: Span) -> Equality:
        """The rule, whose sides are made when they are asked for."""
        made = Equality.__new__(Equality)
        made.span, made.like = span, self
        return made


def words(code: str, start: int) -> list[tuple[int, int]]:
    """Where each word of the line at ``start`` begins and ends."""
    spans = (found.span(1) for found in _WORD.finditer(code))
    return [(start + begin, start + end) for begin, end in spans]


def leaves_of(code: str) -> Leaves | None:
    """None where the line is long, or has a number out of range."""
    if len(code) > LONGEST:
        return None
    parts = _LEAF.split(code)
    names = [name for name in parts[1::3] if name]
    written = [number for number in parts[2::3] if number]
    numbers = tuple(map(float, written))
    if math.inf in numbers:
        return None
    if any(not number and text.strip("0.") for number, text in zip(numbers, written, strict=True)):
        return None
    parts[1::3] = [name and "@" for name in parts[1::3]]
    parts[2::3] = [number and "#" for number in parts[2::3]]
    return Leaves("".join(filter(None, parts)), names, numbers)


def rule_of(form: Form, leaves: Leaves, code: str, start: int, span: Span) -> Equality:
    """The rule of the line at ``start`` that has this form."""
    names = tuple(dict.fromkeys(leaves.names))
    places = {name: k for k, name in enumerate(names)}
    pattern = tuple(map(places.__getitem__, leaves.names)) if len(names) < len(leaves.names) else ()
    return Like(form, names, pattern, leaves.numbers, start, code).rule(span)


def form_of(first: object, leaves: Leaves, code: str, start: int) -> Form | None:
    """What rules share that differ from the line at ``start`` in names and numbers only, told by its tree.

    None for rules that are more than an equality of two expressions of built-in functions.
    """
    if not isinstance(first, Equality) or len(first.left) != 1 or len(first.right) != 1:
        return None
    inside = [*walk(first.left[0], first.right[0])]
    if not all(map(_plain, inside)) or not _BETWEEN.fullmatch(" ".join(_LEAF.split(code)[::3])):
        return None
    called = {node.function for node in inside if isinstance(node, Call)}
    if "pi" in called and called & {"sin", "cos", "tan"}:  # values that are known exactly
        return None
    numbers = [id(node) for node in inside if isinstance(node, Number)]
    powers = [id(node.exponent) for node in inside if isinstance(node, Power)]
    exponents = tuple(numbers.index(power) for power in powers if power in numbers)
    begins, ends = ({at: k for k, at in enumerate(every)} for every in zip(*words(code, start), strict=True))

    def index(span: Span) -> Span:
        return Span(_INDICES, begins[span.start], ends[span.end])

    return Form(_sides((first.left, first.right), leaves, index), exponents)


def _plain(node: Any) -> bool:
    """Whether nothing but the form of the rule decides what is to be said of a node."""
    if not isinstance(node, Call):
        return not isinstance(node, Symbol) and getattr(node, "unit", None) is None
    row = TABLE.get(node.function)
    return row is not None and node.function not in PLANNED and row.accepts(len(node.arguments))


def _sides(sides: Any, leaves: Leaves, place: Callable[[Span], Span]) -> Sides:
    """The two sides with other leaves, in other places."""
    names, numbers = iter(leaves.names), iter(leaves.numbers)

    def made(node: Any) -> Expression:
        span = place(node.span)
        if isinstance(node, Name):
            return Name(next(names), span)
        if isinstance(node, Number):
            return Number(next(numbers), span)
        return rebuilt(node, tuple(map(made, children(node)))).but(span=span)

    (left,), (right,) = sides
    return (made(left),), (made(right),)
