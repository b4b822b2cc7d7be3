"""Rules of one form, made like the first of them that was read: for sheets of thousands of rules.

The rules of a network differ in names and numbers only. Where two lines are the same but for these,
the grammar makes the same tree of both: the tree of the second is that of the first with its own
leaves, and all of it stands where the rule does. Lines with anything but names, numbers, operators,
parentheses and functions go through the grammar.
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from itertools import chain
from typing import Any, NamedTuple, TypeAlias

from rulesheets.syntax import Span
from rulesheets.syntax.nodes import (
    Call,
    Equality,
    Expression,
    Name,
    Number,
    Power,
    children,
    rebuilt,
    walk,
)

LONGEST = 3_000
"""Characters of a rule that is compared: ten thousand forms of so many are remembered."""

_NUMBER = r"(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?"
_NAME = (
    r"(?!(?=[iteconapITECONAP])(?i:if|then|else|call|and|or|not|pi)\b)"
    r"[a-zA-Z_][a-zA-Z_0-9]*+(?!\w|\s*\()"
)
_LEAF = re.compile(rf"(?<![\w.])(?:({_NAME})|({_NUMBER}))")

Sides: TypeAlias = tuple[tuple[Expression, ...], tuple[Expression, ...]]


class Leaves(NamedTuple):
    """A line: the ``key`` that determines its tree, and its names and numbers in order."""

    key: str
    names: list[str]
    numbers: tuple[float, ...]


class Form:
    """The common part of rules of one form: the ``sides`` of the first, the ``called`` functions,
    and the ``exponents``: which numbers, by their order, stand as such. ``kept`` holds further
    results about them."""

    def __init__(self, sides: Sides) -> None:
        self.sides = sides
        inside = [*walk(*chain(*sides))]
        self.called = {node.function for node in inside if isinstance(node, Call)}
        numbers = [id(node) for node in inside if isinstance(node, Number)]
        powers = [id(node.exponent) for node in inside if isinstance(node, Power)]
        self.exponents = tuple(numbers.index(power) for power in powers if power in numbers)
        self.kept: dict[Any, Any] = {}

    def __reduce__(self) -> tuple[type, tuple[Any, ...]]:
        return Form, (self.sides,)


class Like(NamedTuple):
    """One of these rules: its ``names`` in order of first appearance, the ``pattern`` by which they
    repeat, and its ``numbers``."""

    form: Form
    names: tuple[str, ...]
    pattern: tuple[int, ...]
    numbers: tuple[float, ...]

    @classmethod
    def of(cls, form: Form, names: Sequence[str], numbers: tuple[float, ...]) -> Like:
        """That with these names in the order of the text."""
        places: dict[str, int] = {}
        pattern = tuple([places.setdefault(name, len(places)) for name in names])
        return Like(form, tuple(places), pattern, numbers)

    def sides(self, span: Span) -> Sides:
        """The sides of the rule in these places."""
        names = iter([self.names[k] for k in self.pattern])
        numbers = iter(self.numbers)

        def made(node: Any) -> Expression:
            if isinstance(node, Name):
                return Name(next(names), span)
            if isinstance(node, Number):
                return Number(next(numbers), span)
            whole: Expression = rebuilt(node, tuple(map(made, children(node))), span)
            return whole

        left, right = self.form.sides
        return tuple(map(made, left)), tuple(map(made, right))

    def rule(self, span: Span) -> Equality:
        """The rule, whose sides are made on first use."""
        made: Equality = Equality.__new__(Equality)
        made.span, made.like = span, self
        return made


def leaves_of(code: str) -> Leaves | None:
    """None if the line is long, or has a number out of range."""
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


def form_of(first: object, leaves: Leaves) -> Form | None:
    """The common form of rules that differ from a line only in names and numbers, from its tree.

    None for rules with arms, conditions, symbols or units, and for those whose sides are exchanged:
    the form with the leaves of the line makes another tree of them.
    """
    if not isinstance(first, Equality) or first.span is None or len(first.right) > 1:
        return None
    if len(first.left) > 1 and not isinstance(first.right[0], Call):
        return None
    form = Form((first.left, first.right))
    if "pi" in form.called and form.called & {"sin", "cos", "tan"}:  # values that are known exactly
        return None
    kinds = [type(node) for node in walk(*chain(*form.sides))]
    if (kinds.count(Name), kinds.count(Number)) != (len(leaves.names), len(leaves.numbers)):
        return None
    again = Like.of(form, leaves.names, leaves.numbers).sides(first.span)
    return form if again == form.sides else None
