"""Sweeps by compiled ways: the rows that a way settles at once, block by block, the others one by one."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import suppress
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from rulesheets.model import Value
from solver.compiled.array import ArrayKernel
from solver.compiled.flow import Flow, NotCompilable
from solver.compiled.merge import primary
from solver.compiled.paths import CompiledPaths
from solver.compiled.program import Program
from solver.result import Status

Array: TypeAlias = NDArray[Any]
Solve: TypeAlias = Callable[[int], tuple[Status, tuple[Value, ...], Program | None]]
"""Solves a row step by step: its status, its values, and a new way where one was learned from it."""
Keep: TypeAlias = Callable[[Array, Status], None]
"""Takes the status of rows."""

WORTH = 16
"""So many rows pay for the set-up of a way on arrays."""


TOGETHER = 2**17
"""Rows up to which the columns of a piece share a block of memory, which the next piece takes again."""


class RowKernel:
    """One way on arrays: ``results`` (n,) for each wanted name and a mask (n,) of the rows that count."""

    def __init__(self, program: Program, jit: bool = False) -> None:
        if program.symbols:
            raise NotCompilable
        merged = primary(program)
        self.results = merged.results
        self.nodes = [node for node in merged.results if isinstance(node, int)]
        self.kernel = kernel_of(program.flow, (*self.nodes, merged.holds), jit)

    def __call__(self, columns: Sequence[Array]) -> tuple[list[Array | str], Array]:
        count = len(columns[0]) if columns else 1
        found = list(np.empty((len(self.nodes), count))[:, :count])
        holds = np.empty(count, dtype=bool)
        self.kernel(columns, (*found, holds))
        numbers = iter(found)
        return [next(numbers) if isinstance(node, int) else node for node in self.results], holds


class Sweeper:
    """The rows of sweeps of one pattern."""

    def __init__(self, paths: CompiledPaths, jit: bool = False) -> None:
        self.paths, self.jit = paths, jit
        self._kernels: dict[int, tuple[Program, RowKernel | None]] = {}

    def run(self, columns: Sequence[Array], wanted: int, solve: Solve, keep: Keep) -> list[Array]:
        """The wanted values (n,) from ``columns`` (n,): by the ways there are, by ways learned on the way.

        ``solve`` has the word on a row that no way settles, and ``keep`` is told what it says. A row without
        an answer is NaN.
        """
        known = set(map(id, (*self.paths.programs, *self.paths.refusals)))
        self._kernels = {key: kernel for key, kernel in self._kernels.items() if key in known}
        results: list[Array] = []
        some: Array | None = None  # rows are numbered once a way has left some
        for program in list(self.paths.programs):
            some = self._settled(program, columns, results, some)
        left = np.arange(len(columns[0])) if some is None else some
        for program in list(self.paths.refusals):
            left = self.refused(program, columns, left, keep)
        while len(left):
            row = int(left[0])
            status, values, learned = solve(row)
            if learned is not None and len(left) > WORTH:
                if status is Status.SOLVED:
                    some = None if len(left) == len(columns[0]) else left
                    found = self._settled(learned, columns, results, some)
                    left = left if found is None else found
                else:
                    left = self.refused(learned, columns, left, keep)
            if len(left) and left[0] == row:
                _spread(results, wanted, len(columns[0]))
                left = left[1:]
                for place, value in enumerate(values):
                    _put(results, place, row, value)
                keep(np.array([row]), status)
        _spread(results, wanted, len(columns[0]))
        return results

    def refused(self, program: Program, columns: Sequence[Array], left: Array, keep: Keep) -> Array:
        """The rows that are still left after a refusal had its turn."""
        kernel = self._kernel(program)
        if kernel is None or not len(left):
            return left
        _, holds = kernel([c if len(left) == len(c) else c[left] for c in columns])
        if holds.any():
            keep(left[holds], Status.INFEASIBLE)
        return left[~holds]

    def _settled(
        self, program: Program, columns: Sequence[Array], results: list[Array], left: Array | None
    ) -> Array | None:
        """The rows that are still left after a way had its turn; None stands for all of them."""
        kernel = self._kernel(program)
        if kernel is None or not len(columns[0] if left is None else left):
            return left
        found, holds = kernel(columns if left is None else [c[left] for c in columns])
        everything = bool(holds.all())
        if left is None and not results and not any(isinstance(values, str) for values in found):
            results += found  # type: ignore[arg-type]
            if not everything:
                for column in results:
                    column[~holds] = np.nan
        else:
            _spread(results, len(found), len(columns[0]))
            rows = np.flatnonzero(holds) if left is None else left[holds]
            for place, values in enumerate(found):
                _put(results, place, rows, values if everything or isinstance(values, str) else values[holds])
        return np.flatnonzero(~holds) if left is None else left[~holds]

    def _kernel(self, program: Program) -> RowKernel | None:
        known = self._kernels.get(id(program))
        if known is None:
            try:
                known = program, RowKernel(program, self.jit)
            except NotCompilable:
                known = program, None
            self._kernels[id(program)] = known  # the program is kept, so that its number stays its own
        return known[1]


def kernel_of(flow: Flow, wanted: Sequence[int], jit: bool) -> Callable[..., None]:
    """Machine code where it is asked for and can hold the functions, else blocks of numpy."""
    if jit:
        from solver.compiled.native import NativeKernel, available

        if not available():
            raise ImportError("machine code needs llvmlite: pip install 'backsolve[jit]'")
        with suppress(NotCompilable):
            return NativeKernel(flow, wanted)
    return ArrayKernel(flow, wanted)


def columns_of(number: int, count: int) -> list[Array]:
    """Columns (n,) to be filled."""
    if count <= TOGETHER:
        return list(np.empty((number, count)))
    return [np.empty(count) for _ in range(number)]


def _spread(results: list[Array], wanted: int, count: int) -> None:
    """Columns without an answer, where there are none yet."""
    if not results:
        results += [np.full(count, np.nan) for _ in range(wanted)]


def _put(results: list[Array], place: int, rows: Any, values: Any) -> None:
    """Assign to rows of a column, which takes symbols once there are some."""
    if isinstance(values, str) and results[place].dtype == float:
        results[place] = results[place].astype(object)
    results[place][rows] = values
