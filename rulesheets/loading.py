"""Models: read from files and texts, and kept on disk.

A file that the same code has read before, with the same used files, is neither parsed nor checked
again. Neither the grammar nor lark is then imported, which saves a third of the start of a command.
"""

from __future__ import annotations

import gc
import os
import pickle
import sys
from contextlib import suppress
from functools import cache
from importlib.machinery import PathFinder

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
        return model
    finally:
        if collecting:
            gc.enable()


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
