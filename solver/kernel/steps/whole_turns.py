"""The preimages of a periodic function: the principal one and its whole turns in the range of the unknown."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING

from rulesheets.evaluate import Undefined
from rulesheets.nodes import Expression
from solver.path.isolate import TARGET, Stage, operand

if TYPE_CHECKING:
    from solver.kernel.steps.preimages import Preimages

EPSILON = 2.0**-52
MAX_TURNS = 2_000
LISTED_TURNS = 128
"""Turns either way of the one nearest to the principal one that are listed where there are too many."""
FEW_TURNS = 20
AROUND = 3
PLACES = (0.0, 0.31, 0.69, 1.0)
"""Shares of a finite range that holds too many whole turns: so many are looked for around each."""
LOST = 1e-3
"""Share of a turn up to which rounding may tell turns apart."""
MOST = 1e300
"""Turns that a float can count."""


def whole_turns(
    preimages: Preimages, principal: float, period: float, rest: tuple[Stage, ...]
) -> list[float]:
    """The principal preimage and its whole turns that ``rest``, the stages still to undo, leads into the
    window of the unknown. Where some are left out, ``preimages`` is no longer complete.
    """
    bent = next((place for place, stage in enumerate(rest) if not _affine(stage)), None)
    turns = _WholeTurns(preimages, principal, period, rest)
    return turns.straight() if bent is None else turns.bent(bent)


def _affine(stage: Stage) -> bool:
    """Whether equal steps of the target are undone to equal steps of the operand."""
    return stage.operation in ("negative", "sum", "product", "quotient") and stage.divisor != TARGET


class _WholeTurns:
    def __init__(
        self, preimages: Preimages, principal: float, period: float, rest: tuple[Stage, ...]
    ) -> None:
        self.preimages, self.principal, self.period, self.rest = preimages, principal, period, rest
        self.unknown, self.variable = preimages.isolation.unknown, preimages.variable

    def straight(self) -> list[float]:
        """Where what is left to undo is affine: all turns in the window."""
        first = self._through(self.principal, self.rest)
        stride = self._through(self.principal + self.period, self.rest) - first
        if self.preimages.rounding(first) > LOST * abs(stride):
            self.preimages.uncounted()
        if EPSILON * abs(first) > LOST * abs(stride):
            self.preimages.complete = (
                False  # the floats next to such answers need not be good enough to be told
            )
        window = self._window(stride)
        if window is None or stride == 0 or not math.isfinite(stride):
            return [self.principal]
        low, high = window
        start, end = sorted(_bounded((x - first) / stride) for x in (low, high))
        counts = range(_floor(start) - 1, 2 - _floor(-end))
        if counts.stop - counts.start > MAX_TURNS:
            self.preimages.complete = False
            nearest = min(max(0, counts.start), counts.stop)
            counts = range(nearest - LISTED_TURNS, nearest + LISTED_TURNS)
        slack = 1e-12 * abs(stride)
        inside = [k for k in counts if low - slack <= first + k * stride <= high + slack]
        return [self._turn(k) for k in sorted(inside, key=lambda k: (abs(k), k < 0))]

    def bent(self, bent: int) -> list[float]:
        """Where what is left to undo is not affine from stage ``bent`` on: all that the image of that stage
        admits, or that a finite range of the unknown can lead to. Where both are infinite, or hold too many
        turns, a few.
        """
        low, high = self.rest[bent].low, self.rest[bent].high
        if math.isfinite(low) and math.isfinite(high):
            foot = self._through(self.principal, self.rest[:bent])
            stride = self._through(self.principal + self.period, self.rest[:bent]) - foot
            slack = 1e-9 * max(abs(low), abs(high), abs(foot))
            ends = sorted(((low - slack - foot) / stride, (high + slack - foot) / stride)) if stride else []
            if ends and ends[1] - ends[0] <= MAX_TURNS:
                return [self._turn(k) for k in sorted(range(-_floor(-ends[0]), _floor(ends[1]) + 1), key=abs)]
        if not (math.isfinite(self.variable.low) and math.isfinite(self.variable.high)):
            self.preimages.complete = False
            near = (self._turn(k) for k in sorted(range(-FEW_TURNS, FEW_TURNS + 1), key=abs))
            return [next((turn for turn in near if self._leads_inside(turn)), self.principal)]
        low, high = self._range_of_operand()
        first, last = (low - self.principal) / self.period, (high - self.principal) / self.period
        if last - first <= MAX_TURNS:
            tried = set(range(_floor(first), 1 - _floor(-last)))
        else:
            self.preimages.complete = False
            middles = (round(_bounded((x - self.principal) / self.period)) for x in self._operands())
            tried = {m + k for m in (0, *middles) for k in range(-AROUND, AROUND + 1)}
        inside = [k for k in tried if self._leads_inside(self._turn(k))]
        return [self._turn(k) for k in sorted(inside, key=lambda k: (abs(k), k < 0))]

    def _turn(self, count: int) -> float:
        return self.principal + count * self.period

    def _through(self, target: float, stages: tuple[Stage, ...]) -> float:
        """The target with stages undone that have one preimage each."""
        for stage in stages:
            known = {**self.preimages.values, TARGET.name: target}
            target = self.preimages.evaluate(stage.forms[0], known)
        return target

    def _window(self, stride: float) -> tuple[float, float] | None:
        """Where to look for whole turns: the declared range, else one turn. None: the principal one only.

        An unknown that is itself the angle is looked for in the turn around 0 even where whole turns make
        a difference to other rules.
        """
        low, high = self.variable.low, self.variable.high
        if low > -math.inf and high < math.inf:
            return low, high
        turn = self.preimages.graph.turn(self.unknown)
        self.preimages.complete = self.preimages.complete and turn is not None
        span = turn or abs(stride)
        if low > -math.inf:
            return low, low + span
        if high < math.inf:
            return high - span, high
        return (-span / 2, span / 2) if turn or not self.rest else None

    def _operands(self) -> Iterator[float]:
        """What is still to undo, at places all over the finite range of the unknown."""
        part, low, high = self._operand, self.variable.low, self.variable.high
        for share in PLACES:
            known = {**self.preimages.values, self.unknown: low + share * (high - low)}
            try:
                yield self.preimages.evaluate(part, known)
            except Undefined:
                continue

    @property
    def _operand(self) -> Expression:
        isolation, equation = self.preimages.isolation, self.preimages.equation
        depth = len(isolation.stages) - len(self.rest)
        return operand(equation.left, equation.right, self.unknown, depth)

    def _range_of_operand(self) -> tuple[float, float]:
        """Bounds of what is still to undo, over the finite range of the unknown."""
        from rulesheets.evaluate.enclosure import enclose

        known = self.preimages.values
        box = {n: (float(v), float(v)) for n, v in known.items() if not isinstance(v, str)}
        bounds = enclose(self._operand, {**box, self.unknown: (self.variable.low, self.variable.high)})
        return (-math.inf, math.inf) if any(map(math.isnan, bounds)) else bounds

    def _leads_inside(self, target: float) -> bool:
        """Whether some preimage of what is left to undo lies in the range of the unknown, or near it."""
        found = self.preimages.reached(target, self.rest)
        low, high = self.variable.low, self.variable.high
        slack = 1e-9 * max(abs(low), abs(high))
        return any(low - slack <= number <= high + slack for number in found)


def _floor(turns: float) -> int:
    """All its digits, of a number of mpmath too (``math.floor`` takes the float next to it)."""
    whole = int(turns)
    return whole - 1 if whole > turns else whole


def _bounded(turns: float) -> float:
    """A number of turns, or the most that are looked at: a range may hold more than there are floats."""
    return min(max(turns, -MOST), MOST)
