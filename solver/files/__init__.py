"""Columns of numbers and symbols on disk: written completely or not at all, read in pieces.

This module has output files, and messages about files of rows.
"""

from __future__ import annotations

import csv
import os
import stat
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, suppress
from importlib.util import find_spec
from io import StringIO
from typing import BinaryIO, TextIO

from rulesheets.diagnosis import Diagnosis, error, error_at, refusal
from rulesheets.files import expect_regular, writing
from rulesheets.syntax import Source, Span

with suppress(ImportError):  # a system without refuses to remove open files by itself
    import fcntl


@contextmanager
def readable_rows(path: str) -> Iterator[None]:
    """Raise RuleSheetError (E304, E440) if the file cannot be read within the context."""
    expect_regular(path)
    try:
        yield
    except (OSError, ValueError, csv.Error) as failure:
        reason = getattr(failure, "strerror", None) or str(failure)
        note = "rows come from a CSV file with a heading of names, or from a Parquet file"
        raise refusal("E440", f"{path} cannot be read as rows: {reason}", None, note) from None


def wrong_cell(path: str, line: int, text: str, name: str, *, number: bool = False) -> Diagnosis:
    kinds = "a number" if number else "a number, a symbol ('open)"
    place = Span(Source(f"{path}, line {line}", text), 0, len(text))
    note = f"a cell is {kinds}, or blank where the row has no value"
    message = f"line {line} of {path}: this is not a valid value for {name}"
    return error_at("E440", message, place, note)


def require_extra(extra: str, purpose: str, *packages: str, code: str = "E441") -> None:
    """Raise RuleSheetError if a package of an extra is not installed."""
    if any(find_spec(package) is None for package in packages):
        cure = f"pip install 'backsolve[{extra}]'"
        raise refusal(code, f"{purpose} {packages[0]}, which is not installed", None, cure)


def other_sweep(path: str, reason: str) -> Diagnosis:
    again = "give the options that it was written with, or another file"
    notes = (again, "without --resume it is replaced")
    return error("E448", f"{path} is not the beginning of this sweep: {reason}", notes=notes)


def csv_text(rows: Iterable[Iterable[object]]) -> str:
    """Lines of CSV: numbers with all digits, None as an empty cell."""
    text = StringIO()
    csv.writer(text, lineterminator="\n").writerows(rows)
    return text.getvalue()


UNFINISHED = ".backsolve-unfinished"
"""Ending of a file under construction."""

_LONGEST = 200
"""Bytes of its name that such a file keeps of the final one: most systems allow 255."""


def write_file(path: str, data: bytes) -> None:
    """Write a whole file. Raises RuleSheetError (E416)."""
    file = Replacement(path)
    try:
        file.write(data)
        file.keep()
    finally:
        file.discard()


def expect_no_input(path: str, inputs: Iterable[str]) -> None:
    """Raise RuleSheetError (E418) if an output is one of the inputs, whatever its name or link.

    Devices and pipes can be both.
    """
    for read in inputs:
        with suppress(OSError, ValueError):
            if os.path.isfile(path) and os.path.samefile(path, read):
                what = "it is read" if path == read else f"it is {read}, which is read"
                message = f"{path} is an input of this command, and would be overwritten: {what}"
                raise refusal("E418", message, None, "write to another file")


class Replacement:
    """A new file next to its final place: readers see the old one or the complete new one.

    ``keep`` moves it into place when its bytes are on the disk, ``discard`` removes it unless it is
    kept. A link is followed and the mode of an existing file kept. A pipe, a terminal or
    ``/dev/null`` is written to directly. Unfinished files of killed processes in the folder are
    removed. Raises RuleSheetError (E416) for every failure of the system.
    """

    stream: BinaryIO
    """The file itself, for a library that writes to one."""

    def __init__(self, path: str) -> None:
        self._path, self._target = path, os.path.realpath(path)
        self._unfinished: str | None = None
        with writing(path):
            there = os.stat(self._target).st_mode if os.path.exists(self._target) else None
            if there is not None and not stat.S_ISREG(there):
                self.stream = open(self._target, "wb")  # noqa: SIM115
                return
            self._unfinished, self.stream = _unfinished_file(*os.path.split(self._target))
            if there is not None:
                os.chmod(self._unfinished, stat.S_IMODE(there))

    def write(self, data: bytes) -> None:
        with writing(self._path):
            self.stream.write(data)

    def keep(self) -> None:
        """Put the file in its place."""
        with writing(self._path):
            self.stream.flush()
            if self._unfinished is not None:
                os.fsync(self.stream.fileno())
            self.stream.close()
            if self._unfinished is not None:
                os.replace(self._unfinished, self._target)
                self._unfinished = None

    def discard(self) -> None:
        """Remove the file, unless it is kept; the previous file stays."""
        with suppress(OSError):  # bytes that a full disk refused are discarded
            self.stream.close()
        if self._unfinished is not None:
            with suppress(OSError):  # the folder may have been removed meanwhile
                os.unlink(self._unfinished)
            self._unfinished = None


class Printed:
    """An open stream as a file. ``clear`` removes other output from the terminal first."""

    def __init__(self, stream: TextIO, clear: Callable[[], None] = lambda: None) -> None:
        self._stream, self._clear = stream, clear

    def write(self, data: bytes) -> None:
        self._clear()
        self._stream.write(data.decode())

    def keep(self) -> None:
        self._stream.flush()

    def discard(self) -> None:
        """Nothing that was printed can be removed."""


def _unfinished_file(folder: str, name: str) -> tuple[str, BinaryIO]:
    """A new file of its own, locked while this process lives, and its path.

    Unlocked files of this kind, of processes that ended, are removed.
    """
    with suppress(OSError), os.scandir(folder) as items:
        for item in items:
            if item.name.endswith(UNFINISHED) and item.is_file(follow_symlinks=False):
                with suppress(OSError), open(item.path, "ab") as left:
                    _lock(left)
                    os.unlink(item.path)
    short = os.fsdecode(os.fsencode(name)[:_LONGEST])
    while True:
        path = os.path.join(folder, f"{short}.{os.urandom(4).hex()}{UNFINISHED}")
        file = open(path, "xb")  # noqa: SIM115
        # a file system without locks, or somebody removes it this very moment
        with suppress(OSError):
            _lock(file)
        if os.path.exists(path):
            return path, file
        file.close()


def _lock(file: BinaryIO) -> None:
    """Lock a file for as long as it is open. Raises OSError if another process has it."""
    if "fcntl" in globals():
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
