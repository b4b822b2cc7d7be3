"""A curve of answers: a block that leaves its unknowns free at the numbers at hand, however it is torn.

Where rules say the same at these numbers, be it in a roundabout way, the answers are no points but a curve.
No search for points finds it, and exact arithmetic may even prove that there is nothing: numbers that agree
to their last places contradict one another beyond these. Here points are sought that satisfy the rule check;
one from which a way leads on along which all rules still hold is a point of a curve.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

from solver.kernel.candidates import Answer
from solver.kernel.freedom import rank_loss
from solver.kernel.outcome import BlockOutcome
from solver.kernel.question import Question

if TYPE_CHECKING:
    from numpy.typing import NDArray

MAX_UNKNOWNS = 60
WORK = 400
"""Starts times unknowns of a search."""
FEWEST, MOST = 6, 32
ENDS = 6
"""Ends of a search that are looked at."""
NULL = 1e-7
"""Singular values of the scaled Jacobian below that share of the largest leave a direction free."""
AWAY = 0.02
"""How far along a direction, in units of the unknowns, rules have to hold still."""
MOVED = 1e-9
"""Share of its size by which an unknown moves that is free."""
CORRECTIONS = 4


def free_curve(question: Question) -> BlockOutcome | None:
    """What a block leaves free at a point that satisfies it; None where no such point is found."""
    kernel = question.kernel
    if not kernel.smooth or len(question.unknowns) > MAX_UNKNOWNS:
        return None
    import numpy as np

    with np.errstate(all="ignore"):
        try:
            return _Curve(question).found()
        except (ArithmeticError, ValueError, np.linalg.LinAlgError):
            return None


def curve_through(question: Question, point: Mapping[str, float]) -> BlockOutcome | None:
    """What a block leaves free at an answer of it; None where no way leads on from there."""
    if not question.kernel.smooth or len(question.unknowns) > MAX_UNKNOWNS:
        return None
    import numpy as np

    with np.errstate(all="ignore"):
        try:
            return _Curve(question).through(np.array([point[name] for name in question.unknowns]))
        except (ArithmeticError, ValueError, np.linalg.LinAlgError):
            return None


class _Curve:
    def __init__(self, question: Question) -> None:
        import numpy as np

        from solver.kernel.search.start_search import sizes_of

        self.question = question
        sizes = sizes_of(question)
        self.sizes = sizes
        self.scale = np.array([sizes[name] for name in question.unknowns])
        self.low = np.array([variable.low for variable in question.variables])
        self.high = np.array([variable.high for variable in question.variables])

    def found(self) -> BlockOutcome | None:
        from solver.kernel.search.start_search import starts_of

        count = min(max(WORK // len(self.scale), FEWEST), MOST)
        ends = self._projected(starts_of(self.question, self.sizes, 0, count // 2))
        for end in sorted(ends, key=lambda x: float(max(abs(x) / self.scale)))[:ENDS]:
            point = self._settled(end)
            if point is not None and (freedom := self.through(point)) is not None:
                return freedom
        return None

    def _projected(self, starts: NDArray[Any]) -> NDArray[Any]:
        from solver.numerics.multistart import project

        arrays, known = self.question.kernel.arrays, self.question.known
        residual, jacobian = partial(arrays.residual, known), partial(arrays.jacobian, known)
        return project(residual, jacobian, starts, self.scale, self.low, self.high)

    def _settled(self, x: NDArray[Any]) -> NDArray[Any] | None:
        """The point with a few corrections of least norm, if every rule holds there and it is in range."""
        import numpy as np

        question = self.question
        for _ in range(CORRECTIONS):
            point = question.named(x.tolist())
            if question.holds(point):
                return x if question.outside(point) is None else None
            matrix, weight, rows = self._scaled(x)
            miss = np.array(question.residual(x.tolist())) / rows
            x = x - weight * np.linalg.lstsq(matrix, miss, rcond=NULL)[0]
        return None

    def _scaled(self, x: NDArray[Any]) -> tuple[NDArray[Any], NDArray[Any], NDArray[Any]]:
        """The Jacobian in units of the unknowns and of the rules, and these units."""
        import numpy as np

        weight = np.maximum(abs(x), 1e-3 * self.scale)
        matrix = np.array(self.question.jacobian(x.tolist()), dtype=float) * weight
        rows = abs(matrix).max(axis=1)
        if not np.isfinite(rows).all():
            raise ValueError("a slope is infinite")
        rows = np.where(rows > 0.0, rows, 1.0)
        return matrix / rows[:, None], weight, rows

    def through(self, x: NDArray[Any]) -> BlockOutcome | None:
        """What is free along every direction from the point in which all rules hold on."""
        import numpy as np

        matrix, weight, _ = self._scaled(x)
        _, singular, right = np.linalg.svd(matrix)
        ways = [direction for s, direction in zip(singular, right, strict=True) if s <= NULL * singular[0]]
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
