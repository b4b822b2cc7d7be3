"""What a record starts from, and what it knows at a place of one answer's steps."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from rulesheets.model import Value
from rulesheets.syntax.nodes import Expression, Name, Symbol

CLEAR = 1e-6
"""Discriminants and divisors smaller than this, relative to their terms, are left to a full solve."""
STRANGE = 1e-6
"""A rule that is missed by more than this, relative to its terms, is broken."""


@dataclass(frozen=True)
class Pattern:
    """What is fixed before the numbers: which inputs vary, what the others are, what is wanted."""

    inputs: tuple[str, ...]
    given: Mapping[str, Value]
    want: tuple[str, ...]
    guesses: Mapping[str, float]


@dataclass
class State:
    """The nodes of the variables that are known, and what must hold for them to count.

    ``settled`` are the rules that hold by the way an unknown was computed, ``used`` the conditions that let
    in the rules that were solved, ``apart`` pairs of nodes that are required to differ. ``absorbed``: a rule
    has a number that may be so large beside its variables that floats lose them.
    """

    values: dict[str, int]
    symbols: dict[str, str]
    decided: dict[int, bool]
    settled: set[int] = field(default_factory=set)
    used: set[int] = field(default_factory=set)
    apart: set[frozenset[int]] = field(default_factory=set)
    checks: list[int] = field(default_factory=list)
    finite: list[int] = field(default_factory=list)
    absorbed: bool = False

    def fork(self) -> State:
        return replace(
            self,
            values=dict(self.values),
            symbols=dict(self.symbols),
            decided=dict(self.decided),
            settled=set(self.settled),
            used=set(self.used),
            apart=set(self.apart),
            checks=list(self.checks),
            finite=list(self.finite),
        )


def symbol_of(expression: Expression, symbols: Mapping[str, str]) -> str | None:
    """The symbol that an expression is, or that its variable has; None where it is a number."""
    match expression:
        case Symbol(name):
            return name
        case Name(name):
            return symbols.get(name)
        case _:
            return None
