"""How large unknowns may be expected to be, from the scalings that leave the rules of a block unchanged.

``v = omega*r`` and ``a = omega^2*r`` stay true if r, v and a are doubled, or if omega is doubled, v too and
a is quadrupled. Such scalings are found from the rules alone, without units: terms of a sum scale alike,
factors add their exponents, arguments of sines don't scale (the reasoning of dimensional analysis; E.
Buckingham, *On physically similar systems*, 1914). The numbers that are known then tell the size of each kind
of quantity.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from rulesheets.functions import named
from rulesheets.model import Equation
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
)

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Vector = NDArray[np.float64]

_ALIKE = frozenset({"abs", "min", "max", "round", "int", "frac", "mod"})
_DIRECTIONS = named(lambda row: row.direction)
RANK = 1e-9


class Scalings:
    """``exponents`` (names, k): how each variable changes under k independent scalings of the rules."""

    def __init__(self, equations: Sequence[Equation], names: Sequence[str]) -> None:
        self.places = {name: i for i, name in enumerate(names)}
        self._zero: list[Vector] = []
        for equation in equations:
            self._alike(self._exponents(equation.left), self._exponents(equation.right))
        self.exponents = _null_space(np.array(self._zero).reshape(-1, len(names)))

    def sizes(self, known: Mapping[str, float]) -> Mapping[str, float]:
        """The size of every variable that fits the ``known`` numbers best (in the mean of logarithms)."""
        given = {name: math.log(abs(v)) for name, v in known.items() if v}
        rows = self.exponents[[self.places[name] for name in given]]
        scaling = np.linalg.lstsq(rows, np.array(list(given.values())), rcond=RANK)[0]
        exponents = np.clip(self.exponents @ scaling, -200.0, 200.0)
        return dict(zip(self.places, np.exp(exponents).tolist(), strict=True))

    def _alike(self, *terms: Vector | None) -> Vector | None:
        """Note that the terms scale alike; None is a zero, which scales anyhow."""
        first = next((term for term in terms if term is not None), None)
        if first is not None:
            self._zero += [term - first for term in terms if term is not None and term is not first]
        return first

    def _fixed(self, *terms: Vector | None) -> Vector:
        """Note that the terms do not scale; nor does what is made of them."""
        self._zero += [term for term in terms if term is not None]
        return self._none()

    def _none(self) -> Vector:
        return np.zeros(len(self.places))

    def _exponents(self, node: Expression) -> Vector | None:
        match node:
            case Number(value):
                return self._none() if value else None
            case Name(name):
                vector = self._none()
                vector[self.places[name]] = 1.0
                return vector
            case Negative(operand):
                return self._exponents(operand)
            case Sum(terms):
                return self._alike(*map(self._exponents, terms))
            case Product(left, right):
                return _sum(self._exponents(left), self._exponents(right), 1.0)
            case Quotient(left, right):
                return _sum(self._exponents(left), self._exponents(right), -1.0)
            case Power(base, Number(exponent)):
                inner = self._exponents(base)
                return None if inner is None else exponent * inner
            case Power(base, exponent):
                return self._fixed(self._exponents(base), self._exponents(exponent))
            case Call("sqrt", (argument,)):
                inner = self._exponents(argument)
                return None if inner is None else 0.5 * inner
            case Call(function, arguments) if function in _ALIKE:
                return self._alike(*map(self._exponents, arguments))
            case Call(function, arguments) if function in _DIRECTIONS:
                self._alike(*map(self._exponents, arguments))
                return self._none()
            case Call(_, arguments):
                return self._fixed(*map(self._exponents, arguments))
            case _:
                return self._none()


def _sum(left: Vector | None, right: Vector | None, sign: float) -> Vector | None:
    return None if left is None or right is None else left + sign * right


def _null_space(matrix: NDArray[Any]) -> NDArray[np.float64]:
    """Orthonormal columns that span {x: A x = 0}."""
    if not len(matrix):
        return np.eye(matrix.shape[1])
    triangle = np.linalg.qr(matrix, mode="r") if len(matrix) > matrix.shape[1] else matrix
    _, singular, right = np.linalg.svd(triangle)
    rank = int((singular > RANK * max(singular[0], 1.0)).sum())
    return np.asarray(right[rank:].T, dtype=float)
