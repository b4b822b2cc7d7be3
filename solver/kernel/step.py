"""One equation solved for one unknown at given numbers: every preimage, or why there is none.

The stages of an isolated equation are undone, the outermost operation first.
"""

from __future__ import annotations

import math
from bisect import bisect
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from fractions import Fraction
from itertools import zip_longest
from typing import Any, NamedTuple

from rulesheets.diagnosis import listed
from rulesheets.evaluate import Undefined, rounded_derivatives, value
from rulesheets.evaluate.digits import extended, in_many_digits
from rulesheets.evaluate.number import number_text, rounded, undecided
from rulesheets.model import Value, Values
from rulesheets.syntax.nodes import (
    Call,
    Expression,
    Name,
    Number,
    Quotient,
    Symbol,
    exchange,
    names,
)
from solver.accuracy.rule_check import check_rule
from solver.accuracy.rule_sides import jumps, moves_of, passed_end, sides
from solver.facts import AsksNothing, BeyondFloats, DoubleRoot, Fact, NoRoot, NoValue, OutOfRange
from solver.kernel.emitter import enclose
from solver.numerics.linear_algebra import are_alike
from solver.numerics.tolerances import (
    BACKWARD,
    BESIDE_ROOT,
    CANCELLED,
    CLEAR,
    CORNER,
    DELICATE,
    EPS,
    LOST_TURN,
    SAME_TURN,
)
from solver.path import TARGET, Quadratic, Stage, Step
from solver.path.graph import ModelGraph, within_half_turns

OTHERWISE = "another value of"
"""The needed value for a rule on which its unknown has no influence."""
NESTED, WIDER = 2, 1e-9
"""Levels of rules that an implied range is computed from, and the share by which it is widened."""
MAX_TURNS = 2_000
LISTED_TURNS = 128
"""Turns either way of the one nearest to the principal one that are listed where there are too
many."""
FEW_TURNS = 20
SIMPLEST = 12
"""Numerator and denominator up to which a share of an angle is simple."""
MOST = 1e300
"""Turns that a float can count."""


def is_scaled(rest: Sequence[Stage]) -> bool:
    """Whether an unknown is not an angle, nor a simple share of one in degrees or radians, but a
    quantity that an angle is computed from: a time, a position, the day of a year."""
    scale = 1.0
    for stage in rest:
        if stage.operation in ("product", "quotient"):
            try:
                scale *= value(stage.forms[0], {TARGET.name: 1.0})
            except KeyError:  # it depends on other variables
                return True
    shares = (scale, scale * math.degrees(1.0), scale * math.radians(1.0))
    for share in shares:
        simple = Fraction(share).limit_denominator(SIMPLEST)
        if abs(simple) <= SIMPLEST and math.isclose(simple, share, rel_tol=SAME_TURN):
            return False
    return True


def is_affine(stage: Stage) -> bool:
    """Whether equal steps of the target lead to equal steps of the operand."""
    return stage.operation in ("negative", "sum", "product", "quotient") and stage.divisor != TARGET


def reach(graph: ModelGraph, name: str) -> tuple[float, float]:
    """The declared range of a variable; if that is infinite, and the variable no angle, the finite
    one implied by rules that always apply and have it as their value (``y = 3*sind(x)``)."""
    if name not in graph.reaches:
        variable = graph.model.variables[name]
        declared = ends = variable.low, variable.high
        if graph.turn(name) is None:
            ends = _implied(graph, name, NESTED)
        graph.reaches[name] = ends if all(map(math.isfinite, ends)) else declared
    return graph.reaches[name]


def _implied(graph: ModelGraph, name: str, levels: int) -> tuple[float, float]:
    """The range of a variable in rules within ``levels`` others, wider by more than rounding."""
    low, high = graph.model.variables[name].low, graph.model.variables[name].high
    bounded = math.isfinite(low) and math.isfinite(high)
    for index in graph.users[name] if levels and not bounded else ():
        rule = graph.model.equations[index]
        for defined, by in () if rule.guard else rule.definitions:
            if defined == name:
                ends = enclose(by, {n: _implied(graph, n, levels - 1) for n in names(by)})
                size = WIDER * max(map(abs, filter(math.isfinite, ends)), default=0.0)
                low, high = max(low, ends[0] - size), min(high, ends[1] + size)
    return low, high


def window(low: float, high: float, span: float) -> tuple[float, float]:
    """A range; of an infinite one a part, from its end, or around 0."""
    if high < math.inf:
        return (low if low > -math.inf else high - span), high
    return (low, low + span) if low > -math.inf else (-span / 2, span / 2)


def _floor(turns: float) -> int:
    """With all digits, also for a number of mpmath (``math.floor`` takes the nearest float), or the
    largest number considered: a range may hold more than there are floats."""
    whole = int(min(max(turns, -MOST), MOST))
    return whole - 1 if whole > turns else whole


SAMPLES = (0.7310585786300049, -1.8393972058572117, 3.3219280948873626)
"""Values at which an equation that may not depend on its unknown is tried; no special points."""


_NEEDS = {"square": "sqrt of", "power": "a root or logarithm of"}


class StepOutcome(NamedTuple):
    """``values``: the preimages, principal first; ``fact`` says why there is none, or no particular
    one.

    ``double``: two preimages coincide. ``delicate``: a target so close to the end of an image that
    rounding decides how many preimages there are. ``rounded``: the floats of numbers on the way are
    not near enough to what the decimals as written lead to.
    """

    values: tuple[Value, ...] = ()
    fact: Fact | None = None
    complete: bool = True
    double: DoubleRoot | None = None
    delicate: bool = False
    rounded: bool = False


def in_floats(values: Mapping[str, Any]) -> dict[str, Value]:
    """The nearest floats of numbers with more digits."""
    return {name: v if isinstance(v, str) else float(v) for name, v in values.items()}


class NoPreimage(Exception):
    """A stage has no preimage; carries the fact."""

    def __init__(self, fact: Fact) -> None:
        self.fact = fact


class StepSolver:
    """The preimages that satisfy the equation, in its range, to the last digits: in floats; a
    subclass uses another arithmetic.

    ``proven``: formulas find all that exist. ``complete``: none was left out. ``clamped``: a target
    was moved to the end of an image. ``delicate``: rounding decides whether there is a preimage.
    ``floats`` are the known ``values`` in floats, for the rule check. ``guess``: of the unknown, if
    many turns are answers. ``careful``: formulas are evaluated in many digits where floats cancel.
    ``origins`` are the steps that some of the values came from.
    """

    rounds, by_decimals, cancelled, rounded = True, True, False, False

    def __init__(
        self,
        graph: ModelGraph,
        equation: int,
        unknown: str,
        values: Values,
        guess: float | None = None,
        careful: bool = False,
        origins: Mapping[str, Step] | None = None,
    ) -> None:
        self.graph, self.index, self.unknown, self.guess = graph, equation, unknown, guess
        self.careful, self.known, self.origins = careful, values, origins or {}
        self.equation = graph.model.equations[equation]
        self.variable = graph.model.variables[unknown]
        isolation, names = graph.isolated(equation, graph.number[unknown])
        assert isolation is not None
        self.isolation, own = isolation, self.equation.names
        self.floats: dict[str, Value] = {name: values[name] for name in own if name in values}
        self.values = {name: values[n] for name, n in zip(names, own, strict=True) if n in values}
        self.names = names
        self.proven = self.complete = isolation.proven
        self.clamped = self.delicate = False

    def outcome(self) -> StepOutcome:
        """All values of the unknown of the isolation that satisfy the equation at the known
        values."""
        try:
            found = self.preimages()
        except NoPreimage as refused:
            outcome = StepOutcome(fact=refused.fact, delicate=self.delicate)
        except Undefined as undefined:
            fact: Fact = NoValue(self.index, self.unknown, str(undefined))
            if undefined.overflow:
                fact = BeyondFloats(self.index, self.unknown)
            delicate = undefined.overflow or self.delicate or self._on_the_edge(undefined)
            # a value beyond floats is an answer all the same
            outcome = StepOutcome(fact=fact, complete=not undefined.overflow, delicate=delicate)
        else:
            if len(found) == 1 and isinstance(found[0], str):
                return StepOutcome((found[0],))
            outcome = self._kept([self._wrapped(v) for v in found if not isinstance(v, str)])
        if not (outcome.values or self.proven):
            outcome = self._unproven(outcome.delicate)
        return outcome._replace(rounded=True) if self.rounded else outcome

    def _unproven(self, delicate: bool) -> StepOutcome:
        fact = NoRoot((self.index,), (self.unknown,), proven=False)
        return StepOutcome(fact=fact, complete=False, delicate=delicate)

    def _on_the_edge(self, undefined: Undefined) -> bool:
        """Whether rounding may have led an operation out of its domain: to a pole, beyond an
        end."""
        return passed_end(undefined, self.values, CANCELLED, self._uncomputed()) is not None

    def _wrapped(self, number: float) -> float:
        """An angle without a declared range is reported in (-180, 180]."""
        turn = self.graph.turn(self.unknown)
        isolation, ranged = self.isolation, self.variable.ranged
        if turn is None or ranged or not isolation.stages or isolation.period is None:
            return number
        return self._in_one_turn(number, turn)

    def _in_one_turn(self, number: float, turn: float) -> float:
        return within_half_turns(number, turn)

    def _kept(self, numbers: list[float]) -> StepOutcome:
        kept: list[float] = []
        ordered: list[float] = []  # of a long list only the neighbours need comparing
        outside: list[float] = []
        lost = False
        for number in numbers:
            number = self._inside(self._polished(number))
            if not math.isfinite(number):
                lost = True
            elif not self.variable.admits(float(number)):
                outside.append(float(number))
            elif self._holds(number):
                place = bisect(ordered, number)
                beside, near = ordered[max(place - 1, 0) : place + 1], self._near(8 * EPS)
                if not any(are_alike((number,), (v,), near) for v in beside):
                    kept.append(number)
                    ordered.insert(place, number)
        if not kept:
            return self._why_none(numbers, outside, lost)
        double: DoubleRoot | None = None
        kinks = any(stage.operation == "abs" for stage in self.isolation.stages)
        branches = 1 if kinks else self.isolation.branches
        fewer = len(kept) < max(len(numbers), branches)
        if branches > 1 and fewer and all(map(self._touches, kept)):
            double = DoubleRoot((self.index,), (self.unknown,), {self.unknown: 1.0})
        complete, delicate = self.complete and not lost, self.delicate or double is not None
        return StepOutcome(tuple(kept), None, complete, double, delicate)

    def _why_none(self, numbers: list[float], outside: list[float], lost: bool) -> StepOutcome:
        """Why none of these preimages is an answer."""
        delicate = self.delicate
        if outside:
            nearest = min(outside, key=self.variable.distance)
            # beside a larger number
            lost = not check_rule(self.equation, self._floats(nearest)).holds
            fact = OutOfRange(self.index, self.unknown, nearest)
            return StepOutcome(fact=fact, delicate=delicate or lost)
        if self.isolation.verify and self._indifferent():
            return StepOutcome(fact=AsksNothing(self.index, self.unknown))
        for number in numbers:
            miss, slope = (None, 0.0) if lost else self._slope(number)
            # between two floats it may well hold, where one last place moves it farther than it
            # misses by
            lost = lost or (miss is not None and abs(miss) <= abs(slope) * math.ulp(float(number)))
        if lost:
            return StepOutcome(
                fact=BeyondFloats(self.index, self.unknown), complete=False, delicate=True
            )
        if not self.complete:
            return self._unproven(delicate)
        others = [name for name in self.equation.names if name != self.unknown]
        reading = f"{OTHERWISE} {listed(others, 'or')}" if others else "other numbers"
        return StepOutcome(fact=NoValue(self.index, self.unknown, reading), delicate=delicate)

    def _inside(self, number: float) -> float:
        """The number; if only rounding has led it beyond an end of its range, that end."""
        end = self.variable.nearest(float(number)) if math.isfinite(number) else number
        if end == float(number) or not check_rule(self.equation, self._floats(end)).holds:
            return number
        return end

    def _floats(self, number: float) -> dict[str, Value]:
        """The values in floats, with that of the unknown."""
        return {**self.floats, self.unknown: float(number)}

    def _holds(self, number: float) -> bool:
        if not (self.isolation.verify or self.clamped):
            return True
        check = check_rule(self.equation, self._floats(number))
        near = check.delicate or check.scaled <= DELICATE
        self.delicate = self.delicate or (near and not check.holds)
        return check.holds

    def _polished(self, number: float) -> float:
        """One or two Newton corrections in the equation as written, for the last digits of a long
        chain, or of a root: floats have no 1/1.5. With care a value given by a formula is right to
        the last digit where its rounding in floats is more than the values in its rule explain."""
        start, stages = self.isolation.start, self.isolation.stages
        if self.isolation.identity:
            return self._given(start, number)
        takes_root = any(stage.operation in ("power", "root") for stage in stages)
        if len(stages) < 2 and self.isolation.quadratic is None and not takes_root:
            return number
        miss, slope = self._slope(number)
        for _ in range(2):
            if not (
                miss
                and slope
                and math.isfinite(slope)
                and abs(miss) <= DELICATE * abs(slope * number)
            ):
                return number
            corrected = number - miss / slope
            better, slope = self._slope(corrected)
            if better is None or abs(better) >= abs(miss):
                return number
            number, miss = corrected, better
        return number

    def _given(self, formula: Expression, number: float) -> float:
        """The value of a formula: ``10*sin(0.7*112)``, which no other values explain, or
        ``1/cosd(d) - 1`` at a small d in many digits."""
        if isinstance(formula, Number) or (self.floats and not self.careful):
            return number
        with suppress(OverflowError):
            if (exact := self._written(formula)) is not None:
                return float(exact)
        with suppress(Undefined):  # a part may overflow where the value does not
            _, slopes, rounded = rounded_derivatives(formula, self.values)
            if rounded <= BACKWARD * sum(moves_of(slopes, self.values)):
                return number
        with suppress(Undefined):  # digits hold no exponent as large as that of exp(-1e300)
            if in_many_digits(formula):
                return float(extended(formula, self.values))
        return number

    def _touches(self, number: float) -> bool:
        """Whether two preimages are one: the equation does not change to first order there, up to
        rounding, and neither crosses 0 nor ends there, as ``x^n`` of an odd or a broken n at 0."""
        beside = BESIDE_ROOT * (abs(float(number)) or 1.0)
        before, after = (self._slope(number + step)[0] for step in (-beside, beside))
        if before is None or after is None:
            return before is after
        slope = self._slope(number)[1]
        return before * after >= 0.0 and abs(slope) * beside <= CORNER * abs(after)

    def _explained(self, number: float) -> bool:
        """Whether what the rule misses by in floats is the rounding of its variables, and not of
        its own numbers."""
        at, moves = self._floats(number), math.inf
        with suppress(Undefined):
            left, right, slopes, _ = sides(self.equation, at)
            moves = sum(moves_of(slopes, at))
        if jumps(self.equation) or not math.isfinite(moves):  # as at the end of a domain
            return check_rule(self.equation, at).holds
        return moves > 0.0 and abs(left - right) <= BACKWARD * moves

    def _slope(self, number: float) -> tuple[float | None, float]:
        """The residual of the equation in floats, and its slope by the unknown."""
        at = self._floats(number)
        try:
            left, right, slopes, _ = sides(self.equation, at)
        except Undefined:
            return None, 0.0
        return left - right, slopes.get(self.unknown, 0.0)

    # --- the preimages, and the arithmetic ---

    def preimages(self) -> list[Value]:
        """Values of the unknown, principal first; raises :class:`NoPreimage` or ``Undefined`` for
        none."""
        isolation = self.isolation
        if isolation.quadratic is not None:
            return list(self._roots(isolation.quadratic))
        if isolation.identity and isinstance(isolation.start, Symbol):
            return [isolation.start.name]
        if isolation.identity and isinstance(isolation.start, Name):
            return [self.values[isolation.start.name]]
        found = self._undo([self._start()], isolation.stages)
        if self.cancelled and not all(map(self._explained, found)):
            self.by_decimals, self.rounded = False, True
            found = self._undo([self.evaluate(isolation.start, self.values)], isolation.stages)
        return list(found)

    def _start(self) -> float:
        """The value of the start, with the decimals as written where floats leave but rounding."""
        return self._within_domains(self._by_decimals(self.isolation.start, self.values)[0])

    def _by_decimals(self, formula: Expression, at: Values) -> tuple[Expression, bool]:
        """A formula with the numbers that its parts are with the decimals as written, where floats
        leave but rounding; and whether there are such parts."""
        close = undecided(formula, in_floats(at), CANCELLED) if self.by_decimals else []
        known = dict[Expression, float]()
        for part in close:
            exact = None if isinstance(part, Number) else self._written(part, at)
            if exact is not None and exact == float(exact):
                known[part] = float(exact)
        if not known:
            return formula, bool(close)
        self.cancelled = True
        for part, number in known.items():
            formula = exchange(formula, part, Number(number))
        return self._by_decimals(formula, at)[0], True

    def _within_domains(self, formula: Expression) -> float:
        """The value of a formula, where arguments that only rounding has led beyond the end of a
        domain lie at that end: ``acosd((a^2 + b^2 - c^2)/(2*a*b))`` of a flat triangle."""
        try:
            return self.evaluate(formula, self.values)
        except Undefined as undefined:
            passed = passed_end(undefined, in_floats(self.values), BACKWARD, self._uncomputed())
            if passed is None or isinstance(undefined.expression, Quotient):
                raise
            argument, end = passed
            with suppress(Undefined):
                number = self._within_domains(exchange(formula, argument, Number(end)))
                self.clamped = True
                return number
            raise

    def _uncomputed(self) -> set[str]:
        """The names, in the isolation, of numbers that were not computed."""
        both = zip(self.names, self.equation.names, strict=True)
        return {name for name, own in both if own not in self.origins}

    def evaluate(self, expression: Expression, values: Values) -> float:
        return value(expression, values)

    def _root(self, number: float) -> float:
        return math.sqrt(number)

    def _near(self, share: float) -> float:
        """The relative error at which numbers are distinguished if floats use ``share``."""
        return share

    # --- stages ---

    def _undo(self, targets: list[float], stages: tuple[Stage, ...]) -> list[float]:
        whole = stages is self.isolation.stages
        for place, stage in enumerate(stages):
            found: list[float] = []
            refused: Exception | None = None
            for target in targets:
                if whole:
                    target = self._as_written(target, stage, stages[:place])
                try:
                    found += self._operands(stage, target, stages[place + 1 :])
                except (NoPreimage, Undefined) as error:
                    refused = error
            if not found and refused is not None:
                raise refused
            is_sum = whole and stage.operation == "sum"
            if found and is_sum and abs(found[0]) <= CANCELLED * abs(target):
                found = [0.0] if self._leads_to(0.0, stages[: place + 1]) else found
            targets = found
        return targets

    def _as_written(self, target: float, stage: Stage, before: Sequence[Stage]) -> float:
        """The target, or the end of an image next to it that the decimals as written lead to."""
        for end in (stage.low, stage.high):
            near = 0.0 < abs(target - end) <= CANCELLED * abs(end) < math.inf
            if near and self._leads_to(end, before):
                return end
        return target

    def _leads_to(self, number: float, stages: Sequence[Stage]) -> bool:
        """Whether some stages lead exactly to a number with the decimals as written."""
        from solver.kernel.written import led_to  # where floats leave but rounding

        target = led_to(self.isolation, tuple(stages))
        found = target is not None and self._written(target) == number
        self.cancelled = self.cancelled or found
        return found

    def _written(
        self, expression: Expression, at: Mapping[str, Any] | None = None
    ) -> Fraction | None:
        """The exact value of an expression of names of the isolation, and of the target ``at`` a
        stage, with the decimals as written; None if it is not known."""
        from rulesheets.evaluate.exact import as_written, value_as_written
        from solver.kernel.written import WrittenNumbers

        if not self.by_decimals:
            return None
        written = WrittenNumbers(self.graph, self.known, self.origins)
        own = dict(zip(self.names, self.equation.names, strict=True))

        def read(name: str) -> Fraction:
            return as_written(at[name]) if at and name == TARGET.name else written.number(own[name])

        return value_as_written(expression, read)

    def _operands(self, stage: Stage, target: float, rest: tuple[Stage, ...]) -> list[float]:
        """The operands for which an operation has the target as its value."""
        if (
            stage.operation == "power"
            and (exponent := self._whole_exponent(stage, target)) is not None
        ):
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
            found.append(
                [principal] if stage.period is None else self._turns(principal, stage.period, rest)
            )
        # the first of each form, the second of each, …: the first few have some of every form
        return [number for some in zip_longest(*found) for number in some if number is not None]

    def _in_image(self, stage: Stage, target: float) -> float:
        """The target, moved to the end of the image if it lies outside; verification decides."""
        low, high = stage.low, stage.high
        if low < target < high or (target == low and not stage.low_open):
            return target
        if target == high and not stage.high_open:
            return target
        edge, is_open = (low, stage.low_open) if target <= low else (high, stage.high_open)
        off = abs(target - edge)
        self.delicate = self.delicate or off <= DELICATE * self._size()
        if is_open or off > self._near(CLEAR) * self._size():
            kind = _NEEDS.get(stage.operation, f"{stage.operation} =")
            shown = rounded(float(target), 10)
            if shown == edge:  # which only more digits tell from it
                shown = float(target)
            reading = f"{kind} {number_text(shown)}"  # such as sqrt of -3.2, cosd = 1.08
            if off and shown == edge:
                reading += f" {'-' if target < edge else '+'} {number_text(float(off))}"
            raise NoPreimage(NoValue(self.index, self.unknown, reading, pole=False))
        self.clamped = True
        return edge

    def _size(self) -> float:
        """The size of the numbers that the start of the chain was computed from."""
        numbers = [abs(v) for v in self.values.values() if isinstance(v, float)]
        largest = max([1.0, *numbers])
        return largest * largest  # a power would raise where it overflows

    def _divisible(self, stage: Stage, at: dict[str, Value]) -> None:
        """Refuse a stage that divides by 0 for the target ``at``."""
        if stage.divisor is None:
            return
        if self._coefficient(stage.divisor, at) != 0.0:
            return
        # what it divides; not a number where that is not asked: more digits tell a tiny divisor
        # from 0 then
        form, dividend = stage.forms[0], 0.0
        if stage.operation == "quotient" and stage.divisor != TARGET:
            dividend = math.nan
        elif stage.operation == "power":
            dividend = self.evaluate(TARGET, at) - 1.0
        elif isinstance(form, Quotient):
            dividend = self.evaluate(form.left, at)
        if self._indifferent() or (dividend == 0.0 and not self.isolation.common):
            raise NoPreimage(AsksNothing(self.index, self.unknown))
        self.delicate = self.delicate or not abs(dividend) > DELICATE * self._size()
        reading = f"0 times {self.unknown} = {number_text(float(dividend))}"
        if stage.operation != "product":
            reading = f"division by 0 for {self.unknown}"
        raise NoPreimage(NoValue(self.index, self.unknown, reading, pole=True))

    def _indifferent(self) -> bool:
        """Whether the equation holds at different values of its unknown: it cancels."""
        tried = ({**self.floats, self.unknown: number} for number in SAMPLES)
        checks = [
            check for at in tried if (check := check_rule(self.equation, at)).miss is not None
        ]
        return len(checks) > 1 and all(check.holds for check in checks)

    def _coefficient(self, expression: Expression, at: Values) -> float:
        """The value of an expression; 0 if it is with the decimals as written: the last digits of
        0.1 and 0.3 would lead to roots of 1e17."""
        if isinstance(expression, Name | Number):
            return self.evaluate(expression, at)
        formula, cancels = self._by_decimals(expression, at)
        number = self.evaluate(formula, at)
        self.delicate = self.delicate or (cancels and self.rounds and number != 0.0)
        if number and abs(number) <= CANCELLED and self._written(expression, at) == 0:
            number, self.cancelled = 0.0, True
        return number

    def _whole_exponent(self, stage: Stage, target: float) -> float | None:
        """The only exponent that may take a negative base to a target: real powers of it have whole
        ones. None if the base has a logarithm."""
        if not isinstance(stage.divisor, Call) or stage.divisor.function != "ln":
            return None
        number = self.evaluate(stage.divisor.arguments[0], self.values)
        if number > 0.0:
            return None
        if number == 0.0 and target == 1.0:
            return 0.0
        if number in (0.0, -1.0) or target == 0.0:  # many, or none
            self.proven = False
            raise NoPreimage(NoRoot((self.index,), (self.unknown,), proven=False))
        return float(round(math.log(abs(target)) / math.log(-number)))

    # --- whole turns ---

    def _turns(self, principal: float, period: float, rest: tuple[Stage, ...]) -> list[float]:
        """The principal preimage and its whole turns that ``rest``, the remaining stages, leads
        into the window of the unknown. If some are left out, the list is no longer complete."""
        bent = next((place for place, stage in enumerate(rest) if not is_affine(stage)), None)
        if bent is None:
            counts = self._affine_turns(principal, period, rest)
        else:
            counts = self._nonaffine_turns(principal, period, rest, bent)
        return [principal + k * period for k in sorted(counts, key=lambda k: (abs(k), k < 0))]

    def _affine_turns(
        self, principal: float, period: float, rest: tuple[Stage, ...]
    ) -> Iterable[int]:
        """For an affine rest: all turns in the declared range, else in one turn. An unknown that is
        itself the angle is searched around 0 even if whole turns make a difference to others."""
        first = self._through(principal, rest)
        stride = self._through(principal + period, rest) - first
        size = abs(stride)
        if self._near(EPS) * abs(first) > LOST_TURN * size:  # of one operation or two
            self.uncounted()
        if EPS * abs(first) > LOST_TURN * size:
            self.complete = False  # floats next to such answers may not be good enough to be told
        turn = self.graph.turn(self.unknown)
        low, high = reach(self.graph, self.unknown)
        bounded = low > -math.inf or high < math.inf
        self.complete = self.complete and (turn is not None or high - low < math.inf)
        low, high = window(low, high, turn or size)
        if stride == 0 or not math.isfinite(stride):
            return (0,)
        if not (bounded or turn or not rest):
            if not is_scaled(rest):
                return (0,)
            # a quantity of which an angle is a multiple (a time, a place, a day) is rather positive
            start = 0.0 if self.guess is None else self.guess - size / 2
            count = _floor((first - start) / size + SAME_TURN)
            return (-count if stride > 0.0 else count,)
        begin, end = sorted((x - first) / stride for x in (low, high))
        counts = range(_floor(begin) - 1, 2 - _floor(-end))
        if counts.stop - counts.start > MAX_TURNS:
            self.complete = False
            nearest = min(max(0, counts.start), counts.stop)
            counts = range(nearest - LISTED_TURNS, nearest + LISTED_TURNS)
        slack = SAME_TURN * size
        inside = [k for k in counts if low - slack <= first + k * stride <= high + slack]
        if inside:
            return inside
        beside = min(counts, key=lambda k: self.variable.distance(first + k * stride))
        return (beside,) if self.variable.distance(first + beside * stride) else ()

    def _nonaffine_turns(
        self, principal: float, period: float, rest: tuple[Stage, ...], bent: int
    ) -> Iterable[int]:
        """For a rest that is not affine from stage ``bent`` on: all that the image of that stage
        admits; else those of a few that lead into a finite range of the unknown, or the first."""
        low, high = rest[bent].low, rest[bent].high
        if math.isfinite(low) and math.isfinite(high):
            foot = self._through(principal, rest[:bent])
            stride = self._through(principal + period, rest[:bent]) - foot
            slack = CLEAR * max(abs(low), abs(high), abs(foot))
            ends = (
                sorted(((low - slack - foot) / stride, (high + slack - foot) / stride))
                if stride
                else []
            )
            if ends and ends[1] - ends[0] <= MAX_TURNS:
                return range(-_floor(-ends[0]), _floor(ends[1]) + 1)
        low, high = reach(self.graph, self.unknown)
        slack = CLEAR * max(abs(low), abs(high))

        def leads_inside(count: int) -> bool:
            try:
                found = self._undo([principal + count * period], rest)
            except (NoPreimage, Undefined):
                return False
            return any(low - slack <= number <= high + slack for number in found)

        self.complete, few = False, range(-FEW_TURNS, FEW_TURNS + 1)
        if math.isfinite(low) and math.isfinite(high):
            return filter(leads_inside, few)
        return (next(filter(leads_inside, sorted(few, key=abs)), 0),)

    def _through(self, target: float, stages: tuple[Stage, ...]) -> float:
        """The target after undoing stages with one preimage each."""
        for stage in stages:
            target = self.evaluate(stage.forms[0], {**self.values, TARGET.name: target})
        return target

    def uncounted(self) -> None:
        """Called if whole turns are absorbed by the number that they are added to."""
        self.complete, self.delicate = False, True

    # --- quadratics ---

    def _roots(self, quadratic: Quadratic) -> list[float]:
        a, b = (self._coefficient(part, self.values) for part in (quadratic.a, quadratic.b))
        c = self.evaluate(quadratic.c, self.values)
        if a == 0.0:
            if b == 0.0:
                fact = AsksNothing(self.index, self.unknown) if c == 0.0 else None
                reading = f"0 times {self.unknown} = {number_text(float(-c))}"
                raise NoPreimage(fact or NoValue(self.index, self.unknown, reading, pole=True))
            return [-c / b]
        square, product = b * b, 4 * a * c
        discriminant = square - product
        if discriminant < 0.0:
            size = max(square, abs(product))
            self.delicate = self.delicate or -discriminant <= DELICATE * size
            if discriminant < -self._near(CLEAR) * size:
                raise NoPreimage(
                    NoValue(self.index, self.unknown, f"sqrt of {number_text(float(discriminant))}")
                )
            discriminant, self.clamped = 0.0, True
        self.delicate = self.delicate or 0.0 < discriminant <= CANCELLED * square
        root = self._root(discriminant)
        q = -0.5 * (b - root if b < 0.0 else b + root)
        roots = [q / a, c / q if q else 0.0]
        return sorted(roots, reverse=True) if roots[0] != roots[1] else roots[:1]
