"""A block with a closed form at given numbers: every answer, without a search."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import NamedTuple

from rulesheets.evaluate import value
from rulesheets.model import Value
from solver.kernel.candidates import Candidates
from solver.kernel.question import Question
from solver.kernel.root_check import astray
from solver.numerics.tolerances import CLEAR, UNCANCELLED
from solver.path.elimination import Circle, ClosedForm, Coefficient, Formula, Let, Parabola

MOST = 300
"""Candidates that whole turns make of one."""


class Unclear(Exception):
    """A divisor or a discriminant too near to zero for the formulas to cover every solution."""


def solve_by_formula(question: Question, candidates: Candidates, form: ClosedForm) -> bool:
    """Find the answers by the closed form; False where it does not settle which they are."""
    try:
        found = evaluate(form, question.values)
    except (Unclear, ArithmeticError):
        return False
    points = [point for one in found for point in _turned(question, one)]
    trial = Candidates(question)
    if not all(_settled(question, trial, point) for point in points):
        return False
    candidates.take(trial)
    for point in points:
        candidates.note(point)
    return True


def _turned(question: Question, values: Mapping[str, float]) -> list[dict[str, float]]:
    """The candidate, with every whole turn of its angles that a declared range has room for.

    Of too many the ones nearest to 0, which are still more than are listed.
    """
    points = [{name: values[name] for name in question.unknowns}]
    ranged = [v for v in question.variables if v.low > -math.inf or v.high < math.inf]
    angles = [(v, turn) for v in ranged if (turn := question.turn(v.name)) is not None]
    most = round(MOST ** (1 / max(len(angles), 1)))
    for variable, turn in angles:
        low, high = question.domain(variable.name)
        number = values[variable.name]
        turns = range(math.ceil((low - number) / turn), math.floor((high - number) / turn) + 1)
        if len(turns) > most:
            first = min(max(turns.start, round(-number / turn) - most // 2), turns.stop - most)
            turns = range(first, first + most)
        points = [{**p, variable.name: number + k * turn} for p in points for k in turns or (0,)]
    return points


def _settled(question: Question, candidates: Candidates, point: dict[str, float]) -> bool:
    """Whether it is plain that a candidate is an answer, or that it is none."""
    count = len(candidates.answers)
    candidates.refine(list(point.values()))
    if len(candidates.answers) > count or candidates.outside is not None:
        return True
    return astray(question, point)


def evaluate(form: ClosedForm, values: Mapping[str, Value]) -> list[dict[str, float]]:
    """Candidates: all solutions are among them. Raises Unclear, and Undefined for what overflows."""
    found: list[dict[str, float]] = [{}]
    for formula in form.formulas:
        found = [{**one, **more} for one in found for more in _values(formula, {**values, **one})]
    return found


def _values(formula: Formula, values: Mapping[str, Value]) -> Iterator[dict[str, float]]:
    match formula:
        case Let(name, expression, divisor, size):
            number = value(expression, values)
            if divisor and (size is None or abs(number) <= CLEAR * value(size, values)):
                raise Unclear
            yield {name: number}
        case Parabola(name, a, b, c):
            for root in roots(*(_number(part, values) for part in (a, b, c))):
                yield {name: root}
        case Circle(x, y, a, b, k, square):
            for point in meets(*(_number(part, values) for part in (a, b, k, square))):
                yield dict(zip((x, y), point, strict=True))


class Rounded(NamedTuple):
    """A number and the size of the terms that it was added up from."""

    value: float
    size: float


def _number(coefficient: Coefficient, values: Mapping[str, Value]) -> Rounded:
    return Rounded(value(coefficient.expression, values), value(coefficient.size, values))


def roots(a: Rounded, b: Rounded, c: Rounded) -> tuple[float, ...]:
    """The real roots of ``a x² + b x + c``. Raises Unclear where rounding may hide or make some."""
    if a.size == 0.0:
        if b.value == 0.0 or abs(b.value) <= CLEAR * b.size:
            raise Unclear
        return (-c.value / b.value,)
    discriminant = b.value * b.value - 4.0 * a.value * c.value
    if abs(a.value) <= CLEAR * a.size:
        raise Unclear
    _clear(
        discriminant,
        b.value * b.value + abs(4.0 * a.value * c.value),
        b.size * b.size + 4.0 * a.size * c.size,
    )
    if discriminant < 0.0:
        return ()
    q = -0.5 * (b.value + math.copysign(math.sqrt(discriminant), b.value))
    return q / a.value, c.value / q


def meets(a: Rounded, b: Rounded, k: Rounded, square: Rounded) -> tuple[tuple[float, float], ...]:
    """Where ``a x + b y = k`` meets ``x² + y² = square``: two points or none. Raises Unclear between."""
    length = a.value * a.value + b.value * b.value
    _clear(length, length, a.size * a.size + b.size * b.size)
    discriminant = length * square.value - k.value * k.value
    _clear(
        discriminant,
        length * abs(square.value) + k.value * k.value,
        (a.size * a.size + b.size * b.size) * square.size + k.size * k.size,
    )
    if discriminant < 0.0:
        return ()
    root = math.sqrt(discriminant)
    return tuple(
        (
            (a.value * k.value - sign * b.value * root) / length,
            (b.value * k.value + sign * a.value * root) / length,
        )
        for sign in (1.0, -1.0)
    )


def _clear(number: float, terms: float, size: float) -> None:
    """Raise Unclear unless a number is known to be no zero: by what it came from, and by rounding."""
    if not (math.isfinite(size) and abs(number) > max(CLEAR * terms, UNCANCELLED * size)):
        raise Unclear
