"""Loops whose calls lie across the end of a chunk of frames."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import pytest

from rulesheets.deadline import in_one_chunk

resource = pytest.importorskip("resource")
DEPTHS = range(300)
TURNS = 200


def nothing() -> None:
    pass


def loop() -> int:
    """How many pages of memory a loop of calls asks for."""
    before = resource.getrusage(resource.RUSAGE_SELF).ru_minflt
    for _ in range(TURNS):
        nothing()
    return int(resource.getrusage(resource.RUSAGE_SELF).ru_minflt - before)


def deep(depth: int, work: Callable[[], int]) -> int:
    return deep(depth - 1, work) if depth else work()


def test_a_loop_needs_no_memory_however_deep_it_is() -> None:
    for depth in DEPTHS:
        assert deep(depth, in_one_chunk(loop)) < TURNS / 2
        assert in_one_chunk(partial(deep, depth, loop))() < TURNS / 2


def test_it_is_the_function_that_it_wraps() -> None:
    @in_one_chunk
    def divided(a: float, *, by: float) -> float:
        """A quotient."""
        return a / by

    assert divided.__name__ == "divided"
    assert divided.__doc__ == "A quotient."
    assert divided(6.0, by=2.0) == 3.0
    with pytest.raises(ZeroDivisionError):
        divided(6.0, by=0.0)
