"""Models: read from files and texts, and kept on disk.

A file that the same code has read before, with the same used files, is neither parsed nor checked
again. Neither the grammar nor lark is then imported, which saves a fifth of the start of a command.
Results about a kept model that do not depend on numbers can be kept, too.
"""

from __future__ import annotations

import gc
import marshal
import os
import pickle
import sys
from collections.abc import Callable
from contextlib import suppress
from functools import cache
from importlib.machinery import PathFinder
from io import BytesIO
from types import FunctionType
from typing import Any

from rulesheets.diagnosis import RuleSheetError
from rulesheets.files import MAIN_SHEET, confined, find_sheet, outside, read_source
from rulesheets.functions import TABLE
from rulesheets.model import Model
from rulesheets.store import load as look_up
from rulesheets.store import save
from rulesheets.syntax import Source, escaped

LONGEST_KEPT = 2**20
"""Characters of a text beyond which its model is made every time."""

_CODE = os.path.dirname(os.path.abspath(__file__))
_ENDINGS = (".py", ".lark", ".toml", ".txt")


def load(
    path: str | os.PathLike[str],
    *,
    within: str | os.PathLike[str] | None = None,
    allow_python: bool = False,
) -> Model:
    """The model of a rule sheet file.

    ``path`` is a file, a folder that holds ``model.tk``, or the bare name of a shipped model
    (``offset_slider_crank``). For sheets that you do not trust ``within`` names a folder: the sheet
    and every file that it uses must lie in it, links resolved. ``allow_python`` lets the Python
    files run that the sheet names by ``use python``. Raises RuleSheetError with all mistakes.
    """
    file = find_sheet(os.fsdecode(path))
    folder = None if within is None else os.fsdecode(within)
    if not confined(file, folder):
        raise RuleSheetError(outside(file))
    parent, base = os.path.split(os.path.abspath(file))
    name = escaped(os.path.basename(parent) if base == MAIN_SHEET else os.path.splitext(base)[0])
    return _model(read_source(file), os.path.dirname(file), file, name, folder, allow_python)


def loads(
    text: str,
    name: str = "<text>",
    base: str | os.PathLike[str] | None = None,
    *,
    within: str | os.PathLike[str] | None = None,
    allow_python: bool = False,
) -> Model:
    """The model of a text, called ``name`` in messages; ``use`` paths begin at ``base``.

    ``within`` confines used files to a folder, links resolved; ``allow_python`` lets Python files
    run. Raises RuleSheetError with all mistakes, TypeError for an argument that is not a text.
    """
    if not isinstance(text, str):
        raise TypeError(f"a text is needed, and this is of the type {type(text).__name__}")
    folder = os.fspath(base) if base is not None else ""
    confines = None if within is None else os.fsdecode(within)
    return _model(Source(name, text), folder, None, name, confines, allow_python)


def _model(
    source: Source, folder: str, file: str | None, name: str, within: str | None, python: bool
) -> Model:
    """The model, from the cache or built.

    Garbage collection is off: a large sheet has a million nodes, which all stay in use, and
    searching them for garbage takes longer than making them.
    """
    # registered functions affect a sheet, but are not a part of it
    own = next(reversed(TABLE.values())).source is not None
    keeps = file is not None and not own and len(source.text) <= LONGEST_KEPT
    # by the first, messages call it
    paths = (file, os.path.abspath(file)) if file is not None else ()
    key = stamp(_CODE) + repr((paths, name)).encode() + source.text.encode() if keeps else b""
    collecting = gc.isenabled()
    gc.disable()
    try:
        kept = look_up("model", key) if keeps else None
        if kept is not None:
            found: tuple[Model, list[Source], dict[str, str]] = pickle.loads(kept)
            if _current(*found[1:], within):
                found[0].__dict__["_key"] = key, found[1]
                return found[0]
        from rulesheets.build import build, gather  # with them comes lark

        program = gather(source, folder, file, within, python)
        files = (*paths[1:], *(os.path.abspath(used.name) for used in program.texts))
        model = build(program, name, files)
        if keeps and not program.python:
            with suppress(RecursionError):  # a product of hundreds of factors
                _ = model.unit_warnings  # which commands ask for
                made = model, program.texts, program.links
                save("model", key, pickle.dumps(made, pickle.HIGHEST_PROTOCOL))
                model.__dict__["_key"] = key, program.texts
        return model
    finally:
        if collecting:
            gc.enable()


class _Pickler(pickle.Pickler):
    """Pickles the place of a rule instead of the rule, and the source of a compiled function."""

    def __init__(self, file: BytesIO, model: Model) -> None:
        super().__init__(file, pickle.HIGHEST_PROTOCOL)
        self.places = {id(part): place for place, part in enumerate((model, *model.equations))}

    def persistent_id(self, part: Any) -> int | None:
        return self.places.get(id(part))

    def reducer_override(self, part: Any) -> Any:
        again = getattr(part, "again", None) if isinstance(part, FunctionType) else None
        return NotImplemented if again is None else (again, (marshal.dumps(part.__code__),))


class _Unpickler(pickle.Unpickler):
    def __init__(self, data: bytes, model: Model) -> None:
        super().__init__(BytesIO(data))
        self.parts = model, *model.equations

    def persistent_load(self, place: Any) -> Any:
        return self.parts[place]


def _question(model: Model, question: str) -> bytes:
    """The cache key of the results about a model; empty for one that is not kept."""
    key: bytes
    key, texts = model.__dict__.get("_key", (b"", ()))
    return key and key + repr((question, [(text.name, text.text) for text in texts])).encode()


def recall(model: Model, question: str) -> None:
    """Attach to a model the cached results for the same question."""
    if (key := _question(model, question)) and (kept := look_up("found", key)):
        model.__dict__.update(_Unpickler(kept, model).load())


def keep(model: Model, question: str, *once: Callable[[Model], object]) -> None:
    """Keep the ``once`` results of these functions for a model, if all can be pickled."""
    if key := _question(model, question):
        file, found = BytesIO(), {function.__name__: function(model) for function in once}
        with suppress(AttributeError, TypeError, RecursionError, pickle.PicklingError):
            _Pickler(file, model).dump(found)
            save("found", key, file.getvalue())


@cache
def stamp(code: str) -> bytes:
    """Identifies the code in a folder, and the units of pint, among all that make models."""
    folders = [code, *(entry.path for entry in os.scandir(code) if entry.is_dir())]
    entries = (entry for folder in folders for entry in os.scandir(folder))
    files = (entry for entry in entries if entry.name.endswith(_ENDINGS))
    found = sorted((file.path, file.stat().st_mtime_ns, file.stat().st_size) for file in files)
    pint = PathFinder.find_spec("pint")
    about = pint and pint.origin and (pint.origin, os.stat(pint.origin).st_mtime_ns)
    return repr((sys.version, found, about)).encode()


def _current(texts: list[Source], links: dict[str, str], within: str | None) -> bool:
    """Whether the files of a model, and the links to them, are unchanged."""
    if not all(
        os.path.realpath(path) == end and confined(path, within) for path, end in links.items()
    ):
        return False
    with suppress(RuleSheetError):
        return all(read_source(text.name) == text for text in texts)
    return False
