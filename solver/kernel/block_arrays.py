"""A block on arrays of points, for searches from many starts."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from rulesheets.evaluate import differentiate
from rulesheets.model import Equation
from rulesheets.syntax import nodes
from solver.kernel.chain import Chain, compile_chain
from solver.kernel.emitter import compile_expressions
from solver.numerics.linear_algebra import Array
from solver.path.isolate import smooth
from solver.ranking.sizes import Scalings

MAX_CHAINS = 32


class BlockArrays:
    """The smooth forms of a block on points (k, n), its chains on tears (k, t); compiled once."""

    def __init__(
        self,
        equations: Sequence[Equation],
        unknowns: tuple[str, ...],
        known: tuple[str, ...],
        chains: Sequence[Chain],
    ) -> None:
        names = (*unknowns, *known)
        self.n = len(unknowns)
        forms = [smooth(e.left, e.right) for e in equations]
        partials = {  # that are not 0 everywhere, by row and column; raises NotDifferentiable
            (i, j): differentiate(form, unknown)
            for i, form in enumerate(forms)
            for j, unknown in enumerate(unknowns)
            if unknown in nodes.names(form)
        }
        self.places = list(partials)
        self._forms = compile_expressions(forms, names, arrays=True)
        self._partials = compile_expressions(list(partials.values()), names, arrays=True)
        self.scalings = Scalings(equations, names)
        self.chains: list[Callable[..., Sequence[Any]]] = []
        for chain in chains[:: -(-len(chains) // MAX_CHAINS)]:
            steps = chain.assignments[: len(chain.assignments) - len(chain.residuals)]
            torn = chain._replace(assignments=steps)
            self.chains.append(compile_chain(torn, known, unknowns, arrays=True))

    def residual(self, known: Sequence[float], x: Array) -> Array:
        return self._stacked(self._forms(*x.T, *known), len(x))

    def jacobian(self, known: Sequence[float], x: Array) -> Array:
        matrices = np.zeros((len(x), self.n, self.n))
        for (i, j), values in zip(self.places, self._partials(*x.T, *known), strict=True):
            matrices[:, i, j] = values
        return matrices

    def starts(self, known: Sequence[float], tears: Array) -> Array:
        """Each point (k, tears) followed along one of the chains, in rotation."""
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
