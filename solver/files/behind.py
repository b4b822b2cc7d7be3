"""Bytes on their way to a file while the next ones are made.

A write to a file that grows takes longer than making its bytes where the system has to find memory for
them first, and both can run at once: neither needs the interpreter.
"""

from __future__ import annotations

from queue import Queue
from threading import Thread

from solver.files.replacing import Replacement

BATCH = 2**25
"""Bytes that are handed over at once: each time the two threads wait for the interpreter."""
AHEAD = 2
"""Batches that may wait: what bounds the memory."""


class WriteBehind:
    """Writes to a file in order, in a thread that starts with the first of them.

    What goes wrong there (RuleSheetError, E416) is raised by the next call that hands bytes over, or by
    ``finish``. ``end`` must come before the file itself is kept or discarded.
    """

    def __init__(self, file: Replacement) -> None:
        self._file = file
        self._batch: list[bytes] = []
        self._size = 0
        self._waiting: Queue[list[bytes] | None] = Queue(AHEAD)
        self._failure: BaseException | None = None
        self._thread: Thread | None = None
        self._ended = False

    def write(self, data: bytes) -> None:
        if self._ended:
            return
        self._batch.append(data)
        self._size += len(data)
        if self._size >= BATCH:
            self._hand_over()

    def finish(self) -> None:
        """Wait until everything is written."""
        self._hand_over()
        self.end()
        self._raise()

    def end(self) -> None:
        """End the thread; bytes that were not handed over, and any that still come, are dropped."""
        self._ended = True
        if self._thread is not None:
            self._waiting.put(None)
            self._thread.join()
            self._thread = None

    def _hand_over(self) -> None:
        if self._thread is None:
            self._thread = Thread(target=self._work, daemon=True, name="writing")
            self._thread.start()
        self._waiting.put(self._batch)
        self._batch, self._size = [], 0
        self._raise()

    def _raise(self) -> None:
        if self._failure is not None:
            raise self._failure

    def _work(self) -> None:
        while (batch := self._waiting.get()) is not None:
            if self._failure is None:
                try:
                    for data in batch:
                        self._file.write(data)
                except BaseException as failure:
                    self._failure = failure
