"""What is known of a code, wherever it is said."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Entry:
    """``title``: what is wrong, without a full stop; ``cause`` and ``fix`` are sentences."""

    title: str
    cause: str
    fix: str
