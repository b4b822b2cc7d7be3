"""Contestants run in turn, so that all meet the same machine; the best of each counts.

Processor time for what runs on one core (others who use the machine don't count), wall clock beside
it.
"""

from __future__ import annotations

import ctypes
import gc
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import repeat


@dataclass(frozen=True)
class Contestant:
    """``run(argument)`` does ``units`` of work (rows, or 1). ``by_hand`` is what somebody writes
    who has solved the linkage on paper; ``threads`` is more than one where it uses them."""

    name: str
    run: Callable[..., object]
    argument: object
    units: int = 1
    threads: int = 1
    kind: str = "peer"
    note: str = ""


@dataclass(frozen=True)
class Time:
    """Seconds a unit: of processors, and by the clock."""

    cpu: float
    wall: float


AT_LEAST = 0.01
"""Seconds that one measurement takes: shorter calls are repeated."""

PATIENCE = 4.0
"""Seconds for all measurements of one contestant; there are two of each at least."""


WARM = 3
"""Calls before the first that counts: some learn from the first ones."""


def race(contestants: Sequence[Contestant], rounds: int) -> dict[str, Time]:
    """The best time of each, by name. A first call of each is not counted."""
    calls = {c.name: _calls(c) for c in contestants}
    spent = dict.fromkeys(calls, 0.0)
    best: dict[str, Time] = {}
    for round_ in range(rounds):
        for contestant in contestants:
            name = contestant.name
            if round_ > 1 and spent[name] > PATIENCE:
                continue
            found = _measure(contestant, calls[name])
            spent[name] += found.wall * contestant.units * calls[name]
            before = best.get(name, found)
            best[name] = Time(min(before.cpu, found.cpu), min(before.wall, found.wall))
    return best


def _calls(contestant: Contestant) -> int:
    """How often a run is repeated: sweeps never."""
    for _ in range(WARM if contestant.units == 1 else 1):
        contestant.run(contestant.argument)
    if contestant.units > 1:
        return 1
    calls = 1
    while (once := _measure(contestant, calls).cpu * calls) < AT_LEAST:
        calls = max(2 * calls, int(1.2 * AT_LEAST / max(once / calls, 1e-9)))
    return calls


def _measure(contestant: Contestant, calls: int) -> Time:
    run, argument = contestant.run, contestant.argument
    gc.collect()
    gc.disable()
    if contestant.units > 1:
        _give_back()
    try:
        cpu, wall = time.process_time(), time.perf_counter()
        for _ in repeat(None, calls):
            run(argument)
        cpu, wall = time.process_time() - cpu, time.perf_counter() - wall
    finally:
        gc.enable()
    work = calls * contestant.units
    return Time(cpu / work, wall / work)


def _give_back() -> None:
    """Free memory back to the system (where that is glibc's), so that every sweep writes to fresh
    pages."""
    trim = getattr(ctypes.CDLL(None), "malloc_trim", None)
    if trim is not None:
        trim(0)
