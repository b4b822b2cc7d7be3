"""Rules of one shape, read as lark has read the first of them: for sheets of thousands of rules.

The rules of a network differ in names and numbers only. Where two lines have the same kinds of words in the
same order, the grammar makes the same tree of both, so that the second is the tree of the first with its own
leaves and places. Lines with anything but names, numbers, operators and parentheses go through the grammar.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple, TypeAlias

from rulesheets.parse.layout import Line
from rulesheets.syntax import nodes
from rulesheets.syntax.nodes import Call, Equality, Name, Number, children
from rulesheets.syntax.source import Source, Span

LONG = 20_000
"""Characters of a text from which on its rules are compared with one another."""

_WORDS = re.compile(
    r"(\s*)(?:((?!(?:if|then|else|call|and|or|not|pi)\b)[a-z_]\w*)|((?:\d+\.?\d*|\.\d+)(?:e[+-]?\d+)?)|([-+*/^(),=]))",
    re.ASCII | re.IGNORECASE,
)
Builder: TypeAlias = Callable[[Source, Sequence[Any], Sequence[int], Sequence[int]], Equality]


class Words(NamedTuple):
    """The words of a rule: what its tree depends on (``shape``), names and numbers as they are (other words
    None), and where each begins and ends in the text."""

    shape: tuple[str, ...]
    leaves: list[Any]
    starts: list[int]
    ends: list[int]


def words_of(line: Line) -> Words | None:
    """None where the line has other words, or a number out of range."""
    shape, leaves, starts, ends = [], list[Any](), [], []
    place = line.start
    for blank, name, number, sign in _WORDS.findall(line.code):
        place += len(blank)
        starts.append(place)
        place += len(name) or len(number) or 1
        ends.append(place)
        if name:
            shape.append("name")
            leaves.append(name)
        elif number:
            shape.append("0")
            value = float(number)
            if not 0.0 < value < float("inf") and number.strip("0."):
                return None
            leaves.append(value)
        else:
            if sign == "(" and shape and shape[-1] == "name":
                shape[-1] = leaves[-1].lower()
            shape.append(sign)
            leaves.append(None)
    return Words(tuple(shape), leaves, starts, ends) if place == line.start + len(line.code) else None


def builder(first: object, words: Words) -> Builder | None:
    """What builds the tree of another rule of that shape, told by the tree of the first."""
    if not isinstance(first, Equality):
        return None
    begins = {start: i for i, start in enumerate(words.starts)}
    stops = {end: i for i, end in enumerate(words.ends)}

    def span(node: Any) -> str:
        return f"S(source, starts[{begins[node.span.start]}], ends[{stops[node.span.end]}])"

    def built(node: Any) -> str:
        place = span(node)
        if type(node) in (Name, Number):  # perhaps in parentheses of its own
            around = range(begins[node.span.start], stops[node.span.end] + 1)
            inside = next(i for i in around if words.leaves[i] is not None)
            return f"{type(node).__name__}(leaves[{inside}], {place})"
        parts = [built(part) for part in children(node)]
        match node:
            case nodes.Sum():
                return f"Sum(({', '.join(parts)},), {place})"
            case Call(function, _):
                return f"Call({function!r}, ({''.join(f'{part}, ' for part in parts)}), {place})"
            case _:
                return f"{type(node).__name__}({', '.join(parts)}, {place})"

    sides = (f"({''.join(f'{built(node)}, ' for node in side)})" for side in (first.left, first.right))
    text = f"lambda source, leaves, starts, ends: Equality({', '.join(sides)}, {span(first)})"
    found: Builder = eval(text, {"S": Span, **vars(nodes)})  # of our own words and whole numbers
    return found
