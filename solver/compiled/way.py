"""What a translation starts from, and what it knows along one way through the forks of a path."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

from rulesheets.nodes import Expression, Name, Symbol

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rulesheets.model import Value

CLEAR = 1e-6
"""Discriminants and divisors smaller than this, relative to their terms, are left to the step-by-step way."""
STRANGE = 1e-6
"""A root that came out negative by more than this, relative to its terms, belongs to no answer."""


@dataclass(frozen=True)
class Pattern:
    """What is fixed before the numbers: which inputs vary, what the others are, what is wanted."""

    inputs: tuple[str, ...]
    given: Mapping[str, Value]
    want: tuple[str, ...]
    guesses: Mapping[str, float]
    pruned: tuple[str, ...] | None = ()
    """The names that the path is pruned to where it is not to ``want``; None: a path to all there is."""
    clear: float = CLEAR


@dataclass
class Way:
    """What is known along one way through the forks."""

    values: dict[str, int]
    symbols: dict[str, str]
    decided: dict[int, bool]
    settled: set[int] = field(default_factory=set)
    apart: set[frozenset[int]] = field(default_factory=set)
    """Pairs of numbers that are required to differ."""
    chosen: list[int] = field(default_factory=list)
    checks: list[int] = field(default_factory=list)
    finite: list[int] = field(default_factory=list)
    undone: list[int] = field(default_factory=list)
    """Products and quotients that make a rule hold if no digit of them is lost."""
    order: list[int] = field(default_factory=list)
    gone: int = 1
    drowned: bool = False
    """Whether a rule has a number that may drown its variables: then results must be known to some digits."""

    def fork(self) -> Way:
        return replace(
            self,
            values=dict(self.values),
            symbols=dict(self.symbols),
            decided=dict(self.decided),
            settled=set(self.settled),
            apart=set(self.apart),
            chosen=list(self.chosen),
            checks=list(self.checks),
            finite=list(self.finite),
            undone=list(self.undone),
            order=list(self.order),
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
