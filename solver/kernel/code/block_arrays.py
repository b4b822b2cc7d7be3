"""The equations of a block, and the chains of its tearing, on numpy arrays of points."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from rulesheets.evaluate import differentiate
from rulesheets.functions.arrays import ARRAYS
from rulesheets.syntax import nodes
from rulesheets.syntax.nodes import Expression
from solver.kernel.code.chain import Chain
from solver.kernel.code.scalar import Emitter
from solver.numerics.multistart import Array
from solver.path.smooth import smooth
from solver.ranking.sizes import Scalings

if TYPE_CHECKING:
    from solver.kernel.code.block import BlockKernel

MAX_CHAINS = 32


class BlockArrays:
    """The smooth forms of a block on points (k, n), its chains on tears (k, t); compiled once."""

    def __init__(self, kernel: BlockKernel) -> None:
        self.kernel = kernel
        self.n = len(kernel.unknowns)
        self.names = (*kernel.unknowns, *kernel.known)
        forms = [smooth(e.left, e.right) for e in kernel.equations]
        partials = _partials(forms, kernel.unknowns)
        self.places = list(partials)
        self._forms = compile_arrays(forms, self.names)
        self._partials = compile_arrays(list(partials.values()), self.names)
        self.scalings = Scalings(kernel.equations, self.names)
        every = kernel.chains()
        self.chains = [_followed(kernel, chain) for chain in every[:: -(-len(every) // MAX_CHAINS)]]

    def residual(self, known: Sequence[float], x: Array) -> Array:
        return self._stacked(self._forms(*x.T, *known), len(x))

    def jacobian(self, known: Sequence[float], x: Array) -> Array:
        matrices = np.zeros((len(x), self.n, self.n))
        for (i, j), values in zip(self.places, self._partials(*x.T, *known), strict=True):
            matrices[:, i, j] = values
        return matrices

    def starts(self, known: Sequence[float], tears: Array) -> Array:
        """Each point (k, tears) followed along one of the chains, by turns."""
        found = np.empty((len(tears), self.n))
        for place, chain in enumerate(self.chains):
            mine = tears[place :: len(self.chains)]
            try:
                found[place :: len(self.chains)] = self._stacked(chain(*mine.T, *known), len(mine))
            except ArithmeticError:  # among the known numbers alone, which are no arrays
                found[place :: len(self.chains)] = np.nan
        return found

    def _stacked(self, columns: Sequence[Any], k: int) -> Array:
        return np.stack([np.broadcast_to(column, (k,)) for column in columns], axis=1)


def _partials(forms: Sequence[Expression], unknowns: Sequence[str]) -> dict[tuple[int, int], Expression]:
    """The derivatives that are not 0 everywhere, by row and column.

    Raises NotDifferentiable.
    """
    found = {}
    for (i, form), (j, unknown) in itertools.product(enumerate(forms), enumerate(unknowns)):
        if unknown in nodes.names(form):
            found[i, j] = differentiate(form, unknown)
    return found


def compile_arrays(expressions: Sequence[Expression], names: Sequence[str]) -> Callable[..., Sequence[Any]]:
    """A function of arrays, in the order of ``names``, that returns the values of all expressions."""
    emitter = Emitter(names, ARRAYS, np.power)
    return emitter.function([emitter.of(expression) for expression in expressions])


def _followed(kernel: BlockKernel, chain: Chain) -> Callable[..., Sequence[Any]]:
    emitter = Emitter((*chain.tears, *kernel.known), ARRAYS, np.power)
    for assignment in chain.assignments[: len(chain.assignments) - len(chain.residuals)]:
        emitter.assign(assignment.name, assignment.expression)
        emitter.clamp(assignment.name, assignment.low, assignment.high, np.clip)
    return emitter.function([emitter.argument(name) for name in kernel.unknowns])
