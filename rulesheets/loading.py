"""From a file or a text to a model: read, parsed, checked and expanded."""

from __future__ import annotations

import gc
import os

from rulesheets.build import build
from rulesheets.diagnosis import RuleSheetError, error
from rulesheets.model import Model
from rulesheets.reading import confined, files_read, read_source
from rulesheets.spelling import suggestion
from rulesheets.syntax.source import Source, escaped
from rulesheets.uses import gather, outside

MAIN_SHEET = "model.tk"


def load(
    path: str | os.PathLike[str],
    *,
    within: str | os.PathLike[str] | None = None,
    allow_python: bool = False,
) -> Model:
    """The model of a rule sheet file.

    ``path`` is a file, a folder that holds ``model.tk``, or the bare name of a shipped model
    (``offset_slider_crank``). For sheets of strangers ``within`` names a folder: the sheet and every file
    that it uses must lie in it, links resolved. ``allow_python`` lets the files run that the sheet names by
    ``use python``. Raises RuleSheetError where anything in it is wrong.
    """
    file = find_sheet(os.fsdecode(path))
    folder = None if within is None else os.fsdecode(within)
    if not confined(file, folder):
        raise RuleSheetError(outside(file))
    return _model(read_source(file), os.path.dirname(file), file, _model_name(file), folder, allow_python)


def loads(
    text: str,
    name: str = "<text>",
    base: str | os.PathLike[str] | None = None,
    *,
    within: str | os.PathLike[str] | None = None,
    allow_python: bool = False,
) -> Model:
    """The model of a text. Messages call it ``name``; ``use`` paths are relative to the folder ``base``.

    ``within`` confines used files to a folder, links resolved; ``allow_python`` lets files of Python run.
    Raises RuleSheetError where anything in it is wrong, TypeError for what is no text.
    """
    if not isinstance(text, str):
        raise TypeError(f"a text is needed, and this is of the type {type(text).__name__}")
    folder = os.fspath(base) if base is not None else ""
    confines = None if within is None else os.fsdecode(within)
    return _model(Source(name, text), folder, None, name, confines, allow_python)


def _model(
    source: Source, folder: str, file: str | None, name: str, within: str | None, python: bool
) -> Model:
    """The model, made while the garbage collector rests.

    A large sheet has a million nodes, which all stay: to look for garbage among them takes longer
    than to make them.
    """
    collecting = gc.isenabled()
    gc.disable()
    try:
        program = gather(source, folder, file, within, python)
        return build(program, name, files_read(file, program.texts))
    finally:
        if collecting:
            gc.enable()


def _model_name(file: str) -> str:
    """The name of the folder for ``model.tk``, else that of the file."""
    folder, base = os.path.split(os.path.abspath(file))
    return escaped(os.path.basename(folder) if base == MAIN_SHEET else os.path.splitext(base)[0])


def find_sheet(path: str) -> str:
    """The file that a path or the bare name of a shipped model stands for.

    Raises RuleSheetError (E309) for a bare name that is neither.
    """
    if os.path.isfile(path):
        return path
    if os.path.isfile(os.path.join(path, MAIN_SHEET)):
        return os.path.join(path, MAIN_SHEET)
    bare = path.rstrip("/")
    if bare in shipped_models():
        return shipped_model(bare)
    if os.path.exists(path) or os.path.dirname(bare) or bare.endswith(".tk"):
        return path
    here = sorted(name for name in os.listdir() if name.endswith(".tk"))
    raise RuleSheetError(
        error(
            "E309",
            f"there is no rule sheet and no shipped model {bare}",
            notes=suggestion(bare, (*shipped_models(), *here))
            or ("a sheet is named by its path, such as crank.tk; `backsolve models` lists the shipped ones",),
        )
    )


def find_variable_sheet(path: str, sheet: str) -> str:
    """The file of a variable sheet: the path itself, or a file of that name beside the rule sheet.

    ``sheet`` is what :func:`find_sheet` takes. Raises RuleSheetError (E310) where neither is there.
    """
    folder = os.path.dirname(find_sheet(sheet))
    beside = os.path.join(folder, path)
    found = next((file for file in (path, beside) if os.path.exists(file)), None)
    if found is not None:
        return found
    there = sorted(name for name in os.listdir(folder or ".") if name.endswith(".csv"))
    notes = suggestion(path, there) or ((f"beside {sheet} there are {', '.join(there)}",) if there else ())
    raise RuleSheetError(
        error("E310", f"there is no variable sheet {path}, neither here nor beside {sheet}", notes=notes)
    )


def shipped_models() -> tuple[str, ...]:
    """The names of the models that come with the package."""
    folder = _models_folder()
    if not os.path.isdir(folder):
        return ()
    return tuple(
        name for name in sorted(os.listdir(folder)) if os.path.isfile(os.path.join(folder, name, MAIN_SHEET))
    )


def shipped_model(name: str) -> str:
    """The file of a shipped model."""
    return os.path.join(_models_folder(), name, MAIN_SHEET)


def _models_folder() -> str:
    """``rulesheets/models`` where installed, ``models`` beside the package in a checkout."""
    package = os.path.dirname(os.path.abspath(__file__))
    installed = os.path.join(package, "models")
    return installed if os.path.isdir(installed) else os.path.join(os.path.dirname(package), "models")
