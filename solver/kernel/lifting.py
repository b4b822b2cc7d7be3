"""A large block with unknowns of their own for what has to be positive: arguments of logarithms and roots,
and divisors.

A start need not lie in the domain then. The new unknowns begin positive and are kept so, and that they are
what they stand for is asked for by equations, which Newton's method may break on the way as it does any
other (J. Albersmeyer & M. Diehl, SIAM J. Optim. 20 (2010) 1655-1684: the lifted Newton method). Differences
are lifted: of a logarithmic mean those at both ends.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rulesheets.syntax.nodes import (
    Call,
    Expression,
    Name,
    Negative,
    Number,
    Power,
    Product,
    Quotient,
    Sum,
    exchange,
    names,
    subtract,
)
from rulesheets.syntax.program import walk
from solver.kernel.emitter import SparseSystem, divisors
from solver.numerics.linear_algebra import Array

_OF_POSITIVE = frozenset({"ln", "log", "log10", "log2", "sqrt"})
CANCELS = 0.05
"""Share of its largest term below which a difference is not begun as it is at a start."""
APART = 0.1, 0.03
"""The shares of that term at which it begins instead: the least, and by how much that of each further
difference of a rule is larger, as they may be divided by what they differ by."""


class Lifting:
    """The ``system`` of n equations with more unknowns and as many more equations; ``start`` gives those."""

    def __init__(self, system: SparseSystem, known: Sequence[float]) -> None:
        self.n, self.known = system.n, np.array(known, dtype=float)
        found = [tuple(dict.fromkeys(_differences(shape.form))) for shape in system.shapes]
        pairs = list(zip(system.shapes, found, strict=True))
        self.added = sum(len(each) * len(shape.rows) for shape, each in pairs)
        n, total, shapes = self.n, system.n, []
        self._lifted: list[tuple[float, NDArray[np.intp], NDArray[np.intp], Array, Callable[..., Any]]] = []
        for shape, differences in pairs if self.added else ():
            places, form = np.where(shape.places < n, shape.places, shape.places + self.added), shape.form
            for number, difference in enumerate(differences):
                mine, new = np.arange(total, total + len(shape.rows)), Name(f"#{len(places)}")
                total += len(mine)
                places = np.concatenate([places, mine[None]])
                meant = subtract(new, difference)
                shapes.append(shape.changed(meant, mine, places, n + self.added))
                terms = shape.compiled([difference, *difference.terms])
                share = APART[0] + APART[1] * number
                self._lifted.append((share, mine, shape.places, shape.numbers, terms))
                form = exchange(form, difference, new)
            shapes.append(shape.changed(form, shape.rows, places, n + self.added))
        self.system = system.changed(shapes, total) if shapes else system

    @property
    def some(self) -> bool:
        """Whether there is anything to lift."""
        return self.added > 0

    def start(self, x: Array) -> Array:
        """The point (n,) with the new unknowns: as it has them, or a share of the terms in them."""
        everything, found = np.concatenate([x, self.known]), np.ones(self.added)
        for share, mine, places, numbers, terms in self._lifted:
            with np.errstate(all="ignore"):
                at, *of = np.broadcast_arrays(*terms(*everything[places], *numbers), mine)[:-1]
                size = np.abs(of).max(axis=0)
            begun = np.where(at > CANCELS * size, at, share * size)
            found[mine - self.n] = np.where(np.isfinite(begun) & (begun > 0.0), begun, 1.0)
        return np.concatenate([x, found])


def _differences(form: Expression) -> Iterator[Sum]:
    """What has to be positive, or not 0, where the form has a value, and is a difference with names in it."""
    for divisor in divisors(form):
        yield from _factors(divisor)
    for node in walk(form):
        match node:
            case Call(function, (argument,)) if function in _OF_POSITIVE:
                yield from _factors(argument)
            case Power(base, Number(exponent)) if exponent != round(exponent):
                yield from _factors(base)
            case Power(base, exponent) if not isinstance(exponent, Number):
                yield from _factors(base)


def _factors(node: Expression) -> Iterator[Sum]:
    match node:
        case Sum(terms) if any(isinstance(term, Negative) for term in terms) and any(names(node)):
            yield node
        case Product(one, other) | Quotient(one, other):
            yield from _factors(one)
            yield from _factors(other)
        case Power(base, _) | Negative(base):
            yield from _factors(base)
