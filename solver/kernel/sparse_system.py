"""A block on arrays: a large one as a sparse system, a small one at many points at once.

A sparse system has its residual and exact Jacobian, with rules of one shape (``path/shapes.py``) as
rows of one function of arrays.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cached_property, partial
from graphlib import CycleError, TopologicalSorter
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rulesheets.evaluate import differentiate, slopes_by_name
from rulesheets.model import Equation
from rulesheets.syntax import nodes
from rulesheets.syntax.nodes import ZERO, Expression, Name, Product, Quotient, names, subtract
from solver.kernel.chain import Chain, compile_chain
from solver.kernel.emitter import compile_expressions, divisors
from solver.numerics.linear_algebra import Array, SparseMap, Triplets
from solver.numerics.tolerances import BESIDE
from solver.path.graph import shape_of
from solver.path.isolate import smooth
from solver.path.shapes import Alike, Family
from solver.ranking.sizes import Scalings


class SparseSystem:
    """Residual (n,) and Jacobian of n rules as functions of points (n,); ``known`` names in their
    order."""

    def __init__(self, rules: Alike, unknowns: Sequence[str], known: Sequence[str]) -> None:
        self.n = len(unknowns)
        place = {name: place for place, name in enumerate((*unknowns, *known))}
        order = np.array([place[name] for name in rules.names], dtype=np.intp)
        self.shapes = [_Arrays(family, order[family.columns], self.n) for family in rules.families]
        self.rows = np.concatenate([shape.slope_rows for shape in self.shapes])
        self.columns = np.concatenate([shape.slope_columns for shape in self.shapes])

    def at(self, known: Sequence[float]) -> SparseMap:
        """Residual and Jacobian at these values of the known names; nan where undefined."""
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

    def with_explicit(self, x: Array, known: Sequence[float]) -> Array:
        """The point (n,) with every unknown that a rule gives explicitly (``l = sqrt(u^2 + v^2)``)
        replaced by its value; unchanged if such rules are circular."""
        everything = np.concatenate([x, np.array(known, dtype=float)])
        for function, targets, places, numbers in self._explicit:
            with np.errstate(all="ignore"):
                found = np.broadcast_to(function(*everything[places], *numbers)[0], len(targets))
            there = np.isfinite(found)
            everything[targets[there]] = found[there]
        return everything[: self.n]

    @cached_property
    def _explicit(
        self,
    ) -> list[tuple[Callable[..., Any], NDArray[np.intp], NDArray[np.intp], Array]]:
        """Functions of arrays with the unknowns that they give, in an order of evaluation."""
        giving = [shape for shape in self.shapes if shape.explicit]
        across = [shape.places.T.tolist() for shape in giving]
        rules: dict[int, tuple[int, int, int]] = {}
        members = (
            (s.of_factors, place, j, m)
            for j, s in enumerate(giving)
            for m, place in enumerate(s.rows.tolist())
        )
        for _, _, j, member in sorted(members):
            for k in giving[j].explicit:
                if (target := across[j][member][k]) < self.n and target not in rules:
                    rules[target] = j, k, member
                    break
        read = [{k: _read(form) for k, form in shape.explicit.items()} for shape in giving]
        needed = {
            target: [i for k in read[j][mine] if (i := across[j][member][k]) in rules]
            for target, (j, mine, member) in rules.items()
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
            for (j, k), targets in groups.items():
                shape, mine = giving[j], [rules[target][2] for target in targets]
                owners = np.array(targets, dtype=np.intp)
                value = shape.compiled([shape.explicit[k]])
                found.append((value, owners, shape.places[:, mine], shape.numbers[:, mine]))
            order.done(*ready)
        return found

    def divides_by_nothing(
        self, x: Sequence[float], known: Sequence[float], bars: Sequence[float]
    ) -> bool:
        """Whether a rule has a divisor that may be 0, or nearly, within the error bars of the
        unknowns."""
        everything = np.array([*x, *known], dtype=float)
        off = np.array([*bars, *[0.0] * len(known)])
        for shape in self.shapes:
            for read, function in shape.divisors:
                with np.errstate(all="ignore"):
                    at, *slopes = function(*everything[shape.places], *shape.numbers)
                    moves = sum(
                        np.abs(s) * off[shape.places[k]] for k, s in zip(read, slopes, strict=True)
                    )
                    near = ~np.less(moves, BESIDE * np.abs(at))
                if (near & (shape.places[read] < self.n).any(axis=0)).any():
                    return True
        return False


class _Arrays:
    """A family as one function of arrays; ``places`` (k, m) of its names among unknowns and known
    ones. ``explicit``: what it gives for the name at a place, where a side is a single name, or
    (``of_factors``) the product of two where the other side is a number: ``f*Re = 64``."""

    def __init__(self, family: Family, places: NDArray[np.intp], n: int) -> None:
        self.rows, self.places, self.numbers = family.places, places, family.numbers
        shape, _ = shape_of(family.first)
        self.form = subtract(shape.left, shape.right)
        self.explicit, self.of_factors = dict[int, Expression](), False
        for side, other in ((shape.left, shape.right), (shape.right, shape.left)):
            match side:
                case Name():
                    self.explicit |= dict.fromkeys(_read(side), other)
                case Product(Name() as one, Name() as two) if one != two and not _read(other):
                    self.explicit |= {k: Quotient(other, two) for k in _read(one)}
                    self.explicit |= {k: Quotient(other, one) for k in _read(two)}
                    self.of_factors = True
        self.compile(n)

    def compile(self, n: int) -> None:
        """Functions of the form and of its slopes by the names that are among n unknowns."""
        places = self.places
        arguments = [f"#{k}" for k in range(len(places))] + [
            f"#.{k}" for k in range(len(self.numbers))
        ]
        self.moving = [(k, places[k] < n) for k in range(len(places)) if (places[k] < n).any()]
        self._all_move = [bool(m.all()) for _, m in self.moving]
        self.compiled = partial(compile_expressions, arguments=arguments, arrays=True)
        self._residual = self.compiled([self.form])
        slopes = slopes_by_name(self.form, {f"#{k}" for k, _ in self.moving})
        self._partials = self.compiled([slopes.get(f"#{k}", ZERO) for k, _ in self.moving])
        self.slope_rows = np.concatenate([self.rows[m] for _, m in self.moving])
        self.slope_columns = np.concatenate([places[k][m] for k, m in self.moving])

    def residual(self, everything: Array) -> Any:
        with np.errstate(all="ignore"):
            return self._residual(*everything[self.places], *self.numbers)[0]

    def slopes(self, everything: Array) -> Array:
        with np.errstate(all="ignore"):
            columns = self._partials(*everything[self.places], *self.numbers)
        found = []
        for column, (_, m), all_move in zip(columns, self.moving, self._all_move, strict=True):
            full = column if np.ndim(column) else np.full(len(m), column)
            found.append(full if all_move else full[m])
        return np.concatenate(found)

    @cached_property
    def divisors(self) -> list[tuple[list[int], Callable[..., Any]]]:
        """The divisors, with their slopes by the names in them."""
        found = []
        for divisor in dict.fromkeys(divisors(self.form)):
            read = _read(divisor)
            slopes = [differentiate(divisor, f"#{k}") for k in read]
            if read:
                found.append((read, self.compiled([divisor, *slopes])))
        return found


def _read(expression: Expression) -> list[int]:
    """The places of the names of a template that do not stand for numbers, in order of
    occurrence."""
    return [int(name[1:]) for name in dict.fromkeys(names(expression)) if not name.startswith("#.")]


# --- a block on arrays of points, for searches from many starts ---

MAX_CHAINS = 32
"""Chains of a tearing along which starts are followed at most."""


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
        forms = [smooth(*e.sides) for e in equations]
        partials = {  # that are not 0 everywhere, by row and column
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
