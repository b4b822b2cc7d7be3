"""A solution path as a value: what to do in which order, before any number exists."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias


@dataclass(frozen=True, slots=True)
class Evaluate:
    """Solve one equation for one unknown by isolation; ``branches`` is how many preimages it can have."""

    equation: int
    unknown: str
    branches: int = 1


@dataclass(frozen=True, slots=True)
class Select:
    """Solve for ``unknown`` whichever of the guarded ``equations`` turns out to be active."""

    equations: tuple[int, ...]
    unknown: str
    branches: int = 1


@dataclass(frozen=True, slots=True)
class SolveBlock:
    """Solve ``equations`` simultaneously for as many ``unknowns``; ``tears`` are iterated on, the rest follows.

    ``order`` lists the explicit steps inside the block, ``residuals`` the equations that close it.
    """

    equations: tuple[int, ...]
    unknowns: tuple[str, ...]
    tears: tuple[str, ...]
    order: tuple[Evaluate, ...] = ()
    residuals: tuple[int, ...] = ()


@dataclass(frozen=True, slots=True)
class Assume:
    """Solve case by case on a condition that waits on an unknown."""

    condition: int


@dataclass(frozen=True, slots=True)
class Check:
    """Evaluate an equation all of whose variables are known: a redundant rule."""

    equation: int


Step: TypeAlias = Evaluate | Select | SolveBlock | Assume | Check


@dataclass(frozen=True, slots=True)
class Path:
    """Steps in order. ``undetermined`` are the unknowns that no step reaches."""

    steps: tuple[Step, ...]
    undetermined: tuple[str, ...] = ()
