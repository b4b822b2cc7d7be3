"""A file that grows beside its place and is moved there when it is whole, however long that takes."""

from __future__ import annotations

import os
import stat
from contextlib import suppress
from types import TracebackType
from typing import BinaryIO, Self

from rulesheets.diagnosis import RuleSheetError
from rulesheets.input_messages import unwritable
from rulesheets.writing import open_beside
from solver.files.growing import GrowingFile


class Replacement:
    """A file under construction beside its place: readers see the old one or the new one, never half of it.

    ``keep`` moves it into place, ``discard`` leaves no trace; as a context it is kept unless an
    exception leaves the block. A link is followed and the mode of an existing file kept. What is
    no regular file (a pipe, a terminal, ``/dev/null``) is written directly. Every failure of the
    system raises RuleSheetError (E416).
    """

    def __init__(self, path: str) -> None:
        self._path = path
        self._target = os.path.realpath(path)
        self._beside: str | None = None
        try:
            self._file = self._opened()
        except OSError as failure:
            self._forget()
            raise RuleSheetError(unwritable(path, failure)) from None

    def write(self, data: bytes) -> None:
        try:
            self._file.write(data)
        except OSError as failure:
            raise RuleSheetError(unwritable(self._path, failure)) from None

    def keep(self) -> None:
        """Put the file in its place."""
        try:
            self._file.close()
            if self._beside is not None:
                os.replace(self._beside, self._target)
                self._beside = None
        except OSError as failure:
            self.discard()
            raise RuleSheetError(unwritable(self._path, failure)) from None
        except BaseException:  # an interruption while the last bytes are written
            self.discard()
            raise

    def discard(self) -> None:
        """Forget the file; what stood in its place before stays."""
        try:
            self._file.close()
        except OSError:
            pass  # bytes that a full disk refused are not wanted any more
        finally:
            self._forget()

    def _forget(self) -> None:
        if self._beside is not None:
            with suppress(OSError):  # who removes the folder in the meantime leaves nothing to remove
                os.unlink(self._beside)
            self._beside = None

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, failure: BaseException | None, trace: TracebackType | None
    ) -> None:
        if kind is None:
            self.keep()
        else:
            self.discard()

    def _opened(self) -> BinaryIO | GrowingFile:
        try:
            there: os.stat_result | None = os.stat(self._target)
        except FileNotFoundError:
            there = None
        if there is not None and not stat.S_ISREG(there.st_mode):
            return open(self._target, "wb")
        self._beside, handle = open_beside(self._target, 0o666)
        file = GrowingFile(handle)
        if there is not None:
            try:
                os.chmod(self._beside, stat.S_IMODE(there.st_mode))
            except OSError:
                file.close()
                raise
        return file
