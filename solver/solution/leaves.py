"""What following a path leads to: branches on the way, leaves at their ends."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

from rulesheets.deadline import TimeIsUp
from rulesheets.model import Model, Value
from rulesheets.syntax import nodes
from solver.facts import Conflict, DoubleRoot, Fact, Gap, NoRoot, NoValue, OutOfRange
from solver.path.cases import EQUAL, activity

if TYPE_CHECKING:
    from typing import Any, TypeAlias

    from solver.accuracy.forward_error import ForwardErrors
    from solver.attempts import Attempt
    from solver.kernel.outcome import BlockOutcome
    from solver.path.cases import Pair
    from solver.path.steps import SolveBlock, Step


@dataclass
class Branch:
    """What is known along one way through the path.

    ``precise`` are values to more digits than floats have, where they were computed so.
    """

    values: dict[str, Value]
    decided: dict[int, bool]
    assumed: dict[int, bool] = field(default_factory=dict)
    signs: dict[Pair, int] = field(default_factory=dict)
    void: dict[int, Fact] = field(default_factory=dict)
    steps: list[Step] = field(default_factory=list)
    settled: set[int] = field(default_factory=set)
    blank: set[str] = field(default_factory=set)
    origins: dict[str, Step] = field(default_factory=dict)
    facts: tuple[Fact, ...] = ()
    attempts: dict[SolveBlock, tuple[Attempt, ...]] = field(default_factory=dict)
    precise: dict[str, Any] = field(default_factory=dict)

    @property
    def conditions(self) -> dict[int, bool]:
        """How each condition came out, or is assumed to."""
        return {**self.decided, **self.assumed}

    def fork(self) -> Branch:
        return replace(
            self,
            values=dict(self.values),
            decided=dict(self.decided),
            assumed=dict(self.assumed),
            signs=dict(self.signs),
            void=dict(self.void),
            steps=list(self.steps),
            settled=set(self.settled),
            blank=set(self.blank),
            origins=dict(self.origins),
            attempts=dict(self.attempts),
            precise=dict(self.precise),
        )


@dataclass(frozen=True)
class Leaf:
    """The end of a branch: all that could be computed along it, checked.

    ``conflicts`` are rules that do not hold there; ``missing`` the wanted names without a value.
    ``worst`` is the largest scaled residual of the ``checked`` rules. ``loose``: nothing contradicts
    the cases that follow, and nothing determines them.
    """

    branch: Branch
    missing: tuple[str, ...]
    conflicts: tuple[Fact, ...]
    worst: float
    checked: int

    loose: bool = False

    @property
    def solved(self) -> bool:
        return not self.missing and not self.conflicts

    @property
    def on_edge(self) -> bool:
        """Whether an equality between unknowns was assumed on the way."""
        return EQUAL in self.branch.signs.values()


def leaf_errors(model: Model, leaf: Leaf) -> ForwardErrors:
    """The error bars of the values of a leaf: of those known to more digits, what rounding them has cost."""
    from solver.accuracy.forward_error import ForwardErrors, forward_errors

    branch = leaf.branch
    decided = branch.conditions
    doubles = [fact for fact in branch.facts if isinstance(fact, DoubleRoot)]
    found = forward_errors(model, branch.values, branch.steps, lambda e: activity(e, decided), doubles)
    if not branch.precise or doubles:
        return found
    rounded = {name: _rounding(branch.values[name], exact) for name, exact in branch.precise.items()}
    return ForwardErrors({**found.error, **rounded}, found.blocks, found.cancelled)


def _rounding(value: Value, exact: Any) -> float:
    """The distance of a float from the exact value, rounded up."""
    distance = 0.0 if isinstance(value, str) else float(abs(exact - value))
    return math.nextafter(distance, math.inf) if distance else 0.0


def infinite(model: Model, branch: Branch, name: str) -> bool:
    """Whether a variable that calls only pass on to one another has no value because it is infinite there."""
    blank = model.variables[name].passed and name not in branch.values
    return blank and any(
        isinstance(fact, NoValue) and fact.pole and fact.unknown == name for fact in branch.void.values()
    )


def blocked(leaf: Leaf) -> bool:
    """Whether something stands in the way of a leaf's missing values, other than freedom."""
    return any(
        isinstance(fact, Conflict | NoRoot | OutOfRange) or (isinstance(fact, NoValue) and not fact.pole)
        for fact in leaf.branch.void.values()
    )


def excluded(leaf: Leaf) -> bool:
    """Whether it is proven that no value fits a case that the leaf assumes: nothing is hidden there."""
    asked = {name for pair in leaf.branch.signs for side in pair for name in nodes.names(side)}

    return any(
        isinstance(fact, Conflict) or not asked.isdisjoint(without_value(fact)[1])
        for fact in leaf.branch.void.values()
    )


def without_value(fact: Fact) -> tuple[tuple[int, ...], tuple[str, ...]]:
    """The equations that a fact says no value satisfies, and the unknowns of which they ask it, proven."""
    match fact:
        case NoValue(equation=equation, unknown=unknown, pole=False):
            return (equation,), (unknown,)
        case OutOfRange(equation=equation, unknown=unknown):
            return (equation,), (unknown,)
        case NoRoot(equations=equations, unknowns=unknowns, proven=True):
            return equations, unknowns
        case _:
            return (), ()


Outcomes: TypeAlias = "dict[tuple[SolveBlock, tuple[Value, ...]], BlockOutcome]"
"""What a block came to at the values that it was met at."""


@dataclass(frozen=True)
class Exploration:
    """Every leaf that was reached, in order of preference, and whether they are known to be all.

    ``dead`` leaves contradict a rule; ``adrift`` are cases that nothing contradicts, but that leave
    undetermined what they were assumed on. ``delicate``: somewhere two roots, or an edge, lay closer than
    floats can tell; ``outcomes`` are what the blocks came to;
    ``work`` is what it took, counted (see ``kernel/budget.py``); ``gaps`` are why they may not be all.
    """

    leaves: tuple[Leaf, ...]
    complete: bool
    dead: tuple[Leaf, ...]
    adrift: tuple[Leaf, ...] = ()
    delicate: bool = False
    outcomes: Outcomes = field(default_factory=dict, repr=False, compare=False)
    work: int = 0
    gaps: tuple[Gap, ...] = ()


class CutOff(TimeIsUp):
    """The limit in time was met: what was ``found`` until then, and the values ``known`` before any fork."""

    def __init__(self, found: Exploration, known: Mapping[str, Value]) -> None:
        super().__init__()
        self.found, self.known = replace(found, complete=False), dict(known)
