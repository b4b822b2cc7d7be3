"""Files written as a whole or not at all."""

from __future__ import annotations

import os
import tempfile

from rulesheets.diagnosis import RuleSheetError
from rulesheets.input_messages import unwritable


def replace_file(path: str, text: str) -> None:
    """Write ``text`` (UTF-8) to ``path``: readers see the old file or the new one, never half of it.

    A link is followed and the mode of an existing file kept. Raises RuleSheetError (E416)
    where the file cannot be written.
    """
    target = os.path.realpath(path)
    try:
        mode = os.stat(target).st_mode & 0o777 if os.path.exists(target) else 0o666 & ~_umask()
        _write_beside(target, text, mode)
    except OSError as failure:
        raise RuleSheetError(unwritable(path, failure)) from None


def _write_beside(target: str, text: str, mode: int) -> None:
    handle, temporary = tempfile.mkstemp(dir=os.path.dirname(target), prefix=".", suffix=".new")
    try:
        with os.fdopen(handle, "w", encoding="utf-8", newline="") as file:
            file.write(text)
        os.chmod(temporary, mode)
        os.replace(temporary, target)
    except BaseException:
        os.unlink(temporary)
        raise


def _umask() -> int:
    current = os.umask(0)
    os.umask(current)
    return current
