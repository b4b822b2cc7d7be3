"""Entries of the cache: each written as a whole or not at all."""

from __future__ import annotations

import os


def write_beside(target: str, data: bytes, mode: int) -> None:
    """Write to a file of a name of its own in the same folder, then give it the name of ``target``.

    Raises OSError, and leaves nothing behind then.
    """
    temporary = os.path.join(os.path.dirname(target), f".{os.getpid()}-{os.urandom(8).hex()}.new")
    exclusive = os.O_WRONLY | os.O_CREAT | os.O_EXCL | getattr(os, "O_BINARY", 0)
    handle = os.open(temporary, exclusive, 0o600)
    try:
        with open(handle, "wb") as file:
            file.write(data)
        os.chmod(temporary, mode)
        os.replace(temporary, target)
    except BaseException:
        os.unlink(temporary)
        raise
