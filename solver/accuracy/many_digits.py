"""A rule at an answer in many digits: for the rule check, if floats cannot decide.

The values are the exact numbers that they are, π is π (``sin(pi)`` is 0), and nothing saturates
(``tanh(20)`` is less than 1). F is computed to two precisions, until they agree on it and it is larger than
its rounding; if not even the highest do, F vanishes there like that of an identity, unless an operation has
absorbed a term.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from itertools import pairwise
from typing import Any, NamedTuple

from rulesheets.deadline import expect_time
from rulesheets.evaluate import Undefined, extended, extended_derivatives
from rulesheets.evaluate.digits import context
from rulesheets.model import Equation, Value
from rulesheets.syntax.nodes import Call, Expression, Name, Power, Sum, children
from solver.numerics.tolerances import COMMON, EPS, PRECISIONS, SMALLEST_NORMAL, SPARE

HALVINGS = 24
"""Bisections that tell a root, towards which F shrinks, from a pole or a jump."""


class Residual(NamedTuple):
    """``miss`` is F, and ``scaled`` is |F| / Σ|∂F/∂v · v|, both rounded to floats; nan if F has no value.

    ``reaches``: a change of one value by no more than a given share of it makes F vanish.
    """

    miss: float
    scaled: float
    reaches: bool


def residual_in_many_digits(
    equation: Equation, values: Mapping[str, Value], share: float, steep: float, noise: float
) -> Residual:
    """F of an equation of numbers at the ``values``.

    ``share`` is the change of them that is admitted. If that takes F farther than a share ``steep`` of its
    sides, no slope is believed: the others must suffice, or F must change its sign. ``noise`` bounds the
    error that floats make in F, if that is known.
    """
    rule = _Rule(equation, values)
    power = context(PRECISIONS[0]).mpf(10)
    try:
        size = noise / EPS if SMALLEST_NORMAL < noise < math.inf else rule.largest(PRECISIONS[0])
        misses = [rule.miss(digits) for digits in PRECISIONS]
        for (rough, some), (fine, more) in pairwise(zip(PRECISIONS, misses, strict=True)):
            clear = abs(more) > size * power ** (SPARE - rough) or (more and fine == PRECISIONS[-1])
            if clear and abs(some - more) <= COMMON * abs(more):
                return _judged(rule, more, fine, share, steep)
        if abs(misses[-1]) > size * power ** (SPARE - PRECISIONS[-1]):
            return _judged(rule, misses[-1], PRECISIONS[-1], share, steep)
        seen = max(abs(misses[0]), rule.terms(PRECISIONS[0]))
    except Undefined as error:
        reaches = not error.hole and rule.reaches(share, PRECISIONS[-1])  # 0/0 may be anything beside 0
        return Residual(math.nan, 0.0 if reaches else math.inf, reaches)
    if abs(misses[-1]) <= seen * power ** -PRECISIONS[0] and not rule.absorbed():
        return Residual(0.0, 0.0, True)
    return Residual(math.nan, math.inf, False)


def _judged(rule: _Rule, miss: Any, digits: int, share: float, steep: float) -> Residual:
    try:
        gross = rule.gross(digits)
        limit = steep * gross
        moves = rule.moves(digits, limit / share)
        total = sum(map(abs, moves.values()))
        scaled = abs(miss) / total if total else math.inf
        some = sum(abs(move) for move in moves.values() if share * abs(move) <= limit)
        gentle = abs(miss) <= share * gross and (share * total <= limit or abs(miss) <= share * some)
        reaches = scaled <= share and (
            gentle or any(rule.straddles(moves, 2 * t, digits) for t in (scaled, share, share / 1e3))
        )
    except Undefined:
        reaches = rule.reaches(share, digits)
        return Residual(float(miss), 0.0 if reaches else math.inf, reaches)
    return Residual(float(miss), float(scaled), bool(reaches))


class _Rule:
    def __init__(self, equation: Equation, values: Mapping[str, Value]) -> None:
        self.sides = equation.left, equation.right
        self.values: dict[str, Any] = {name: values[name] for name in equation.names}

    def miss(self, digits: int, moved: Mapping[str, Any] | None = None) -> Any:
        """F at the values, some of them ``moved``. Raises Undefined."""
        expect_time()
        left, right = (extended(side, {**self.values, **(moved or {})}, digits) for side in self.sides)
        return left - right

    def gross(self, digits: int) -> Any:
        """The size of both sides. Raises Undefined."""
        return sum(abs(extended(side, self.values, digits)) for side in self.sides)

    def terms(self, digits: int) -> Any:
        """The size of what the sides add up. Raises Undefined."""
        terms = [term for side in self.sides for term in (side.terms if isinstance(side, Sum) else (side,))]
        return sum(abs(extended(term, self.values, digits)) for term in terms)

    def largest(self, digits: int) -> Any:
        """The size of the largest number that is added to others in F. Raises Undefined."""
        terms, parts = [*self.sides], [*self.sides]
        while parts:
            terms += [operand for part in parts if isinstance(part, Sum) for operand in children(part)]
            parts = [operand for part in parts for operand in children(part)]
        return max(abs(extended(term, self.values, digits)) for term in terms)

    def moves(self, digits: int, limit: Any) -> dict[str, Any]:
        """∂F/∂v · |v| by variable; central differences if a slope has no value, or their sum is beyond the
        limit. Raises Undefined."""
        try:
            left, right = (extended_derivatives(side, self.values, digits)[1] for side in self.sides)
        except Undefined:
            return self.differences(digits)
        found = {n: (left.get(n, 0) - right.get(n, 0)) * size for n, _, size in self._numbers(digits)}
        return found if sum(map(abs, found.values())) <= limit else self.differences(digits)

    def differences(self, digits: int) -> dict[str, Any]:
        """Central differences, at a third of the digits. Raises Undefined."""
        step = context(digits).mpf(10) ** -(digits // 3)
        found = {}
        for name, number, size in self._numbers(digits):
            above, below = (self.miss(digits, {name: number + size * s}) for s in (step, -step))
            found[name] = (above - below) / (2 * step)
        return found

    def absorbed(self) -> bool:
        """Whether F, which vanishes in all the digits, and with it its slopes, does so for want of more."""
        if not any(absorbs(side, self.values, PRECISIONS[-1]) for side in self.sides):
            return False
        try:
            return not any(self.differences(PRECISIONS[-1]).values())
        except Undefined:
            return False

    def straddles(self, moves: Mapping[str, Any], share: Any, digits: int) -> bool:
        """Whether F changes its sign as all values move along its slopes, and against them, by that share.
        Raises Undefined."""
        sign = context(digits).sign
        above, below = (
            self.miss(digits, {n: v + size * sign(moves[n]) * s for n, v, size in self._numbers(digits)})
            for s in (share, -share)
        )
        return bool(above >= 0 >= below)

    def reaches(self, share: float, digits: int) -> bool:
        """Whether F vanishes, or changes its sign without a pole, within a change of one value by that share:
        for where F has no slope, or no value, as at the end of a domain."""
        moves = ((-share, -share / 1e3, 0.0), (share, share / 1e3, 0.0))
        return any(
            self._vanishes(name, number, [size * change for change in changes], digits)
            for name, number, size in self._numbers(digits)
            for changes in moves
        )

    def _vanishes(self, name: str, number: Any, changes: list[Any], digits: int) -> bool:
        """Whether F is 0 at one of these changes of a variable, or between two of them."""
        found = [
            (change, miss)
            for c in changes
            if (miss := self._tried(name, change := number + c, digits)) is not None
        ]
        if any(miss == 0 for _, miss in found):
            return True
        return any(self._meet(name, one, other, digits) for one, other in pairwise(found))

    def _meet(self, name: str, one: tuple[Any, Any], other: tuple[Any, Any], digits: int) -> bool:
        """Whether F has a root between two points (value, F), and no pole or jump: it shrinks towards it."""
        largest = max(abs(one[1]), abs(other[1]))
        for _ in range(HALVINGS):
            middle = (one[0] + other[0]) / 2
            there = self._tried(name, middle, digits) if one[1] * other[1] <= 0 else None
            if there is None:
                return False
            one, other = ((middle, there), other) if there * one[1] > 0 else (one, (middle, there))
        return bool(max(abs(one[1]), abs(other[1])) * 2 ** (HALVINGS // 4) < largest)

    def _tried(self, name: str, number: Any, digits: int) -> Any | None:
        try:
            return self.miss(digits, {name: number})
        except Undefined:
            return None

    def _numbers(self, digits: int) -> Iterator[tuple[str, Any, Any]]:
        """The variables, their values, and the sizes of these."""
        mp = context(digits)
        for name, value in self.values.items():
            yield name, mp.mpf(value), mp.mpf(max(abs(value), SMALLEST_NORMAL))


# --- true equality told from a residual below the working precision ---
#
# ``erf(x) = 1`` is satisfied by no number, ``exp(-x^2) + 1 = 1`` by none; at 1e100 they miss by less than any
# digits show. If both sides agree in all of these, what tells is whether an operation lost an operand: a term
# beside a larger one, a slope beside the value that it leads away from.


def absorbs(expression: Expression, values: Mapping[str, Any], digits: int) -> bool:
    """Whether some operation of an expression loses all of one operand at the values, in that many digits."""
    stack: list[Any] = [expression]
    while stack:
        node = stack.pop()
        try:
            match node:
                case Sum(terms) if _absorbs([extended(term, values, digits) for term in terms], digits):
                    return True
                case Call(_, (operand,)) if _saturates(node, extended(operand, values, digits), digits):
                    return True
                case Call("atan2" | "atan2d", sides) if _absorbs(
                    [extended(side, values, digits) for side in sides], digits
                ):
                    return True
                case Power(base, exponent) if _next_to_one(
                    extended(base, values, digits), extended(exponent, values, digits), digits
                ):
                    return True
        except Undefined:
            continue
        finally:
            stack.extend(children(node))
    return False


def _absorbs(terms: list[Any], digits: int) -> bool:
    """Whether a term is not 0, and nothing beside the largest."""
    sizes = [abs(term) for term in terms if term]
    return len(sizes) > 1 and min(sizes) < max(sizes) * _nothing(digits)


def _next_to_one(base: Any, exponent: Any, digits: int) -> bool:
    """Whether a power is not 1, and nothing beside 1 tells it from that."""
    return bool(base > 0 and 0 < abs(exponent * context(digits).log(base)) < _nothing(digits))


def _saturates(call: Call, at: Any, digits: int) -> bool:
    """Whether a function goes on changing there, but by nothing beside its value."""
    argument = Name("0")
    result, slopes = extended_derivatives(Call(call.function, (argument,)), {argument.name: at}, digits)
    move = abs(slopes[argument.name] * at)
    flat = call.function == "tanh" and abs(result) == 1  # its slope is computed as 1 - tanh^2
    return bool(flat or 0 < move < abs(result) * _nothing(digits))


def _nothing(digits: int) -> Any:
    return context(digits).mpf(10) ** (SPARE - digits)
