"""The process that solves for a page: a JSON object a line in, one a line out.

It ends when the server does: its input is closed then, which a thread of its own waits for, whatever
is being solved.
"""

from __future__ import annotations

import json
import os
import sys
import threading
import traceback
from queue import SimpleQueue
from typing import Any

from solver.page.bench import Bench

MEMORY = 4 * 2**30
"""Bytes of address space that a sheet may come to need."""


def main() -> None:
    """Answer until the input ends."""
    replies, sys.stdout = sys.stdout, sys.stderr
    _bound_memory()
    waiting: SimpleQueue[str] = SimpleQueue()
    threading.Thread(target=_listen, args=(waiting,), daemon=True).start()
    bench = Bench()
    reply: dict[str, Any] = {"ready": True}
    while True:
        replies.write(json.dumps(reply, allow_nan=False, separators=(",", ":")) + "\n")
        replies.flush()
        reply = _answer(bench, waiting.get())


def _listen(waiting: SimpleQueue[str]) -> None:
    for line in sys.stdin:
        waiting.put(line)
    os._exit(0)


def _answer(bench: Bench, line: str) -> dict[str, Any]:
    try:
        return bench.answer(json.loads(line))
    except MemoryError:
        return {"failed": "this sheet needs more memory than a page may take"}
    except RecursionError:
        return {"failed": "this sheet is nested too deeply"}
    except (ValueError, TypeError, KeyError, LookupError) as wrong:
        traceback.print_exc()
        return {"failed": str(wrong)}


def _bound_memory() -> None:
    try:
        import resource
    except ImportError:  # no such limit on this system
        return
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))


if __name__ == "__main__":
    main()
