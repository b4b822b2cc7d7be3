"""A large block as a sparse system: residual and exact Jacobian, with rules of one shape compiled once.

Rules of one shape (``path/graph.py``) are the rows of one vectorised function.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rulesheets.evaluate import differentiate
from rulesheets.syntax.nodes import subtract
from solver.kernel.emitter import compile_arrays
from solver.numerics.multistart import Array
from solver.numerics.sparse_newton import Triplets
from solver.path.graph import Alike, Family, template


class SparseSystem:
    """Residual (n,) and Jacobian of n rules as functions of points (n,); ``known`` names in their order.

    Raises NotDifferentiable.
    """

    def __init__(self, rules: Alike, unknowns: Sequence[str], known: Sequence[str]) -> None:
        self.n = len(unknowns)
        place = {name: place for place, name in enumerate((*unknowns, *known))}
        order = np.array([place[name] for name in rules.names], dtype=np.intp)
        self.shapes = [_Shape(family, order[family.columns], self.n) for family in rules.families]
        self.rows = np.concatenate([shape.slope_rows for shape in self.shapes])
        self.columns = np.concatenate([shape.slope_columns for shape in self.shapes])

    def at(self, known: Sequence[float]) -> tuple[Callable[[Array], Array], Callable[[Array], Triplets]]:
        """Residual and Jacobian at these values of the known names; nan where they are undefined."""
        constants = np.array(known, dtype=float)

        def residual(x: Array) -> Array:
            everything, found = np.concatenate([x, constants]), np.empty(self.n)
            for shape in self.shapes:
                found[shape.rows] = shape.residual(everything)
            return found

        def jacobian(x: Array) -> Triplets:
            everything = np.concatenate([x, constants])
            slopes = np.concatenate([shape.slopes(everything) for shape in self.shapes])
            return slopes, self.rows, self.columns

        return residual, jacobian


class _Shape:
    """A family as one function of arrays; ``places`` (k, m) of its names among unknowns and known ones."""

    def __init__(self, family: Family, places: NDArray[np.intp], n: int) -> None:
        self.rows, self.places, self.numbers = family.places, places, family.numbers
        form = subtract(*template(family.first))
        arguments = [f"#{k}" for k in range(len(places))] + [f"#.{k}" for k in range(len(self.numbers))]
        self.moving = [(k, places[k] < n) for k in range(len(places)) if (places[k] < n).any()]
        self._residual = compile_arrays([form], arguments)
        self._partials = compile_arrays([differentiate(form, f"#{k}") for k, _ in self.moving], arguments)
        self.slope_rows = np.concatenate([self.rows[m] for _, m in self.moving])
        self.slope_columns = np.concatenate([places[k][m] for k, m in self.moving])

    def residual(self, everything: Array) -> Any:
        with np.errstate(all="ignore"):
            return self._residual(*everything[self.places], *self.numbers)[0]

    def slopes(self, everything: Array) -> Array:
        with np.errstate(all="ignore"):
            columns = self._partials(*everything[self.places], *self.numbers)
        every = zip(columns, self.moving, strict=True)
        return np.concatenate([np.broadcast_to(column, len(m))[m] for column, (_, m) in every])
