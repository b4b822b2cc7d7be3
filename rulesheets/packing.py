"""Records as plain values that ``marshal`` writes and reads fast, and back.

A record becomes a tuple of the number of its class and its fields, a tuple a list, a mapping a pair of
lists; numbers, texts and None stay. Names and places, most of what there is, go by number. Reading
builds records of this program and nothing else: an entry on disk can name no code to run.
"""

from __future__ import annotations

from importlib import import_module

from rulesheets.nodes import Name
from rulesheets.source import Source, Span

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence
    from typing import Any

_SPAN, _MAPPING, _NAME, _FIRST = range(4)
_ANY, _ALL_PLAIN, _PLAIN_THEN_PLACE = range(3)
"""Shapes of a record, told with its class: what needs no look at every field is told apart, for speed."""
_SHAPES = 3
_PLAIN = frozenset({int, float, str, bytes, bool, type(None)})


class Unpackable(Exception):
    """A value holds what is no record of this program."""


class Packing:
    """Packs values; ``classes`` fills with the records met.

    ``sources`` are those that places may lie in, ``names`` the names that variables may have.
    """

    def __init__(self, sources: Sequence[Source] = (), names: Iterable[str] = ()) -> None:
        self.classes: list[str] = []
        self._numbers: dict[type, int] = {}
        self._sources = {id(source): number for number, source in enumerate(sources)}
        self._names = {name: number for number, name in enumerate(names)}

    def pack(self, value: Any) -> Any:
        """Raises Unpackable, and RecursionError for what is nested too deeply."""
        kind = type(value)
        if kind in _PLAIN:
            return value
        if kind is Span:
            return _SPAN, self._source(value.source), value.start, value.end
        if kind is Name and value.span is not None and value.name in self._names:
            span = value.span
            return _NAME, self._names[value.name], self._source(span.source), span.start, span.end
        if kind is tuple:
            return list(map(self.pack, value))
        if kind is dict:
            return _MAPPING, list(map(self.pack, value)), list(map(self.pack, value.values()))
        number = self._numbers.get(kind) or self._number(kind)
        fields = [getattr(value, name) for name in kind.__match_args__]
        kinds = set(map(type, fields[:-1]))
        last = fields[-1] if fields else None
        if kinds <= _PLAIN and type(last) in _PLAIN:
            return (number + _ALL_PLAIN, *fields)
        if kinds <= _PLAIN and type(last) is Span:
            return (number + _PLAIN_THEN_PLACE, *fields[:-1], self._source(last.source), last.start, last.end)
        return (number, *[self.pack(field) for field in fields])

    def number_of(self, name: str) -> int:
        return self._names[name]

    def _source(self, source: Source) -> int:
        number = self._sources.get(id(source))
        if number is None:
            raise Unpackable(source.name)
        return number

    def _number(self, kind: Any) -> int:
        if not hasattr(kind, "__record__"):
            raise Unpackable(kind.__qualname__)
        self.classes.append(f"{kind.__module__}:{kind.__qualname__}")
        number = self._numbers[kind] = _FIRST + _SHAPES * (len(self.classes) - 1)
        return number


class Unpacking:
    """Unpacks what a :class:`Packing` of the same sources and names has packed with these ``classes``."""

    def __init__(
        self, classes: Sequence[str], sources: Sequence[Source] = (), names: Sequence[str] = ()
    ) -> None:
        self._classes = [_record(name) for name in classes for _ in range(_SHAPES)]
        self._sources = sources
        self._names = names

    def unpack(self, packed: Any) -> Any:
        kind = type(packed)
        if kind is tuple:
            number = packed[0]
            if number == _NAME:
                _, name, source, start, end = packed
                return Name(self._names[name], Span(self._sources[source], start, end))
            if number == _SPAN:
                return Span(self._sources[packed[1]], packed[2], packed[3])
            if number == _MAPPING:
                return dict(zip(map(self.unpack, packed[1]), map(self.unpack, packed[2]), strict=True))
            cls = self._classes[number - _FIRST]
            shape = (number - _FIRST) % _SHAPES
            if shape == _ALL_PLAIN:
                return cls(*packed[1:])
            if shape == _PLAIN_THEN_PLACE:
                return cls(*packed[1:-3], Span(self._sources[packed[-3]], packed[-2], packed[-1]))
            return cls(*map(self.unpack, packed[1:]))
        if kind is list:
            return tuple(map(self.unpack, packed))
        return packed


def _record(name: str) -> Any:
    """The record class of that name. Raises Unpackable for any other name."""
    module, _, qualified = name.partition(":")
    found = None
    if module.partition(".")[0] in ("rulesheets", "solver"):
        found = getattr(import_module(module), qualified, None)
    if not hasattr(found, "__record__"):
        raise Unpackable(name)
    return found
