"""Enclosures of the residual of a chain with one tear, and of its slope, over boxes of the tear.

They are compiled on first use, to code for one box.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import suppress
from fractions import Fraction
from functools import cached_property, lru_cache
from math import inf, isnan, nan
from typing import Any, TypeAlias, TypeVar

from rulesheets.evaluate.exact import Decimals, Independent, Inexact, as_written
from rulesheets.functions import INTERVALS
from rulesheets.functions.intervals import EMPTY, LINE, Interval, cut, divide, greatest
from rulesheets.functions.intervals import least as smaller
from rulesheets.syntax.nodes import Name, Number, Product, Quotient, names, walk
from solver.kernel.chain import (
    Assignment,
    Chain,
    chosen,
    cleared,
    directions,
    limited,
    reciprocal,
    sides,
    slope_chain,
    steps,
    stepwise,
)
from solver.kernel.emitter import IntervalEmitter, Pair, like_signed

# --- interval operations that compiled code calls ---


def bounded(low: float, high: float, least: float, most: float) -> Interval:
    """The part of an interval between ``least`` and ``most``."""
    low, high = greatest(low, least), smaller(high, most)
    return (low, high) if low <= high else EMPTY


def beside_jump(low: float, high: float, side: int) -> Interval:
    """The lower (-1) or the upper (1) value next to a jump by 1; both of others."""
    if high - low != 1.0:
        return low, high
    return (high, high) if side > 0 else (low, low)


def quotient(
    a_low: float, a_high: float, b_low: float, b_high: float, not_negative: int, relational: int
) -> Interval:
    """A product x*c = t does not bound x if both c and t may be 0; a reciprocal (``relational`` 2),
    by which some t is multiplied, if c may be 0."""
    if not_negative:
        b_low, b_high = like_signed(a_low, a_high, b_low, b_high)
    if relational and b_low <= 0.0 <= b_high and (relational == 2 or a_low <= 0.0 <= a_high):
        return -inf, inf
    return divide(a_low, a_high, b_low, b_high)


def constant(low: float, high: float, *slopes: float) -> Interval:
    """A slope; 0 if it is that of a function of what is constant, even where its own has a pole."""
    return (low, high) if any(slopes) else (0.0, 0.0)


# --- a chain over boxes ---

LONGEST_SLOPE = 750
"""Parts of the expressions of a derivative up to which its sign beside 0/0 is worth the time."""
FAR, DECADES = 4096.0, 16.0
"""The size from which boxes are also examined over reciprocals; and the quotient of the ends of
nearer ones that are."""
LATEST = 16
"""Points at which exact values are kept."""


def _is_rootless(found: Interval) -> bool:
    low, high = found
    return low > 0.0 or high < 0.0 or (isnan(low) and isnan(high))


Code: TypeAlias = Callable[..., Any]
T = TypeVar("T")


class Enclosure:
    """Bounds over boxes of the tear, given the numbers ``known`` to the chain, in this order.

    Names that are ``ranged`` are known within ranges: their ends follow those of the tear in a box.
    ``shared`` is common to chains that differ in names only.
    """

    def __init__(
        self,
        chain: Chain,
        known: Sequence[str],
        ranged: Sequence[str] = (),
        shared: dict[str, Any] | None = None,
    ) -> None:
        self._chain, self._known, self._ranged = chain, tuple(known), tuple(ranged)
        self._shared = {} if shared is None else shared
        self._exactly_at = lru_cache(LATEST)(self._followed)
        self._zero_at = lru_cache(LATEST)(self._zero)

    @cached_property
    def _slope(self) -> Chain:
        return slope_chain(self._chain)

    @cached_property
    def cleared(self) -> Chain | None:
        return cleared(self._chain)

    @property
    def operations(self) -> int:
        """The number of operations on all boxes of one level of a search: range, sections and
        slope."""

        def count() -> int:
            chains = self._chain, self._chain, self._slope
            return sum(len(chain.assignments) for chain in chains)

        return self._once("operations", count)

    def _once(self, key: str, make: Callable[[], T]) -> T:
        if key not in self._shared:
            self._shared[key] = make()
        found: T = self._shared[key]
        return found

    def ranges(self, boxes: Sequence[tuple[float, ...]], known: Sequence[float]) -> list[Interval]:
        """The residual over each box; nan, nan if it is undefined all over it or has no root."""
        on_box = self._range(*known)
        found = [on_box(*box) for box in boxes]
        for place, (box, (below, above)) in enumerate(zip(boxes, found, strict=True)):
            if below <= 0.0 <= above and (
                self._has_none_beside_jumps(box, known) or self._has_none_far(box, known)
            ):
                found[place] = nan, nan
        return found

    def _has_none_beside_jumps(self, box: tuple[float, ...], known: Sequence[float]) -> bool:
        """Whether there is no root on either side of the jumps in the chain."""
        return bool(self._sides) and all(
            _is_rootless(side._range(*known)(*box)) for side in self._sides
        )

    def _has_none_far(self, box: tuple[float, ...], known: Sequence[float]) -> bool:
        """Whether a box far from 0 has no root, using the reciprocal of the tear."""
        low, high, *others = box
        near, most = (low, high) if low > 0.0 else (-high, -low)
        if near <= 0.0 or (near < FAR and most < DECADES * near):
            return False
        far, squared = self._far[low > 0.0]
        ends = divide(1.0, 1.0, near, most)
        ends = INTERVALS["sqrt"](*ends) if squared else ends
        if _is_rootless(far._range(*known)(*ends, *others)):
            return True
        return not others and far.leaves_zero(0.0, (0.0, ends[1]), known)

    def leaves_zero(self, at: float, box: Interval, known: Sequence[float]) -> bool:
        """Whether the numerator of the residual is exactly 0 at a point of a box and, by one of its
        first derivatives, nowhere else in it."""
        zero = self._zero_at(at, tuple(known))
        return zero is not None and zero.is_alone(box, known)

    def _zero(self, at: float, known: Sequence[float]) -> ExactZero | None:
        last = self._last_zero(at, known)
        return None if last is None else ExactZero(last)

    def _last_zero(self, at: float, known: Sequence[float]) -> Enclosure | None:
        """The numerator or the first of its derivatives that is exactly 0 at a point where its own
        derivative is not."""
        derivative, longest = self.numerator or self, inf
        while derivative._length < longest and derivative.is_zero_at(at, known):
            if not derivative._derivative.is_zero_at(at, known):
                return derivative
            derivative, longest = derivative._derivative, LONGEST_SLOPE
        return None

    @cached_property
    def _derivative(self) -> Enclosure:
        return self._beside("derivative", self._slope)

    @cached_property
    def _length(self) -> int:
        return len(walk(*(item.expression for item in self._chain.assignments)))

    def is_zero_at(self, x: float, known: Sequence[float]) -> bool:
        """Whether the residual is exactly 0 at a point."""
        return self.exactly_at(x, known).is_zero(Name(self._chain.residuals[0]))

    def is_pole(self, x: float, known: Sequence[float]) -> bool:
        """Whether a rational number other than 0 is divided by exactly 0 at a point, or multiplied
        by the reciprocal of exactly 0: that alone is none, as a dividend of 0 leaves its unknown
        free."""
        point = self.exactly_at(x, known)
        numbers = self._exact(known) | {self._chain.tears[0]: as_written(x)}
        exact, infinite = Decimals(numbers, None), set[str]()
        for item in self._chain.assignments:
            for part in walk(item.expression):
                match part:
                    case Quotient(dividend, divisor) if point.is_zero(divisor):
                        if item.reciprocal:
                            infinite.add(item.name)
                            continue
                    case Product(dividend, Name(factor)) if factor in infinite:
                        pass
                    case _:
                        continue
                with suppress(Inexact):
                    if exact.of(dividend):
                        return True
            with suppress(Inexact):
                numbers[item.name] = exact.of(item.expression)
        return False

    def exactly_at(self, x: float, known: Sequence[float]) -> Independent:
        """The values of a chain at a point."""
        return self._exactly_at(x, tuple(known))

    def _followed(self, x: float, known: Sequence[float]) -> Independent:
        point = Independent(self._exact(known) | {self._chain.tears[0]: as_written(x)})
        for item in self._chain.assignments:
            with suppress(Inexact):
                point.numbers[item.name] = point.of(item.expression)
        return point

    def _exact(self, known: Sequence[float]) -> dict[str, Fraction]:
        return {n: as_written(v) for n, v in zip(self._known, known, strict=True)}

    @cached_property
    def numerator(self) -> Enclosure | None:
        """Bounds of the numerator of the residual, if it divides by something that varies."""
        return None if self.cleared is None else self._beside("numerator", self.cleared)

    def slopes_over(
        self, boxes: Sequence[tuple[float, ...]], known: Sequence[float]
    ) -> list[Interval]:
        """The derivative of the residual by the tear; unbounded where it may be undefined
        somewhere."""
        on_box = self._slope_range(*known)
        found = (on_box(*box) for box in boxes)
        return [LINE if isnan(below) or isnan(above) else (below, above) for below, above in found]

    @cached_property
    def _sides(self) -> tuple[Enclosure, ...]:
        return tuple(self._beside(f"side {k}", side) for k, side in enumerate(sides(self._chain)))

    @cached_property
    def _far(self) -> dict[bool, tuple[Enclosure, bool]]:
        """Bounds over |x|^(-1/n), and whether n is 2: of a positive tear x (True), and of a
        negative one."""
        found = {}
        for sign in (-1.0, 1.0):
            chain, order = reciprocal(self._chain, sign)
            found[sign > 0.0] = self._beside(f"far {sign}", chain), order == 2.0
        return found

    def _beside(self, name: str, chain: Chain) -> Enclosure:
        """Bounds for a chain derived from this one, compiled once for all that differ in names."""
        return Enclosure(chain, self._known, self._ranged, self._once(name, dict))

    @property
    def _range(self) -> Code:
        """A function of the known numbers that gives one of the ends of a box, for the residual."""
        return self._once("range", self._range_made)

    def _range_made(self) -> Code:
        emitter = _followed(self._chain, self._known, self._ranged)
        residual = emitter.of(Name(self._chain.residuals[0]))
        if self.cleared is not None:
            emitter.line(
                f"if not {residual[0]} <= 0.0 <= {residual[1]}: return {', '.join(residual)}"
            )
            *items, numerator = self.cleared.assignments
            followed = {item.name for item in self._chain.assignments}
            for item in items:
                if item.name not in followed:
                    emitter.assign(item.name, emitter.of(item.expression))
            low, high = emitter.of(numerator.expression)
            emitter.line(f"if {low} > 0.0 or {high} < 0.0: return nan, nan")
        return emitter.function(residual)

    @property
    def _slope_range(self) -> Code:
        """The same for the slope of the residual."""
        return self._once("slope range", self._slope_range_made)

    def _slope_range_made(self) -> Code:
        of_values = len(self._chain.assignments)
        emitter = _followed(self._slope, self._known, self._ranged, of_values)
        return emitter.function(emitter.of(Name(self._slope.residuals[0])))


class ExactZero:
    """A point where a residual is exactly 0, as ``last`` is, the derivative of which is not.

    ``told`` are boxes around it, each with whether the slope of ``last`` has one sign there: then
    it has in every part of the box, and otherwise in no larger one.
    """

    def __init__(self, last: Enclosure) -> None:
        self.last, self.told = last, list[tuple[Interval, bool]]()

    def is_alone(self, box: Interval, known: Sequence[float]) -> bool:
        for other, alone in self.told:
            whole, part = (other, box) if alone else (box, other)
            if whole[0] <= part[0] and part[1] <= whole[1]:
                return alone
        ((least, most),) = self.last.slopes_over([box], known)
        alone = -inf < least <= most < inf and (least > 0.0 or most < 0.0)
        self.told.append((box, alone))
        return alone


def _followed(
    chain: Chain, known: Sequence[str], ranged: Sequence[str], smooth: int = 0
) -> IntervalEmitter:
    """The box of every name of a chain; returns nan, nan if some value must leave its domain.

    With slopes after the first ``smooth`` assignments: returns -inf, inf if some value may leave
    it, or one of those first may jump, or have a pole that a choice hides. A slope may jump, at a
    kink.
    """
    emitter = IntervalEmitter(
        (*chain.tears, *ranged),
        known,
        cut=cut,
        bounded=bounded,
        beside_jump=beside_jump,
        quotient=quotient,
        constant=constant,
    )
    otherwise = "return -inf, inf" if smooth else "return nan, nan"
    moving = {*chain.tears, *ranged, *(item.name for item in chain.assignments)}
    valued = {f"d {item.name}": item for item in chain.assignments[:smooth]}
    for place, item in enumerate(chain.assignments):
        for direction in directions(item.expression) if smooth else ():
            y, x = (emitter.of(argument) for argument in direction.arguments)
            emitter.line(f"if cut({y[0]}, {y[1]}, {x[0]}, {x[1]}): {otherwise}")
        for part, *ends, exponent in limited(item.expression) if place < smooth else ():
            if not moving.isdisjoint(names(part)):
                (low, high), (one, other) = emitter.of(part), emitter.of(exponent)
                bottom, top = (emitter.number(Number(end))[0] for end in ends)
                inside = f"{bottom} <= {low} and {high} <= {top}"
                whole = f"{one} == {other} and {one} % 1.0 == 0.0"
                emitter.line(f"if not ({inside} or {whole}): {otherwise}")
        for step in steps(stepwise(item.expression)) if place < smooth else ():
            low, high = emitter.of(step)
            emitter.line(f"if {low} != {high}: {otherwise}")
        for side in chosen(item.expression) if place < smooth else ():
            low, high = emitter.of(side)
            emitter.line(f"if not -inf < {low} <= {high} < inf: {otherwise}")
        low, high = _assigned(emitter, item)
        if place >= smooth > 0 and chain.tears[0] not in names(valued[item.name].expression):
            inner = valued.keys() & {*names(item.expression)}
            slopes = (emitter.of(Name(name)) for name in sorted(inner))
            low, high = emitter.apply("constant", (low, high), *slopes)
        if item.side:
            low, high = emitter.apply("beside_jump", (low, high), more=f", {item.side}")
        (least, _), (most, _) = emitter.number(Number(item.low)), emitter.number(Number(item.high))
        if item.low == -inf and item.high == inf:
            emitter.line(f"if {low} != {low}: {otherwise}")
        elif smooth:
            emitter.line(f"if not ({least} <= {low} and {high} <= {most}): {otherwise}")
        else:
            low, high = emitter.apply("bounded", (low, high), (least, most))
            emitter.line(f"if {low} != {low}: {otherwise}")
        emitter.assign(item.name, (low, high))
        if item.low == -inf and item.high == inf and not (item.relational or item.side):
            emitter.let(item.name, item.expression)
    return emitter


def _assigned(emitter: IntervalEmitter, item: Assignment) -> Pair:
    """The value of an assignment: a quotient that must not be negative has a divisor with the sign
    of its dividend."""
    expression = item.expression
    if not isinstance(expression, Quotient) or not (item.relational or item.low >= 0.0):
        return emitter.of(expression)
    above, below = emitter.of(expression.left), emitter.of(expression.right)
    how = 2 if item.reciprocal else int(item.relational)
    return emitter.apply("quotient", above, below, more=f", {item.low >= 0.0:d}, {how}")
