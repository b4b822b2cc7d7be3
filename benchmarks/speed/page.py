"""What was measured, as Markdown: tables, and what is held to what."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from benchmarks.pages import markdown_table


@dataclass(frozen=True)
class Claim:
    """``measured`` is held to at most ``limit`` (at least, where ``more``)."""

    text: str
    limit: float
    measured: float
    unit: str = "×"
    more: bool = False

    @property
    def met(self) -> bool:
        return self.measured >= self.limit if self.more else self.measured <= self.limit

    def row(self) -> tuple[str, str, str, str]:
        sign = "≥" if self.more else "≤"
        numbers = f"{sign} {self.limit:g} {self.unit}", f"{figures(self.measured)} {self.unit}"
        return self.text, *numbers, "yes" if self.met else "**no**"


@dataclass(frozen=True)
class Section:
    """One part of the measurement: a table, remarks below it, and claims. ``bars`` go into the
    picture: title, unit, and for each contestant its name, number and kind."""

    name: str
    title: str
    head: tuple[str, ...]
    rows: Sequence[tuple[str, ...]]
    remarks: Sequence[str] = ()
    claims: Sequence[Claim] = ()
    bars: Sequence[tuple[str, str, Sequence[tuple[str, float, str]]]] = field(default=())

    def markdown(self) -> str:
        parts = [markdown_table(self.head, self.rows), *self.remarks]
        if self.claims:
            rows = [claim.row() for claim in self.claims]
            parts.append(markdown_table(("held to", "limit", "measured", "met"), rows))
        return "\n\n".join(parts)


def figures(number: float) -> str:
    """Two or three figures, without an exponent."""
    if number == 0 or number != number:
        return f"{number:g}"
    if abs(number) >= 100:
        return f"{float(f'{number:.3g}'):,.0f}"
    return f"{number:.3g}" if abs(number) >= 1 else f"{number:.2g}"
