"""The paths of one model: those found before, in this process or another, and the way to a new one."""

from __future__ import annotations

from collections.abc import Mapping

from rulesheets.model import Model
from solver.path.graph import ModelGraph
from solver.path.kept import keep_paths, kept_paths
from solver.path.steps import Path

TYPE_CHECKING = False
if TYPE_CHECKING:
    from solver.path.kept import Key

MAX_KEPT = 64
"""Paths of one start that are kept on disk; what meets more cases than that plans them anew."""


class Planner:
    """Paths of one model, kept by the pattern that they answer to."""

    def __init__(self, model: Model) -> None:
        self.graph = ModelGraph(model)
        self._paths: dict[Key, Path] = {}
        self._recalled: dict[Key, set[Key]] = {}
        self._start: Key = (frozenset(), frozenset(), frozenset(), None)
        self._asked: set[Key] | None = None

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
        asked = self._asked
        if asked is not None:
            asked.add(key)
        return found

    def recall(self, known: frozenset[str], want: frozenset[str] | None) -> None:
        """Look up the paths kept for solves from these inputs, and note those asked for from here on."""
        start: Key = (known, frozenset(), frozenset(), want)
        if start not in self._recalled:
            kept = kept_paths(self.graph.model, start)
            self._paths.update(kept)
            self._recalled[start] = set(kept)
        self._start, self._asked = start, set()

    def keep(self) -> None:
        """Keep the paths asked for since :meth:`recall` on disk, for solves from the same inputs."""
        asked, self._asked = self._asked, None
        if not asked:
            return
        before = self._recalled[self._start]
        if not asked <= before and len(before | asked) <= MAX_KEPT:
            self._recalled[self._start] = before | asked
            keep_paths(self.graph.model, self._start, {key: self._paths[key] for key in before | asked})


def planner(model: Model) -> Planner:
    """The planner of a model, with every path that it has found so far."""
    found = model.__dict__.get("_planner")
    if found is None:
        found = Planner(model)
        model.__dict__["_planner"] = found
    return found
