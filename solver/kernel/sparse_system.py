"""A large block as a sparse system: residual and exact Jacobian, with rules of one shape compiled once.

Two rules have one shape where they differ in names and numbers only, as the rules of a network do: they are
the rows of one vectorised function.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from rulesheets.evaluate import differentiate
from rulesheets.syntax.nodes import Expression, Name, Number, Power, operands, rebuilt
from solver.kernel.emitter import compile_arrays
from solver.numerics.multistart import Array
from solver.numerics.sparse_newton import Triplets


class SparseSystem:
    """Residual (n,) and Jacobian of the ``forms`` as functions of points (n,); ``known`` in their order.

    Raises NotDifferentiable.
    """

    def __init__(self, forms: Sequence[Expression], unknowns: Sequence[str], known: Sequence[str]) -> None:
        self.n = len(unknowns)
        self.places = {name: place for place, name in enumerate((*unknowns, *known))}
        self.numbers: dict[float, int] = {}
        grouped: dict[tuple[Expression, tuple[bool, ...]], list[tuple[int, list[int]]]] = {}
        for row, form in enumerate(forms):
            shape, places = self._shape(form)
            moving = tuple(place < self.n for place in places)
            grouped.setdefault((shape, moving), []).append((row, places))
        self.shapes = [_Shape(*key, members) for key, members in grouped.items()]
        self.rows = np.concatenate([shape.slope_rows for shape in self.shapes])
        self.columns = np.concatenate([shape.slope_columns for shape in self.shapes])

    def _shape(self, form: Expression) -> tuple[Expression, list[int]]:
        """The form with names and numbers told by their order alone, and where their values stand."""
        order: dict[int, int] = {}

        def place(leaf: Name | Number) -> Expression:
            return Name(f"#{order.setdefault(self._place(leaf), len(order))}")

        return _mapped(form, place), list(order)

    def _place(self, leaf: Name | Number) -> int:
        if isinstance(leaf, Name):
            return self.places[leaf.name]
        return len(self.places) + self.numbers.setdefault(leaf.value, len(self.numbers))

    def at(self, known: Sequence[float]) -> tuple[Callable[[Array], Array], Callable[[Array], Triplets]]:
        """Residual and Jacobian at these values of the known names; nan where they are undefined."""
        constants = np.array([*known, *self.numbers], dtype=float)

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
    """Rules that differ in names and numbers only: one function of arrays for all of them."""

    def __init__(
        self, form: Expression, moving: Sequence[bool], members: list[tuple[int, list[int]]]
    ) -> None:
        self.rows = np.array([row for row, _ in members])
        self.places = np.array([places for _, places in members], dtype=np.intp).reshape(len(members), -1).T
        arguments = [f"#{k}" for k in range(len(moving))]
        inner = [k for k, moves in enumerate(moving) if moves]
        partials = [differentiate(form, arguments[k]) for k in inner]
        self._residual = compile_arrays([form], arguments)
        self._partials = compile_arrays(partials, arguments)
        self.slope_rows = np.tile(self.rows, len(inner))
        self.slope_columns = self.places[inner].ravel()

    def residual(self, everything: Array) -> Any:
        with np.errstate(all="ignore"):
            return self._residual(*everything[self.places])[0]

    def slopes(self, everything: Array) -> Array:
        with np.errstate(all="ignore"):
            columns = self._partials(*everything[self.places])
        return np.concatenate([np.broadcast_to(column, len(self.rows)) for column in columns])


def _mapped(form: Expression, place: Callable[[Any], Expression]) -> Expression:
    """The form with its leaves changed, but for exponents, which belong to its shape."""
    if isinstance(form, Power) and isinstance(form.exponent, Number):
        return Power(_mapped(form.base, place), form.exponent)
    if isinstance(form, Name | Number):
        return place(form)
    return rebuilt(form, tuple(_mapped(part, place) for part in operands(form)))
