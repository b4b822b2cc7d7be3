"""The paths of one model: those found before, and how to find a new one."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TypeAlias

from rulesheets.model import Model
from solver.path.build import build_path
from solver.path.graph import ModelGraph
from solver.path.steps import Path

Key: TypeAlias = tuple[frozenset[str], frozenset[tuple[int, bool]], frozenset[int], frozenset[str] | None]
"""What a path answers to: known variables, outcomes of conditions, void equations, wanted variables."""


class Planner:
    """Paths of one model, kept by the pattern that they answer to."""

    def __init__(self, model: Model) -> None:
        self.graph = ModelGraph(model)
        self._paths: dict[Key, Path] = {}

    def path(
        self,
        known: frozenset[str],
        decided: Mapping[int, bool],
        void: frozenset[int] = frozenset(),
        want: frozenset[str] | None = None,
    ) -> Path:
        """The path from the ``known`` variables, given how conditions came out.

        ``void`` equations are not solved for anything (they asked nothing, or nothing could
        satisfy them, at the values at hand); ``want`` prunes to what these names need.
        """
        key = (known, frozenset(decided.items()), void, want)
        found = self._paths.get(key)
        if found is None:
            found = build_path(self.graph, known, decided, void, want)
            self._paths[key] = found
        return found


def planner(model: Model) -> Planner:
    """The planner of a model, with every path that it has found so far."""
    found = model.__dict__.get("_planner")
    if found is None:
        found = Planner(model)
        model.__dict__["_planner"] = found
    return found
