"""A function while its lines are read."""

from __future__ import annotations

from dataclasses import dataclass, field

from rulesheets import nodes
from rulesheets.source import Source, Span


@dataclass(frozen=True, slots=True)
class Head:
    """The first line of a function."""

    name: str
    arguments: tuple[str, ...]
    results: tuple[str, ...]


@dataclass
class FunctionDraft:
    """What is known of a function so far; ``begun`` once its rules have begun, ``end`` where it ends."""

    head: Head
    start: int
    end: int
    comment: str
    above: tuple[nodes.CommentLine, ...]
    parameters: list[str] = field(default_factory=list)
    remarks: list[str] = field(default_factory=list)
    rules: list[nodes.Rule | nodes.CommentLine] = field(default_factory=list)
    begun: bool = False

    def node(self, source: Source) -> nodes.Function:
        return nodes.Function(
            self.head.name,
            self.head.arguments,
            self.head.results,
            tuple(self.parameters),
            tuple(self.rules),
            self.comment,
            Span(source, self.start, self.end),
            self.above,
            "; ".join(self.remarks),
        )
