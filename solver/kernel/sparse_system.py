"""A large block as a sparse system: residual and exact Jacobian, with rules of one shape compiled once.

Rules of one shape (``path/graph.py``) are the rows of one vectorised function.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import cached_property, partial
from graphlib import CycleError, TopologicalSorter
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rulesheets.evaluate import differentiate
from rulesheets.syntax.nodes import Call, Expression, Name, Number, Power, Quotient, children, names, subtract
from solver.kernel.emitter import compile_expressions
from solver.numerics.linear_algebra import Array
from solver.numerics.sparse_newton import Triplets
from solver.path.graph import Alike, Family, shape_of

BESIDE = 0.25
"""The largest share of a divisor that the error bars of its variables may be."""


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

    def with_told(self, x: Array, known: Sequence[float]) -> Array:
        """The point (n,) with every unknown that a rule tells outright (``l = sqrt(u^2 + v^2)``) as that has
        it; as it is where such rules go round in a circle."""
        everything = np.concatenate([x, np.array(known, dtype=float)])
        for function, targets, places, numbers in self._told:
            with np.errstate(all="ignore"):
                found = np.broadcast_to(function(*everything[places], *numbers)[0], len(targets))
            there = np.isfinite(found)
            everything[targets[there]] = found[there]
        return everything[: self.n]

    @cached_property
    def _told(self) -> list[tuple[Callable[..., Any], NDArray[np.intp], NDArray[np.intp], Array]]:
        """Functions of arrays with the unknowns that they tell, in an order in which they may be followed."""
        telling = [shape for shape in self.shapes if shape.told]
        across = [shape.places.T.tolist() for shape in telling]
        rules: dict[int, tuple[int, int, int]] = {}
        members = ((place, j, m) for j, s in enumerate(telling) for m, place in enumerate(s.rows.tolist()))
        for _, j, member in sorted(members):
            for side, k in telling[j].told.items():
                if (target := across[j][member][k]) < self.n and target not in rules:
                    rules[target] = j, side, member
                    break
        read = [{side: _read(shape.sides[1 - side]) for side in shape.told} for shape in telling]
        needed = {
            target: [i for k in read[j][side] if (i := across[j][member][k]) in rules]
            for target, (j, side, member) in rules.items()
        }
        found, order = [], TopologicalSorter(needed)
        try:
            order.prepare()
        except CycleError:
            return []
        while order.is_active():
            groups: dict[tuple[int, int], list[int]] = {}
            for target in (ready := order.get_ready()):
                groups.setdefault(rules[target][:2], []).append(target)
            for (j, side), targets in groups.items():
                shape, mine = telling[j], [rules[target][2] for target in targets]
                told = np.array(targets, dtype=np.intp)
                other = shape.compiled([shape.sides[1 - side]])
                found.append((other, told, shape.places[:, mine], shape.numbers[:, mine]))
            order.done(*ready)
        return found

    def divides_by_nothing(self, x: Sequence[float], known: Sequence[float], bars: Sequence[float]) -> bool:
        """Whether a rule divides by what may be 0, or nearly, as the unknowns are off by their error bars."""
        everything = np.array([*x, *known], dtype=float)
        off = np.array([*bars, *[0.0] * len(known)])
        for shape in self.shapes:
            for read, function in shape.divisors:
                with np.errstate(all="ignore"):
                    at, *slopes = function(*everything[shape.places], *shape.numbers)
                    moves = sum(np.abs(s) * off[shape.places[k]] for k, s in zip(read, slopes, strict=True))
                    near = ~np.less(moves, BESIDE * np.abs(at))
                if (near & (shape.places[read] < self.n).any(axis=0)).any():
                    return True
        return False


class _Shape:
    """A family as one function of arrays; ``places`` (k, m) of its names among unknowns and known ones.
    ``told`` are its sides that are a name alone (0: the left one), with the place of that name."""

    def __init__(self, family: Family, places: NDArray[np.intp], n: int) -> None:
        self.rows, self.places, self.numbers = family.places, places, family.numbers
        shape, _ = shape_of(family.first)
        self.sides = shape.left, shape.right
        self.form = subtract(*self.sides)
        self.arguments = [f"#{k}" for k in range(len(places))]
        alone = {k: _read(side) for k, side in enumerate(self.sides) if isinstance(side, Name)}
        self.told = {k: read[0] for k, read in alone.items() if read}
        self.arguments += [f"#.{k}" for k in range(len(self.numbers))]
        self.moving = [(k, places[k] < n) for k in range(len(places)) if (places[k] < n).any()]
        self.compiled = partial(compile_expressions, arguments=self.arguments, arrays=True)
        self._residual = self.compiled([self.form])
        self._partials = self.compiled([differentiate(self.form, f"#{k}") for k, _ in self.moving])
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

    @cached_property
    def divisors(self) -> list[tuple[list[int], Callable[..., Any]]]:
        """What is divided by, with its slopes by the names in it."""
        found = []
        for divisor in dict.fromkeys(divisors(self.form)):
            read = _read(divisor)
            slopes = [differentiate(divisor, f"#{k}") for k in read]
            if read:
                found.append((read, self.compiled([divisor, *slopes])))
        return found


def _read(expression: Expression) -> list[int]:
    """The places of the names of a template that stand for no numbers, in the order in which they occur."""
    return [int(name[1:]) for name in dict.fromkeys(names(expression)) if not name.startswith("#.")]


def divisors(expression: Expression) -> Iterator[Expression]:
    """What a rule divides by, with variables in it (a power of it, or the cosine in a tangent)."""
    stack: list[Any] = [expression]
    while stack:
        node = stack.pop()
        match node:
            case Quotient(_, divisor) if any(names(divisor)):
                yield divisor
            case Power(_, Number(exponent)) if exponent > 0.0:
                pass
            case Power(base, _) if any(names(base)):
                yield base
            case Call("tan" | "tand" as function, arguments):
                yield Call(function.replace("tan", "cos"), arguments)
        stack.extend(children(node))
