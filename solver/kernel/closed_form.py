"""The candidates of a closed form, over numbers of any kind.

The formulas are written once, with the operators of numbers. A ``FormulaNumbers`` says what the
numbers are: floats, nodes of a program, expressions of a chain.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Any

from rulesheets.evaluate import value
from solver.numerics.tolerances import CLEAR, UNCANCELLED
from solver.path import Circle, ClosedForm, Coefficient, Formula, Let, Parabola


class FormulaNumbers:
    """The numbers of one branch of candidates, and what it asks of them.

    ``let`` and ``coefficient`` give the value of a formula and the number of a coefficient, at
    known values; ``kept`` the values kept of the numbers of a point. ``apart`` returns a divisor
    that is not 0, ``square_roots`` both roots of the difference of two numbers (none of a negative
    one), ``signed`` one of them with the sign of another number. ``fork`` begins another branch.
    """

    def roots(self: Any, a: Any, b: Any, c: Any) -> tuple[Any, ...]:
        """The roots of ``a x² + b x + c``, without cancellation."""
        below = self.apart(a)
        for root in self.square_roots(b * b, 4.0 * (a * c))[:1]:
            q = -0.5 * (b + self.signed(root, b))
            return q / below, c / q
        return ()


def candidates(
    form: ClosedForm, on: Any, known: Mapping[str, Any]
) -> Iterator[tuple[Any, dict[str, Any]]]:
    """Every candidate: the arithmetic of its branch, and the ``known`` values with those kept of
    all generators."""
    if not form:
        yield on, dict(known)
        return
    formula, rest = form[0], form[1:]
    if isinstance(formula, Let):
        yield from candidates(rest, on, {**known, formula.name: on.let(formula, known)})
        return
    for point in list(_points(formula, on, known)):
        branch = on.fork()
        yield from candidates(rest, branch, {**known, **branch.kept(formula, point)})


def _points(formula: Formula, on: Any, known: Mapping[str, Any]) -> Iterator[dict[str, Any]]:
    numbers = (on.coefficient(part, known) for part in formula if isinstance(part, Coefficient))
    match formula:
        case Parabola(name):
            yield from ({name: root} for root in on.roots(*numbers))
        case Circle(x, y):
            a, b, k, square = numbers
            length = on.apart(a * a + b * b)
            for root in on.square_roots(length * square, k * k):
                yield {x: (a * k - b * root) / length, y: (b * k + a * root) / length}


class Unclear(Exception):
    """A divisor or a discriminant is too near to zero for the formulas to cover every solution."""


class Rounded:
    """A float, the sizes of the ``terms`` of its last sum together, and the ``size`` that they had
    before anything cancelled."""

    def __init__(self, number: float, terms: float = 0.0, size: float = 0.0) -> None:
        self.number, self.terms, self.size = number, terms, size

    def __add__(self, other: Rounded) -> Rounded:
        terms = abs(self.number) + abs(other.number)
        return Rounded(self.number + other.number, terms, self.size + other.size)

    def __sub__(self, other: Rounded) -> Rounded:
        return self + -1.0 * other

    def __mul__(self, other: Rounded) -> Rounded:
        return Rounded(self.number * other.number, 0.0, self.size * other.size)

    def __rmul__(self, factor: float) -> Rounded:
        return Rounded(factor * self.number, 0.0, abs(factor) * self.size)

    def __truediv__(self, other: Rounded) -> Rounded:
        return Rounded(self.number / other.number)


class RoundedFloats(FormulaNumbers):
    """Raises Unclear where rounding may hide an answer, or create one."""

    def fork(self) -> RoundedFloats:
        return self

    def let(self, formula: Let, known: Mapping[str, Any]) -> float:
        number, size = value(formula.expression, known), formula.size
        if formula.divisor and (size is None or abs(number) <= CLEAR * value(size, known)):
            raise Unclear
        return number

    def coefficient(self, part: Coefficient, known: Mapping[str, Any]) -> Rounded:
        size = value(part.size, known)
        return Rounded(value(part.expression, known), size, size)

    def apart(self, number: Rounded) -> Rounded:
        least = max(CLEAR * number.terms, UNCANCELLED * number.size)
        if not (math.isfinite(number.size) and abs(number.number) > least):
            raise Unclear
        return number

    def square_roots(self, one: Rounded, other: Rounded) -> tuple[Rounded, ...]:
        square = self.apart(one - other).number
        return tuple(Rounded(s * math.sqrt(square)) for s in (1.0, -1.0) if square >= 0.0)

    def signed(self, root: Rounded, like: Rounded) -> Rounded:
        return Rounded(math.copysign(root.number, like.number))

    def roots(self, a: Rounded, b: Rounded, c: Rounded) -> tuple[Rounded, ...]:
        return super().roots(a, b, c) if a.size else (-1.0 * c / self.apart(b),)

    def kept(self, formula: Any, found: Mapping[str, Rounded]) -> dict[str, float]:
        return {name: number.number for name, number in found.items()}


FLOATS = RoundedFloats()
