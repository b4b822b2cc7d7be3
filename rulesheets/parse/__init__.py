"""Text → RuleSheet: lines (layout), sections, and what each line says (grammar, builder).

A file that the same code has read before is not parsed again: then neither the grammar nor lark is
imported, which take a fifth of the time in which a command starts.
"""

from __future__ import annotations

import os
import pickle
import sys
from contextlib import suppress
from functools import cache
from io import BytesIO
from typing import Any

from rulesheets import store
from rulesheets.functions import TABLE
from rulesheets.syntax import Source
from rulesheets.syntax.nodes import RuleSheet

LONGEST_KEPT = 2**20
"""Characters of a text beyond which it is parsed every time."""

_ROOM = os.path.dirname(__file__)
_CODE = (_ROOM, os.path.join(_ROOM, os.pardir, "syntax"), os.path.join(_ROOM, os.pardir))


def parse(source: Source) -> RuleSheet:
    """The rule sheet that a text says. Raises RuleSheetError with what is wrong, line by line."""
    from rulesheets.parse.sections import read  # with it comes lark

    return read(source)


def parse_file(source: Source) -> RuleSheet:
    """The same of a text that is in a file, which is likely to be read again."""
    last = next(reversed(TABLE.values()))
    if len(source.text) > LONGEST_KEPT or last.source is not None:
        return parse(source)  # ends of ranges are evaluated, so that functions of one's own matter
    key = _stamp() + source.text.encode()
    kept = store.load("syntax", key)
    if kept is not None:
        sheet: RuleSheet = _Reader(source, kept).load()
        return sheet
    sheet = parse(source)
    with suppress(RecursionError):  # a product of hundreds of factors
        store.save("syntax", key, _written(sheet))
    return sheet


@cache
def _stamp() -> bytes:
    """What tells this code from any other that parses."""
    files = (file for folder in _CODE for file in os.scandir(folder) if file.name.endswith((".py", ".lark")))
    found = sorted((file.path, file.stat().st_mtime_ns, file.stat().st_size) for file in files)
    return repr((sys.version, found)).encode()


def _written(sheet: RuleSheet) -> bytes:
    buffer = BytesIO()
    _Writer(buffer, pickle.HIGHEST_PROTOCOL).dump(sheet)
    return buffer.getvalue()


class _Writer(pickle.Pickler):
    """Writes nodes; the source in their places is left out."""

    def persistent_id(self, obj: Any) -> str | None:
        return "" if type(obj) is Source else None


class _Reader(pickle.Unpickler):
    """Reads nodes that stand in a source."""

    def __init__(self, source: Source, data: bytes) -> None:
        super().__init__(BytesIO(data))
        self.source = source

    def persistent_load(self, pid: str) -> Source:
        return self.source
