"""Rules of one form, read as lark has read the first of them: for sheets of thousands of rules.

The rules of a network differ in names and numbers only. Where two lines are the same but for these, the
grammar makes the same tree of both: the tree of the second is that of the first with its own leaves and
places. Lines with anything but names, numbers, operators, parentheses and built-in functions go through the
grammar.
"""

from __future__ import annotations

import math
import re
from itertools import count
from typing import Any, NamedTuple

from rulesheets.functions import PLANNED, TABLE
from rulesheets.parse.layout import Line
from rulesheets.syntax import Source, Span
from rulesheets.syntax.forms import NUMBER, Form, Like, words
from rulesheets.syntax.nodes import Call, Equality, Name, Number, Power, Sum, Symbol, children
from rulesheets.syntax.program import walk

LONG = 20_000
"""Characters of a text from which on its rules are compared with one another."""
LONGEST = 300
"""Characters of a rule that is compared: no tree of so many is too deep for what works on trees."""

_NAME = r"(?!(?=[iteconapITECONAP])(?i:if|then|else|call|and|or|not|pi)\b)[a-zA-Z_][a-zA-Z_0-9]*+(?!\w|\s*\()"
_LEAF = re.compile(rf"(?<![\w.])(?:({_NAME})|({NUMBER}))")
_BETWEEN = re.compile(r"(?:[a-z_]\w*(?=\s*\()|pi\b|[-+*/^(),=\s])*", re.ASCII | re.IGNORECASE)


class Leaves(NamedTuple):
    """A line: what its tree depends on (``key``), its names and its numbers in the order of the text."""

    key: tuple[Any, ...]
    names: list[str]
    numbers: tuple[float, ...]


def leaves_of(line: Line) -> Leaves | None:
    """None where the line is long, or has a number out of range."""
    parts = _LEAF.split(line.code)
    names = parts[1::3]
    written = [number for number in parts[2::3] if number]
    numbers = tuple(map(float, written))
    if len(line.code) > LONGEST or math.inf in numbers:
        return None
    if any(not number and text.strip("0.") for number, text in zip(numbers, written, strict=True)):
        return None
    return Leaves((*parts[::3], *map(bool, names)), [name for name in names if name], numbers)


def rule_of(form: Form, leaves: Leaves, source: Source, line: Line) -> Equality:
    """The rule of a line that has this form."""
    names = tuple(dict.fromkeys(leaves.names))
    repeats = len(names) < len(leaves.names)
    pattern = tuple(map(names.index, leaves.names)) if repeats else ()
    start = line.start + len(line.code) - len(line.code.lstrip())
    like = Like(form, names, pattern, leaves.numbers, line.start, line.code)
    return like.rule(Span(source, start, line.end))


def form_of(first: object, line: Line) -> Form | None:
    """What rules share that differ from this line in names and numbers only, told by its tree.

    None for rules that are more than an equality of two expressions of built-in functions.
    """
    if not isinstance(first, Equality) or len(first.left) != 1 or len(first.right) != 1:
        return None
    sides = (first.left[0], first.right[0])
    inside = [node for side in sides for node in walk(side)]
    if not all(map(_plain, inside)) or not _BETWEEN.fullmatch(" ".join(_LEAF.split(line.code)[::3])):
        return None
    called = {node.function for node in inside if isinstance(node, Call)}
    if "pi" in called and called & {"sin", "cos", "tan"}:  # values that are known exactly
        return None
    left, right = map(_Writer(line).written, sides)
    numbers = [id(node) for node in inside if isinstance(node, Number)]
    powers = [id(node.exponent) for node in inside if isinstance(node, Power)]
    exponents = tuple(numbers.index(power) for power in powers if power in numbers)
    return Form(f"lambda source, places, names, numbers: (({left},), ({right},))", exponents)


def _plain(node: Any) -> bool:
    """Whether nothing but the form of the rule decides what is to be said of a node."""
    if not isinstance(node, Call):
        return not isinstance(node, Symbol) and getattr(node, "unit", None) is None
    row = TABLE.get(node.function)
    return row is not None and node.function not in PLANNED and row.accepts(len(node.arguments))


class _Writer:
    """Python that makes the nodes of a line again, of the leaves of another."""

    def __init__(self, line: Line) -> None:
        places = words(line.code, line.start)
        self.starts = {start: k for k, (start, _) in enumerate(places)}
        self.ends = {end: k for k, (_, end) in enumerate(places)}
        self.names, self.numbers = count(), count()

    def written(self, node: Any) -> str:
        span = f"S(source, places[{self.starts[node.span.start]}][0], places[{self.ends[node.span.end]}][1])"
        if isinstance(node, Name):
            return f"Name(names[{next(self.names)}], {span})"
        if isinstance(node, Number):
            return f"Number(numbers[{next(self.numbers)}], {span})"
        parts = "".join(f"{self.written(part)}, " for part in children(node))
        match node:
            case Sum():
                return f"Sum(({parts}), {span})"
            case Call(function):
                return f"Call({function!r}, ({parts}), {span})"
            case _:
                return f"{type(node).__name__}({parts}{span})"
