"""Paths by the pattern of inputs."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from rulesheets.model import Model, once
from solver.path import Path
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
        key = known, frozenset(decided.items()), inactive, want, required
        if key not in self.paths:
            from solver.path.building import Building  # most paths are kept from an earlier run

            self.paths[key] = Building(self.graph, known, decided, inactive, want, required).run()
        return self.paths[key]


@once
def planner(model: Model) -> Planner:
    """The planner of a model, with every path found so far."""
    return Planner(ModelGraph(model))
