"""A block with one tear: the residual as a function of the tear, searched over its whole range.

For a large tear floats cannot distinguish ``x + 2*(2 - x) + x - 3`` from 0. There the chain is
followed in many digits, and its residual must be explained by the last places of its numbers.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from functools import cache, partial
from itertools import pairwise, takewhile
from math import nan
from typing import Any

from rulesheets.deadline import expect_time
from rulesheets.evaluate import Undefined
from rulesheets.evaluate.digits import context, extended
from rulesheets.functions.intervals import Interval
from rulesheets.syntax.nodes import Number, calls, terms, walk
from solver.accuracy.rule_check import absorbs
from solver.accuracy.rule_sides import with_named_numbers
from solver.kernel.block import BlockKernel
from solver.kernel.candidates import MOST_REPEATED, Answer, BlockOutcome, Candidates, Undecided
from solver.kernel.chain import Chain, followed
from solver.kernel.linear_block import left_free
from solver.kernel.problem import BlockProblem
from solver.numerics.isolation import IsolationLimits, RootSearch, isolate_roots
from solver.numerics.tolerances import BACKWARD, BESIDE_HOLE, NOTHING, ROUGHLY, SPARE

DIGITS = 60
"""Decimal digits of a number next to 1."""
STEP = 1e-20
"""Relative change of a number that tells how the residual depends on it."""


def vanishes(chain: Chain, x: float, known: Mapping[str, float]) -> bool:
    """Whether the last residual of a chain is 0 at this value of its only tear, up to rounded
    numbers."""
    digits, numbers = DIGITS + max(0, math.frexp(x)[1] // 3), dict(known)
    steps = [
        i._replace(expression=with_named_numbers(i.expression, numbers)) for i in chain.assignments
    ]
    mp, named = context(digits), chain._replace(assignments=tuple(steps))

    def residual(moved: Mapping[str, Any]) -> Any:
        return followed(named, {**numbers, chain.tears[0]: mp.mpf(x), **moved}, digits)[
            steps[-1].name
        ]

    try:
        miss = residual({})
        if abs(miss) <= NOTHING:
            return True
        moves = (
            abs(residual({name: number * (1 + mp.mpf(STEP))}) - miss) / STEP
            for name, number in numbers.items()
        )
        return bool(abs(miss) <= BACKWARD * sum(moves))
    except (Undefined, OverflowError, ZeroDivisionError):
        return False


def tends_to_zero(chain: Chain, points: Sequence[float], known: Mapping[str, float]) -> bool:
    """Whether the last residual of a chain, which vanishes at these values of its only tear, only
    tends to 0 there, as that of ``erf(x) = 1``: it changes from one to another, or an operation
    absorbs what it is."""
    misses, last = [], chain.assignments[-1]
    for x in points:
        digits = DIGITS + max(0, math.frexp(x)[1] // 3)
        values = followed(chain, {**known, chain.tears[0]: context(digits).mpf(x)}, digits)
        size = sum(abs(extended(term, values, digits)) for term in terms(last.expression))
        if any(absorbs(item.expression, values, digits) for item in chain.assignments):
            return True
        miss = values[last.name]
        misses.append(miss if abs(miss) > size * context(digits).mpf(10) ** (SPARE - digits) else 0)
    return bool(max(misses) - min(misses) > max(map(abs, misses)) / 2)


SEARCH_BOXES, BRIEF_BOXES = 12_000, 1_500
SEARCH_ALIVE = 2_000
SEARCH_LEVELS = 220
USUAL_LEVELS, LEVELS_WITHIN = 24, 5
BOXES = 5
"""Boxes of a search that cost as much as a unit of work, where a search is of no more use than its
time."""
OPERATIONS = 4
"""Of one level of a search for each assignment of a chain: its range twice, sections, and the
slope."""
SHARES = (0.137, 0.291, 0.433, 0.618, 0.787, 0.913)
FAR = 10.0
"""The distances from the near end of an interval that reaches far out, in ends, at which it is
sampled."""
POWERS = range(-12, 25)
"""Powers of 2 times the typical size at which a plateau is looked for."""
FAINT = 1e-30
"""Size of samples for which rules may be meaningless, whether or not their unknown is free."""
REMOTE = 1e50
"""Half way, in decades, to where a search over an infinite range ends."""
MIN_SAMPLES = 3
MAX_SUSPECTS = 8
"""Points of an undecided search that are examined more closely."""
MOST_CHAINS = 64
"""Combinations of preimages beyond which a search of the whole range takes longer than it is
worth."""


class TearSearch:
    """The search over one tear; ``kernel`` is that of the block, or of another tearing of it. A
    ``brief`` one looks into few boxes."""

    def __init__(
        self,
        problem: BlockProblem,
        candidates: Candidates,
        kernel: BlockKernel,
        brief: bool = False,
    ) -> None:
        self.problem, self.candidates, self.brief = problem, candidates, brief
        self.kernel, self.budget = kernel, problem.budget
        self.known = dict(zip(kernel.known, problem.known, strict=True))
        self.tear = self.kernel.block.tears[0]
        self.flat: list[tuple[int, float, float]] = []
        self.stretches: list[Undecided] = []
        self.doubts = self.lost = False

    @property
    def left(self) -> tuple[Interval, ...] | None:
        """The intervals of the tear in which there may be other roots; None if they may be
        anywhere."""
        if self.doubts or self.lost:
            return None
        return tuple((low, high) for _, _, low, high in self.stretches)

    def run(self, within: Sequence[Interval] | None = None) -> bool:
        """Find the roots along every chain, where there may be some: in the range of the tear, or
        ``within`` these parts of it. True if they are proven to be all."""
        every = self.kernel.chains
        self.doubts = self._is_doubtful()
        levels = USUAL_LEVELS if within is None else LEVELS_WITHIN
        work = levels * sum(OPERATIONS * len(chain.assignments) for chain in every)
        hopeless = self.brief and self.doubts
        if len(every) > MOST_CHAINS or work > self.budget.of_block or hopeless:
            self.lost = True
            return False
        found = [self._search(place, within) for place in range(len(every))]
        variable = self.problem.graph.model.variables[self.tear]
        # a rounding outside, perhaps
        for end in filter(math.isfinite, (variable.low, variable.high)):
            points = [
                self._along(place, end) for place in range(len(every)) if variable.admits(end)
            ]
            for point in points:
                if point is not None and self.problem.holds(point):
                    self.candidates.keep(point)
        self.doubts = self.doubts or not self.kernel.exhaustive
        return all(found) and not self.doubts

    def _search(self, place: int, within: Sequence[Interval] | None) -> bool:
        """Find the roots along one chain. True if they are proven to be all of it."""
        expect_time()
        enclosure, known = self.kernel.enclosure(place), self.problem.known
        candidates = self.candidates
        function = self.kernel.chain_function(place)
        levels = self.budget.levels(enclosure.operations, SEARCH_LEVELS)
        search = isolate_roots(
            partial(self._ranges, place, self._holes(place)),
            partial(enclosure.slopes_over, known=known),
            lambda x: function(x, *known)[-1],
            *self.problem.domain(self.tear),
            IsolationLimits(
                BRIEF_BOXES if self.brief or candidates.sensible else SEARCH_BOXES,
                SEARCH_ALIVE,
                levels,
            ),
            within,
        )
        self.budget.spend(search.levels * enclosure.operations)
        self.budget.used += search.evaluations // BOXES
        search = self._nearest(place, self._without_holes(place, search))
        confined = search.complete or (search.unresolved and not self.kernel.repeating)
        self.lost |= not confined
        self.stretches += [Undecided(self.kernel, place, *ends) for ends in search.unresolved]
        for x in search.crossings:
            self._candidate(place, x)
        along = [self._along(place, x) for x in search.roots if x not in search.crossings]
        self.doubts = self.doubts or None in along  # floats have no value there
        proven = [root for root in along if root is not None]
        for root in proven:
            candidates.proven(root)
        if search.complete:
            candidates.separate(proven)
        short = map(_short, search.unresolved[:MAX_SUSPECTS])
        for x in (*search.touching, *short):
            if not self._is_absorbed(place, x):
                self._candidate(place, x)
        doubtful = (*search.touching, *(0.5 * (a + b) for a, b in search.unresolved))
        sole = candidates.sensible is None and not self.brief
        for x in doubtful[: MAX_SUSPECTS if sole else 0]:
            point = self._along(place, x)
            if point is not None and not self._is_absorbed(place, x):
                candidates.suspect(point)
        self.flat += [(place, *interval) for interval in search.flat]
        return search.complete

    def _nearest(self, place: int, search: RootSearch) -> RootSearch:
        """The search with the roots of the first periods, if there are more in further ones."""
        if search.complete or len(search.roots) <= MOST_REPEATED or not self.kernel.repeating:
            return search
        points = [(point, x) for x in search.roots if (point := self._along(place, x)) is not None]
        points.sort(key=lambda pair: self.problem.periods(pair[0]))
        nearest = {x for _, x in points[:MOST_REPEATED]}
        crossings = tuple(nearest.intersection(search.crossings))
        return search._replace(roots=tuple(nearest), crossings=crossings)

    def _ranges(
        self, place: int, holes: Sequence[float], boxes: Sequence[Interval]
    ) -> list[Interval]:
        """The residual over each box; nan, nan also if it is 0/0 at a hole and 0 nowhere else."""
        found = self.kernel.enclosure(place).ranges(boxes, self.problem.known)
        for number, (box, (below, above)) in (
            enumerate(zip(boxes, found, strict=True)) if holes else ()
        ):
            if below <= 0.0 <= above and box[0] < box[1] and self._is_monotone(place, holes, *box):
                found[number] = nan, nan
        return found

    def _holes(self, place: int) -> list[float]:
        """The points where the residual is 0/0: of 0, 1, the ends of the tear's domain, and given
        numbers at which floats divide by 0."""
        (low, high), given = self.problem.domain(self.tear), self.problem.known
        inside = [x for x in given if low <= x <= high]
        undefined = [x for x in inside if type(self._followed(place, x)) is ZeroDivisionError]
        points = dict.fromkeys((0.0, 1.0, *filter(math.isfinite, (low, high)), *undefined))
        holes = [x for x in points if self._is_hole(place, x)]
        for x in holes:
            if x not in undefined:
                self.candidates.accidental |= self._that_move(place, x)
        beside = (self._along(place, x + BESIDE_HOLE * (abs(x) or 1.0)) for x in holes)
        self.candidates.holes += [
            point for point in beside if point and self.candidates.nearly(point, ROUGHLY)
        ]
        return holes

    def _that_move(self, place: int, x: float) -> set[str]:
        """The known numbers without which the residual's numerator would not be 0 at a point."""
        numerator = self.kernel.enclosure(place).numerator or self.kernel.enclosure(place)
        given, names = self.problem.known, self.problem.kernel.known
        others = [(v or 1.0) * (1.0 - 1.0 / (3.0 + k)) for k, v in enumerate(given)]
        if numerator.is_zero_at(x, others):
            return set()
        moved = ((*given[:k], other, *given[k + 1 :]) for k, other in enumerate(others))
        alone = {n for n, at in zip(names, moved, strict=True) if not numerator.is_zero_at(x, at)}
        return alone or {*names}

    def _without_holes(self, place: int, search: RootSearch) -> RootSearch:
        """The search without boxes around exact points at which the residual is 0/0.

        If its numerator is 0 there and monotone on a box, it is 0 nowhere else in it; and at such a
        point a rule divides by 0.
        """
        if search.complete or not search.unresolved:
            return search
        holes = [
            x for x in dict.fromkeys(map(_short, search.unresolved)) if self._is_hole(place, x)
        ]
        left = tuple(box for box in search.unresolved if not self._is_monotone(place, holes, *box))
        touching = tuple(x for x in search.touching if not self._is_monotone(place, holes, x, x))
        return search._replace(unresolved=left, touching=touching, complete=not left)

    def _is_monotone(self, place: int, holes: Sequence[float], low: float, high: float) -> bool:
        """Whether the numerator of the residual is 0 nowhere on a box but at some hole."""
        enclosure, known = self.kernel.enclosure(place), self.problem.known
        boxes = ((hole, (min(low, hole), max(high, hole))) for hole in holes)
        return any(enclosure.leaves_zero(hole, box, known) for hole, box in boxes)

    def _is_hole(self, place: int, x: float) -> bool:
        """Whether the residual's numerator is exactly 0 at a point where a rule has no value: the
        rule as written, if not the step that it was solved to (``t = v*s`` from ``v = t/s``)."""
        enclosure, known = self.kernel.enclosure(place), self.problem.known
        numerator = enclosure.numerator or enclosure
        if not numerator.is_zero_at(x, known):
            return False
        point = numerator.exactly_at(x, known)
        return any(map(point.is_zero, self.problem.kernel.divisors)) or enclosure.is_pole(x, known)

    def _is_doubtful(self) -> bool:
        """Whether a search proves nothing: some number is so large or small that answers may lie
        outside the searched range; or a chain has no value anywhere because it divides by 0: it
        uses a rule that does not determine its unknown at these numbers (``0*y``)."""
        parts = (part for form in self.problem.kernel.forms for part in walk(form))
        numbers = (*self.problem.known, *(part.value for part in parts if isinstance(part, Number)))
        if any(v and not 1 / REMOTE <= abs(v) <= REMOTE for v in numbers):
            return True
        samples = self._samples()
        for place in range(len(self.kernel.chains)):
            ends = (self._followed(place, x) for x in samples)
            kinds = [*map(type, takewhile(lambda end: isinstance(end, Exception), ends))]
            if len(kinds) == len(samples) and ZeroDivisionError in kinds:
                return True
        return False

    def freedom(self) -> BlockOutcome | None:
        """If the residual vanishes at every trial, the tear is free and the other unknowns move
        with it."""
        for place in range(len(self.kernel.chains)):
            found = [point for x in self._samples() if (point := self._along(place, x)) is not None]
            points = list({point[self.tear]: point for point in found}.values())
            if len(points) >= MIN_SAMPLES and self._satisfied(place, points):
                return self._free(points[0], points[1])
        return None

    def flat_stretch(self) -> BlockOutcome | None:
        """After the search: an interval of the tear on which every point is an answer (``int(x) =
        3``). Answers found on it are no longer listed."""
        for place, low, high in self.flat or self._plateaus():
            far = self.problem.is_far_out({self.tear: min(low, high, key=abs)}) and low * high > 0.0
            if far:  # terms are absorbed there, unless the rules hold at the usual sizes as well
                low, high = sorted(math.copysign(self._size, low) * share for share in (1.0, 2.0))
            # next to nothing beyond both ends, too, it grows from 0 as that of a multiple root,
            # where one that leaves a plateau jumps or bends
            beyond = [self._along(place, end) for end in (low - (high - low), high + (high - low))]
            near = all(point is not None and self.candidates.nearly(point) for point in beyond)
            if near and not far:
                continue
            first, second = (self._along(place, x) for x in _inside(low, high, self._size))
            apart = first and second and first[self.tear] != second[self.tear]
            if first and second and apart and self._satisfied(place, (first, second)):
                tears = first[self.tear], second[self.tear]
                if not tends_to_zero(self.kernel.chains[place], tears, self.known):
                    answers = self.candidates.answers
                    answers[:] = [one for one in answers if not self._joins(place, low, high, one)]
                    return self._free(first, second)
        return None

    def _plateaus(self) -> Iterator[tuple[int, float, float]]:
        """Intervals beside a kink on which all rules hold, though a given number misses by rounding
        what they make there, as 397.8 misses ``0.0765*min(5200, x)``."""
        bent = any(call.function in ("min", "max") for call in calls(*self.kernel.forms))
        low, high = self.problem.domain(self.tear)
        sizes = [math.ldexp(self._size, power) for power in POWERS]
        xs = sorted(x for size in sizes for x in (-size, size) if low <= x <= high)
        for place in range(len(self.kernel.chains) if bent else 0):

            @cache
            def holds(x: float, place: int = place) -> bool:
                point = self._along(place, x)
                return point is not None and self.problem.holds(point)

            for outside, inside in (*pairwise(xs), *pairwise(xs[::-1])):
                far = 2 * inside - outside
                if holds(inside) and not holds(outside) and holds(far):
                    yield place, min(inside, far), max(inside, far)

    def _joins(self, place: int, low: float, high: float, answer: Answer) -> bool:
        """Whether a chain leads through answers from an interval to this answer."""
        end = answer.values[self.tear]
        start, there = min(max(end, low), high), self._along(place, end)
        if there is None or not self.candidates.covers(answer, there):
            return False
        far = start - end
        reaches = (far, math.copysign(min(abs(far), abs(end)), far))
        between = [self._along(place, end + share * r) for r in reaches for share in SHARES]
        return all(there is not None and self.problem.holds(there) for there in between)

    def _satisfied(self, place: int, points: Sequence[Mapping[str, float]]) -> bool:
        """Whether the block really holds at all these points of a chain."""
        chain = self.kernel.chains[place]
        return all(map(self.problem.holds, points)) and all(
            vanishes(chain, point[self.tear], self.known) for point in points
        )

    def _free(self, first: dict[str, float], second: dict[str, float]) -> BlockOutcome:
        span = second[self.tear] - first[self.tear]
        direction = {name: (second[name] - v) / span for name, v in first.items()}
        return left_free(
            self.problem, first, direction, tuple(n for n, v in first.items() if v != second[n])
        )

    def _samples(self) -> list[float]:
        low, high = self.problem.domain(self.tear)
        if math.isfinite(low) and math.isfinite(high):
            return [low + (high - low) * share for share in SHARES]
        size = self._size
        middle = low if math.isfinite(low) else high if math.isfinite(high) else 0.0
        signs = (1.0, -1.0) if middle == 0.0 else (1.0,) if math.isfinite(low) else (-1.0,)
        sizes = (size,) if size > FAINT else (size, 1.0)
        return [middle + sign * s * share for s in sizes for sign in signs for share in SHARES]

    @property
    def _size(self) -> float:
        return self.problem.scale[self.problem.unknowns.index(self.tear)]

    def _followed(self, place: int, x: float) -> Sequence[float] | Exception:
        """The numbers along a chain, or why there are none."""
        try:
            found: Sequence[float] = self.kernel.chain_function(place)(x, *self.problem.known)
        except (ArithmeticError, ValueError) as error:
            return error
        return found

    def _along(self, place: int, x: float) -> dict[str, float] | None:
        if isinstance(found := self._followed(place, x), Exception):
            return None
        return dict(zip(self.problem.unknowns, found, strict=False))

    def _is_absorbed(self, place: int, x: float) -> bool:
        """Whether the residual is 0 only because floats as large as x absorb its other terms."""
        chain = self.kernel.chains[place]
        return self.problem.is_far_out({self.tear: x}) and (
            not vanishes(chain, x, self.known) or tends_to_zero(chain, (x,), self.known)
        )

    def _candidate(self, place: int, root: float) -> None:
        point = self._along(place, root)
        if point is not None:
            self.candidates.refine(list(point.values()))


def _inside(low: float, high: float, size: float) -> tuple[float, float]:
    """Two points of an interval; of one that reaches far out, near its end next to 0."""
    near, far = sorted((low, high), key=abs)
    one, other = (math.copysign(max(abs(near), size), far) * FAR**power for power in (1, 2))
    if low * high > 0.0 and abs(other) < abs(far):
        return one, other
    return low + SHARES[0] * (high - low), low + SHARES[1] * (high - low)


def _short(box: tuple[float, float]) -> float:
    """A number of few digits in a box, or next to a narrow one."""
    low, high = box
    middle = 0.5 * (low + high)
    reach = max(high - low, 1e-9 * max(1.0, abs(middle)))
    numbers = (round(middle, digits) for digits in range(10))
    return next((number for number in numbers if abs(number - middle) <= reach), middle)
