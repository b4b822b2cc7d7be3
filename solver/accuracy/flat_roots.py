"""How far a root of higher multiplicity may be off: as far as the rules hold along it.

Where two answers coincide the rules vary in the second order along the direction in which they do so,
and half of the digits are known. Where more do, the rules are flatter still. That is found out by going
along, ever farther, coming back to the curve by Gauss–Newton steps across the direction, and asking
the rule check.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from rulesheets.evaluate import Undefined, derivatives, value
from rulesheets.model import Equation, Value
from solver.accuracy.rule_check import check_rule

FIRST = 64.0
"""How much farther than at a double root the rules have to hold for it to be one of more."""
FACTOR = 4.0
FARTHEST = 1e-2
"""Beside the size of the unknowns."""
CORRECTIONS = 4


def flat_reach(
    equations: Sequence[Equation], values: Mapping[str, Value], direction: Mapping[str, float], reach: float
) -> float:
    """``reach``, in units of ``direction``, where the rules fail beyond it; else as far as they hold."""
    flat = _Flat(equations, values, direction)
    size = max((abs(float(values[name])) for name in direction), default=0.0) or 1.0
    if not flat.holds(FIRST * reach):
        return reach
    reach *= FIRST
    while reach < FARTHEST * size and flat.holds(reach):
        reach *= FACTOR
    return reach


class _Flat:
    def __init__(
        self, equations: Sequence[Equation], values: Mapping[str, Value], direction: Mapping[str, float]
    ) -> None:
        self.equations, self.values, self.direction = equations, dict(values), direction

    def holds(self, reach: float) -> bool:
        """Whether the rules hold at that distance, on either side."""
        return any(self._holds(sign * reach) for sign in (1.0, -1.0))

    def _holds(self, far: float) -> bool:
        there = dict(self.values)
        for name, part in self.direction.items():
            there[name] = float(there[name]) + far * part
        try:
            for _ in range(CORRECTIONS if len(self.direction) > 1 else 0):
                self._correct(there)
            return all(check_rule(equation, there).holds for equation in self.equations)
        except (Undefined, ArithmeticError):
            return False

    def _correct(self, there: dict[str, Value]) -> None:
        """One Gauss–Newton step, by no part along the direction."""
        from solver.numerics.linear_algebra import any_rank

        names = list(self.direction)
        sizes = [abs(number) or 1.0 for number in (float(self.values[name]) for name in names)]
        rows, misses = [[self.direction[name] for name in names]], [0.0]
        for equation in self.equations:
            left, right = (derivatives(side, there)[1] for side in (equation.left, equation.right))
            rows.append([left.get(name, 0.0) - right.get(name, 0.0) for name in names])
            misses.append(value(equation.right, there) - value(equation.left, there))
        for name, step in zip(names, any_rank(rows, sizes).solve(misses), strict=True):
            there[name] = float(there[name]) + step
