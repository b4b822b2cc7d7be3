"""One equation solved for one unknown at given numbers: every preimage, or why there is none."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping

from rulesheets.evaluate import Undefined, derivatives, value
from rulesheets.evaluate.number import number_text
from rulesheets.model import Value, Variable
from rulesheets.nodes import Call, Expression, Name, Number, Quotient, Symbol
from rulesheets.record import dataclass
from solver.facts import AsksNothing, BeyondFloats, DoubleRoot, Fact, NoRoot, NoValue, OutOfRange
from solver.kernel.exponents import exponents
from solver.path.graph import ModelGraph
from solver.path.isolate import TARGET, Isolation, Quadratic, Stage, operand
from solver.witness import gross, testify

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

MAX_TURNS = 2_000
LISTED_TURNS = 128
"""Turns either way that are listed where there are too many to list all."""
FEW_TURNS = 20
AROUND = 3
PLACES = (0.0, 0.31, 0.69, 1.0)
"""Shares of a finite range that holds too many whole turns: so many are looked for around each."""
EPSILON = 2.0**-52
SAMPLES = (0.7310585786300049, -1.8393972058572117, 3.3219280948873626)
"""Where an equation is tried that may not depend on its unknown; no special points of anything."""
DELICATE = 1e-6
"""How far beyond the end of an image a target may lie for the distance to be no more than lost digits."""

CANCELLED = 1e-12
"""Share of what a number is made of that may be no more than what cancellation has left of its rounding."""


@dataclass(frozen=True, slots=True)
class StepOutcome:
    """``values``: the preimages, principal first; ``fact`` says why there is none, or none in particular.

    ``double``: two preimages coincide. ``delicate``: a target so near to the end of an image that rounding
    decides how many preimages there are.
    """

    values: tuple[Value, ...] = ()
    fact: Fact | None = None
    complete: bool = True
    double: DoubleRoot | None = None
    delicate: bool = False


def solve_step(
    graph: ModelGraph, equation: int, isolation: Isolation, values: Mapping[str, Value]
) -> StepOutcome:
    """All values of the unknown of ``isolation`` that satisfy the equation at the known ``values``."""
    return StepSolver(graph, equation, isolation, values).outcome()


class _Refused(Exception):
    """A stage that has no preimage; carries the fact."""

    def __init__(self, fact: Fact) -> None:
        self.fact = fact


class StepSolver:
    """The preimages in floats; a subclass may have another arithmetic."""

    def __init__(
        self, graph: ModelGraph, equation: int, isolation: Isolation, values: Mapping[str, Value]
    ) -> None:
        self.graph, self.index, self.isolation = graph, equation, isolation
        self.equation = graph.model.equations[equation]
        self.values = {name: values[name] for name in self.equation.names if name in values}
        self.variable: Variable = graph.model.variables[isolation.unknown]
        self.complete = True
        self.clamped = self.delicate = False

    def outcome(self) -> StepOutcome:
        try:
            found = self._raw()
        except _Refused as refused:
            return StepOutcome(fact=refused.fact, delicate=self.delicate)
        except Undefined as undefined:
            unknown = self.isolation.unknown
            if undefined.overflow:
                return StepOutcome(fact=BeyondFloats(self.index, unknown), delicate=True)
            return StepOutcome(fact=NoValue(self.index, unknown, str(undefined)))
        if len(found) == 1 and isinstance(found[0], str):
            return StepOutcome((found[0],))
        return self._kept([self._wrapped(v) for v in found if not isinstance(v, str)])

    # --- the arithmetic ---

    def _value(self, expression: Expression, values: Mapping[str, Value]) -> float:
        return value(expression, values)

    def _root(self, number: float) -> float:
        return math.sqrt(number)

    def _near(self, share: float) -> float:
        """The relative error at which numbers are told apart where floats take ``share``."""
        return share

    def _raw(self) -> list[Value]:
        isolation = self.isolation
        if isolation.quadratic is not None:
            return list(self._roots(isolation.quadratic))
        if isolation.identity and isinstance(isolation.start, Symbol):
            return [isolation.start.name]
        if isolation.identity and isinstance(isolation.start, Name):
            return [self.values[isolation.start.name]]
        targets = [self._value(isolation.start, self.values)]
        for place, stage in enumerate(isolation.stages):
            targets = self._undo(stage, targets, isolation.stages[place + 1 :])
        return list(targets)

    # --- stages ---

    def _undo(self, stage: Stage, targets: list[float], rest: tuple[Stage, ...]) -> list[float]:
        found: list[float] = []
        refused: Exception | None = None
        for target in targets:
            try:
                if (base := self._base(stage)) is not None:
                    found.extend(self._exponents(base, target))
                    continue
                inside = self._in_image(stage, target)
                self._divisible(stage, inside)
                for form in stage.forms:
                    found.extend(self._form(stage, form, inside, rest))
            except (_Refused, Undefined) as error:
                refused = error
        if not found and refused is not None:
            raise refused
        return found

    def _form(self, stage: Stage, form: Expression, target: float, rest: tuple[Stage, ...]) -> list[float]:
        try:
            principal = self._value(form, {**self.values, TARGET.name: target})
        except Undefined as undefined:
            if form is stage.forms[-1] and len(stage.forms) == 1:
                raise
            self.complete = self.complete and not undefined.overflow
            return []
        if stage.period is None:
            return [principal]
        return self._turns(principal, stage.period, rest)

    def _in_image(self, stage: Stage, target: float) -> float:
        """The target, moved to the end of the image if it lies outside; verification has the last word."""
        low, high = stage.low, stage.high
        if low < target < high or (target == low and not stage.low_open):
            return target
        if target == high and not stage.high_open:
            return target
        edge, is_open = (low, stage.low_open) if target <= low else (high, stage.high_open)
        off = abs(target - edge)
        self.delicate = self.delicate or off <= DELICATE * self._size()
        if is_open or off > self._near(1e-9) * self._size():
            reading = _reading(stage.operation, float(target))
            raise _Refused(NoValue(self.index, self.isolation.unknown, reading, pole=False))
        self.clamped = True
        return edge

    def _size(self) -> float:
        """How large the numbers are that the start of the chain was made of."""
        numbers = [abs(v) for n in self.equation.names if isinstance(v := self.values.get(n), float)]
        largest = max([1.0, *numbers])
        return largest * largest  # a power would raise where it overflows

    def _divisible(self, stage: Stage, target: float) -> None:
        if stage.divisor is None:
            return
        at = {**self.values, TARGET.name: target}
        divisor = self._value(stage.divisor, at)
        self.delicate = self.delicate or self._cancels(stage.divisor, at)
        if divisor != 0.0:
            return
        unknown = self.isolation.unknown
        dividend = self._dividend(stage, target)
        if dividend == 0.0 or self._holds_anyway():
            raise _Refused(AsksNothing(self.index, unknown))
        self.delicate = self.delicate or abs(dividend) <= DELICATE * self._size()
        reading = f"0 times {unknown} = {number_text(float(dividend))}"
        if stage.operation != "product":
            reading = f"division by 0 for {unknown}"
        raise _Refused(NoValue(self.index, unknown, reading, pole=True))

    def _cancels(self, expression: Expression, at: Mapping[str, Value]) -> bool:
        """Whether an expression comes out as next to nothing of what it is made of, but not as 0."""
        if isinstance(expression, Name | Number):
            return False
        result, slopes = derivatives(expression, at)
        made_of = sum(abs(slope * v) for n, slope in slopes.items() if isinstance(v := at[n], float))
        return result != 0.0 and abs(result) <= CANCELLED * made_of

    def _dividend(self, stage: Stage, target: float) -> float:
        """What a vanishing divisor divides: where it is 0 too, the equation holds whatever the unknown is."""
        form = stage.forms[0]
        if stage.operation == "quotient" and stage.divisor != TARGET:
            return math.nan
        if stage.operation == "power":
            return target - 1.0
        if isinstance(form, Quotient):
            return self._value(form.left, {**self.values, TARGET.name: target})
        return 0.0

    def _holds_anyway(self) -> bool:
        """Whether the equation holds for different values of the unknown: one that it does not depend on."""
        known: dict[str, Value] = {n: v if isinstance(v, str) else float(v) for n, v in self.values.items()}
        unknown = self.isolation.unknown
        return all(testify(self.equation, {**known, unknown: number}).holds for number in SAMPLES)

    # --- exponents ---

    def _base(self, stage: Stage) -> float | None:
        """The base of a power whose exponent is asked for, where it is not positive and has no logarithm."""
        match stage:
            case Stage("power", divisor=Call("ln", (base,))):
                number = self._value(base, self.values)
                return None if number > 0.0 else number
            case _:
                return None

    def _exponents(self, base: float, target: float) -> tuple[float, ...]:
        unknown, found = self.isolation.unknown, exponents(base, target)
        if found.anything:
            raise _Refused(AsksNothing(self.index, unknown))
        if not found.values:
            reading = f"a power of {number_text(float(base))} to be {number_text(float(target))}"
            raise _Refused(NoValue(self.index, unknown, reading))
        self.complete = self.complete and found.complete
        return found.values

    # --- whole turns ---

    def _turns(self, principal: float, period: float, rest: tuple[Stage, ...]) -> list[float]:
        """The principal preimage and its whole turns within the window of the unknown."""
        bent = next((place for place, stage in enumerate(rest) if not _affine(stage)), None)
        if bent is not None:
            return self._bent_turns(principal, period, rest, bent)
        first, second = self._through(principal, rest), self._through(principal + period, rest)
        stride = second - first
        window = self._window(stride, bare=not rest)
        if window is None or stride == 0 or not math.isfinite(stride):
            return [principal]
        low, high = window
        ends = sorted(((low - first) / stride, (high - first) / stride))
        counts = range(math.floor(ends[0]) - 1, math.ceil(ends[1]) + 2)
        if counts.stop - counts.start > MAX_TURNS:
            self.complete = False
            counts = range(-LISTED_TURNS, LISTED_TURNS)
        slack = 1e-12 * abs(stride)
        inside = [k for k in counts if low - slack <= first + k * stride <= high + slack]
        return [principal + k * period for k in sorted(inside, key=lambda k: (abs(k), k < 0))]

    def _bent_turns(self, principal: float, period: float, rest: tuple[Stage, ...], bent: int) -> list[float]:
        """Whole turns where what is left to undo is not affine from stage ``bent`` on: all that the image of
        that stage admits, or that a finite range of the unknown can lead to. Where both are infinite, or hold
        too many turns, a few.
        """
        low, high = rest[bent].low, rest[bent].high
        if math.isfinite(low) and math.isfinite(high):
            foot = self._through(principal, rest[:bent])
            stride = self._through(principal + period, rest[:bent]) - foot
            slack = 1e-9 * max(abs(low), abs(high), abs(foot))
            ends = sorted(((low - slack - foot) / stride, (high + slack - foot) / stride)) if stride else []
            if ends and ends[1] - ends[0] <= MAX_TURNS:
                turns = range(math.ceil(ends[0]), math.floor(ends[1]) + 1)
                return [principal + k * period for k in sorted(turns, key=abs)]
        if not (math.isfinite(self.variable.low) and math.isfinite(self.variable.high)):
            self.complete = False
            near = (principal + k * period for k in sorted(range(-FEW_TURNS, FEW_TURNS + 1), key=abs))
            return [next((turn for turn in near if self._leads_inside(turn, rest)), principal)]
        low, high = self._range_of_operand(rest)
        first, last = (low - principal) / period, (high - principal) / period
        if last - first <= MAX_TURNS:
            counts = set(range(math.floor(first), math.ceil(last) + 1))
        else:
            self.complete = False
            middles = (round((x - principal) / period) for x in self._operands(rest))
            counts = {m + k for m in (0, *middles) for k in range(-AROUND, AROUND + 1)}
        inside = [k for k in counts if self._leads_inside(principal + k * period, rest)]
        return [principal + k * period for k in sorted(inside, key=lambda k: (abs(k), k < 0))]

    def _operands(self, rest: tuple[Stage, ...]) -> Iterator[float]:
        """What the stages ``rest`` are still to undo, at places all over the finite range of the unknown."""
        part, low, high = self._operand(rest), self.variable.low, self.variable.high
        for share in PLACES:
            try:
                yield self._value(part, {**self.values, self.isolation.unknown: low + share * (high - low)})
            except Undefined:
                continue

    def _operand(self, rest: tuple[Stage, ...]) -> Expression:
        depth = len(self.isolation.stages) - len(rest)
        return operand(self.equation.left, self.equation.right, self.isolation.unknown, depth)

    def _range_of_operand(self, rest: tuple[Stage, ...]) -> tuple[float, float]:
        """Bounds of what the stages ``rest`` are still to undo, over the finite range of the unknown."""
        import numpy as np

        from rulesheets.evaluate.enclosure import enclose

        unknown, part = self.isolation.unknown, self._operand(rest)
        boxes: dict[str, Any] = {
            name: (float(v), float(v)) for name, v in self.values.items() if not isinstance(v, str)
        }
        boxes[unknown] = np.array([self.variable.low]), np.array([self.variable.high])
        with np.errstate(all="ignore"):
            low, high = enclose(part, boxes)
        bounds = float(np.min(low)), float(np.max(high))
        return (-math.inf, math.inf) if any(map(math.isnan, bounds)) else bounds

    def _leads_inside(self, target: float, rest: tuple[Stage, ...]) -> bool:
        """Whether some preimage of the stages left over lies in the range of the unknown, or near it."""
        try:
            found = [target]
            for place, stage in enumerate(rest):
                found = self._undo(stage, found, rest[place + 1 :])
        except (_Refused, Undefined):
            return False
        low, high = self.variable.low, self.variable.high
        slack = 1e-9 * max(abs(low), abs(high))
        return any(low - slack <= number <= high + slack for number in found)

    def _window(self, stride: float, bare: bool) -> tuple[float, float] | None:
        """Where to look for whole turns: the declared range, else one turn. None: the principal one only.

        ``bare``: the unknown itself is the angle; then it is looked for in the turn around 0 even
        where whole turns make a difference to other rules.
        """
        low, high = self.variable.low, self.variable.high
        if low > -math.inf and high < math.inf:
            return low, high
        turn = self.graph.turn(self.isolation.unknown)
        self.complete = self.complete and turn is not None
        span = turn or abs(stride)
        if low > -math.inf:
            return low, low + span
        if high < math.inf:
            return high - span, high
        return (-span / 2, span / 2) if turn or bare else None

    def _through(self, target: float, rest: tuple[Stage, ...]) -> float:
        for stage in rest:
            target = self._value(stage.forms[0], {**self.values, TARGET.name: target})
        return target

    def _wrapped(self, number: float) -> float:
        """An angle without a declared range is reported in (-180, 180]."""
        turn = self.graph.turn(self.isolation.unknown)
        bounded = self.variable.low > -math.inf or self.variable.high < math.inf
        if turn is None or bounded or not self.isolation.stages or self.isolation.period is None:
            return number
        wrapped = math.remainder(number, turn) if abs(number) > turn / 2 else number
        return turn / 2 if wrapped == -turn / 2 else wrapped

    # --- quadratics ---

    def _roots(self, quadratic: Quadratic) -> list[float]:
        a, b, c = (self._value(part, self.values) for part in (quadratic.a, quadratic.b, quadratic.c))
        unknown = self.isolation.unknown
        self.delicate = self._cancels(quadratic.a, self.values) or self._cancels(quadratic.b, self.values)
        if a == 0.0:
            if b == 0.0:
                fact = AsksNothing(self.index, unknown) if c == 0.0 else None
                reading = f"0 times {unknown} = {number_text(float(-c))}"
                raise _Refused(fact or NoValue(self.index, unknown, reading, pole=True))
            return [-c / b]
        discriminant = b * b - 4 * a * c
        if discriminant < 0.0:
            self.delicate = self.delicate or -discriminant <= DELICATE * max(b * b, abs(4 * a * c))
            if discriminant < -self._near(1e-9) * max(b * b, abs(4 * a * c)):
                raise _Refused(NoValue(self.index, unknown, f"sqrt of {number_text(float(discriminant))}"))
            discriminant, self.clamped = 0.0, True
        root = self._root(discriminant)
        q = -0.5 * (b - root if b < 0.0 else b + root)
        roots = [q / a, c / q if q else 0.0]
        principal = sorted(roots, reverse=a > 0) if roots[0] != roots[1] else roots[:1]
        return sorted(principal, reverse=True)

    # --- what is kept ---

    def _kept(self, numbers: list[float]) -> StepOutcome:
        kept: list[float] = []
        outside: float | None = None
        lost = False
        for number in numbers:
            number = self._inside(self._polished(number))
            if not math.isfinite(number):
                lost = True
            elif not self.variable.admits(float(number)):
                outside = float(number)
            elif self._holds(number) and not any(self._same(number, other) for other in kept):
                kept.append(number)
        if kept:
            double = self._double(kept[0]) if len(kept) == 1 < self.isolation.branches else None
            complete, delicate = self.complete and not lost, self.delicate or double is not None
            return StepOutcome(tuple(kept), None, complete, double, delicate)
        unknown = self.isolation.unknown
        if outside is not None:
            return StepOutcome(fact=OutOfRange(self.index, unknown, outside), delicate=self.delicate)
        if self.isolation.verify and self._indifferent():
            return StepOutcome(fact=AsksNothing(self.index, unknown))
        if lost:
            return StepOutcome(fact=BeyondFloats(self.index, unknown), delicate=True)
        if not self.complete:
            fact = NoRoot((self.index,), (unknown,), proven=False)
            return StepOutcome(fact=fact, complete=False, delicate=self.delicate)
        last = self.isolation.stages[0].operation if self.isolation.stages else "equation"
        reading = f"{last} to come out otherwise"
        return StepOutcome(fact=NoValue(self.index, unknown, reading), delicate=self.delicate)

    def _inside(self, number: float) -> float:
        """The number; where rounding alone has led it beyond an end of its range, that end."""
        end = self.variable.nearest(float(number)) if math.isfinite(number) else number
        if end == float(number) or not testify(self.equation, self._floats(end)).holds:
            return number
        return end

    def _floats(self, number: float) -> dict[str, Value]:
        """The values in floats, with that of the unknown."""
        return {**self.values, self.isolation.unknown: number}

    def _indifferent(self) -> bool:
        """Whether the equation holds to rounding wherever it is tried: its unknown cancels."""
        unknown, tried = self.isolation.unknown, 0
        for number in SAMPLES:
            at = {**self.values, unknown: number}
            try:
                miss = value(self.equation.left, at) - value(self.equation.right, at)
            except Undefined:
                continue
            if not abs(miss) <= 8 * EPSILON * gross(self.equation, at):
                return False
            tried += 1
        return tried >= 2

    def _double(self, number: float) -> DoubleRoot | None:
        """Where two preimages coincide, the equation does not change to first order. (A kink does.)"""
        if any(stage.operation == "abs" for stage in self.isolation.stages):
            return None
        unknown = self.isolation.unknown
        return (
            DoubleRoot((self.index,), (unknown,), {unknown: 1.0}) if self._slope(number)[1] == 0.0 else None
        )

    def _same(self, a: float, b: float) -> bool:
        return abs(a - b) <= self._near(8 * 2.0**-52) * max(abs(a), abs(b))

    def _holds(self, number: float) -> bool:
        if not (self.isolation.verify or self.clamped):
            return True
        testimony = testify(self.equation, {**self.values, self.isolation.unknown: number})
        self.delicate = self.delicate or (testimony.delicate and not testimony.holds)
        return testimony.holds

    def _polished(self, number: float) -> float:
        """One or two Newton corrections in the equation as written, for the last digits of a long chain."""
        if len(self.isolation.stages) < 2 and self.isolation.quadratic is None:
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
        unknown = self.isolation.unknown
        at = {**self.values, unknown: number}
        try:
            left, by_left = derivatives(self.equation.left, at)
            right, by_right = derivatives(self.equation.right, at)
        except Undefined:
            return None, 0.0
        return left - right, by_left.get(unknown, 0.0) - by_right.get(unknown, 0.0)


def _affine(stage: Stage) -> bool:
    """Whether equal steps of the target are undone to equal steps of the operand."""
    return stage.operation in ("negative", "sum", "product", "quotient") and stage.divisor != TARGET


def _reading(operation: str, target: float) -> str:
    """What a stage would need: ``sqrt of -3.2``, ``cosd = 1.08``."""
    if operation == "square":
        return f"sqrt of {number_text(target)}"
    if operation == "power":
        return f"a root or logarithm of {number_text(target)}"
    return f"{operation} = {number_text(target)}"
