"""Records on arrays: kernels, and the rows that a refusal settles at once."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import suppress
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from solver.result import Status
from solver.trace.arrays import ArrayKernel
from solver.trace.flow import Flow, NotCompilable
from solver.trace.program import Program, counts

Array: TypeAlias = NDArray[Any]
Keep: TypeAlias = Callable[[Array, Status], None]
"""Takes the status of rows."""

WORTH = 16
"""So many rows pay for the set-up of a record on arrays."""


TOGETHER = 2**17
"""Rows up to which the columns of a piece share a block of memory, which the next piece takes again."""


class Refusals:
    """The refusals of one pattern, on arrays."""

    def __init__(self, jit: bool = False) -> None:
        self.jit = jit
        self._kernels: dict[int, tuple[Program, Callable[..., None] | None]] = {}

    def left(self, program: Program, columns: Sequence[Array], left: Array, keep: Keep) -> Array:
        """The rows that are still left after a refusal had its turn."""
        kernel = self._kernel(program)
        if kernel is None or not len(left):
            return left
        holds = np.empty(len(left), dtype=bool)
        kernel([c if len(left) == len(c) else c[left] for c in columns], (holds,))
        if holds.any():
            keep(left[holds], Status.INFEASIBLE)
        return left[~holds]

    def _kernel(self, program: Program) -> Callable[..., None] | None:
        known = self._kernels.get(id(program))
        if known is None:
            kernel = None
            if not program.symbols:
                with suppress(NotCompilable):
                    holds = counts(program.flow, program.endings[0])
                    kernel = kernel_of(program.flow, (holds,), self.jit)
            known = program, kernel
            self._kernels[id(program)] = known  # the program is kept, so that its number stays its own
        return known[1]


def kernel_of(flow: Flow, wanted: Sequence[int], jit: bool) -> Callable[..., None]:
    """Machine code where it is asked for and can hold the functions, else blocks of numpy."""
    if jit:
        from solver.trace.llvm import NativeKernel, available

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
