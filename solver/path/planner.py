"""The paths of one model: those found before, and the way to a new one."""

from __future__ import annotations

from collections.abc import Mapping

from rulesheets.model import Model
from solver.path.graph import ModelGraph
from solver.path.steps import Path


class Planner:
    """Paths of one model, kept by the pattern that they answer to."""

    def __init__(self, model: Model) -> None:
        self.graph = ModelGraph(model)
        self._paths: dict[object, Path] = {}

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
            from solver.path.build import build_path

            found = build_path(self.graph, known, decided, void, want)
            self._paths[key] = found
        return found
