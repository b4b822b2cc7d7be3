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
from collections.abc import Mapping
from contextlib import suppress

from rulesheets.evaluate import Undefined, value
from rulesheets.model import Equation, Value
from rulesheets.syntax.nodes import names
from solver.accuracy.rule_sides import (
    RuleCheck,
    gross,
    heights,
    jumps,
    leads_to_zero,
    moves_of,
    remembered,
    sides,
    symbol_of,
)
from solver.numerics.tolerances import BACKWARD, EPS, ROUNDINGS, STEEP

LEAP = 4.0
"""How many times as far as a rule's slopes ask for its values are moved to see whether it jumps
there."""


def check_rule(equation: Equation, values: Mapping[str, Value]) -> RuleCheck:
    """Evaluate an equation all of whose variables have values."""
    kept = remembered(equation, values)
    if kept.check is None:
        found = _by_slopes(equation, values)
        if found.holds and found.miss is not None and jumps(equation) and _leaps(equation, values):
            found = RuleCheck(False, found.miss, found.scaled)
        kept.check = found
    return kept.check


def _by_slopes(equation: Equation, values: Mapping[str, Value]) -> RuleCheck:
    left, right = equation.left, equation.right
    symbols = symbol_of(left, values), symbol_of(right, values)
    if symbols != (None, None):
        same = symbols[0] == symbols[1]
        return RuleCheck(same, None, 0.0 if same else math.inf)
    try:
        a, b, slopes, noise = sides(equation, values)
    except Undefined as error:
        underflow = 0.0 in error.arguments  # a divisor, or what a logarithm is taken of
        if error.overflow or underflow:
            from solver.accuracy.rule_in_digits import look_again

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
    from solver.accuracy.rule_in_digits import RuleInDigits, look_again  # floats mostly decide

    with suppress(Undefined):
        slight = small and bound <= STEEP * gross(equation, values)
        if slight and RuleInDigits(equation, values).straddles(slopes, 2 * BACKWARD):
            return RuleCheck(True, miss, scaled)
    return look_again(equation, values, noise)


def _leaps(equation: Equation, values: Mapping[str, Value]) -> bool:
    """Whether F jumps where its slopes promise 0: ``int(x) + x = 3`` is satisfied neither below 2,
    nor at 2."""
    from solver.accuracy.rule_in_digits import DIGITS, RuleInDigits

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
