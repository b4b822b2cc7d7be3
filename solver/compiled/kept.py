"""Compiled ways kept on disk, so that the same rows teach the same ways only once.

What a sweep learns depends on its pattern and on the rows it learns from, and its numbers depend on
that to the last bit: an entry is found by both. A way that finds roots by search is not kept, and
neither is anything for a model that comes from no text.
"""

from __future__ import annotations

import marshal

from rulesheets import store
from solver.compiled.flow import Flow
from solver.compiled.program import Ending, Program

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from solver.compiled.paths import CompiledPaths

KIND = "ways"


def recall_ways(paths: CompiledPaths, lessons: bytes) -> bool:
    """Take the ways that these lessons taught before; whether there were any to take.

    ``lessons`` tell the rows that ``paths``, which knows nothing yet, would learn from.
    """
    if not paths.model.digest:
        return False
    data = store.load(KIND, _key(paths, lessons))
    if data is None:
        return False
    ways, refusals, failures = marshal.loads(data)
    for fork, first in ways:
        program = _program(fork)
        paths.take(program, program if first is None else _program(first))
    paths.refusals.extend(map(_program, refusals))
    paths.failures = failures
    return True


def keep_ways(paths: CompiledPaths, lessons: bytes) -> None:
    """Keep what these lessons taught, for :func:`recall_ways`."""
    everything = (*paths.forks, *paths.programs, *paths.refusals)
    if not paths.model.digest or any(program.flow.finders for program in everything):
        return
    ways = [
        (_plain(fork), None if first is fork else _plain(first))
        for fork, first in zip(paths.forks, paths.programs, strict=True)
    ]
    try:
        data = marshal.dumps((ways, list(map(_plain, paths.refusals)), paths.failures))
    except ValueError:
        return  # a number of another kind than Python's own
    store.save(KIND, _key(paths, lessons), data)


def _key(paths: CompiledPaths, lessons: bytes) -> bytes:
    pattern = paths.pattern
    fixed = sorted(pattern.given.items()), sorted(pattern.guesses.items())
    rest = pattern.inputs, pattern.want, pattern.pruned, pattern.clear, pattern.as_written, pattern.accuracy
    return store.digest(paths.model.digest, repr((fixed, rest)).encode(), lessons)


def _plain(program: Program) -> tuple[Any, ...]:
    endings = [(e.results, e.holds, e.finite, e.gone, e.order) for e in program.endings]
    return program.flow.plain, program.flow.nodes, program.inputs, endings, program.symbols


def _program(plain: tuple[Any, ...]) -> Program:
    style, nodes, inputs, endings, symbols = plain
    flow = Flow(style)
    for node in nodes:  # in their order they get their numbers again
        flow.node(*node)
    return Program(flow, inputs, tuple(Ending(*ending) for ending in endings), symbols)
