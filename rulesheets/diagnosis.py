"""Diagnoses: what is wrong, where, and what to do about it."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

from rulesheets.source import Span


class Severity(Enum):
    ERROR = "error"
    WARNING = "warning"
    NOTE = "note"

    def __str__(self) -> str:
        return self.value


@dataclass(frozen=True, slots=True)
class Label:
    """A place with a word on why it is shown. The first label of a diagnosis is the primary one."""

    span: Span
    text: str = ""


@dataclass(frozen=True, slots=True)
class Diagnosis:
    """One complaint.

    ``code`` is a row of the catalogue (``E101`` …); ``notes`` are whole sentences, the
    suggestion first; ``variables`` are full names.
    """

    code: str
    severity: Severity
    message: str
    labels: tuple[Label, ...] = ()
    notes: tuple[str, ...] = ()
    variables: tuple[str, ...] = ()


class RuleSheetError(Exception):
    """A sheet, a variable sheet or a command that is wrong. ``diagnoses`` has at least one error."""

    def __init__(self, *diagnoses: Diagnosis) -> None:
        super().__init__("\n".join(diagnosis.message for diagnosis in diagnoses))
        self.diagnoses = diagnoses
