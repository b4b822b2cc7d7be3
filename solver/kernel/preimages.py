"""The stages of an isolated equation undone at given numbers, the outermost operation first."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from fractions import Fraction
from itertools import zip_longest

from rulesheets.evaluate import Undefined, derivatives, value
from rulesheets.evaluate.number import enclose, number_text
from rulesheets.model import Value, Variable
from rulesheets.syntax.nodes import Call, Expression, Name, Number, Quotient, Symbol
from solver.accuracy.rule_check import check_rule
from solver.facts import AsksNothing, Fact, NoRoot, NoValue
from solver.numerics.tolerances import CANCELLED, DELICATE, EPS
from solver.path.graph import ModelGraph
from solver.path.isolate import TARGET, Isolation, Quadratic, Stage, operand

MAX_TURNS = 2_000
LISTED_TURNS = 128
"""Turns either way of the one nearest to the principal one that are listed where there are too many."""
FEW_TURNS = 20
SIMPLE = 12
"""Numerator and denominator up to which a share of an angle is simple."""
SAME_TURN = 1e-12
"""Share of a turn that rounding may miss the beginning of a turn by."""
LOST = 1e-3
"""Share of a turn up to which rounding may tell turns apart."""
MOST = 1e300
"""Turns that a float can count."""


def is_scaled(rest: Sequence[Stage]) -> bool:
    """Whether an unknown is no angle, nor a simple share of one in degrees or radians, but what an angle is
    computed from: a time, a place, the day of a year."""
    scale = 1.0
    for stage in rest:
        if stage.operation in ("product", "quotient"):
            try:
                scale *= value(stage.forms[0], {TARGET.name: 1.0})
            except KeyError:  # it depends on other variables
                return True
    shares = (scale, scale * math.degrees(1.0), scale * math.radians(1.0))
    for share in shares:
        simple = Fraction(share).limit_denominator(SIMPLE)
        if abs(simple) <= SIMPLE and math.isclose(simple, share, rel_tol=SAME_TURN):
            return False
    return True


def is_affine(stage: Stage) -> bool:
    """Whether equal steps of the target are undone to equal steps of the operand."""
    return stage.operation in ("negative", "sum", "product", "quotient") and stage.divisor != TARGET


def _floor(turns: float) -> int:
    """All its digits, of a number of mpmath too (``math.floor`` takes the float next to it)."""
    whole = int(turns)
    return whole - 1 if whole > turns else whole


def _bounded(turns: float) -> float:
    """A number of turns, or the most that are looked at: a range may hold more than there are floats."""
    return min(max(turns, -MOST), MOST)


SAMPLES = (0.7310585786300049, -1.8393972058572117, 3.3219280948873626)
"""Where an equation is tried that may not depend on its unknown; no special points of anything."""


_NEEDS = {"square": "sqrt of", "power": "a root or logarithm of"}


class Refused(Exception):
    """A stage that has no preimage; carries the fact."""

    def __init__(self, fact: Fact) -> None:
        self.fact = fact


class Preimages:
    """What undoing the stages leads to, in floats; a subclass may have another arithmetic.

    ``proven``: formulas find all that there are. ``complete``: none was left out. ``clamped``: a target was
    moved to the end of an image. ``delicate``: rounding decides whether there is a preimage. ``floats`` are
    the known ``values`` in floats, for the check of rules. ``guess``: of the unknown, where many turns are
    answers.
    """

    def __init__(
        self,
        graph: ModelGraph,
        equation: int,
        isolation: Isolation,
        values: Mapping[str, Value],
        guess: float | None = None,
    ) -> None:
        self.graph, self.index, self.isolation, self.guess = graph, equation, isolation, guess
        self.equation = graph.model.equations[equation]
        self.values = {name: values[name] for name in self.equation.names if name in values}
        self.floats: dict[str, Value] = self.values
        self.variable: Variable = graph.model.variables[isolation.unknown]
        self.proven = self.complete = isolation.proven
        self.clamped = self.delicate = False

    def preimages(self) -> list[Value]:
        """Values of the unknown, principal first; raises :class:`Refused` or ``Undefined`` where none is."""
        isolation = self.isolation
        if isolation.quadratic is not None:
            return list(self._roots(isolation.quadratic))
        if isolation.identity and isinstance(isolation.start, Symbol):
            return [isolation.start.name]
        if isolation.identity and isinstance(isolation.start, Name):
            return [self.values[isolation.start.name]]
        return list(self._undo([self.evaluate(isolation.start, self.values)], isolation.stages))

    # --- the arithmetic ---

    def evaluate(self, expression: Expression, values: Mapping[str, Value]) -> float:
        return value(expression, values)

    def _root(self, number: float) -> float:
        return math.sqrt(number)

    def _near(self, share: float) -> float:
        """The relative error at which numbers are told apart where floats take ``share``."""
        return share

    def rounding(self, number: float) -> float:
        """How far a number may be off that was computed in one operation or two."""
        return self._near(EPS) * abs(number)

    # --- stages ---

    def reached(self, target: float, stages: tuple[Stage, ...]) -> list[float]:
        """What undoing stages leads to from a target; nothing where one of them refuses it."""
        try:
            return self._undo([target], stages)
        except (Refused, Undefined):
            return []

    def _undo(self, targets: list[float], stages: tuple[Stage, ...]) -> list[float]:
        for place, stage in enumerate(stages):
            found: list[float] = []
            refused: Exception | None = None
            for target in targets:
                try:
                    found += self._operands(stage, target, stages[place + 1 :])
                except (Refused, Undefined) as error:
                    refused = error
            if not found and refused is not None:
                raise refused
            targets = found
        return targets

    def _operands(self, stage: Stage, target: float, rest: tuple[Stage, ...]) -> list[float]:
        """What one operation has to be of, to come out as a target."""
        if (exponent := self._whole_exponent(stage, target)) is not None:
            return [exponent]
        at: dict[str, Value] = {**self.values, TARGET.name: self._in_image(stage, target)}
        self._divisible(stage, at)
        found: list[list[float]] = []
        for form in stage.forms:
            try:
                principal = self.evaluate(form, at)
            except Undefined as undefined:
                if len(stage.forms) == 1:
                    raise
                self.complete = self.complete and not undefined.overflow
                continue
            found.append([principal] if stage.period is None else self._turns(principal, stage.period, rest))
        # the first of each form, the second of each, …: who takes no more than some takes of every form
        return [number for some in zip_longest(*found) for number in some if number is not None]

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
            kind = _NEEDS.get(stage.operation, f"{stage.operation} =")
            reading = f"{kind} {number_text(float(target))}"  # such as sqrt of -3.2, cosd = 1.08
            if float(target) == edge:  # which only more digits tell from it
                reading += f" {'-' if target < edge else '+'} {number_text(float(off))}"
            raise Refused(NoValue(self.index, self.isolation.unknown, reading, pole=False))
        self.clamped = True
        return edge

    def _size(self) -> float:
        """How large the numbers are that the start of the chain was made of."""
        numbers = [abs(v) for n in self.equation.names if isinstance(v := self.values.get(n), float)]
        largest = max([1.0, *numbers])
        return largest * largest  # a power would raise where it overflows

    def _divisible(self, stage: Stage, at: dict[str, Value]) -> None:
        """Refuse a stage that divides by 0 with the target ``at`` hand."""
        if stage.divisor is None:
            return
        divisor = self.evaluate(stage.divisor, at)
        self.delicate = self.delicate or self._cancels(stage.divisor, at)
        if divisor != 0.0:
            return
        # what it divides; not a number where that is not asked: more digits tell a tiny divisor from 0 then
        unknown, form, dividend = self.isolation.unknown, stage.forms[0], 0.0
        if stage.operation == "quotient" and stage.divisor != TARGET:
            dividend = math.nan
        elif stage.operation == "power":
            dividend = self.evaluate(TARGET, at) - 1.0
        elif isinstance(form, Quotient):
            dividend = self.evaluate(form.left, at)
        if self._indifferent() or (dividend == 0.0 and not self.isolation.common):
            raise Refused(AsksNothing(self.index, unknown))
        self.delicate = self.delicate or not abs(dividend) > DELICATE * self._size()
        reading = f"0 times {unknown} = {number_text(float(dividend))}"
        if stage.operation != "product":
            reading = f"division by 0 for {unknown}"
        raise Refused(NoValue(self.index, unknown, reading, pole=True))

    def _indifferent(self) -> bool:
        """Whether the equation holds at different values of its unknown: it cancels."""
        tried = ({**self.floats, self.isolation.unknown: number} for number in SAMPLES)
        checks = [check for at in tried if (check := check_rule(self.equation, at)).miss is not None]
        return len(checks) > 1 and all(check.holds for check in checks)

    def _cancels(self, expression: Expression, at: Mapping[str, Value]) -> bool:
        """Whether an expression comes out as next to nothing of what it is made of, but not as 0."""
        if isinstance(expression, Name | Number):
            return False
        result, slopes = derivatives(expression, at)
        made_of = sum(abs(slope * v) for n, slope in slopes.items() if isinstance(v := at[n], float))
        return result != 0.0 and abs(result) <= CANCELLED * made_of

    def _whole_exponent(self, stage: Stage, target: float) -> float | None:
        """The only exponent that may take a negative base to a target: real powers of it have whole ones.
        None where the base has a logarithm."""
        match stage:
            case Stage("power", divisor=Call("ln", (base,))):
                number = self.evaluate(base, self.values)
                if number > 0.0:
                    return None
                if number == 0.0 and target == 1.0:
                    return 0.0
                if number in (0.0, -1.0) or target == 0.0:  # many, or none
                    self.proven = False
                    raise Refused(NoRoot((self.index,), (self.isolation.unknown,), proven=False))
                return float(round(math.log(abs(target)) / math.log(-number)))
            case _:
                return None

    # --- whole turns ---

    def _turns(self, principal: float, period: float, rest: tuple[Stage, ...]) -> list[float]:
        """The principal preimage and its whole turns that ``rest``, the stages still to undo, leads into the
        window of the unknown. Where some are left out, the list is no longer complete."""
        bent = next((place for place, stage in enumerate(rest) if not is_affine(stage)), None)
        if bent is None:
            counts = self._straight_turns(principal, period, rest)
        else:
            counts = self._bent_turns(principal, period, rest, bent)
        return [principal + k * period for k in sorted(counts, key=lambda k: (abs(k), k < 0))]

    def _straight_turns(self, principal: float, period: float, rest: tuple[Stage, ...]) -> Iterable[int]:
        """Where what is left to undo is affine: all turns in the declared range, else in one turn. An unknown
        that is itself the angle is looked for around 0 even where whole turns make a difference to others."""
        first = self._through(principal, rest)
        stride = self._through(principal + period, rest) - first
        size = abs(stride)
        if self.rounding(first) > LOST * size:
            self.uncounted()
        if EPS * abs(first) > LOST * size:
            self.complete = False  # floats next to such answers may not be good enough to be told
        low, high = self.variable.low, self.variable.high
        turn = self.graph.turn(self.isolation.unknown)
        bounded = low > -math.inf or high < math.inf
        if not (low > -math.inf and high < math.inf):
            self.complete = self.complete and turn is not None
            span = turn or size
            low, high = (low, low + span) if low > -math.inf else (high - span, high)
            if not bounded:
                low, high = -span / 2, span / 2
        if stride == 0 or not math.isfinite(stride):
            return (0,)
        if not (bounded or turn or not rest):
            if not is_scaled(rest):
                return (0,)
            # what an angle is a multiple of (a time, a place, a day of the year) is rather positive
            start = 0.0 if self.guess is None else self.guess - size / 2
            count = _floor(_bounded((first - start) / size + SAME_TURN))
            return (-count if stride > 0.0 else count,)
        begin, end = sorted(_bounded((x - first) / stride) for x in (low, high))
        counts = range(_floor(begin) - 1, 2 - _floor(-end))
        if counts.stop - counts.start > MAX_TURNS:
            self.complete = False
            nearest = min(max(0, counts.start), counts.stop)
            counts = range(nearest - LISTED_TURNS, nearest + LISTED_TURNS)
        slack = 1e-12 * size
        return [k for k in counts if low - slack <= first + k * stride <= high + slack]

    def _bent_turns(
        self, principal: float, period: float, rest: tuple[Stage, ...], bent: int
    ) -> Iterable[int]:
        """Where what is left to undo is not affine from stage ``bent`` on: all that the image of that stage
        admits, or that a finite range of the unknown can lead to; else the first of a few."""
        low, high = rest[bent].low, rest[bent].high
        if math.isfinite(low) and math.isfinite(high):
            foot = self._through(principal, rest[:bent])
            stride = self._through(principal + period, rest[:bent]) - foot
            slack = 1e-9 * max(abs(low), abs(high), abs(foot))
            ends = sorted(((low - slack - foot) / stride, (high + slack - foot) / stride)) if stride else []
            if ends and ends[1] - ends[0] <= MAX_TURNS:
                return range(-_floor(-ends[0]), _floor(ends[1]) + 1)
        low, high = self.variable.low, self.variable.high
        slack = 1e-9 * max(abs(low), abs(high))

        def leads_inside(count: int) -> bool:
            found = self.reached(principal + count * period, rest)
            return any(low - slack <= number <= high + slack for number in found)

        few = range(-FEW_TURNS, FEW_TURNS + 1)
        if not (math.isfinite(low) and math.isfinite(high)):
            self.complete = False
            return (next(filter(leads_inside, sorted(few, key=abs)), 0),)
        unknown, depth = self.isolation.unknown, len(self.isolation.stages) - len(rest)
        box = {n: (float(v), float(v)) for n, v in self.values.items() if not isinstance(v, str)}
        left = operand(self.equation.left, self.equation.right, unknown, depth)
        ends = [(end - principal) / period for end in enclose(left, {**box, unknown: (low, high)})]
        if not ends[1] - ends[0] <= MAX_TURNS:
            self.complete = False
            return filter(leads_inside, few)
        return filter(leads_inside, range(_floor(ends[0]), 1 - _floor(-ends[1])))

    def _through(self, target: float, stages: tuple[Stage, ...]) -> float:
        """The target with stages undone that have one preimage each."""
        for stage in stages:
            target = self.evaluate(stage.forms[0], {**self.values, TARGET.name: target})
        return target

    def uncounted(self) -> None:
        """Called where whole turns are lost beside the number that they are added to."""
        self.complete, self.delicate = False, True

    # --- quadratics ---

    def _roots(self, quadratic: Quadratic) -> list[float]:
        a, b, c = (self.evaluate(part, self.values) for part in (quadratic.a, quadratic.b, quadratic.c))
        unknown = self.isolation.unknown
        self.delicate = self._cancels(quadratic.a, self.values) or self._cancels(quadratic.b, self.values)
        if a == 0.0:
            if b == 0.0:
                fact = AsksNothing(self.index, unknown) if c == 0.0 else None
                reading = f"0 times {unknown} = {number_text(float(-c))}"
                raise Refused(fact or NoValue(self.index, unknown, reading, pole=True))
            return [-c / b]
        square, product = b * b, 4 * a * c
        discriminant = square - product
        if discriminant < 0.0:
            size = max(square, abs(product))
            self.delicate = self.delicate or -discriminant <= DELICATE * size
            if discriminant < -self._near(1e-9) * size:
                raise Refused(NoValue(self.index, unknown, f"sqrt of {number_text(float(discriminant))}"))
            discriminant, self.clamped = 0.0, True
        root = self._root(discriminant)
        q = -0.5 * (b - root if b < 0.0 else b + root)
        roots = [q / a, c / q if q else 0.0]
        return sorted(roots, reverse=True) if roots[0] != roots[1] else roots[:1]
