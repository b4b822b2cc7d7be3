"""A file that grows by whichever way is the quicker: through the memory of the system, or past it.

A write ends in memory that the system must find first and free again when the disk has it. That hides a slow
disk from a short file; of a long one it can take several times as long as the disk would (the bytes are
copied, and the memory is cleared before). Linux lets a writer go past it (``O_DIRECT``, open(2)), with bytes
at whole blocks of memory and of the file. Which of the two is quicker is a matter of the machine, of what
else it does, and of how much is written already, so both are tried, again and again.
"""

from __future__ import annotations

import errno
import os
from mmap import mmap
from time import perf_counter

BATCH = 2**24
"""Bytes of a write: of whole blocks on any disk."""
SHORT = 2**26
"""Bytes that go through memory before the other way is tried: their readers will find them there."""
TRIALS = 0.02
"""The share of the time that may go into trying the slower way again."""

DIRECT: int = getattr(os, "O_DIRECT", 0)


class GrowingFile:
    """Takes bytes in order for the open file ``handle``, and closes it in the end.

    Raises OSError. The last bytes are written by ``close``.
    """

    def __init__(self, handle: int) -> None:
        self._handle = handle
        self._batch: mmap | None = None
        self._held = 0
        self._written = 0
        self._seconds = {0: 0.0, DIRECT: 0.0}  # of the last batch, by the flag of its way
        self._since = 0.0

    def write(self, data: bytes) -> None:
        rest = memoryview(data)
        while len(rest):
            batch = self._batch = self._batch or mmap(-1, BATCH)  # at a whole page of memory
            taken = min(len(rest), BATCH - self._held)
            batch[self._held : self._held + taken] = rest[:taken]
            rest, self._held = rest[taken:], self._held + taken
            if self._held == BATCH:
                self._held = 0
                self._put(batch)

    def close(self) -> None:
        """Write what is left. The file is closed even where that fails."""
        handle, self._handle = self._handle, -1
        if handle < 0:
            return
        try:
            if self._batch is not None and self._held:
                _divert(handle, 0)
                _write(handle, memoryview(self._batch)[: self._held])
        finally:
            os.close(handle)

    def _put(self, batch: mmap) -> None:
        way, began, left = self._way(), perf_counter(), memoryview(batch)
        try:
            _divert(self._handle, way)
        except OSError:
            if not way:
                raise
        else:
            left = _write(self._handle, left, way)
        if left:
            del self._seconds[way]
            _divert(self._handle, 0)
            _write(self._handle, left)
        else:
            self._seconds[way] = perf_counter() - began
            self._since += self._seconds[way]
        self._written += BATCH

    def _way(self) -> int:
        """The flag for the next batch."""
        if self._written < SHORT:
            return 0
        quicker, *slower = sorted(self._seconds, key=self._seconds.__getitem__)
        if slower and self._seconds[slower[0]] < TRIALS * self._since:
            self._since = 0.0
            return slower[0]
        return quicker


def _divert(handle: int, flag: int) -> None:
    """Let the next bytes of an open file go the way of a flag.

    Raises OSError where the file system knows at once that it has no such way (others tell as they write).
    """
    if DIRECT:
        import fcntl

        before = fcntl.fcntl(handle, fcntl.F_GETFL)
        if before & DIRECT != flag:
            fcntl.fcntl(handle, fcntl.F_SETFL, before & ~DIRECT | flag)


def _write(handle: int, data: memoryview, way: int = 0) -> memoryview:
    """What is left where the file system has no such way."""
    while len(data):
        try:
            data = data[os.write(handle, data) :]
        except OSError as failure:
            if not way or failure.errno not in (errno.EINVAL, errno.EOPNOTSUPP):
                raise
            return data
    return data
