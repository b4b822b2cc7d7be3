"""Finding, reading and writing files."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager

from rulesheets.diagnosis import Diagnosis, RuleSheetError, error_at, refusal, suggestion
from rulesheets.syntax import Source, Span
from rulesheets.syntax.nodes import RuleSheet

ENDING = ".tk"
"""The ending of the name of a rule sheet."""
MAIN_SHEET = "model.tk"
"""The sheet of a folder."""

_PACKAGE = os.path.dirname(os.path.abspath(__file__))
_INSTALLED = os.path.join(_PACKAGE, "models")
_BESIDE = os.path.join(os.path.dirname(_PACKAGE), "models")
_MODELS = _INSTALLED if os.path.isdir(_INSTALLED) else _BESIDE
"""``rulesheets/models`` if installed, ``models`` next to the package in a checkout."""

_LARGEST = 64 * 2**20
"""Bytes beyond which a file is not taken for a rule sheet."""


def read_source(path: str | os.PathLike[str]) -> Source:
    """The text of a UTF-8 file (a byte order mark is dropped), line ends as ``\\n``.

    Raises RuleSheetError for a file that is missing, a folder, unreadable, too large, or not a
    text.
    """
    name = os.fspath(path)
    expect_regular(name)
    try:
        with open(name, "rb") as file:
            data = file.read(_LARGEST + 1)
    except FileNotFoundError:
        raise refusal("E301", f"there is no file {name}", None, *near_files(name)) from None
    except IsADirectoryError:
        note = "name a file in it; a folder is a sheet where it holds a model.tk"
        raise refusal("E302", f"{name} is a folder, not a file", None, note) from None
    except (OSError, ValueError) as failure:
        reason = getattr(failure, "strerror", None) or str(failure)
        raise refusal("E304", f"{name} cannot be read: {reason}") from None
    return Source(name, decoded(name, data))


def parsed(source: Source, path: str | None) -> RuleSheet:
    """The rule sheet of a text; ``path`` is its file.

    Raises RuleSheetError with the mistakes, line by line, or (E312) for a file that is not a rule
    sheet.
    """
    from rulesheets.parse.sections import parse  # with it comes lark

    try:
        return parse(source)
    except RuleSheetError:
        if path is None or is_sheet(path):
            raise
        note = f"mistakes are shown only in files that end in {ENDING}"
        raise refusal("E312", f"{source.name} is not a rule sheet", None, note) from None


def is_sheet(path: str) -> bool:
    """Whether a file has the name of a rule sheet, links resolved: others are never quoted."""
    return os.path.realpath(path).lower().endswith(ENDING)


def confined(path: str, within: str | None) -> bool:
    """Whether a file lies in the folder ``within``, links resolved; always for None."""
    if within is None:
        return True
    folder = os.path.realpath(within)
    return os.path.realpath(path).startswith(os.path.join(folder, ""))


def outside(path: str, place: Span | None = None) -> Diagnosis:
    message = f"{path} lies outside the folder that sheets are confined to"
    return error_at("E311", message, place, "links count as the files that they lead to")


def near_files(path: str) -> tuple[str, ...]:
    """The note on a missing file: its folder is missing too, or has a file with a similar name."""
    folder, name = os.path.split(path)
    if not os.path.isdir(folder or "."):
        return (f"there is no folder {folder} either",)
    ending = os.path.splitext(name)[1]
    others = (other for other in os.listdir(folder or ".") if other.endswith((ending, ".tk")))
    return suggestion(name, sorted(others))


def decoded(name: str, data: bytes) -> str:
    """The text of the bytes of a sheet. Raises RuleSheetError (E303, E305)."""
    if len(data) > _LARGEST:
        raise refusal("E305", f"{name} is too large for a rule sheet")
    nul = data.find(b"\0")
    if nul >= 0:
        raise RuleSheetError(_not_text(name, data, nul))
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as wrong:
        raise RuleSheetError(_not_text(name, data, wrong.start)) from None
    return text.replace("\r\n", "\n").replace("\r", "\n")


def _not_text(name: str, data: bytes, place: int) -> Diagnosis:
    """A diagnosis with the likely kind of the file and its first byte that is not text."""
    readable = data[:place].decode("utf-8", "replace")
    source = Source(name, readable.replace("\r\n", "\n"))
    here = Span(source, len(source.text), len(source.text) + 1)
    if b"\0" in data:
        note = "a rule sheet is a UTF-8 text file"
        return error_at("E303", f"{name} is a binary file, not a rule sheet", None, note)
    label = f"byte 0x{data[place]:02x} is not valid in UTF-8"
    note, shown = "save the sheet in the encoding UTF-8", here if is_sheet(name) else None
    return error_at("E303", f"{name} is not UTF-8 text", shown, note, label=label)


def find_sheet(path: str) -> str:
    """The file that a path or the bare name of a shipped model stands for.

    Raises RuleSheetError (E309) for a bare name that is neither.
    """
    if os.path.isfile(path):
        return path
    if os.path.isfile(os.path.join(path, MAIN_SHEET)):
        return os.path.join(path, MAIN_SHEET)
    bare = path.rstrip("/")
    shipped = shipped_model(bare)
    if os.path.basename(bare) == bare and os.path.isfile(shipped):
        return shipped
    if os.path.exists(path) or os.path.dirname(bare) or bare.endswith(".tk"):
        return path
    here = sorted(name for name in os.listdir() if name.endswith(".tk"))
    others = "`backsolve models` lists the shipped ones"
    note = f"a sheet is named by its path, such as crank.tk; {others}"
    notes = suggestion(bare, (*shipped_models(), *here)) or (note,)
    raise refusal("E309", f"there is no rule sheet and no shipped model {bare}", None, *notes)


def find_variable_sheet(path: str, sheet: str) -> str:
    """The file of a variable sheet: the path itself, or a file of that name next to the rule sheet.

    ``sheet`` is what :func:`find_sheet` takes. Raises RuleSheetError (E310) if neither exists.
    """
    folder = os.path.dirname(find_sheet(sheet))
    beside = os.path.join(folder, path)
    found = next((file for file in (path, beside) if os.path.exists(file)), None)
    if found is not None:
        return found
    there = sorted(name for name in os.listdir(folder or ".") if name.endswith(".csv"))
    notes = suggestion(path, there)
    if there and not notes:
        notes = (f"beside {sheet} there are {', '.join(there)}",)
    if "=" in path:
        notes = (f"did you mean --{'over' if ':' in path else 'set'} {path}?",)
    message = f"there is no variable sheet {path}, neither here nor beside {sheet}"
    raise refusal("E310", message, None, *notes)


def shipped_models() -> tuple[str, ...]:
    """The names of the models that come with the package."""
    there = sorted(os.listdir(_MODELS)) if os.path.isdir(_MODELS) else ()
    return tuple(name for name in there if os.path.isfile(shipped_model(name)))


def shipped_model(name: str) -> str:
    return os.path.join(_MODELS, name, MAIN_SHEET)


@contextmanager
def writing(path: str) -> Iterator[None]:
    """Raise RuleSheetError (E416) if the system fails to write the file within the context."""
    try:
        yield
    except OSError as failure:
        message = f"{path} cannot be written: {failure.strerror}"
        raise refusal("E416", message, None, "choose another place") from None


def expect_regular(name: str) -> None:
    """Raise RuleSheetError (E304) for a pipe or a device: reading it may never end."""
    if os.path.exists(name) and not (os.path.isfile(name) or os.path.isdir(name)):
        message = f"{name} cannot be read: it is a pipe or a device, not a file"
        note = "a dash in place of the sheet reads it from standard input"
        raise refusal("E304", message, None, note)
