"""An option of the command line as a place that a diagnosis can point at."""

from __future__ import annotations

from dataclasses import dataclass

from rulesheets.diagnosis import Diagnosis, Label, error
from rulesheets.source import Source, Span


@dataclass(frozen=True)
class Option:
    """One option as the user wrote it: ``text`` is what stands after ``--name``."""

    name: str
    text: str

    @property
    def source(self) -> Source:
        return Source("command line", f"--{self.name} {self.text}")

    def place(self, part: str) -> Span:
        """The place of a part of the text, the last where there are several."""
        start = len(self.name) + 3 + max(self.text.rfind(part), 0)
        return Span(self.source, start, start + max(len(part), 1))

    def repeated(self, name: str) -> Diagnosis:
        start = len(self.name) + 3 + self.text.find(name)
        return error(
            "E421",
            f"{name} is given twice",
            Label(Span(self.source, start, start + len(name)), "again"),
            notes=("keep one of the options",),
        )
