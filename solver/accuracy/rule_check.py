"""The independent check: does a rule, as written, hold at an answer?

A rule holds if its backward error is small: |F| ≤ 64 eps · Σ|∂F/∂v · v| over its variables, that
is, if values within a few ulp of those reported satisfy it exactly. If the rounding of its own
evaluation may have produced F (``cosd(x + 90)`` at a small x), or hidden it (``tanh(x) = 1`` at
20), F and its slopes are evaluated again to as many digits as needed. If F changes a lot within so
small a change, slopes alone are not sufficient (``cosd(x) = 2`` at 1e90): the other values must
explain the residual, or F must change its sign there. They are not sufficient next to a jump either
(``int(x) + x = 3`` below 2), as the values that they predict may lie beyond it. ``check_rule``
decides for one rule; ``alike.accepted`` tells of many rules at once which hold clearly, and
compiled programs do so for rows.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from contextlib import suppress
from copy import copy
from itertools import pairwise
from typing import Any

from rulesheets.deadline import expect_time
from rulesheets.evaluate import Undefined, value
from rulesheets.evaluate.digits import context, extended, extended_derivatives
from rulesheets.model import Equation, Values
from rulesheets.syntax.nodes import Call, Expression, Name, Power, Sum, names, terms, walk
from solver.accuracy.rule_sides import (
    RuleCheck,
    gross,
    heights,
    jumps,
    leads_to_zero,
    moves_of,
    passed_end,
    remembered,
    sides,
    symbol_of,
    with_named_numbers,
)
from solver.numerics.tolerances import (
    BACKWARD,
    CANCELLED,
    COMMON,
    EPS,
    PRECISIONS,
    ROUNDINGS,
    SMALLEST_NORMAL,
    SPARE,
    STEEP,
)

LEAP = 4.0
"""How many times as far as a rule's slopes ask for its values are moved to see whether it jumps
there."""


def check_rule(equation: Equation, values: Values) -> RuleCheck:
    """Evaluate an equation all of whose variables have values."""
    kept = remembered(equation, values)
    if kept.check is None:
        found = _by_slopes(equation, values)
        if found.holds and found.miss is not None and jumps(equation) and _leaps(equation, values):
            found = RuleCheck(False, found.miss, found.scaled, delicate=True)
        if not found.holds and jumps(equation) and _is_met(equation, values):
            found = RuleCheck(True, 0.0)
        kept.check = found
    return kept.check


def _is_met(equation: Equation, values: Values) -> bool:
    """Whether a rule with jumps holds with the decimals as written: ``n = int(0.57*100)`` at
    57."""
    from rulesheets.evaluate.exact import as_written, value_as_written  # of rules that jump

    return value_as_written(equation.form, lambda name: as_written(values[name])) == 0


def _by_slopes(equation: Equation, values: Values) -> RuleCheck:
    left, right = equation.sides
    symbols = symbol_of(left, values), symbol_of(right, values)
    if symbols != (None, None):
        same = symbols[0] == symbols[1]
        return RuleCheck(same, None, 0.0 if same else math.inf)
    try:
        a, b, slopes, noise = sides(equation, values)
    except Undefined as error:
        underflow = 0.0 in error.arguments  # a divisor, or what a logarithm is taken of
        if error.overflow or underflow or passed_end(error, values, CANCELLED):
            return look_again(equation, values, math.inf)
        return RuleCheck(False, None, math.inf)
    miss, off = a - b, abs(a - b) + noise
    if off == 0.0:
        return RuleCheck(True, miss)
    moves, both = list(moves_of(slopes, values)), abs(a) + abs(b)
    total = sum(moves)
    bound, scaled = BACKWARD * total, abs(miss) / total if total else math.inf
    small = off <= bound < math.inf
    if small and leads_to_zero(abs(miss), off, moves, both):
        return RuleCheck(True, miss, scaled)
    if abs(miss) > bound + ROUNDINGS * noise:
        return RuleCheck(False, miss, scaled)
    with suppress(Undefined):
        slight = small and bound <= STEEP * gross(equation, values)
        if slight and RuleInDigits(equation, values).straddles(slopes, 2 * BACKWARD):
            return RuleCheck(True, miss, scaled)
    return look_again(equation, values, noise)


def _leaps(equation: Equation, values: Values) -> bool:
    """Whether F jumps where its slopes promise 0: ``int(x) + x = 3`` is satisfied neither below 2,
    nor at 2."""
    tied = {name for _, height in heights(equation) for name in names(height)}
    try:
        left, right, slopes, _ = sides(equation, values)
        miss = float(RuleInDigits(equation, values).miss(DIGITS))
        moves = {n: s * abs(v) for n, s in slopes.items() if isinstance(v := values[n], float)}
        total = sum(map(abs, moves.values()))
        if abs(miss) <= BACKWARD * sum(abs(move) for n, move in moves.items() if n not in tied):
            return False  # it is 0, or the other values make up for it
        moved, share = dict(values), LEAP * max(abs(miss) / total if total else 0.0, EPS)
        for name, move in moves.items():
            if move:
                number = float(values[name])
                moved[name] = number - math.copysign(share * abs(number), move * miss)
        there = value(equation.left, moved) - value(equation.right, moved)
    except Undefined:
        return False
    return abs(there) > 4 * LEAP * (abs(miss) + EPS * (abs(left) + abs(right) + total))


# --- in many digits, if floats cannot decide ---
#
# The values are the exact numbers that they are, π is π (``sin(pi)`` is 0), and nothing saturates
# (``tanh(20)`` is less than 1). F is computed to two precisions, until they agree on it and it is
# larger than its rounding; if not even the highest do, F vanishes there like that of an identity,
# unless an operation has absorbed a term.

DIGITS = 50
BENT_OVER = 2.0**-10
"""Share of a value by which it is moved to see how a rule bends."""
HALVINGS = 24
"""Bisections that tell a root, towards which F shrinks, from a pole or a jump."""


def in_decimals(
    expressions: Iterable[Expression], values: Mapping[str, Any]
) -> tuple[tuple[Expression, ...], dict[str, Any]]:
    """Expressions and values with numbers as decimals: the shortest ones for their floats.

    0.1 is a tenth there. Values with more digits than floats stay.
    """
    numbers: dict[str, float] = {}
    named = tuple(with_named_numbers(expression, numbers) for expression in expressions)
    exact, known = context(PRECISIONS[-1]).mpf, {**values, **numbers}
    return named, {name: exact(repr(v)) if isinstance(v, float) else v for name, v in known.items()}


def look_again(equation: Equation, values: Values, noise: float) -> RuleCheck:
    """The check of an equation of numbers; ``noise`` bounds the error of F in floats, if known.

    Values may change by a share BACKWARD. If that changes F by more than a share STEEP of its
    sides, no slope is trusted: the others must suffice, or F must change its sign.
    """
    if not all(
        isinstance(v := values[name], float) and math.isfinite(v) for name in equation.names
    ):
        return RuleCheck(False, None, math.inf)
    rule, rough, fine = RuleInDigits(equation, values), PRECISIONS[0], PRECISIONS[-1]
    power = context(rough).mpf(10)
    try:
        size = noise / EPS if SMALLEST_NORMAL < noise < math.inf else rule.largest(rough)
        misses = [rule.miss(rough)]
        for some, more in pairwise(PRECISIONS):
            found, agreed = misses[-1], rule.miss(more)
            misses.append(agreed)
            clear = abs(agreed) > size * power ** (SPARE - some) or (agreed and more == fine)
            if clear and abs(found - agreed) <= COMMON * abs(agreed):
                return rule.judged(agreed, more)
        if abs(misses[-1]) > size * power ** (SPARE - fine):
            return rule.judged(misses[-1], fine)
        added = (abs(extended(term, values, rough)) for term in terms(*rule.sides))
        seen = max(abs(misses[0]), sum(added))
    except Undefined as error:
        reaches = not error.hole and rule.reaches(fine)  # 0/0 may be anything beside 0
        return RuleCheck(reaches, None, 0.0 if reaches else math.inf, True)
    # what operations absorb need not be as small
    rule.underflows = size * power**-fine < SMALLEST_NORMAL
    if abs(misses[-1]) <= seen * power**-rough and not rule.absorbed():
        return RuleCheck(True, 0.0, 0.0, True)
    return RuleCheck(False, None, math.inf, True)


class RuleInDigits:
    def __init__(self, equation: Equation, values: Values) -> None:
        self.sides: tuple[Expression, ...] = equation.sides
        self.values: dict[str, Any] = {name: values[name] for name in equation.names}
        self.underflows = True

    def miss(self, digits: int, moved: Mapping[str, Any] | None = None) -> Any:
        """F at the values, some of them ``moved``. Raises Undefined."""
        expect_time()
        left, right = (
            extended(side, {**self.values, **(moved or {})}, digits) for side in self.sides
        )
        return left - right

    def largest(self, digits: int) -> Any:
        """The size of the largest number that is added to others in F. Raises Undefined."""
        added = [term for part in walk(*self.sides) if isinstance(part, Sum) for term in part.terms]
        return max(abs(extended(term, self.values, digits)) for term in (*self.sides, *added))

    def judged(self, miss: Any, digits: int) -> RuleCheck:
        """Whether F, which is ``miss``, vanishes within a small enough change of the values."""
        shown = number if math.isfinite(number := float(miss)) else None
        self.underflows = abs(miss) < SMALLEST_NORMAL
        try:
            gross = sum(abs(extended(side, self.values, digits)) for side in self.sides)
            moves = self.moves(digits, STEEP * gross / BACKWARD)
            sizes = [*map(abs, moves.values())]
            scaled = abs(miss) / sum(sizes) if any(sizes) else math.inf
            reaches = scaled <= BACKWARD and (
                leads_to_zero(abs(miss), abs(miss), sizes, gross)
                or any(
                    self.straddles(moves, 2 * t, digits) for t in (scaled, BACKWARD, BACKWARD / 1e3)
                )
            )
        except Undefined:
            reaches = self.reaches(digits)
            scaled = 0.0 if reaches else math.inf
        with suppress(Undefined):
            if not reaches and self.in_decimals().vanishes(digits):
                reaches, scaled = True, min(scaled, BACKWARD)
        return RuleCheck(bool(reaches), shown, float(scaled), True)

    def moves(self, digits: int, limit: Any) -> dict[str, Any]:
        """∂F/∂v · |v| by variable; central differences if a slope has no value, or their sum
        exceeds the limit. Raises Undefined."""
        with suppress(Undefined):
            left, right = (
                extended_derivatives(side, self.values, digits)[1] for side in self.sides
            )
            found = {
                n: (left.get(n, 0) - right.get(n, 0)) * size for n, _, size in self._numbers(digits)
            }
            if sum(map(abs, found.values())) <= limit:
                return found
        return self.differences(digits)

    def differences(self, digits: int) -> dict[str, Any]:
        """Central differences, at a third of the digits. Raises Undefined."""
        step = context(digits).mpf(10) ** -(digits // 3)
        found = {}
        for name, number, size in self._numbers(digits):
            above, below = (self.miss(digits, {name: number + size * s}) for s in (step, -step))
            found[name] = (above - below) / (2 * step)
        return found

    def absorbed(self) -> bool:
        """Whether F, and with it its slopes, vanishes in all the digits only because there are too
        few."""
        with suppress(Undefined):
            lost = any(absorbs(side, self.values, PRECISIONS[-1]) for side in self.sides)
            return lost and not any(self.differences(PRECISIONS[-1]).values())
        return False

    def straddles(self, moves: Mapping[str, Any], share: Any, digits: int = DIGITS) -> bool:
        """Whether F changes sign as all values move along its slopes, and against them, by that
        share. Raises Undefined."""
        sign = context(digits).sign
        above, below = (
            self.miss(
                digits, {n: v + size * sign(moves[n]) * s for n, v, size in self._numbers(digits)}
            )
            for s in (share, -share)
        )
        return bool(above >= 0 >= below)

    def reaches(self, digits: int) -> bool:
        """Whether F vanishes, or changes its sign without a pole, within a small enough change of
        one value: for points at which F has no slope, or no value, as at the end of a domain."""
        for name, number, size in self._numbers(digits):
            for share in (-BACKWARD, BACKWARD):
                tried = [number + size * change for change in (share, share / 1e3, 0.0)]
                found = [(at, self._tried(name, at, digits)) for at in tried]
                if any(miss == 0 for _, miss in found):
                    return True
                if any(self._meet(name, one, other, digits) for one, other in pairwise(found)):
                    return True
        return False

    def in_decimals(self) -> RuleInDigits:
        """The rule in decimals. It counts if no value moves F: as the exponent of (-0.2)^x, or x at
        the double root of x^2 - 1.72*x + 0.7396."""
        rule = copy(self)
        rule.sides, rule.values = in_decimals(self.sides, self.values)
        return rule

    def vanishes(self, digits: int) -> bool:
        """Whether F is 0, up to terms beyond slopes, as one value changes by a share BACKWARD: at a
        root of any multiplicity it changes as far as the value does. Raises Undefined."""
        miss, bends = self.miss(digits), 0
        for name, number, size in self._numbers(digits):
            above, below = (
                self._tried(name, number + size * s, digits) for s in (BENT_OVER, -BENT_OVER)
            )
            if above is not None and below is not None:
                bends = max(
                    bends, max(abs(above + below - 2 * miss), abs(above - below)) / BENT_OVER**2
                )
        most = max(abs(extended(term, self.values, digits)) for term in terms(*self.sides))
        return abs(miss) <= BACKWARD**2 * min(bends, most) and not self.absorbed()

    def _meet(self, name: str, one: tuple[Any, Any], other: tuple[Any, Any], digits: int) -> bool:
        """Whether F has a root between two points (value, F), not a pole or a jump; or shrinks to 0
        towards the end of its domain, beyond which it is None."""
        if one[1] is None:
            one, other = other, one
        if one[1] is None or (other[1] is not None and one[1] * other[1] > 0):
            return False
        ends, largest = other[1] is None, max(abs(one[1]), abs(other[1] or 0))
        halvings = 8 * HALVINGS if ends else HALVINGS  # F may be flat there, as a square root
        for _ in range(halvings):
            middle = (one[0] + other[0]) / 2
            there = self._tried(name, middle, digits)
            if there is None and not ends:
                return False
            if there is not None and there * one[1] > 0:
                one = middle, there
            else:
                other = middle, there
                ends = there is None
        return bool(max(abs(one[1]), abs(other[1] or 0)) * 2 ** (halvings // 4) < largest)

    def _tried(self, name: str, number: Any, digits: int) -> Any | None:
        with suppress(Undefined):
            return self.miss(digits, {name: number})
        return None

    def _numbers(self, digits: int) -> Iterator[tuple[str, Any, Any]]:
        """The variables, their values, and the sizes of these: 0 stands for an underflow only if F
        underflows, too."""
        mp = context(digits)
        for name, number in self.values.items():
            least = SMALLEST_NORMAL if number or self.underflows else 0.0
            yield name, mp.mpf(number), mp.mpf(max(abs(number), least))


# --- true equality told from a residual below the working precision ---
#
# ``erf(x) = 1`` is satisfied by no number, ``exp(-x^2) + 1 = 1`` by none; at 1e100 they miss by
# less than any digits show. If both sides agree in all of these, what tells is whether an operation
# lost an operand: a term beside a larger one, a slope beside the value that it leads away from.


def absorbs(expression: Expression, values: Mapping[str, Any], digits: int) -> bool:
    """Whether some operation of an expression loses all of one operand at the values, in that many
    digits."""
    nothing = context(digits).mpf(10) ** (SPARE - digits)
    for node in walk(expression):
        lost = False
        with suppress(Undefined):
            # one that is nothing beside the largest
            # it goes on changing, but by nothing beside its value
            match node:
                case Sum(parts) | Call("atan2" | "atan2d", parts):
                    numbers = [extended(part, values, digits) for part in parts]
                    sizes = [abs(number) for number in numbers if number]
                    lost = len(sizes) > 1 and min(sizes) < max(sizes) * nothing
                case Call(function, (operand,)):
                    argument, at = Name("0"), extended(operand, values, digits)
                    call = Call(function, (argument,))
                    result, slopes = extended_derivatives(call, {argument.name: at}, digits)
                    # its slope is computed as 1 - tanh^2
                    flat = function == "tanh" and abs(result) == 1
                    lost = flat or 0 < abs(slopes[argument.name] * at) < abs(result) * nothing
                case Power(base, exponent):  # not 1, and nothing beside 1 tells it from that
                    root, power = (extended(part, values, digits) for part in (base, exponent))
                    lost = root > 0 and 0 < abs(power * context(digits).log(root)) < nothing
        if lost:
            return True
    return False
