"""The explicit form behind a number: of the preimages that an isolation has, the one that was taken."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from sys import float_info

from rulesheets.evaluate import Undefined, value
from rulesheets.model import Value
from rulesheets.syntax.nodes import Expression, Number, add, call, multiply, names, substitute, subtract
from solver.path.isolate import TARGET, Isolation

CLOSE = math.sqrt(float_info.epsilon)
"""A form may lose digits that the answer has (near a double root half of them), and still is the one."""


def explicit_form(isolation: Isolation, values: Mapping[str, Value]) -> Expression | None:
    """The form of ``isolation`` whose value is that of the unknown in ``values``.

    Where the answer lies whole turns away from every preimage, the form says how many:
    ``asind(y) + 360``. None where no form has a value near the answer.
    """
    if isolation.identity:
        return isolation.start
    answer = values[isolation.unknown]
    if isinstance(answer, str):
        return None
    known = {name: found for name, found in values.items() if name != isolation.unknown}
    nearest, distance = None, math.inf
    for form in _candidates(isolation, known, answer):
        off = abs(_value(form, known) - answer)
        if off < distance:
            nearest, distance = form, off
    return nearest if distance <= CLOSE * _size(nearest, answer, known) else None


def _candidates(isolation: Isolation, known: Mapping[str, Value], answer: float) -> Iterator[Expression]:
    yield from isolation.forms()
    if isolation.period is not None:
        yield from _turned(isolation, known, answer)


def _turned(isolation: Isolation, known: Mapping[str, Value], answer: float) -> Iterator[Expression]:
    """The forms with as many whole turns as bring them nearest to the answer."""
    at = next(i for i, stage in enumerate(isolation.stages) if stage.period)
    period = isolation.stages[at].period or 0.0
    for inside in _through(isolation, (isolation.start,), 0, at + 1):
        (plain,) = _through(isolation, (inside,), at + 1, None)[:1]
        (turned,) = _through(isolation, (add(inside, Number(period)),), at + 1, None)[:1]
        stride = _value(turned, known) - _value(plain, known)
        if not math.isfinite(stride) or stride == 0.0:
            continue
        turns = round((answer - _value(plain, known)) / stride)
        whole = _whole(abs(turns), period)
        moved = add(inside, whole) if turns >= 0 else subtract(inside, whole)
        yield from _through(isolation, (moved,), at + 1, None)


def _through(
    isolation: Isolation, targets: tuple[Expression, ...], first: int, last: int | None
) -> tuple[Expression, ...]:
    for stage in isolation.stages[first:last]:
        targets = tuple(substitute(form, {TARGET.name: t}) for t in targets for form in stage.forms)
    return targets


def _whole(turns: int, period: float) -> Expression:
    """So many periods, those of radians as multiples of pi."""
    halves = round(period / math.pi)
    if math.isclose(period, halves * math.pi, rel_tol=1e-12):
        return multiply(Number(float(turns * halves)), call("pi"))
    return Number(turns * period)


def _value(form: Expression, known: Mapping[str, Value]) -> float:
    """The value of a form, nan where it has none."""
    try:
        return value(form, known)
    except Undefined:
        return math.nan


def _size(form: Expression | None, answer: float, known: Mapping[str, Value]) -> float:
    """How large the numbers are that a form is made of."""
    read = () if form is None else names(form)
    numbers = (abs(found) for name in read if not isinstance(found := known[name], str))
    return max(abs(answer), max(numbers, default=0.0)) or 1.0
