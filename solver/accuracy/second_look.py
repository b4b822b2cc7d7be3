"""A rule at an answer, to as many digits as it takes: for the witness, where floats cannot decide.

The values are the exact numbers that they are, π is π (``sin(pi)`` is 0), and nothing saturates
(``tanh(20)`` is less than 1). F is computed to two precisions, until they agree on it and it is larger than
what rounding makes of it; where not even the highest do, F vanishes there like that of an identity.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, Any

from rulesheets.deadline import expect_time
from rulesheets.evaluate import Undefined, extended, extended_derivatives
from rulesheets.functions.extended import context
from rulesheets.nodes import Sum, operands

if TYPE_CHECKING:
    from rulesheets.model import Equation, Value

DIGITS = (50, 100, 400, 800)
MOST = 1600
"""Digits that tell whether what only the most of these show is F, or rounding."""
AGREEMENT = 1e-6
"""Relative difference of two precisions that have some digits in common."""
UNIT = 2.0**-52
HALVINGS = 24
"""Bisections that tell a root, towards which F shrinks, from a pole or a jump."""
SPARE = 8
"""Digits of the working precision that rounding may take."""
SMALLEST = 2.0**-1022
"""The floats next to 0 are as far apart as those next to this number."""


@dataclass(frozen=True, slots=True)
class Sight:
    """``miss`` is F, and ``scaled`` is |F| / Σ|∂F/∂v · v|, both rounded to floats; nan where F has no value.

    ``reaches``: a change of one value by no more than a given share of it makes F vanish. ``digits``: how
    many it took to see that.
    """

    miss: float
    scaled: float
    reaches: bool
    digits: int = DIGITS[-1]


def look_again(
    equation: Equation, values: Mapping[str, Value], share: float, steep: float, noise: float
) -> Sight:
    """F of an equation of numbers at the ``values``.

    ``share`` is the change of them that is admitted. Where that takes F farther than a share ``steep`` of its
    sides no slope is believed: the others must suffice, or F must change its sign. ``noise`` bounds
    the error that floats make in F, if that is known.
    """
    look = _Look(equation, values)
    try:
        size = context(DIGITS[0]).mpf(noise) / UNIT if math.isfinite(noise) else look.largest(DIGITS[0])
        first = look.miss(DIGITS[0])
        for rough, fine in pairwise(DIGITS):
            some, more = look.miss(rough), look.miss(fine)
            clear = abs(more) > size * context(DIGITS[0]).mpf(10) ** (SPARE - rough)
            if clear and _agree(some, more):
                return _seen(look, more, fine, share, steep)
        if more and (_agree(some, more) or _agree(more, look.miss(MOST))):  # it is F, however small
            sight = _seen(look, more, DIGITS[-1], share, steep)
            if not sight.reaches:
                return sight
    except Undefined as error:
        reaches = not error.hole and look.reaches(share, DIGITS[-1])  # 0/0 may be anything beside 0
        return Sight(math.nan, 0.0 if reaches else math.inf, reaches)
    if abs(more) > size * context(DIGITS[0]).mpf(10) ** (SPARE - DIGITS[-1]):
        return _seen(look, more, DIGITS[-1], share, steep)  # cos(1e-265) is not 1, as only these digits show
    seen = max(abs(first), look.terms(DIGITS[0]))  # fifty digits may see exactly nothing already
    vanishes = abs(more) <= seen * context(DIGITS[0]).mpf(10) ** -DIGITS[0]  # a pole does not
    return Sight(0.0, 0.0, True) if vanishes and not look.drowned() else Sight(math.nan, math.inf, False)


def _agree(one: Any, other: Any) -> bool:
    return bool(abs(one - other) <= AGREEMENT * abs(other))


def _seen(look: _Look, miss: Any, digits: int, share: float, steep: float) -> Sight:
    try:
        gross = look.gross(digits)
        limit = steep * gross
        moves = look.moves(digits, limit / share)
        total = sum(map(abs, moves.values()))
        scaled = abs(miss) / total if total else math.inf
        some = sum(abs(move) for move in moves.values() if share * abs(move) <= limit)
        gentle = abs(miss) <= share * gross and (share * total <= limit or abs(miss) <= share * some)
        reaches = scaled <= share and (
            gentle or any(look.straddles(moves, 2 * t, digits) for t in (scaled, share, share / 1e3))
        )
    except Undefined:
        reaches = look.reaches(share, digits)
        return Sight(float(miss), 0.0 if reaches else math.inf, reaches, digits)
    return Sight(float(miss), float(scaled), bool(reaches), digits)


class _Look:
    def __init__(self, equation: Equation, values: Mapping[str, Value]) -> None:
        self.equation = equation
        self.values: dict[str, Any] = {name: values[name] for name in equation.names}

    def miss(self, digits: int, moved: Mapping[str, Any] | None = None) -> Any:
        """F at the values, some of them ``moved``. Raises Undefined."""
        expect_time()
        at = {**self.values, **(moved or {})}
        return extended(self.equation.left, at, digits) - extended(self.equation.right, at, digits)

    def gross(self, digits: int) -> Any:
        """The size of both sides. Raises Undefined."""
        return sum(abs(extended(s, self.values, digits)) for s in (self.equation.left, self.equation.right))

    def terms(self, digits: int) -> Any:
        """The size of what the sides add up. Raises Undefined."""
        sides = (self.equation.left, self.equation.right)
        terms = [term for side in sides for term in (side.terms if isinstance(side, Sum) else (side,))]
        return sum(abs(extended(term, self.values, digits)) for term in terms)

    def largest(self, digits: int) -> Any:
        """The size of the largest number that is added to others in F. Raises Undefined."""
        parts = terms = [self.equation.left, self.equation.right]
        while parts:
            inside = [(part, operands(part)) for part in parts]
            parts = [operand for _, found in inside for operand in found]
            terms = terms + [term for part, found in inside if isinstance(part, Sum) for term in found]
        return max(abs(extended(term, self.values, digits)) for term in terms)

    def moves(self, digits: int, limit: Any) -> dict[str, Any]:
        """∂F/∂v · |v| by variable; differences in their place where a slope has no value, or their sum is
        beyond the limit. Raises Undefined."""
        try:
            sides = self.equation.left, self.equation.right
            left, right = (extended_derivatives(side, self.values, digits)[1] for side in sides)
        except Undefined:
            return self.differences(digits)
        found = {n: (left.get(n, 0) - right.get(n, 0)) * size for n, _, size in self._numbers(digits)}
        return found if sum(map(abs, found.values())) <= limit else self.differences(digits)

    def differences(self, digits: int) -> dict[str, Any]:
        """Central differences in place of slopes, at a third of the digits. Raises Undefined."""
        step = context(digits).mpf(10) ** -(digits // 3)
        found = {}
        for name, number, size in self._numbers(digits):
            above, below = (self.miss(digits, {name: number + size * s}) for s in (step, -step))
            found[name] = (above - below) / (2 * step)
        return found

    def drowned(self) -> bool:
        """Whether F, which vanishes to all the digits, and with it its slopes, does so for want of more."""
        from solver.accuracy.drowned import drowned

        sides = self.equation.left, self.equation.right
        if not any(drowned(side, self.values, DIGITS[-1]) for side in sides):
            return False
        try:
            return not any(self.differences(DIGITS[-1]).values())
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
        """Whether F vanishes, or changes its sign, within a change of one value by that share of it, to so
        many digits: with fewer than F needs to be seen it vanishes everywhere.

        For where F has no slope, or no value: at the end of a domain.
        """
        moves = ((-share, -share / 1e3, 0.0), (share, share / 1e3, 0.0))  # what lies between them is no pole
        return any(
            self._vanishes(one, size, side, digits)
            for one, _, size in self._numbers(digits)
            for side in moves
        )

    def _vanishes(self, name: str, size: Any, changes: tuple[float, ...], digits: int) -> bool:
        """Whether F is 0 at one of these changes of a variable, or between two of them."""
        mp, found = context(digits), []
        for change in changes:
            at = mp.mpf(self.values[name]) + size * change
            try:
                found.append((at, self.miss(digits, {name: at})))
            except Undefined:
                continue
        return any(miss == 0 for _, miss in found) or any(
            self._meet(name, one, other, digits) for one, other in pairwise(found)
        )

    def _meet(self, name: str, one: tuple[Any, Any], other: tuple[Any, Any], digits: int) -> bool:
        """Whether F has a root between two points (value, F), and no pole or jump: it shrinks towards it."""
        (start, first), (end, last) = one, other
        if first * last > 0:
            return False
        largest = max(abs(first), abs(last))
        for _ in range(HALVINGS):
            middle = (start + end) / 2
            try:
                there = self.miss(digits, {name: middle})
            except Undefined:
                return False
            if there * first > 0:
                start, first = middle, there
            else:
                end, last = middle, there
        return bool(max(abs(first), abs(last)) * 2 ** (HALVINGS // 4) < largest)

    def _numbers(self, digits: int) -> Iterator[tuple[str, Any, Any]]:
        """The variables, their values, and the sizes of these."""
        mp = context(digits)
        for name, value in self.values.items():
            yield name, mp.mpf(value), mp.mpf(max(abs(value), SMALLEST))
