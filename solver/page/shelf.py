"""The sheets that a page may open: those in one folder and below it, and those that come with Backsolve."""

from __future__ import annotations

import os
from hashlib import sha256
from pathlib import Path
from typing import NamedTuple

from rulesheets.loading import MAIN_SHEET, read_source, shipped_model, shipped_models
from solver.files.replacing import write_file

LARGEST = 500_000
"""Characters of a sheet that a page takes."""

LISTED = 200
"""Sheets of the folder that are listed at most."""

SHIPPED = "shipped:"


class Refused(Exception):
    """A sheet that is not there, or not to be opened or written; the text says why."""


class Sheet(NamedTuple):
    """A sheet on the shelf: ``key`` names it, ``folder`` is what its ``use`` paths start from."""

    key: str
    name: str
    file: Path
    within: Path

    @property
    def folder(self) -> Path:
        return self.file.parent

    @property
    def shipped(self) -> bool:
        return self.key.startswith(SHIPPED)

    def read(self) -> str:
        """The text. Raises Refused for one that is too long, RuleSheetError for one that cannot be read."""
        if self.file.is_file() and self.file.stat().st_size > LARGEST:
            raise Refused(f"{self.name} is too long for a page: it takes {LARGEST:,} bytes")
        return read_source(self.file).text

    def write(self, text: str, seen: str) -> None:
        """Replace the file, if it still says what the page has ``seen``. Raises Refused."""
        if self.shipped:
            raise Refused("a sheet that comes with Backsolve is not written to; copy its folder first")
        if fingerprint(self.read()) != seen:
            raise Refused(f"{self.name} has changed on disk since it was opened")
        write_file(str(self.file), text.encode())


class Shelf:
    """Sheets by key: the path from the folder, or ``shipped:`` and the name of a shipped sheet."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder.resolve()

    def listed(self) -> list[dict[str, str]]:
        """Every sheet by key and name, those of the folder first."""
        found: list[dict[str, str]] = []
        for place, folders, files in os.walk(self.folder):
            folders[:] = sorted(name for name in folders if not name.startswith("."))
            for name in sorted(files):
                if name.endswith(".tk") and len(found) < LISTED:
                    key = (Path(place) / name).relative_to(self.folder).as_posix()
                    found.append({"key": key, "name": self._name(key)})
        shipped = [{"key": SHIPPED + name, "name": name} for name in shipped_models()]
        return found + shipped

    def _name(self, key: str) -> str:
        """The path from the folder; a folder in place of the ``model.tk`` in it."""
        parent = os.path.dirname(key)
        return key if os.path.basename(key) != MAIN_SHEET else parent or self.folder.name

    def sheet(self, key: str) -> Sheet:
        """The sheet of that key. Raises Refused for one that is outside the folder."""
        if key.startswith(SHIPPED):
            name = key.removeprefix(SHIPPED)
            if name not in shipped_models():
                raise Refused("there is no such sheet")
            file = Path(shipped_model(name))
            return Sheet(key, name, file, file.parent.parent)
        if "\0" in key:
            raise Refused("there is no such sheet")
        file = (self.folder / key).resolve()
        if not file.is_relative_to(self.folder) or file.suffix != ".tk":
            raise Refused("a page opens the sheets in its folder alone")
        if not file.is_file():
            raise Refused(f"there is no sheet {key}")
        name = file.parent.name if file.name == MAIN_SHEET else file.stem
        return Sheet(key, name, file, self.folder)


def fingerprint(text: str) -> str:
    """Tells whether a text has changed."""
    return sha256(text.encode()).hexdigest()
