"""Cost as a count of calls, which is the same on every machine and under any load."""

from __future__ import annotations

from collections.abc import Callable
from cProfile import Profile
from pstats import Stats


def operations(action: Callable[[], object]) -> int:
    """The calls that an action makes, those of built-in functions included."""
    profile = Profile()
    profile.runcall(action)
    return Stats(profile).total_calls  # type: ignore[attr-defined, no-any-return]


def growth(action: Callable[[int], Callable[[], object]], size: int, factor: int = 4) -> float:
    """By how much the cost grows with the size, as an exponent: 1 is linear, 2 is quadratic.

    ``action(size)`` prepares, uncounted, and returns what is counted. The first run is for what is
    made once.
    """
    from math import log

    action(size)()
    few, many = operations(action(size)), operations(action(factor * size))
    return log(many / few) / log(factor)
