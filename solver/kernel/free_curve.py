"""A curve of answers: a block that leaves its unknowns free at the numbers at hand, however it is torn.

Where rules say the same at these numbers, be it in a roundabout way, the answers are no points but a curve.
No search for points finds it, and exact arithmetic may even prove that there is nothing: numbers that agree
to their last places contradict one another beyond these. Here points are sought that satisfy the rule check;
one from which a way leads on along which all rules still hold is a point of a curve.

A block may have isolated answers beside a curve of them, such as where a common factor is 0. Some starts lead
to these, others to points of the curve.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from solver.facts import Attempt, Beside, Method, RankLoss
from solver.kernel.candidates import Answer, BlockOutcome, Candidates
from solver.kernel.full_search import sizes_of, starts_of
from solver.kernel.question import Question, rank_loss
from solver.numerics.multistart import GAUSS_NEWTON, arrivals
from solver.numerics.newton import NewtonLimits
from solver.numerics.tolerances import FREE, MOVED

MAX_UNKNOWNS = 60
WORK = 400
"""Starts times unknowns of a search."""
FEWEST, MOST = 6, 32
ENDS = 6
"""Ends of a search that are looked at."""
AWAY = 0.02
"""How far along a direction, in units of the unknowns, rules have to hold still."""
CORRECTIONS = 4


def free_curve(question: Question) -> BlockOutcome | None:
    """What a block leaves free at a point that satisfies it; None where no such point is found."""
    kernel = question.kernel
    if not kernel.smooth or len(question.unknowns) > MAX_UNKNOWNS:
        return None
    with np.errstate(all="ignore"):
        try:
            return _Curve(question).found()
        except (ArithmeticError, ValueError, np.linalg.LinAlgError):
            return None


def curve_through(question: Question, point: Mapping[str, float]) -> BlockOutcome | None:
    """What a block leaves free at an answer of it; None where no way leads on from there."""
    if not question.kernel.smooth or len(question.unknowns) > MAX_UNKNOWNS:
        return None
    with np.errstate(all="ignore"):
        try:
            return _Curve(question).through(np.array([point[name] for name in question.unknowns]))
        except (ArithmeticError, ValueError, np.linalg.LinAlgError):
            return None


class _Curve:
    def __init__(self, question: Question) -> None:

        self.question = question
        sizes = sizes_of(question)
        self.sizes = sizes
        self.scale = np.array([sizes[name] for name in question.unknowns])
        self.low = np.array([variable.low for variable in question.variables])
        self.high = np.array([variable.high for variable in question.variables])

    def found(self) -> BlockOutcome | None:

        count = min(max(WORK // len(self.scale), FEWEST), MOST)
        ends = self._projected(starts_of(self.question, self.sizes, 0, count // 2))
        for end in sorted(ends, key=lambda x: float(max(abs(x) / self.scale)))[:ENDS]:
            point = self._settled(end)
            if point is not None and (freedom := self.through(point)) is not None:
                return freedom
        return None

    def _projected(self, starts: NDArray[Any]) -> NDArray[Any]:

        arrays, known = self.question.kernel.arrays, self.question.known
        residual, jacobian = partial(arrays.residual, known), partial(arrays.jacobian, known)
        return arrivals(residual, jacobian, starts, self.scale, GAUSS_NEWTON, (self.low, self.high))

    def _settled(self, x: NDArray[Any]) -> NDArray[Any] | None:
        """The point with a few corrections of least norm, if every rule holds there and it is in range."""
        question = self.question
        for _ in range(CORRECTIONS):
            point = question.named(x.tolist())
            if question.holds(point):
                return x if question.outside(point) is None else None
            matrix, weight, rows = self._scaled(x)
            miss = np.array(question.residual(x.tolist())) / rows
            x = x - weight * np.linalg.lstsq(matrix, miss, rcond=FREE)[0]
        return None

    def _scaled(self, x: NDArray[Any]) -> tuple[NDArray[Any], NDArray[Any], NDArray[Any]]:
        """The Jacobian in units of the unknowns and of the rules, and these units."""
        weight = np.maximum(abs(x), 1e-3 * self.scale)
        matrix = np.array(self.question.jacobian(x.tolist()), dtype=float) * weight
        rows = abs(matrix).max(axis=1)
        if not np.isfinite(rows).all():
            raise ValueError("a slope is infinite")
        rows = np.where(rows > 0.0, rows, 1.0)
        return matrix / rows[:, None], weight, rows

    def through(self, x: NDArray[Any]) -> BlockOutcome | None:
        """What is free along every direction from the point in which all rules hold on."""
        matrix, weight, _ = self._scaled(x)
        _, singular, right = np.linalg.svd(matrix)
        ways = [direction for s, direction in zip(singular, right, strict=True) if s <= FREE * singular[0]]
        others = [there for way in ways if (there := self._along(x, way * weight)) is not None]
        if not others:
            return None
        changes = np.max([abs(there - x) / weight for there in others], axis=0)
        question, point = self.question, self.question.named(x.tolist())
        free = tuple(n for n, moves in zip(question.unknowns, changes, strict=True) if moves > MOVED)
        if not free:
            return None
        change = question.named((others[0] - x).tolist())
        largest = max(abs(change[name]) for name in free) or 1.0
        direction = {name: far / largest if name in free else 0.0 for name, far in change.items()}
        fact = rank_loss(question, point, direction, free)
        fixed = {name: number for name, number in point.items() if name not in free}
        return BlockOutcome((Answer(fixed),), complete=True, facts=(fact,), free=free)

    def _along(self, x: NDArray[Any], way: NDArray[Any]) -> NDArray[Any] | None:
        """A point some way on at which every rule holds, on either side."""
        for side in (AWAY, -AWAY):
            for there in self._projected((x + side * way)[None, :]):
                settled = self._settled(there)
                if settled is not None and _apart(settled, x, way):
                    return settled
        return None


def _apart(one: Sequence[float] | Any, other: Any, way: Any) -> bool:
    """Whether a point lies as far from another as it was moved, or nearly."""
    moved, meant = float(abs(one - other).max()), float(abs(AWAY * way).max())
    return 0.1 * meant <= moved <= 10.0 * meant and math.isfinite(moved)


STARTS = 32
MOST_BESIDE = 12
"""Unknowns of a block up to which isolated answers are sought beside a curve."""
LIMITS = NewtonLimits(iterations=40, escapes=2)


def with_isolated(question: Question, curve: BlockOutcome) -> BlockOutcome:
    """The isolated answers, if any are found from a few starts, with the curve as a note; else the curve."""
    known = curve.answers[0].values if curve.answers else {}
    if not known or len(question.unknowns) > MOST_BESIDE or not question.kernel.smooth:
        return curve
    found = Candidates(question)
    for start in starts_of(question, sizes_of(question), 0, STARTS // 2).tolist():
        found.refine(start, LIMITS)
    regular = [answer for answer in found.answers if answer.double is None]
    answers = tuple(answer for answer in regular if curve_through(question, answer.values) is None)
    return BlockOutcome(answers, facts=(beside(curve),), attempts=curve.attempts) if answers else curve


def beside(curve: BlockOutcome) -> Beside:
    """The note on a curve that there are other answers than those on it."""
    known = tuple(curve.answers[0].values.items()) if curve.answers else ()
    equations = next((f.equations for f in curve.facts if isinstance(f, RankLoss)), ())
    return Beside(equations, curve.free, known)


MOST_SUSPECTS = 12
"""Answers that are looked at; what is flat beyond these counts as what they are."""


def without_curves(question: Question, outcome: BlockOutcome) -> BlockOutcome:
    """The outcome without answers that lie on a curve; what the curve leaves free, where it has no others.

    A list of some points of a curve says nothing of the others, so that it is never complete.
    """
    suspects = [answer for answer in outcome.answers if answer.double]
    if not suspects or outcome.free or len(question.unknowns) == 1:
        return outcome

    found = [curve_through(question, answer.values) for answer in suspects[:MOST_SUSPECTS]]
    curves = [curve for curve in found if curve is not None]
    if not curves:
        return outcome
    points = [a for a, curve in zip(suspects, found, strict=False) if curve is not None] + suspects[
        MOST_SUSPECTS:
    ]
    others = _but(outcome.answers, points)
    if others:
        facts = (*outcome.facts, beside(curves[0]))
        return outcome._replace(answers=others, complete=False, whole=False, stretches=(), facts=facts)
    return curves[0]._replace(attempts=(*outcome.attempts, Attempt(Method.CURVE, 1)))


def _but(answers: Sequence[Answer], points: Sequence[Answer]) -> tuple[Answer, ...]:
    return tuple(answer for answer in answers if not any(answer is point for point in points))
