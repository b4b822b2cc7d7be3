"""A cache on disk: entries identified by all that they depend on.

An entry is read only if it is this user's own, complete, and written under the same key, which is
stored in it. Anything else (a damaged entry, a file of another user) is ignored, and so is a folder
that cannot be written. The cache therefore changes the speed of an answer, never the answer.

``BACKSOLVE_CACHE`` names the folder; if it is set and empty, nothing is kept.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from contextlib import suppress
from zlib import adler32, crc32

MAX_BYTES = 128 * 2**20
"""Size of all entries, beyond which they are removed."""
LOOKING = 16
"""One in so many saves checks the total size."""

_SUFFIX = ".entry"


def load(kind: str, key: bytes) -> bytes | None:
    """The bytes saved under this key; None if there is no trusted entry."""
    path = place(_name(kind, key))
    if path is None:
        return None
    flags = os.O_RDONLY | getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_BINARY", 0)
    try:
        handle = os.open(path, flags)
        with open(handle, "rb") as file:
            if not _own(os.fstat(handle)):
                return None
            data = file.read()
    except OSError:
        return None
    content = data[len(_entry(kind, key, b"")) :]
    return content if data == _entry(kind, key, content) else None


def save(kind: str, key: bytes, data: bytes) -> None:
    """Keep ``data`` under a key. If that is impossible nothing happens."""
    path = place(_name(kind, key))
    if path is None or len(data) > MAX_BYTES // 4:
        return
    with suppress(OSError):
        entry = _entry(kind, key, data)
        if crc32(entry) % LOOKING == 0 and usage()[1] > MAX_BYTES:
            clear()
        # a whole new file takes the place of the entry
        new = os.path.join(os.path.dirname(path), f".{os.getpid()}-{os.urandom(8).hex()}.new")
        exclusive = os.O_WRONLY | os.O_CREAT | os.O_EXCL | getattr(os, "O_BINARY", 0)
        handle = os.open(new, exclusive, 0o600)
        try:
            with open(handle, "wb") as file:
                file.write(entry)
            os.replace(new, path)
        except BaseException:
            os.unlink(new)
            raise


def folder() -> str | None:
    """The folder of the entries by the convention of the system; None if nothing is to be kept."""
    own = os.environ.get("BACKSOLVE_CACHE")
    if own is not None:
        return os.path.abspath(own) if own else None
    home = os.path.expanduser("~")
    if not os.path.isabs(home):
        return None  # a user without a home
    if sys.platform == "win32":
        return os.path.join(os.environ.get("LOCALAPPDATA") or home, "backsolve", "Cache")
    if sys.platform == "darwin":
        return os.path.join(home, "Library", "Caches", "backsolve")
    base = os.environ.get("XDG_CACHE_HOME", "")
    return os.path.join(base if os.path.isabs(base) else os.path.join(home, ".cache"), "backsolve")


def place(name: str) -> str | None:
    """The file of an entry of that name; None if nothing is to be kept. Its folder is made."""
    base = folder()
    if base is None or not trusted(base):
        return None
    try:
        if not os.path.isdir(base):
            os.makedirs(os.path.dirname(base), exist_ok=True)
            os.makedirs(base, mode=0o700, exist_ok=True)
    except OSError:
        return None
    return os.path.join(base, name + _SUFFIX)


def usage() -> tuple[int, int]:
    """The number of entries, and their size in bytes."""
    sizes = [found.st_size for _, found in _entries(folder())]
    return len(sizes), sum(sizes)


def clear() -> int:
    """Remove every entry; return their number. Raises OSError if one cannot be removed."""
    entries = list(_entries(folder()))
    for path, _ in entries:
        with suppress(FileNotFoundError):
            os.unlink(path)
    return len(entries)


# --- one entry --------------------------------------------------------------------------


def _name(kind: str, key: bytes) -> str:
    return f"{kind}-{crc32(key):08x}{adler32(key):08x}{len(key):x}"


def _entry(kind: str, key: bytes, data: bytes) -> bytes:
    """A whole entry: a checksum, which shows damage, all that it depends on, and the data."""
    content = b"%s %s\n%s" % (kind.encode(), key, data)
    return b"%08x%s" % (crc32(content), content)


def _own(found: os.stat_result) -> bool:
    """Whether a file or folder is this user's, and nobody else can write to it."""
    if not hasattr(os, "geteuid"):
        return True  # the folder lies in the user's own profile
    return found.st_uid == os.geteuid() and not found.st_mode & 0o022


def trusted(base: str) -> bool:
    """Whether a folder is this user's alone, or does not exist yet."""
    try:
        return _own(os.stat(base))
    except FileNotFoundError:
        return True
    except OSError:
        return False


# --- all entries --------------------------------------------------------------------------


def _entries(base: str | None) -> Iterator[tuple[str, os.stat_result]]:
    """Entries, and incomplete files of interrupted writers."""
    if base is None or not os.path.isdir(base) or not trusted(base):
        return
    with os.scandir(base) as items:
        for item in items:
            if item.name.endswith((_SUFFIX, ".new")) and item.is_file(follow_symlinks=False):
                with suppress(FileNotFoundError):  # another process has removed it
                    yield item.path, item.stat(follow_symlinks=False)
