"""The roots of a sheet of one unknown by brute force: signs of its rules at many floats, then
bisection.

A witness of completeness that shares no code with the solver. What it finds are roots; it may miss
some.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Iterator
from typing import Any

import mpmath

from benchmarks.expressions import DIGITS, Undefined, evaluated
from benchmarks.hostile_sheets import Sheet, names_of
from solver import Result, Status

SPECIAL = (0.5, 1.0, 2.0, 3.0, 30.0, 45.0, 60.0, 90.0, 120.0, 135.0, 150.0, 180.0, 270.0, 360.0)
DECADES = (*range(-20, 20), *range(-320, -20, 20), *range(20, 309, 20))
SAME = 1e-6
"""Answers are roots if they are so near to them, relatively."""
ROUNDING = 2.0**-50
"""The change of the unknown, a few units of its last place, that may satisfy a rule which is a
check."""
CONTINUOUS = 1e-4
"""What is left, at most, of a continuous function between two floats where these are bisected
further."""
SMALLEST = 2.0**-1022
LARGEST = 1.7976931348623157e308
MANY = 27_720
"""Whole turns that are whole ones of an angle's halves, thirds, … and twelfths."""


def missing(made: Sheet, result: Result) -> Iterator[float]:
    """The roots that an answer denies: of a sheet of one unknown without inputs, where the answers
    are called all, or it is said that there are none."""
    names = names_of(" ".join(" ".join(rule) for rule in made.rules))
    denied = result.status in (Status.INFEASIBLE, Status.INCONSISTENT)
    if (
        made.raw is not None
        or made.inputs
        or made.symbols
        or len(names) != 1
        or not (denied or result.complete)
    ):
        return
    if not denied and not result.solutions:
        return
    (name,) = names
    low, high = made.ranges.get(name, (-math.inf, math.inf))
    found = [
        solution[name] for solution in result.solutions if isinstance(solution.get(name), float)
    ]
    for root in roots(made, name):
        if low <= root <= high and not any(_same(made, name, root, number) for number in found):
            yield root


def _same(made: Sheet, name: str, root: float, found: float) -> bool:
    """Whether they are one answer; angles are listed within one turn, and of one that is read in
    parts, as ``sin(y/3)``, no more."""
    if abs(root - found) <= SAME * abs(root):
        return True
    with mpmath.workdps(DIGITS):
        for turn in (mpmath.mpf(360), 2 * mpmath.pi):
            whole = mpmath.nint((mpmath.mpf(root) - found) / turn)
            if whole and abs(root - found - whole * turn) <= SAME * turn:
                return True
            if abs(root) > turn / 2 and _root_too(made, name, root, MANY * turn):
                return True
    return False


def _root_too(made: Sheet, name: str, root: float, change: Any) -> bool:
    try:
        return all(
            abs(
                evaluated(_miss(rule), {name: root + change}) - evaluated(_miss(rule), {name: root})
            )
            < SAME
            for rule in _asked(made, name, root)
        )
    except Undefined:
        return False


def roots(made: Sheet, name: str) -> list[float]:
    """Isolated roots of a rule that fulfil all the others, as the nearest floats; none that have no
    float."""
    points = sorted(set(_points(made, name)))
    found: list[float] = []
    for rule in made.rules:
        for root in _roots(_miss(rule), name, points):
            if any(abs(root - other) <= 1e-12 * abs(root) for other in found):
                continue
            near = (
                root,
                math.nextafter(root, -math.inf),
                math.nextafter(root, math.inf),
            )  # no float may be exact
            if all(rule in _asked(made, name, x) for x in near) and _fits(made, name, root):
                found.append(root)
    return found


def _points(made: Sheet, name: str) -> Iterator[float]:
    """Floats of every size and sign, special ones, those of the sheet, and their surroundings."""
    yield 0.0
    own = [abs(low_or_high) for pair in made.ranges.values() for low_or_high in pair]
    own += [abs(made.planted[name])] if made.planted else []
    sizes = [*SPECIAL, *own, *(10.0**k for k in DECADES), 1.7e308]
    near = [
        size * (1 + sign * 10.0**-k)
        for size in (*SPECIAL, *own)
        for sign in (1, -1)
        for k in (1, 6, 12)
    ]
    for size in (
        *sizes,
        *near,
        *(4.9 + 8.3 * k for k in range(50)),
        *(0.21 * k + 0.1 for k in range(30)),
    ):
        if size < math.inf:
            yield size
            yield -size


def _miss(rule: tuple[str, str, str]) -> str:
    return f"{rule[1]} - ({rule[2]})"


def _value(text: str, name: str, x: Any) -> Any:
    """None where there is no real value, or no float."""
    if abs(x) > LARGEST:
        return None
    try:
        return evaluated(text, {name: x})
    except Undefined:
        return None


def _roots(text: str, name: str, points: list[float]) -> Iterator[float]:
    values = [_value(text, name, x) for x in points]
    for x, y in zip(points, values, strict=True):
        if y == 0 and _isolated(text, name, x):
            yield x
    for k in range(len(points) - 1):
        here, there = values[k], values[k + 1]
        if here and there and (here < 0) != (there < 0):
            root = _bisected(text, name, points[k], points[k + 1])
            if root is not None:
                yield root


def _isolated(text: str, name: str, x: float) -> bool:
    """Whether what is 0 with 50 digits is so with many more, and not next to it."""
    try:
        if evaluated(text, {name: x}, 8 * DIGITS) != 0:
            return False
    except Undefined:
        return False
    aside = abs(x) * 1e-7 or 1e-30
    return all(_value(text, name, x + sign * aside) for sign in (1, -1))


def _bisected(text: str, name: str, low: Any, high: Any) -> float | None:
    """The float next to a change of sign; None at a pole, a jump, a hole, or beyond the floats."""
    below = _value(text, name, low) < 0
    while _order(high) - _order(low) > 1:
        middle = _float((_order(low) + _order(high)) // 2)
        y = _value(text, name, middle)
        if y is None:
            return None
        if y == 0:
            return middle if _isolated(text, name, middle) else None
        low, high = (middle, high) if (y < 0) == below else (low, middle)
    ends = float(low), float(high)
    if 0 < max(map(abs, ends)) <= SMALLEST:
        return None
    before = max(abs(_value(text, name, x)) for x in ends)
    for _ in range(60):
        with mpmath.workdps(3 * DIGITS):
            middle = (mpmath.mpf(low) + high) / 2
        y = _value(text, name, middle)
        if y is None:
            return None
        low, high = (middle, high) if (y < 0) == below else (low, middle)
    after = max(abs(_value(text, name, x)) for x in (low, high))
    return min(ends, key=lambda x: abs(x - low)) if after <= CONTINUOUS * before else None


def _order(x: float) -> int:
    """The place of a float among the floats."""
    bits: int = struct.unpack("<q", struct.pack("<d", abs(x)))[0]
    return -bits if x < 0 else bits


def _float(order: int) -> float:
    size: float = struct.unpack("<d", struct.pack("<q", abs(order)))[0]
    return -size if order < 0 else size


def _asked(made: Sheet, name: str, root: float) -> list[tuple[str, str, str]]:
    """The rules that apply there."""
    try:
        return [rule for rule in made.rules if not rule[0] or evaluated(rule[0], {name: root})]
    except Undefined:
        return []


def _fits(made: Sheet, name: str, root: float) -> bool:
    """Whether every rule holds there, or changes its sign within a few units of the last place."""
    for rule in _asked(made, name, root):
        around = [_value(_miss(rule), name, root * (1 + sign * ROUNDING)) for sign in (0, 1, -1)]
        if any(y is None for y in around[1:]) and around[0] != 0:
            return False
        if around[0] != 0 and (around[1] < 0) == (around[2] < 0):
            return False
    return True
