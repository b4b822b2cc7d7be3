"""The stages of an isolated equation undone at given numbers, the outermost operation first."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import zip_longest

from rulesheets.evaluate import Undefined, derivatives, value
from rulesheets.evaluate.number import number_text
from rulesheets.model import Value, Variable
from rulesheets.nodes import Call, Expression, Name, Number, Quotient, Symbol
from solver.accuracy.rule_check import check_rule
from solver.facts import AsksNothing, Fact, NoValue
from solver.kernel.steps.exponents import exponents
from solver.path.graph import ModelGraph
from solver.path.isolate import TARGET, Isolation, Quadratic, Stage

DIGITS = 50
"""With which numbers are looked at that floats make 0 of."""
SAMPLES = (0.7310585786300049, -1.8393972058572117, 3.3219280948873626)
"""Where an equation is tried that may not depend on its unknown; no special points of anything."""
DELICATE = 1e-6
"""How far beyond the end of an image a target may lie for the distance to be no more than lost digits."""
EPSILON = 2.0**-52
NOTHING = -5_000
"""Power of 2 of the number 0: below that of any float, and of any product of them."""
CANCELLED = 1e-12
"""Share of what a number is made of that may be no more than what cancellation has left of its rounding."""


class Refused(Exception):
    """A stage that has no preimage; carries the fact."""

    def __init__(self, fact: Fact) -> None:
        self.fact = fact


class Preimages:
    """What undoing the stages leads to, in floats; a subclass may have another arithmetic.

    ``proven``: formulas find all that there are. ``complete``: none was left out. ``clamped``: a target was
    moved to the end of an image. ``delicate``: rounding decides whether there is a preimage.
    """

    def __init__(
        self, graph: ModelGraph, equation: int, isolation: Isolation, values: Mapping[str, Value]
    ) -> None:
        self.graph, self.index, self.isolation = graph, equation, isolation
        self.equation = graph.model.equations[equation]
        self.values = {name: values[name] for name in self.equation.names if name in values}
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

    def _parts(self, number: float) -> tuple[float, int]:
        """A number as a mantissa and the power of 2 that it is multiplied by."""
        return math.frexp(number) if number else (0.0, NOTHING)

    def _near(self, share: float) -> float:
        """The relative error at which numbers are told apart where floats take ``share``."""
        return share

    def rounding(self, number: float) -> float:
        """How far a number may be off that was computed in one operation or two."""
        return self._near(EPSILON) * abs(number)

    # --- stages ---

    def reached(self, target: float, stages: tuple[Stage, ...]) -> list[float]:
        """What undoing stages leads to from a target; nothing where one of them refuses it."""
        try:
            return self._undo([target], stages)
        except (Refused, Undefined):
            return []

    def _undo(self, targets: list[float], stages: tuple[Stage, ...]) -> list[float]:
        for place, stage in enumerate(stages):
            targets = self._undo_stage(stage, targets, stages[place + 1 :])
        return targets

    def _undo_stage(self, stage: Stage, targets: list[float], rest: tuple[Stage, ...]) -> list[float]:
        found: list[float] = []
        refused: Exception | None = None
        for target in targets:
            try:
                if (base := self._base(stage)) is not None:
                    found.extend(self._exponents(base, target))
                    continue
                inside = self._in_image(stage, target)
                self._divisible(stage, inside)
                turns = [self._form(stage, form, inside, rest) for form in stage.forms]
                found.extend(_alternately(turns))
            except (Refused, Undefined) as error:
                refused = error
        if not found and refused is not None:
            raise refused
        return found

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
        self.delicate = self.delicate or _underflows(stage.divisor, at)
        unknown = self.isolation.unknown
        dividend = self._dividend(stage, target)
        if dividend == 0.0 or self._holds_anyway():
            raise Refused(AsksNothing(self.index, unknown))
        self.delicate = self.delicate or abs(dividend) <= DELICATE * self._size()
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
        """What a vanishing divisor divides: where it is 0 too, the equation holds whatever the unknown is."""
        form = stage.forms[0]
        if stage.operation == "quotient" and stage.divisor != TARGET:
            return math.nan
        if stage.operation == "power":
            return target - 1.0
        if isinstance(form, Quotient):
            return self.evaluate(form.left, {**self.values, TARGET.name: target})
        return 0.0

    def _holds_anyway(self) -> bool:
        """Whether the equation holds for different values of the unknown: one that it does not depend on."""
        known: dict[str, Value] = {n: v if isinstance(v, str) else float(v) for n, v in self.values.items()}
        unknown = self.isolation.unknown
        return all(check_rule(self.equation, {**known, unknown: number}).holds for number in SAMPLES)

    # --- exponents ---

    def _base(self, stage: Stage) -> float | None:
        """The base of a power whose exponent is asked for, where it is not positive and has no logarithm."""
        match stage:
            case Stage("power", divisor=Call("ln", (base,))):
                number = self.evaluate(base, self.values)
                return None if number > 0.0 else number
            case _:
                return None

    def _exponents(self, base: float, target: float) -> tuple[float, ...]:
        unknown, found = self.isolation.unknown, exponents(base, target)
        if found.anything:
            raise Refused(AsksNothing(self.index, unknown))
        if not found.values:
            reading = f"a power of {number_text(float(base))} to be {number_text(float(target))}"
            raise Refused(NoValue(self.index, unknown, reading))
        self.complete = self.complete and found.complete
        return found.values

    # --- whole turns ---

    def _turns(self, principal: float, period: float, rest: tuple[Stage, ...]) -> list[float]:
        from solver.kernel.steps.whole_turns import whole_turns

        return whole_turns(self, principal, period, rest)

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
        (a, up), (b, middle), (c, down) = map(self._parts, (a, b, c))
        unit = max(middle, (up + down) // 2)  # the squares of small and large numbers are no floats
        b = _shifted(b, middle - unit)
        square, product = b * b, 4 * _shifted(a * c, up + down - 2 * unit)
        discriminant = square - product
        if discriminant < 0.0:
            size = max(square, abs(product))
            self.delicate = self.delicate or -discriminant <= DELICATE * size
            if discriminant < -self._near(1e-9) * size:
                needed = number_text(float(_shifted(discriminant, 2 * unit)))
                raise Refused(NoValue(self.index, unknown, f"sqrt of {needed}"))
            discriminant, self.clamped = 0.0, True
        root = self._root(discriminant)
        q = -0.5 * (b - root if b < 0.0 else b + root)
        roots = [_shifted(q / a, unit - up), _shifted(c / q, down - unit) if q else 0.0]
        return sorted(roots, reverse=True) if roots[0] != roots[1] else roots[:1]


def _alternately(lists: Iterable[Sequence[float]]) -> Iterator[float]:
    """The first of each, the second of each, …: whoever takes no more than some takes of every form."""
    for some in zip_longest(*lists):
        yield from (number for number in some if number is not None)


def _shifted(mantissa: float, exponent: int) -> float:
    """A number from its parts, infinite where it is too large."""
    if not exponent:
        return mantissa
    try:
        return math.ldexp(mantissa, exponent)
    except OverflowError:
        return math.copysign(math.inf, mantissa)


def _reading(operation: str, target: float) -> str:
    """What a stage would need: ``sqrt of -3.2``, ``cosd = 1.08``."""
    if operation == "square":
        return f"sqrt of {number_text(target)}"
    if operation == "power":
        return f"a root or logarithm of {number_text(target)}"
    return f"{operation} = {number_text(target)}"


def _underflows(expression: Expression, at: Mapping[str, Value]) -> bool:
    """Whether what comes out as 0 in floats is a smaller number than they hold."""
    from rulesheets.evaluate import extended  # rarely needed, and dear to import

    if isinstance(expression, Name | Number):
        return False
    try:
        return bool(extended(expression, at, DIGITS) != 0)
    except Undefined:
        return True
