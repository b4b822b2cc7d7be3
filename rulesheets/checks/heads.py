"""Checks of the heads of functions: each name has one role, and no built-in is defined anew."""

from __future__ import annotations

from collections.abc import Iterator

from rulesheets.checks import messages
from rulesheets.diagnosis import Diagnosis
from rulesheets.functions import PLANNED, TABLE
from rulesheets.nodes import Function


def check_head(function: Function) -> Iterator[Diagnosis]:
    if function.name.lower() in TABLE or function.name.lower() in PLANNED:
        yield messages.shadows_builtin(function)
    roles: dict[str, list[str]] = {}
    for role, names in (
        ("an argument", function.arguments),
        ("a result", function.results),
        ("a parameter", function.parameters),
    ):
        for name in names:
            roles.setdefault(name, []).append(role)
    for name, held in roles.items():
        if len(held) > 1:
            yield messages.repeated_in_head(function, name, _join(held))


def _join(held: list[str]) -> str:
    """``an argument and a result``, or ``twice an argument``."""
    distinct = list(dict.fromkeys(held))
    return " and ".join(distinct) if len(distinct) > 1 else f"twice {distinct[0]}"
