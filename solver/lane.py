"""A worker process that answers questions in turn, each within a time limit."""

from __future__ import annotations

import asyncio
import json
import logging
import sys
import time
from contextlib import suppress
from typing import Any

Json = dict[str, Any]

LARGEST = 64 * 2**20
"""Bytes of one answer."""

SHARE = 0.8
"""The share of a question's time limit after which the solver returns what it knows."""

PATIENCE = 0.5
"""Seconds after which an outdated question is abandoned for its successor."""

_log = logging.getLogger("backsolve.page")


class Lane:
    """A queue of questions. One about a sheet brings it along: the worker may be a new one."""

    def __init__(self, workers: Workers, timeout: float) -> None:
        self.workers, self.timeout = workers, timeout
        self._process: asyncio.subprocess.Process | None = None
        self._turn = asyncio.Lock()
        self._since = 0.0
        self._doing = ""
        self._superseded = False

    async def ask(self, question: Json) -> Json:
        """The worker's answer, or ``gave_up`` with the time limit in seconds."""
        again = self._turn.locked() and question["do"] == self._doing == "solve"
        if again and time.monotonic() - self._since > PATIENCE:
            self._superseded = True
            if self._process is not None:
                with suppress(ProcessLookupError):
                    self._process.kill()
        async with self._turn:
            if self._process is None:
                self._process = await self.workers.take()
            self._since, self._doing, self._superseded = time.monotonic(), question["do"], False
            try:
                asked = {**question, "timeout": SHARE * self.timeout}
                return await asyncio.wait_for(self._answer(asked), self.timeout)
            except TimeoutError:
                _log.warning("gave up %s after %g s", question["do"], self.timeout)
                await self.stop()
                return {"gave_up": self.timeout}
            except asyncio.CancelledError:  # a late answer must not answer a later question
                await self.stop()
                raise
            finally:
                self._doing = ""

    async def stop(self) -> None:
        """Kill the worker; the next question starts another."""
        process, self._process = self._process, None
        if process is not None:
            await _end(process)

    async def _answer(self, question: Json) -> Json:
        assert self._process is not None
        reply = await _exchange(self._process, question)
        if reply is not None:
            return reply
        await self.stop()
        if self._superseded:
            return {"superseded": True}
        _log.warning("a worker ended at %s", question["do"])
        return {"failed": "the solver ended without an answer; it is started anew"}


class Workers:
    """Starts workers; always one more than there are tabs, because starting one takes a second."""

    def __init__(self) -> None:
        self._spare: asyncio.Task[asyncio.subprocess.Process] | None = None

    def ready(self) -> None:
        """Start the next worker."""
        self._spare = self._spare or asyncio.create_task(_started())

    async def take(self) -> asyncio.subprocess.Process:
        spare, self._spare = self._spare, None
        process = await (spare or _started())
        self.ready()
        return process

    async def close(self) -> None:
        if self._spare is not None:
            await _end(await self._spare)


async def _started() -> asyncio.subprocess.Process:
    """A worker that has imported its modules."""
    words, pipe = (sys.executable, "-m", "solver.page.bench"), asyncio.subprocess.PIPE
    start = asyncio.create_subprocess_exec(*words, stdin=pipe, stdout=pipe, limit=LARGEST)
    process = await start
    assert process.stdout is not None
    await process.stdout.readline()
    return process


async def _end(process: asyncio.subprocess.Process) -> None:
    """Kill a worker, which may have ended already."""
    with suppress(ProcessLookupError):
        process.kill()
    await process.communicate()


async def _exchange(process: asyncio.subprocess.Process, question: Json) -> Json | None:
    """Ask one question; None if the worker has ended."""
    assert process.stdin is not None and process.stdout is not None
    try:
        process.stdin.write(json.dumps(question).encode() + b"\n")
        await process.stdin.drain()
        line = await process.stdout.readline()
    except (ConnectionError, ValueError):
        return None
    return json.loads(line) if line else None
