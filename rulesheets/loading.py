"""From a file or a text to a model: read, parse, check, expand."""

from __future__ import annotations

import os
from collections.abc import Mapping

from rulesheets.checks import check, check_figures
from rulesheets.declarations import declared
from rulesheets.diagnosis import RuleSheetError, error
from rulesheets.expand import Expansion, expand
from rulesheets.model import Model, Variable
from rulesheets.program import Program
from rulesheets.reading import read_source
from rulesheets.source import Source
from rulesheets.spelling import suggestion
from rulesheets.uses import gather

MAIN_SHEET = "model.tk"


def load(path: str | os.PathLike[str]) -> Model:
    """The model of a rule sheet file.

    ``path`` is a file, a folder that holds ``model.tk``, or the bare name of a shipped model
    (``offset_slider_crank``). Raises RuleSheetError where anything in it is wrong.
    """
    file = find_sheet(os.fspath(path))
    program = gather(read_source(file), os.path.dirname(file), file)
    return build(program, _model_name(file))


def loads(text: str, name: str = "<text>", base: str | os.PathLike[str] | None = None) -> Model:
    """The model of a text. Messages call it ``name``; ``use`` paths are relative to the folder ``base``."""
    folder = os.fspath(base) if base is not None else ""
    return build(gather(Source(name, text), folder), name)


def build(program: Program, name: str) -> Model:
    """Check a program and expand it. Raises RuleSheetError with every complaint found."""
    check(program)
    variables = declared(program.rows)
    expansion = expand(program)
    model = Model(
        name=name,
        variables=_variables(program, variables, expansion),
        equations=expansion.equations,
        conditions=expansion.conditions,
        figures=program.sheet.figures,
    )
    complaints = tuple(check_figures(program, model.variables))
    if complaints:
        raise RuleSheetError(*complaints)
    return model


def _variables(
    program: Program, rows: Mapping[str, Variable], expansion: Expansion
) -> Mapping[str, Variable]:
    """Rows of the sheet, then names of its rules, then locals of the calls."""
    posted = program.sheet.variables is None
    variables = dict(rows)
    for local in (False, True):
        for name in expansion.names:
            if ("." in name) is local and name not in variables:
                variables[name] = Variable(name, posted=posted and not local)
    return variables


def _model_name(file: str) -> str:
    """The name of the folder for ``model.tk``, else that of the file."""
    folder, base = os.path.split(os.path.abspath(file))
    return os.path.basename(folder) if base == MAIN_SHEET else os.path.splitext(base)[0]


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
        return os.path.join(_models_folder(), bare, MAIN_SHEET)
    if os.path.exists(path) or os.path.dirname(bare) or bare.endswith(".tk"):
        return path
    raise RuleSheetError(
        error(
            "E309",
            f"there is no rule sheet and no shipped model {bare}",
            notes=suggestion(bare, shipped_models())
            or ("a sheet is named by its path, such as crank.tk; `backsolve models` lists the shipped ones",),
        )
    )


def shipped_models() -> tuple[str, ...]:
    """The names of the models that come with the package."""
    folder = _models_folder()
    if not os.path.isdir(folder):
        return ()
    return tuple(
        name for name in sorted(os.listdir(folder)) if os.path.isfile(os.path.join(folder, name, MAIN_SHEET))
    )


def _models_folder() -> str:
    """``rulesheets/models`` where installed, ``models`` beside the package in a checkout."""
    package = os.path.dirname(os.path.abspath(__file__))
    installed = os.path.join(package, "models")
    return installed if os.path.isdir(installed) else os.path.join(os.path.dirname(package), "models")
