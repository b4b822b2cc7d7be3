"""A file → its text."""

from __future__ import annotations

import os
from collections.abc import Iterable

from rulesheets.diagnosis import Diagnosis, Label, RuleSheetError, error
from rulesheets.spelling import suggestion
from rulesheets.syntax.source import Source, Span

ENDING = ".tk"
"""What the name of a rule sheet ends in."""

_LARGEST = 64 * 2**20
"""Bytes beyond which a file is not taken for a rule sheet."""


def read_source(path: str | os.PathLike[str]) -> Source:
    """The text of a UTF-8 file (a byte order mark is dropped), line ends as ``\\n``.

    Raises RuleSheetError for a file that is missing, a folder, unreadable, too large, or no text.
    """
    name = os.fspath(path)
    expect_regular(name)
    try:
        with open(name, "rb") as file:
            data = file.read(_LARGEST + 1)
    except FileNotFoundError:
        raise RuleSheetError(error("E301", f"there is no file {name}", notes=near_files(name))) from None
    except IsADirectoryError:
        notes = ("name a file in it; a folder is a sheet where it holds a model.tk",)
        raise RuleSheetError(error("E302", f"{name} is a folder, not a file", notes=notes)) from None
    except (OSError, ValueError) as failure:
        reason = getattr(failure, "strerror", None) or str(failure)
        raise RuleSheetError(error("E304", f"{name} cannot be read: {reason}")) from None
    return Source(name, decoded(name, data))


def is_sheet(path: str) -> bool:
    """Whether a file has the name of a rule sheet, links resolved: of no other is a line ever shown."""
    return os.path.realpath(path).lower().endswith(ENDING)


def confined(path: str, within: str | None) -> bool:
    """Whether a file lies in the folder ``within``, links resolved. None is the whole file system."""
    if within is None:
        return True
    folder = os.path.realpath(within)
    return os.path.realpath(path).startswith(os.path.join(folder, ""))


def files_read(file: str | None, used: Iterable[Source]) -> tuple[str, ...]:
    """The paths of a sheet (None: a text in no file) and of the files that it uses."""
    paths = (*filter(None, [file]), *(source.name for source in used))
    return tuple(map(os.path.abspath, paths))


def near_files(path: str) -> tuple[str, ...]:
    """The note on a file that is not there: its folder is not either, or holds one that is spelt alike."""
    folder, name = os.path.split(path)
    if not os.path.isdir(folder or "."):
        return (f"there is no folder {folder} either",)
    ending = os.path.splitext(name)[1]
    return suggestion(name, sorted(other for other in os.listdir(folder or ".") if other.endswith(ending)))


def expect_regular(name: str) -> None:
    """Raise RuleSheetError (E304) for a pipe or a device: reading it may never end."""
    if os.path.exists(name) and not (os.path.isfile(name) or os.path.isdir(name)):
        notes = ("a dash in place of the sheet reads it from standard input",)
        raise RuleSheetError(
            error("E304", f"{name} cannot be read: it is a pipe or a device, not a file", notes=notes)
        )


def decoded(name: str, data: bytes) -> str:
    """The text of the bytes of a sheet. Raises RuleSheetError (E303, E305)."""
    if len(data) > _LARGEST:
        raise RuleSheetError(error("E305", f"{name} is too large for a rule sheet"))
    nul = data.find(b"\0")
    if nul >= 0:
        raise RuleSheetError(_not_text(name, data, nul))
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as wrong:
        raise RuleSheetError(_not_text(name, data, wrong.start)) from None
    return text.replace("\r\n", "\n").replace("\r", "\n")


def _not_text(name: str, data: bytes, place: int) -> Diagnosis:
    """Says what the file seems to be, and where the first byte stands that is no text."""
    readable = data[:place].decode("utf-8", "replace")
    source = Source(name, readable.replace("\r\n", "\n"))
    here = Span(source, len(source.text), len(source.text) + 1)
    if b"\0" in data:
        return error(
            "E303",
            f"{name} is a binary file, not a rule sheet",
            notes=("a rule sheet is a UTF-8 text file",),
        )
    return error(
        "E303",
        f"{name} is not UTF-8 text",
        *([Label(here, f"byte 0x{data[place]:02x} is no character")] if is_sheet(name) else []),
        notes=("save the sheet in the encoding UTF-8",),
    )
