"""A figure while its lines are read."""

from __future__ import annotations

from dataclasses import dataclass, field

from rulesheets import nodes
from rulesheets.source import Source, Span


@dataclass
class FigureDraft:
    """What is known of a figure so far; ``end`` is where it ends."""

    name: str
    unit: str | None
    start: int
    end: int
    comment: str
    above: tuple[nodes.CommentLine, ...]
    marks: list[nodes.Mark | nodes.CommentLine] = field(default_factory=list)

    def node(self, source: Source) -> nodes.Figure:
        span = Span(source, self.start, self.end)
        return nodes.Figure(self.name, self.unit, tuple(self.marks), self.comment, span, self.above)
