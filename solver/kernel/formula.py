"""A closed form at given numbers: every candidate for the unknowns of a block."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping

from rulesheets.evaluate import Undefined, value
from rulesheets.model import Value
from solver.path.closed_form import Circle, ClosedForm, Formula, Let, Parabola

CLEAR = 1e-9
"""What is nearer to zero than this, relative to its terms, is left to a search."""


class Unclear(Exception):
    """A divisor or a discriminant too near to zero for the formulas to cover every solution."""


def evaluate(form: ClosedForm, values: Mapping[str, Value]) -> list[dict[str, float]]:
    """Candidates: all solutions are among them. Raises Unclear, and Undefined for what overflows."""
    found: list[dict[str, float]] = [{}]
    for formula in form.formulas:
        found = [{**one, **more} for one in found for more in _values(formula, {**values, **one})]
    return [one for one in found if all(one[name] >= -CLEAR * _largest(one) for name in form.roots)]


def _largest(values: Mapping[str, float]) -> float:
    return max(map(abs, values.values()))


def _values(formula: Formula, values: Mapping[str, Value]) -> Iterator[dict[str, float]]:
    match formula:
        case Let(name, expression, divisor, size):
            number = value(expression, values)
            if divisor and (size is None or abs(number) <= CLEAR * value(size, values)):
                raise Unclear
            yield {name: number}
        case Parabola(name, a, b, c):
            for root in roots(value(a, values), value(b, values), value(c, values)):
                yield {name: root}
        case Circle(x, y):
            parts = (value(part, values) for part in (formula.a, formula.b, formula.k, formula.square))
            for point in meets(*parts):
                yield dict(zip((x, y), point, strict=True))


def roots(a: float, b: float, c: float) -> tuple[float, ...]:
    """The real roots of ``a x² + b x + c``, both or none. Raises Unclear between the two."""
    if a == 0.0:
        if b == 0.0:
            raise Unclear
        return (-c / b,)
    discriminant = b * b - 4.0 * a * c
    if not _clear(discriminant, b * b + abs(4.0 * a * c)):
        raise Unclear
    if discriminant < 0.0:
        return ()
    q = -0.5 * (b + math.copysign(math.sqrt(discriminant), b))
    return q / a, c / q


def meets(a: float, b: float, k: float, square: float) -> tuple[tuple[float, float], ...]:
    """Where ``a x + b y = k`` meets ``x² + y² = square``: two points or none. Raises Unclear between."""
    size = a * a + b * b
    discriminant = size * square - k * k
    if size == 0.0 or not _clear(discriminant, size * abs(square) + k * k):
        raise Unclear
    if discriminant < 0.0:
        return ()
    root = math.sqrt(discriminant)
    return tuple(((a * k - sign * b * root) / size, (b * k + sign * a * root) / size) for sign in (1.0, -1.0))


def _clear(number: float, size: float) -> bool:
    return math.isfinite(size) and abs(number) > CLEAR * size


__all__ = ["Unclear", "Undefined", "evaluate"]
