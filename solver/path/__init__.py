"""A solution path as a value: what to do in which order, before any number exists."""

from __future__ import annotations

from dataclasses import dataclass
from importlib import import_module
from typing import Any, NamedTuple, TypeAlias


class Shown:
    """What a notebook shows as HTML and as LaTeX: by the report, which stands above it and is met by name."""

    __slots__ = ()

    def _repr_html_(self) -> str:
        report: Any = import_module("solver.report.html")
        return str(report.html(self))

    def _repr_latex_(self) -> str:
        report: Any = import_module("solver.report.html")
        return str(report.latex(self))


class Evaluate(NamedTuple):
    """Solve one equation for one unknown by isolation; ``branches`` is how many preimages it can have."""

    equation: int
    unknown: str
    branches: int = 1


class Select(NamedTuple):
    """Solve for ``unknown`` whichever of the guarded ``equations`` turns out to be active."""

    equations: tuple[int, ...]
    unknown: str
    branches: int = 1


class SolveBlock(NamedTuple):
    """Solve ``equations`` simultaneously for as many ``unknowns``.

    ``tears`` are iterated on; ``order`` lists the explicit steps that follow from them and
    ``residuals`` the equations that close the block. ``others`` are tearings to try where this
    one does not settle how many answers there are.
    """

    equations: tuple[int, ...]
    unknowns: tuple[str, ...]
    tears: tuple[str, ...]
    order: tuple[Evaluate, ...] = ()
    residuals: tuple[int, ...] = ()
    others: tuple[SolveBlock, ...] = ()


class Decide(NamedTuple):
    """Evaluate conditions whose variables are known; what follows depends on how they come out."""

    conditions: tuple[int, ...]


class Assume(NamedTuple):
    """Solve case by case on a condition that waits on an unknown; an answer is kept if it fits its case."""

    condition: int

    @property
    def conditions(self) -> tuple[int, ...]:
        return (self.condition,)


class Check(NamedTuple):
    """Evaluate an equation all of whose variables are known: a redundant rule."""

    equation: int


Step: TypeAlias = Evaluate | Select | SolveBlock | Decide | Assume | Check


def equations_of(step: Step) -> tuple[int, ...]:
    """The equations that a step evaluates."""
    match step:
        case Evaluate(equation=equation) | Check(equation=equation):
            return (equation,)
        case Select(equations=equations) | SolveBlock(equations=equations):
            return equations
        case _:
            return ()


def given_by(step: Step) -> tuple[str, ...]:
    """The variables that a step finds."""
    match step:
        case Evaluate(unknown=unknown) | Select(unknown=unknown):
            return (unknown,)
        case SolveBlock(unknowns=unknowns):
            return unknowns
        case _:
            return ()


@dataclass(frozen=True, slots=True)
class Path(Shown):
    """Steps in order; a path that ends in ``Decide`` or ``Assume`` goes on once the outcome is there.

    ``undetermined`` are the unknowns that no step reaches.
    """

    steps: tuple[Step, ...]
    undetermined: tuple[str, ...] = ()

    @property
    def branches(self) -> int:
        """How many answers the direct steps can fork into."""
        product = 1
        for step in self.steps:
            if isinstance(step, Evaluate | Select):
                product *= step.branches
        return product
