"""A file written as a whole or not at all: readers see the old one or the new one, never half of it."""

from __future__ import annotations

import os


def replace_file(path: str, text: str) -> None:
    """Write ``text`` (UTF-8, line ends as they are) to ``path`` as :func:`replace_bytes` does."""
    replace_bytes(path, text.encode("utf-8"))


def replace_bytes(path: str, data: bytes) -> None:
    """Write ``data`` to ``path``.

    A link is followed and the mode of an existing file kept. Raises RuleSheetError (E416)
    where the file cannot be written.
    """
    target = os.path.realpath(path)
    try:
        mode = os.stat(target).st_mode & 0o777 if os.path.exists(target) else 0o666 & ~_umask()
        write_beside(target, data, mode)
    except OSError as failure:
        from rulesheets.diagnosis import RuleSheetError
        from rulesheets.input_messages import unwritable

        raise RuleSheetError(unwritable(path, failure)) from None


def write_beside(target: str, data: bytes, mode: int) -> None:
    """Write to a file of a name of its own in the same folder, then give it the name of ``target``.

    Raises OSError, and leaves nothing behind then.
    """
    temporary, handle = open_beside(target, 0o600)
    try:
        with open(handle, "wb") as file:
            file.write(data)
        os.chmod(temporary, mode)
        os.replace(temporary, target)
    except BaseException:
        os.unlink(temporary)
        raise


def open_beside(target: str, mode: int) -> tuple[str, int]:
    """A new file in the folder of ``target`` that no other writer has: its path, and a handle to write to."""
    name = f".{os.getpid()}-{os.urandom(8).hex()}.new"
    temporary = os.path.join(os.path.dirname(target), name)
    exclusive = os.O_WRONLY | os.O_CREAT | os.O_EXCL | getattr(os, "O_BINARY", 0)
    return temporary, os.open(temporary, exclusive, mode)


def _umask() -> int:
    current = os.umask(0)
    os.umask(current)
    return current
