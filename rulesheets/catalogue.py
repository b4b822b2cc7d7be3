"""The catalogue of diagnoses: every code with its title, its usual cause and its cure.

E1 syntax, E2 names and calls, E3 files, E4 variable sheets, command input and units, W6 warnings about units,
S5 outcomes of a solve. The table itself is ``catalogue.toml``.
"""

from __future__ import annotations

import tomllib
from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True, slots=True)
class Entry:
    """``title``: what is wrong, without a full stop; ``cause`` and ``fix`` are sentences."""

    title: str
    cause: str
    fix: str


_TABLE = tomllib.loads(Path(__file__).with_suffix(".toml").read_text(encoding="utf-8"))

CATALOGUE: dict[str, Entry] = {code: Entry(**row) for code, row in _TABLE.items()}
"""What is known of a code, wherever it is said."""
