"""Paths by the pattern of inputs, before any number but theirs is known, and their cases."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import chain
from typing import Any, NamedTuple

from rulesheets.model import Model, Premise, Values, once
from solver.path import Assume, Check, Decide, Path, SolveBlock, equations_of, given_by
from solver.path.cases import compatible, outcomes, value_said
from solver.path.graph import ModelGraph


@dataclass(eq=False)
class Planner:
    """Paths of one model, kept by their pattern."""

    graph: ModelGraph
    paths: dict[tuple[Any, ...], Path] = field(default_factory=dict)

    def path(
        self,
        known: frozenset[str],
        decided: Mapping[int, bool],
        inactive: frozenset[int] = frozenset(),
        want: frozenset[str] | None = None,
        required: bool = False,
    ) -> Path:
        """The path from the ``known`` variables, given the outcomes of conditions.

        ``inactive`` equations are not solved for anything (they hold for any value, or for none, at
        the present values); ``want`` prunes to what these names need, and ``required`` adds
        requirements that direct steps of one value lead to.
        """
        required = required and want is not None
        key = known, frozenset(decided.items()), inactive, want, required
        if key not in self.paths:
            from solver.path.building import Building  # most paths are kept from an earlier run

            self.paths[key] = Building(self.graph, known, decided, inactive, want, required).run()
        return self.paths[key]


@once
def planner(model: Model) -> Planner:
    """The planner of a model, with every path found so far."""
    return Planner(ModelGraph(model))


def with_checks(model: Model, inputs: Values, want: Sequence[str] | None) -> Sequence[str] | None:
    """The wanted names; if one is an input that the others determine as well, also all that they
    find on the way to it, so that rules which its value contradicts are not pruned."""
    found = dict.fromkeys(want or ())
    for name in [name for name in found if name in inputs]:
        others = {n: v for n, v in inputs.items() if n != name}
        decided, wanted = outcomes(model, others, others), frozenset((name,))
        path = planner(model).path(frozenset(others), decided, want=wanted)
        if name in (names := [*chain.from_iterable(map(given_by, path.steps))]):
            found |= dict.fromkeys(names)
    return want if want is None else tuple(found)


# --- the path with its cases ---

MAX_ENDS = 8
"""The most leaves of a tree: a longer list of cases is useless."""

MAX_CONDITIONS = 4
"""Conditions of one question that are followed up: every combination of outcomes is planned."""


class Case(NamedTuple):
    """The rest of a path for given outcomes of conditions; one without influence is left out."""

    outcomes: tuple[Premise, ...]
    tree: PathTree


class PathTree(NamedTuple):
    """``path``, and the cases that follow if it ends in a question; none if there are too many."""

    path: Path
    cases: tuple[Case, ...] = ()

    @property
    def open(self) -> bool:
        """Whether the path ends in a question without cases."""
        return bool(question(self.path)) and not self.cases

    def ends(self) -> Iterator[PathTree]:
        """The leaves of the tree, this one if it has no cases."""
        if not self.cases:
            yield self
        for case in self.cases:
            yield from case.tree.ends()

    @property
    def branches(self) -> int | None:
        """The largest possible number of answers; None if a block or an open question leaves it
        open."""
        if self.open or any(isinstance(step, SolveBlock) for step in self.path.steps):
            return None
        ahead = [case.tree.branches for case in self.cases]
        known = [count for count in ahead if count is not None]
        if len(known) < len(ahead):
            return None
        assumed = bool(ahead) and isinstance(self.path.steps[-1], Assume)
        return self.path.branches * (sum(known) if assumed else max(known, default=1))


def question(path: Path) -> tuple[int, ...]:
    """The conditions that the rest of a path depends on."""
    last = path.steps[-1] if path.steps else None
    return last.conditions if isinstance(last, Decide | Assume) else ()


def path_tree(model: Model, inputs: Values, want: frozenset[str] | None = None) -> PathTree:
    """The path from ``inputs`` with its cases, down to at most :data:`MAX_ENDS` ends.

    Only the conditions that the inputs decide are evaluated; nothing is solved.
    """
    ahead = _Ahead(model, inputs, want)
    known, decided = frozenset(inputs), outcomes(model, inputs, inputs)
    found = ahead.tree(known, decided, frozenset(), 0)
    for depth in range(1, len(model.conditions) + 1):
        deeper = ahead.tree(known, decided, frozenset(), depth)
        if deeper == found or sum(1 for _ in deeper.ends()) > MAX_ENDS:
            break
        found = deeper
    return found


class _Ahead:
    """Plans again after each question; ``told`` are the equations that earlier steps have used."""

    def __init__(self, model: Model, inputs: Values, want: frozenset[str] | None) -> None:
        self.model, self.inputs, self.want = model, inputs, want

    def tree(
        self, known: frozenset[str], decided: Mapping[int, bool], told: frozenset[int], depth: int
    ) -> PathTree:
        """The path from known variables, with cases down to ``depth``."""
        path = planner(self.model).path(known, decided, want=self.want)
        steps = (
            step for step in path.steps if not (isinstance(step, Check) and step.equation in told)
        )
        path = Path(tuple(steps), path.undetermined)
        conditions = question(path)
        possible = {condition: self._outcomes(decided, condition) for condition in conditions}
        implied = {condition: found[0] for condition, found in possible.items() if len(found) == 1}
        if implied:
            return self.tree(known, {**decided, **implied}, told, depth)
        if not depth or not conditions or len(conditions) > MAX_CONDITIONS:
            return PathTree(path)
        told = told.union(*map(equations_of, path.steps))
        return PathTree(
            path,
            self._cases(
                known.union(*map(given_by, path.steps)), decided, told, conditions, depth - 1
            ),
        )

    def _cases(
        self,
        known: frozenset[str],
        decided: Mapping[int, bool],
        told: frozenset[int],
        open_: tuple[int, ...],
        depth: int,
    ) -> tuple[Case, ...]:
        """A decision tree over the open conditions, without decisions that make no difference."""
        if not open_:
            return (Case((), self.tree(known, decided, told, depth)),)
        first, rest = open_[0], open_[1:]
        said = value_said(self.model.conditions[first])
        named = {said[0]} if said and isinstance(said[1], str) else set()
        found = [
            self._cases(
                known | named if outcome else known, {**decided, first: outcome}, told, rest, depth
            )
            for outcome in self._outcomes(decided, first)
        ]
        if found[0] == found[-1]:
            return found[0]
        return tuple(
            Case((Premise(first, outcome), *case.outcomes), case.tree)
            for outcome, cases in zip((True, False), found, strict=True)
            for case in cases
        )

    def _outcomes(self, decided: Mapping[int, bool], condition: int) -> list[bool]:
        """The possible outcomes of a condition, given those of others."""
        return [
            outcome
            for outcome in (True, False)
            if compatible(
                (
                    (self.model.conditions[k], holds)
                    for k, holds in {**decided, condition: outcome}.items()
                ),
                self.inputs,
            )
        ] or [True, False]
