"""One equation solved for one unknown at given numbers: every preimage, or why there is none.

In many decimal digits (``PreciseStep``) nothing is clamped that floats would clamp for their rounding: a
target just inside an image keeps both of its preimages, and one just outside has none.
"""

from __future__ import annotations

import math
from bisect import bisect
from collections.abc import Mapping
from typing import Any, NamedTuple

from rulesheets.evaluate import Undefined, extended, rounded_derivatives
from rulesheets.evaluate.digits import context
from rulesheets.functions import TABLE
from rulesheets.model import Value
from rulesheets.syntax.nodes import Call, Expression, Name, Number, Power, Quotient
from solver.accuracy.digits import Unresolved
from solver.accuracy.rule_check import check_rule, sides
from solver.facts import AsksNothing, BeyondFloats, DoubleRoot, Fact, NoRoot, NoValue, OutOfRange
from solver.kernel.preimages import Preimages, Refused
from solver.numerics.tolerances import CANCELLED, DELICATE, EPS, SPARE
from solver.path.graph import ModelGraph, within_half_turns
from solver.path.isolate import Isolation, Stage

OTHERWISE = "another value of"
"""What a rule needs on which its unknown has no influence."""


class StepOutcome(NamedTuple):
    """``values``: the preimages, principal first; ``fact`` says why there is none, or none in particular.

    ``double``: two preimages coincide. ``delicate``: a target so near to the end of an image that rounding
    decides how many preimages there are.
    """

    values: tuple[Value, ...] = ()
    fact: Fact | None = None
    complete: bool = True
    double: DoubleRoot | None = None
    delicate: bool = False


class StepSolver(Preimages):
    """The preimages that satisfy the equation, in its range, to the last digits."""

    def outcome(self) -> StepOutcome:
        """All values of the unknown of the isolation that satisfy the equation at the known values."""
        unknown = self.isolation.unknown
        try:
            found = self.preimages()
        except Refused as refused:
            outcome = StepOutcome(fact=refused.fact, delicate=self.delicate)
        except Undefined as undefined:
            fact = BeyondFloats(self.index, unknown) if undefined.overflow else None
            delicate = undefined.overflow or self.delicate or self._on_the_edge(undefined)
            outcome = StepOutcome(
                fact=fact or NoValue(self.index, unknown, str(undefined)), delicate=delicate
            )
        else:
            if len(found) == 1 and isinstance(found[0], str):
                return StepOutcome((found[0],))
            outcome = self._kept([self._wrapped(v) for v in found if not isinstance(v, str)])
        return outcome if outcome.values or self.proven else self._unproven(outcome.delicate)

    def _unproven(self, delicate: bool) -> StepOutcome:
        fact = NoRoot((self.index,), (self.isolation.unknown,), proven=False)
        return StepOutcome(fact=fact, complete=False, delicate=delicate)

    def _on_the_edge(self, undefined: Undefined) -> bool:
        """Whether rounding may have led an operation out of its domain: to a pole, beyond an end."""
        match undefined.expression:
            case Call(function, arguments):
                ends = TABLE[function].domain
            case Quotient(_, divisor):
                arguments, ends = (divisor,), (0.0, 0.0)
            case Power(base, _):
                arguments, ends = (base,), (0.0, 0.0)
            case _:
                return False
        for argument in arguments:
            try:
                number, slopes, rounded = rounded_derivatives(argument, self.values)
            except (Undefined, KeyError):  # of what stands on the way to the unknown
                continue
            made_of = sum(abs(s * v) for n, s in slopes.items() if isinstance(v := self.values[n], float))
            exact = isinstance(argument, Name | Number)
            lost = number == 0.0 and rounded != 0.0  # for want of floats as small as it
            if lost or (not exact and any(abs(number - end) <= CANCELLED * made_of for end in ends)):
                return True
        return False

    def _wrapped(self, number: float) -> float:
        """An angle without a declared range is reported in (-180, 180]."""
        turn = self.graph.turn(self.isolation.unknown)
        bounded = self.variable.low > -math.inf or self.variable.high < math.inf
        if turn is None or bounded or not self.isolation.stages or self.isolation.period is None:
            return number
        return self._in_one_turn(number, turn)

    def _in_one_turn(self, number: float, turn: float) -> float:
        return within_half_turns(number, turn)

    def _kept(self, numbers: list[float]) -> StepOutcome:
        kept: list[float] = []
        ordered: list[float] = []  # of a long list only the neighbours need comparing
        outside: float | None = None
        lost = False
        for number in numbers:
            number = self._inside(self._polished(number))
            if not math.isfinite(number):
                lost = True
            elif not self.variable.admits(float(number)):
                outside = float(number)
            elif self._holds(number):
                place = bisect(ordered, number)
                beside, near = ordered[max(place - 1, 0) : place + 1], self._near(8 * EPS)
                if all(abs(number - v) > near * max(abs(number), abs(v)) for v in beside):
                    kept.append(number)
                    ordered.insert(place, number)
        if not kept:
            return self._refused(numbers, outside, lost)
        double: DoubleRoot | None = None
        kinks = any(stage.operation == "abs" for stage in self.isolation.stages)
        if len(kept) == 1 < self.isolation.branches and not kinks and self._slope(kept[0])[1] == 0.0:
            # where two preimages coincide, the equation does not change to first order
            unknown = self.isolation.unknown
            double = DoubleRoot((self.index,), (unknown,), {unknown: 1.0})
        complete, delicate = self.complete and not lost, self.delicate or double is not None
        return StepOutcome(tuple(kept), None, complete, double, delicate)

    def _refused(self, numbers: list[float], outside: float | None, lost: bool) -> StepOutcome:
        """Why none of these preimages is an answer."""
        unknown, delicate = self.isolation.unknown, self.delicate
        if outside is not None:
            lost = not check_rule(self.equation, self._floats(outside)).holds  # beside a larger number
            return StepOutcome(fact=OutOfRange(self.index, unknown, outside), delicate=delicate or lost)
        if self.isolation.verify and self._indifferent():
            return StepOutcome(fact=AsksNothing(self.index, unknown))
        for number in numbers:
            miss, slope = (None, 0.0) if lost else self._slope(number)
            # between two floats it may well hold, where one last place moves it farther than it misses by
            lost = lost or (miss is not None and abs(miss) <= abs(slope) * math.ulp(float(number)))
        if lost:
            return StepOutcome(fact=BeyondFloats(self.index, unknown), delicate=True)
        if not self.complete:
            return self._unproven(delicate)
        others = [name for name in self.equation.names if name != unknown]
        reading = f"{OTHERWISE} {' or '.join(others)}" if others else "other numbers"
        return StepOutcome(fact=NoValue(self.index, unknown, reading), delicate=delicate)

    def _inside(self, number: float) -> float:
        """The number; where rounding alone has led it beyond an end of its range, that end."""
        end = self.variable.nearest(float(number)) if math.isfinite(number) else number
        if end == float(number) or not check_rule(self.equation, self._floats(end)).holds:
            return number
        return end

    def _floats(self, number: float) -> dict[str, Value]:
        """The values in floats, with that of the unknown."""
        return {**self.floats, self.isolation.unknown: float(number)}

    def _holds(self, number: float) -> bool:
        if not (self.isolation.verify or self.clamped):
            return True
        check = check_rule(self.equation, self._floats(number))
        near = check.delicate or check.scaled <= DELICATE
        self.delicate = self.delicate or (near and not check.holds)
        return check.holds

    def _polished(self, number: float) -> float:
        """One or two Newton corrections in the equation as written, for the last digits of a long chain, or
        of a root: floats have no 1/1.5.
        """
        stages = self.isolation.stages
        takes_root = any(stage.operation in ("power", "root") for stage in stages)
        if len(stages) < 2 and self.isolation.quadratic is None and not takes_root:
            return number
        miss, slope = self._slope(number)
        for _ in range(2):
            if not miss or not slope or not math.isfinite(slope) or abs(miss) > 1e-6 * abs(slope * number):
                return number
            corrected = number - miss / slope
            better, slope = self._slope(corrected)
            if better is None or abs(better) >= abs(miss):
                return number
            number, miss = corrected, better
        return number

    def _slope(self, number: float) -> tuple[float | None, float]:
        """What the equation misses by in floats, and its slope along the unknown."""
        at = self._floats(number)
        try:
            left, right, slopes, _ = sides(self.equation, at)
        except Undefined:
            return None, 0.0
        return left - right, slopes.get(self.isolation.unknown, 0.0)


def exact_turn(turn: float, mp: Any) -> Any:
    """A period in all digits: 360 is itself, the float next to 2π stands for 2π."""
    halves = round(turn / math.pi)
    return halves * mp.pi if math.isclose(turn, halves * math.pi, rel_tol=1e-15) else mp.mpf(turn)


class PreciseStep(StepSolver):
    """The known ``values`` may be mpmath numbers, or floats, which are taken as exact."""

    def __init__(
        self,
        graph: ModelGraph,
        equation: int,
        isolation: Isolation,
        values: Mapping[str, Any],
        digits: int,
        guess: float | None = None,
    ) -> None:
        super().__init__(graph, equation, isolation, values, guess)
        self.digits, self.mp = digits, context(digits)
        self.floats = {n: v if isinstance(v, str) else float(v) for n, v in self.values.items()}

    def evaluate(self, expression: Expression, values: Mapping[str, Value]) -> Any:
        return extended(expression, values, self.digits)

    def _root(self, number: Any) -> Any:
        return self.mp.sqrt(number)

    def _near(self, share: float) -> float:
        return float(10.0 ** (SPARE - self.digits))

    def _cancels(self, expression: Expression, at: Mapping[str, Value]) -> bool:
        return False

    def _on_the_edge(self, undefined: Undefined) -> bool:
        return False

    def _in_image(self, stage: Stage, target: Any) -> Any:
        """Ends that no float holds (π/2) are left to the operation itself."""
        ends = [end for end in (stage.low, stage.high) if math.isfinite(end)]
        return super()._in_image(stage, target) if all(float(end).is_integer() for end in ends) else target

    def _turns(self, principal: Any, period: float, rest: tuple[Stage, ...]) -> list[Any]:
        return super()._turns(principal, exact_turn(period, self.mp), rest)

    def uncounted(self) -> None:
        raise Unresolved

    def _in_one_turn(self, number: Any, turn: float) -> Any:
        whole = exact_turn(turn, self.mp)
        wrapped = number - whole * self.mp.ceil(number / whole - 0.5)
        return wrapped + whole if float(wrapped) == -turn / 2 else wrapped

    def _polished(self, number: Any) -> Any:
        return number
