"""Contestants run in turn, so that all meet the same machine; the best of each counts.

Processor time for what runs on one core (others who use the machine don't count), wall clock beside it.
"""

from __future__ import annotations

import gc
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import repeat


@dataclass(frozen=True)
class Contestant:
    """``run(argument)`` does ``units`` of work (rows, or 1). ``by_hand`` is what somebody writes who has
    solved the linkage on paper; ``threads`` is more than one where it uses them."""

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
    contestant.run(contestant.argument)
    calls = 1
    while (once := _measure(contestant, calls).wall * contestant.units * calls) < AT_LEAST:
        calls = max(2 * calls, int(1.2 * AT_LEAST / max(once / calls, 1e-9)))
    return calls


def _measure(contestant: Contestant, calls: int) -> Time:
    run, argument = contestant.run, contestant.argument
    gc.collect()
    gc.disable()
    try:
        cpu, wall = time.process_time(), time.perf_counter()
        for _ in repeat(None, calls):
            run(argument)
        cpu, wall = time.process_time() - cpu, time.perf_counter() - wall
    finally:
        gc.enable()
    work = calls * contestant.units
    return Time(cpu / work, wall / work)
