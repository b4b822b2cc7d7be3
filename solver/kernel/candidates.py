"""From candidates to answers: refined on the whole block, checked, distinct; and the outcome of a
block."""

from __future__ import annotations

import math
from collections.abc import Sequence
from contextlib import suppress
from typing import NamedTuple

import numpy as np

from rulesheets.evaluate import Undefined
from rulesheets.evaluate.digits import context
from rulesheets.functions import TABLE
from rulesheets.model import Equation
from rulesheets.syntax.nodes import calls
from solver.accuracy.rule_check import check_rule
from solver.accuracy.rule_sides import MANY, gross, jumps
from solver.facts import Attempt, DoubleRoot, Fact, Method, OutOfRange
from solver.kernel.block import BlockKernel
from solver.kernel.problem import BlockProblem, Point, Uncertainty, is_beside_pole, uncertainty
from solver.numerics.linear_algebra import null_direction
from solver.numerics.newton import STANDARD_LIMITS, NewtonLimits, Outcome, newton
from solver.numerics.tolerances import (
    BESIDE_ROOT,
    BLUR,
    CORNER,
    COVERED,
    EPS,
    MEANINGLESS,
    MOVES,
    MULTIPLE,
    NEARLY,
    ORDINARY,
    ROUNDED,
    SAFETY,
    SAME_VALUE,
    SIMPLE,
    STEEPER,
    VANISHED,
)

TINY = 1e-8
"""An unknown smaller than this share of its typical size is measured by that: it may be 0."""
MOST_ANSWERS, MOST_BESIDE, MOST_SINGULAR, MOST_STRAYS = 1_000, 8, 12, 48
MOST_REPEATED = 48
"""Answers of a block that has some in each period, beyond which no others are listed."""
MOST_DULL = 12
"""Points whose refinement gives no new answer: a plateau that is 0 to rounding has infinitely
many."""
FAR_DIGITS, FARTHER = 60, 1e3
"""Decimal digits of a number next to 1, and how much farther out a residual is compared."""
REMOTE = 1e60
"""A size beyond all practical numbers."""


class Answer(NamedTuple):
    """Values of the unknowns of a block; ``double`` if the answer is not a simple root, ``counted``
    if exact arithmetic has shown that it is a root."""

    values: Point
    double: DoubleRoot | None = None
    counted: bool = False


class Candidates:
    """The distinct answers found so far, and the nearest miss."""

    def __init__(self, problem: BlockProblem) -> None:
        self.problem = problem
        self.answers: list[Answer] = []
        self.sensible: Answer | None = None
        self.outside: Fact | None = None
        self.suspects: list[dict[str, float]] = []
        self.holes: list[dict[str, float]] = []
        self.unresolved: list[dict[str, float]] = []
        self.miss = math.inf
        self.nearest: tuple[Point, tuple[float, ...]] = {}, ()
        self.attempts: list[Attempt] = []
        self.strays = self.dull = 0
        self.accidental = set[str]()

    def tried(self, method: Method, complete: bool = False) -> None:
        """Record the new answers of a method."""
        before = sum(attempt.found for attempt in self.attempts)
        self.attempts.append(Attempt(method, len(self.answers) - before, complete))

    @property
    def is_empty(self) -> bool:
        """Whether nothing was found, not even a root out of range."""
        return not (self.answers or self.outside)

    @property
    def has_too_many(self) -> bool:
        """Whether there are so many answers besides the preferred one, if that is known, that
        nobody wants the list: two for every load of a network, say."""
        return self.sensible is not None and len(self.answers) > MOST_BESIDE

    @property
    def is_repeating(self) -> bool:
        """Whether there are many answers, and more in further periods."""
        return len(self.answers) >= MOST_REPEATED and bool(self.problem.kernel.repeating)

    @property
    def endless(self) -> bool:
        """Whether more starts would only find more of a curve of answers, or of a valley without
        any, or the answers of further periods."""
        singular = sum(answer.double is not None for answer in self.answers)
        too_many = self.has_too_many or self.is_repeating
        return singular >= MOST_SINGULAR or self.strays >= MOST_STRAYS or too_many

    def take(self, trial: Candidates) -> None:
        """Take over the answers of a method that had to find all."""
        self.answers += trial.answers
        self.unresolved += trial.unresolved
        self.outside = self.outside or trial.outside

    def refine(self, start: Sequence[float], limits: NewtonLimits = STANDARD_LIMITS) -> None:
        """Newton on the whole block, so that the digits do not depend on how the candidate was
        found."""
        problem = self.problem
        sizes = problem.sizes_at(start, TINY)
        result = newton(problem.residual, problem.jacobian, start, sizes, limits)
        trials = [tuple(start)]
        if result.outcome.found:
            vanished, rounded = (  # with 0 for what is no more than a share of its size
                tuple(
                    0.0 if abs(v) <= share * size else v
                    for v, size in zip(result.x, sizes, strict=True)
                )
                for share in (VANISHED, EPS)
            )
            trials = list(dict.fromkeys((vanished, result.x, rounded, *trials)))
        for x in trials:
            point = problem.named(x)
            self.note(point)
            if problem.holds(point):
                self.keep(point, singular=result.outcome is Outcome.SINGULAR_JACOBIAN)
                return
        point = problem.named(result.x)
        # on a plateau that is 0 in floats alone
        self.strays += result.outcome is Outcome.SINGULAR_JACOBIAN and self.problem.fits(point)
        if not result.outcome.found or self.dull >= MOST_DULL or not self.nearly(point):
            return
        cleared = _cleared(point, uncertainty(problem, point).errors)
        if cleared != point and problem.holds(cleared):
            self.keep(cleared)
            return
        from solver.kernel.root_check import sharp_root

        self.dull += (
            1  # the float next to a root that floats converge to, if every equation holds there
        )
        sharp = sharp_root(problem, result.x, sizes)
        found = None if sharp is None else problem.named(sharp)
        if found is not None and self._near(found, point, BLUR) and problem.holds(found):
            known = len(self.answers)
            self.keep(found)
            self.dull -= len(self.answers) > known

    def keep(
        self,
        point: dict[str, float],
        singular: bool = False,
        alone: float = 0.0,
        counted: bool = False,
    ) -> None:
        """Add a point at which the rules hold, if it is a new answer.

        ``alone``: a radius, relative to the unknowns, within which Newton's method has shown a
        simple root. ``counted``: exact arithmetic has shown that it is a root.
        """
        if len(self.answers) >= MOST_ANSWERS:
            return
        point = self.problem.inside(self.problem.wrapped(point))
        name = self.problem.outside(point)
        if name is not None:
            self.outside = OutOfRange(self.problem.equations[0], name, point[name])
            return
        found = uncertainty(self.problem, point)
        errors = found.errors
        clear = self._with_zeros(point, found)
        if clear != point and self.problem.holds(clear):
            point = clear
            found = found if found.relative is not None else uncertainty(self.problem, clear)
            errors = found.errors
        vague = self._open(point, errors, MULTIPLE)
        if found.relative is not None and alone > SAFETY * found.relative:
            vague = False
        multiple = vague or (
            self._open(point, errors, SIMPLE) and (singular or self._has_fold(point, errors))
        )
        beside = self.problem.beside
        outside = [one for one in self.answers if one.double and not self.problem.fits(one.values)]
        if multiple and outside and not self.problem.fits(point):
            return  # of a curve outside the case one point is enough
        repeated = (
            self._near(beside(point, one.values), one.values, ROUNDED) for one in self.answers
        )
        if not multiple and any(repeated):  # most starts lead to an answer that is known
            return
        if counted or (self.has_root_nearby(point, found) and not self._recedes(point)):
            self._add(Answer(point, self._double(point) if multiple else None, counted), errors)

    def _has_fold(self, point: Point, errors: Sequence[float]) -> bool:
        """Whether the Jacobian is singular within the error bars of a point: rounding does not tell
        this answer from another beyond the fold."""
        x = list(point.values())
        if len(x) > MANY:
            return False
        try:
            direction = null_direction(self.problem.matrix(x), x)
            step = min(e / abs(d) for e, d in zip(errors, direction, strict=True) if abs(d) > MOVES)
            signs = {
                float(np.linalg.slogdet(self.problem.jacobian(moved))[0])
                for side in (-step, step)
                for moved in [[v + side * d for v, d in zip(x, direction, strict=True)]]
            }
        except (ArithmeticError, ValueError):
            return False
        return len(signs) > 1

    def _is_corner(self, point: Point, direction: Sequence[float]) -> bool:
        """Whether some rule changes to first order on either side of a point, where its slope is
        taken as 0 at a kink: the only answer beside it is that point."""
        moving = zip(point.values(), direction, strict=True)
        step = BESIDE_ROOT * min(abs(v or 1.0) / abs(d) for v, d in moving if abs(d) > MOVES)

        def misses(rule: Equation, share: float) -> tuple[float, float]:
            moved = zip(point.items(), direction, strict=True)
            there = {**self.problem.here, **{n: v + share * step * d for (n, v), d in moved}}
            check = check_rule(rule, there)
            return abs(check.miss or 0.0), check.scaled

        def bends(rule: Equation, side: float) -> bool:
            miss, scaled = misses(rule, side)
            return scaled > CORNER * BESIDE_ROOT and misses(rule, 2.0 * side)[0] < STEEPER * miss

        rules = [
            rule
            for rule in self.problem.kernel.equations
            for call in calls(*rule.sides)
            if not TABLE[call.function].smooth
        ]
        return all(any(bends(rule, side) for rule in rules) for side in (1.0, -1.0))

    def _with_zeros(self, point: dict[str, float], found: Uncertainty) -> dict[str, float]:
        """The point with 0 for values that are no larger than their errors: of a large block, where
        whole parts may be 0, as flows that balance; else at a double root, or where more digits
        make them 0."""
        if found.relative is not None:
            return _cleared(point, found.errors)
        sizes = zip(found.errors, self.problem.scale, strict=True)
        clear = _cleared(point, [min(error, TINY * size) for error, size in sizes])
        if clear == point or self._open(point, found.errors, SIMPLE):
            return clear
        from solver.kernel.root_check import root_beside

        root = root_beside(self.problem, point)[0] or point
        return {n: clear[n] if abs(root[n]) <= EPS * abs(v) else v for n, v in point.items()}

    def has_root_nearby(self, point: dict[str, float], found: Uncertainty) -> bool:
        """Whether a root of the block lies within the error bars of a point at which its rules
        hold. One that is too close to a division by 0 for floats is recorded for more digits."""
        # rules and block so well-conditioned that a root is near if the rules hold
        small = ORDINARY * EPS
        if found.relative is None:
            sized = zip(found.errors, point.values(), strict=True)
            ordinary = all(error <= small * abs(v) for error, v in sized if v)
        else:
            ordinary = found.relative <= small
        ordinary = ordinary and found.steepness <= ORDINARY
        # beside a jump, what slopes lead to may lie on its other side
        ordinary = ordinary and not any(map(jumps, self.problem.kernel.equations))
        if ordinary and not is_beside_pole(self.problem, point, found):
            return True
        from solver.kernel.root_check import RootCheck, check_root  # most answers are ordinary

        verdict, root = check_root(self.problem, point, found)
        finite = [error if math.isfinite(error) else 0.0 for error in found.errors]
        if verdict is RootCheck.STANDS and self._open(point, finite, MEANINGLESS):
            verdict = RootCheck.NO_ROOT  # no digit of some unknown is left, as of the sine of 1e99
        if verdict is RootCheck.BESIDE_POLE:
            self._leave_unresolved(root)
        self.strays += verdict is RootCheck.NO_ROOT
        return verdict is RootCheck.STANDS

    def _recedes(self, point: Point) -> bool:
        """Whether a point far out is only on the way to a root at infinity: farther out the
        residual, followed along a chain in many digits, is nearer to 0 but not 0."""
        kernel = self.problem.kernel
        tear, *others = kernel.block.tears or kernel.unknowns
        x = point[tear]
        if others or not self.problem.is_far_out({tear: x}):
            return False
        from solver.kernel.chain import followed

        # of 1/x its cube, too, is to count beside 1
        digits = FAR_DIGITS + max(0, math.frexp(x)[1])
        tears = [context(digits).mpf(v) for v in (x, FARTHER * x)]
        misses = []
        for chain in kernel.chains:
            with suppress(Undefined, ArithmeticError, ValueError):
                ends = (followed(chain, {**self.problem.here, tear: v}, digits) for v in tears)
                misses.append([abs(end[chain.residuals[0]]) for end in ends])
        return any(0 < beyond < 2 * here for here, beyond in sorted(misses)[:1])

    def _leave_unresolved(self, root: dict[str, float]) -> None:
        """Record a root that floats do not resolve."""
        if not any(self._near(root, other, COVERED) for other in self.unresolved):
            self.unresolved.append(root)

    def _add(self, found: Answer, errors: Sequence[float]) -> None:
        """Add an answer, unless it is within rounding of a known one or on one curve with it."""
        point = found.values
        for index, answer in enumerate(self.answers):
            other = answer.values
            here = self.problem.beside(point, other)
            if not self._near(here, other, BLUR):
                continue
            if not (self._near(here, other, ROUNDED) or _within(here, other, errors)):
                shares = (0.25, 0.5, 0.75)  # connected by points at which the rules hold?
                between = (
                    {n: v + share * (other[n] - v) for n, v in here.items()} for share in shares
                )
                if not all(map(self.problem.holds, between)):
                    continue
            if found.double and not answer.double and not self._near(here, other, SAME_VALUE, 0.0):
                self.answers[index] = found  # the other one differs from it by rounding
            return
        self.answers.append(found)

    def _open(self, point: Point, errors: Sequence[float], share: float) -> bool:
        """Whether rounding leaves an unknown uncertain by more than that share of its size."""
        sizes = self.problem.sizes_at(list(point.values()))
        return any(error > share * size for error, size in zip(errors, sizes, strict=True))

    def settles(self, point: dict[str, float]) -> bool:
        """Whether a point is clearly next to an answer or an excluded root (kept), or clearly
        not."""
        count, outside = len(self.answers), self.outside
        self.refine(list(point.values()))
        if len(self.answers) > count or self.outside is not outside:
            return True
        from solver.kernel.root_check import is_clearly_violated

        return is_clearly_violated(self.problem, point)

    def proven(self, point: dict[str, float]) -> None:
        """Try a point next to a root that is proven to exist; record it if floats find no answer
        there, however far off (``ln(exp(x)) = 1e-27`` has an answer that they do not come near). A
        root of the rules multiplied out may not be one of the rules as written: Newton's method
        then leads elsewhere."""
        self.refine(list(point.values()))
        if self._is_known(point) or self.problem.outside(point) is not None:
            return
        from solver.kernel.root_check import root_beside

        root, leads_away = root_beside(self.problem, point)
        if root is not None and self.problem.holds(root):
            self.keep(root)  # where rounding in the rules keeps Newton's method in floats away
        if not (leads_away or (root is not None and self._is_known(root))):
            self._leave_unresolved(point)

    def _is_known(self, root: Point) -> bool:
        beside = self.problem.beside
        return any(self.covers(answer, beside(root, answer.values)) for answer in self.answers)

    def separate(self, roots: Sequence[Point]) -> None:
        """Record which of these roots, proven to be different, rounding has merged with another:
        points between two close roots may all satisfy the rules as far as floats tell."""
        taken: set[int] = set()
        for root in roots:
            covering = [
                (max(abs(v - answer.values[name]) for name, v in root.items()), place)
                for place, answer in enumerate(self.answers)
                if self.covers(answer, root)
            ]
            if covering:
                _, nearest = min(covering)
                if nearest in taken:
                    self.unresolved.append(dict(root))
                taken.add(nearest)

    def covers(self, answer: Answer, root: Point) -> bool:
        """Whether an answer equals that root, up to rounding."""
        if self._near(root, answer.values, COVERED):
            return True
        far = self._near(root, answer.values, BLUR)
        return far and _within(root, answer.values, uncertainty(self.problem, answer.values).errors)

    def suspect(self, point: dict[str, float]) -> None:
        """Record a point that nearly satisfies every equation, or a root near it."""
        from solver.kernel.root_check import root_beside

        root, _ = root_beside(self.problem, point, reach=1.0, most=10)
        if root is not None:
            self.proven(root)
        elif self.nearly(point):
            self.suspects.append(point)

    def nearly(self, point: dict[str, float], share: float = NEARLY) -> bool:
        """Whether every residual at a point is no more than a ``share`` of the terms of its
        equation."""
        everything = {**self.problem.here, **point}
        if any(abs(v) > REMOTE for v in point.values()):
            return False
        try:
            misses = self.problem.residual(list(point.values()))
        except (ArithmeticError, ValueError):
            return False
        sizes = (gross(equation, everything) for equation in self.problem.kernel.equations)
        return all(abs(miss) <= share * size for miss, size in zip(misses, sizes, strict=True))

    def note(self, point: dict[str, float]) -> None:
        """Record the nearest miss inside the ranges, by the largest residual, with all
        residuals."""
        problem, x = self.problem, list(point.values())
        try:
            if len(x) > MANY:
                misses = problem.sparse[0](np.array(x))
            else:
                misses = np.array(problem.residual(x))
        except (ArithmeticError, ValueError):
            return
        if (size := float(np.abs(misses).max())) < self.miss and problem.outside(point) is None:
            self.miss, self.nearest = size, (point, tuple(misses.tolist()))

    def _near(self, one: Point, other: Point, tolerance: float, least: float = 0.01) -> bool:
        """Alike, up to a share of their own sizes or of their usual ones; or of the largest number
        in either, if no unknown comes near its usual size."""
        scales = self.problem.scale
        # of every pair: most part at once
        for (name, v), scale in zip(one.items(), scales, strict=True):
            w = other[name]
            apart = abs(v - w)
            if not apart <= tolerance * max(abs(v), abs(w), least * scale):
                return False
            if least and scale > 1.0 and apart > tolerance * max(abs(v), abs(w)):
                largest = max(1.0, *map(abs, one.values()), *map(abs, other.values()))
                if apart > tolerance * least * largest:
                    return False
        return True

    def _double(self, point: dict[str, float]) -> DoubleRoot | None:
        x = list(point.values())
        try:
            direction = null_direction(self.problem.matrix(x), x)
        except (ArithmeticError, ValueError):
            direction = (1.0,) * len(x)
        if self._is_corner(point, direction):
            return None
        moving = {n: d for n, d in zip(point, direction, strict=True) if abs(d) > MOVES}
        return DoubleRoot(self.problem.equations, tuple(moving), moving)


def _cleared(point: Point, errors: Sequence[float]) -> dict[str, float]:
    """The point with 0 for values that are no larger than their error bars."""
    return {n: v if abs(v) > e else 0.0 for (n, v), e in zip(point.items(), errors, strict=True)}


def _within(one: Point, other: Point, errors: Sequence[float]) -> bool:
    """Whether two points differ by less than rounding."""
    return all(
        abs(v - other[n]) <= 4 * error for (n, v), error in zip(one.items(), errors, strict=True)
    )


class Undecided(NamedTuple):
    """A short interval of the tear that a search along the chain at ``place`` could not decide."""

    kernel: BlockKernel
    place: int
    low: float
    high: float


class BlockOutcome(NamedTuple):
    """``answers`` are distinct, the preferred one first; ``complete`` if they are proven to be all.

    ``facts`` explain what is missing; ``free`` are unknowns that the block does not determine (then
    the one answer holds what it does determine). ``attempts`` are the methods that were tried.
    ``suspects`` are points that nearly satisfy the block, at which floats do not tell whether there
    are two roots, one, or none. If only these prevent ``complete``, ``stretches`` are where they
    lie. ``holes`` are points beside which rules nearly hold and at which one is 0/0. ``unresolved``
    are near roots that are proven to exist, but that floats cannot represent well enough to be
    answers; with them all would be known if ``whole``. ``doubtful``: rounding may have decided
    whether a linear block determines its unknowns, or contradicts itself. ``cut``: there are more
    answers than are listed. ``accidental``: known numbers without which some rule would not be 0/0
    somewhere.
    """

    answers: tuple[Answer, ...] = ()
    complete: bool = False
    facts: tuple[Fact, ...] = ()
    free: tuple[str, ...] = ()
    attempts: tuple[Attempt, ...] = ()
    suspects: tuple[Point, ...] = ()
    holes: tuple[Point, ...] = ()
    stretches: tuple[Undecided, ...] = ()
    unresolved: tuple[Point, ...] = ()
    whole: bool = False
    doubtful: bool = False
    cut: bool = False
    accidental: frozenset[str] = frozenset()

    @property
    def delicate(self) -> bool:
        unclear = self.suspects or self.unresolved
        return self.doubtful or bool(unclear) or any(answer.double for answer in self.answers)

    @classmethod
    def out_of_range(cls, equations: tuple[int, ...], name: str, value: float) -> BlockOutcome:
        return cls(complete=True, facts=(OutOfRange(equations[0], name, value),))
