"""Paths kept on disk: a solve from the same inputs need not be planned again, whatever their values.

Names go by number. Nothing is kept for a model that comes from no text.
"""

from __future__ import annotations

import marshal
from collections.abc import Mapping

from rulesheets import store
from rulesheets.model import Model
from rulesheets.packing import Packing, Unpackable, Unpacking
from solver.path.steps import Path

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any, TypeAlias

    Key: TypeAlias = tuple[frozenset[str], frozenset[tuple[int, bool]], frozenset[int], frozenset[str] | None]
    """What a path answers to: known variables, outcomes of conditions, void equations, wanted variables."""

KIND = "paths"


def kept_paths(model: Model, start: Key) -> dict[Key, Path]:
    """The paths that were kept for solves that begin with this question."""
    if not model.digest:
        return {}
    names = list(model.variables)
    data = store.load(KIND, _entry_key(model, start))
    if data is None:
        return {}
    classes, entries = marshal.loads(data)
    unpacking = Unpacking(classes, names=names)
    return {_key(key, names): unpacking.unpack(path) for key, path in entries}


def keep_paths(model: Model, start: Key, paths: Mapping[Key, Path]) -> None:
    """Keep paths for :func:`kept_paths`."""
    if not model.digest:
        return
    numbers = {name: number for number, name in enumerate(model.variables)}
    packing = Packing(names=numbers)
    try:
        entries = [(_plain(key, numbers), packing.pack(path)) for key, path in paths.items()]
        data = marshal.dumps((packing.classes, entries))
    except (Unpackable, RecursionError, ValueError):
        return
    store.save(KIND, _entry_key(model, start), data)


def _entry_key(model: Model, start: Key) -> bytes:
    numbers = {name: number for number, name in enumerate(model.variables)}
    return store.digest(model.digest, marshal.dumps(_plain(start, numbers)))


def _plain(key: Key, numbers: Mapping[str, int]) -> tuple[Any, ...]:
    known, decided, void, want = key
    wanted = None if want is None else sorted(map(numbers.__getitem__, want))
    return sorted(map(numbers.__getitem__, known)), sorted(decided), sorted(void), wanted


def _key(plain: tuple[Any, ...], names: list[str]) -> Key:
    known, decided, void, want = plain
    wanted = None if want is None else frozenset(map(names.__getitem__, want))
    return frozenset(map(names.__getitem__, known)), frozenset(decided), frozenset(void), wanted
