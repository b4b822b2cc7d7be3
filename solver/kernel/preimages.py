"""The stages of an isolated equation undone at given numbers, the outermost operation first."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
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


class _WholeTurns:
    """The principal preimage and its whole turns that ``rest``, the stages still to undo, leads into the
    window of the unknown. Where some are left out, ``preimages`` is no longer complete.
    """

    def __init__(
        self, preimages: Preimages, principal: float, period: float, rest: tuple[Stage, ...]
    ) -> None:
        self.preimages, self.principal, self.period, self.rest = preimages, principal, period, rest
        self.unknown, self.variable = preimages.isolation.unknown, preimages.variable

    def all(self) -> list[float]:
        bent = next((place for place, stage in enumerate(self.rest) if not is_affine(stage)), None)
        return self.straight() if bent is None else self.bent(bent)

    def straight(self) -> list[float]:
        """Where what is left to undo is affine: all turns in the window."""
        first = self._through(self.principal, self.rest)
        stride = self._through(self.principal + self.period, self.rest) - first
        if self.preimages.rounding(first) > LOST * abs(stride):
            self.preimages.uncounted()
        if EPS * abs(first) > LOST * abs(stride):
            self.preimages.complete = False  # floats next to such answers may not be good enough to be told
        window = self._window(stride)
        if stride == 0 or not math.isfinite(stride):
            return [self.principal]
        if window is None:
            return [self._turn(self._usual(first, stride) if is_scaled(self.rest) else 0)]
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
            tried = set(range(-FEW_TURNS, FEW_TURNS + 1))
        inside = [k for k in tried if self._leads_inside(self._turn(k))]
        return [self._turn(k) for k in sorted(inside, key=lambda k: (abs(k), k < 0))]

    def _usual(self, first: float, stride: float) -> int:
        """The turn in the period around the guess, else in the first one from 0: what an angle is a multiple
        of (a time, a place, a day of the year) is rather positive."""
        guess, size = self.preimages.guess, abs(stride)
        low = 0.0 if guess is None else guess - size / 2
        count = _floor(_bounded((first - low) / size + SAME_TURN))
        return -count if stride > 0.0 else count

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

    def _range_of_operand(self) -> tuple[float, float]:
        """Bounds of what is still to undo, over the finite range of the unknown."""
        isolation, equation = self.preimages.isolation, self.preimages.equation
        depth = len(isolation.stages) - len(self.rest)
        left = operand(equation.left, equation.right, self.unknown, depth)
        known = self.preimages.values
        box = {n: (float(v), float(v)) for n, v in known.items() if not isinstance(v, str)}
        bounds = enclose(left, {**box, self.unknown: (self.variable.low, self.variable.high)})
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


SAMPLES = (0.7310585786300049, -1.8393972058572117, 3.3219280948873626)
"""Where an equation is tried that may not depend on its unknown; no special points of anything."""


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
        inside = self._in_image(stage, target)
        self._divisible(stage, inside)
        # the first of each form, the second of each, …: who takes no more than some takes of every form
        turns = zip_longest(*(self._form(stage, form, inside, rest) for form in stage.forms))
        return [number for some in turns for number in some if number is not None]

    def _form(self, stage: Stage, form: Expression, target: float, rest: tuple[Stage, ...]) -> list[float]:
        try:
            principal = self.evaluate(form, {**self.values, TARGET.name: target})
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

    def _divisible(self, stage: Stage, target: float) -> None:
        if stage.divisor is None:
            return
        at = {**self.values, TARGET.name: target}
        divisor = self.evaluate(stage.divisor, at)
        self.delicate = self.delicate or self._cancels(stage.divisor, at)
        if divisor != 0.0:
            return
        unknown = self.isolation.unknown
        dividend = self._dividend(stage, target)
        # where the equation holds for different values of the unknown, it does not depend on it
        tried = ({**self.floats, unknown: number} for number in SAMPLES)
        anyway = all(check_rule(self.equation, at).holds for at in tried)
        if anyway or (dividend == 0.0 and not self.isolation.common):
            raise Refused(AsksNothing(self.index, unknown))
        self.delicate = self.delicate or not abs(dividend) > DELICATE * self._size()
        reading = f"0 times {unknown} = {number_text(float(dividend))}"
        if stage.operation != "product":
            reading = f"division by 0 for {unknown}"
        raise Refused(NoValue(self.index, unknown, reading, pole=True))

    def _cancels(self, expression: Expression, at: Mapping[str, Value]) -> bool:
        """Whether an expression comes out as next to nothing of what it is made of, but not as 0."""
        if isinstance(expression, Name | Number):
            return False
        result, slopes = derivatives(expression, at)
        made_of = sum(abs(slope * v) for n, slope in slopes.items() if isinstance(v := at[n], float))
        return result != 0.0 and abs(result) <= CANCELLED * made_of

    def _dividend(self, stage: Stage, target: float) -> float:
        """What a vanishing divisor divides: where it is 0 too, the equation holds whatever the unknown is.

        Not a number where that is not asked: more digits tell a divisor that is below floats from 0 then.
        """
        form = stage.forms[0]
        if stage.operation == "quotient" and stage.divisor != TARGET:
            return math.nan
        if stage.operation == "power":
            return target - 1.0
        if isinstance(form, Quotient):
            return self.evaluate(form.left, {**self.values, TARGET.name: target})
        return 0.0

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
        return _WholeTurns(self, principal, period, rest).all()

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


def _reading(operation: str, target: float) -> str:
    """What a stage would need: ``sqrt of -3.2``, ``cosd = 1.08``."""
    if operation == "square":
        return f"sqrt of {number_text(target)}"
    if operation == "power":
        return f"a root or logarithm of {number_text(target)}"
    return f"{operation} = {number_text(target)}"
