"""Isolated answers of a block that also has a curve of them, such as where a common factor is 0.

Searches end on the curve, which attracts them from everywhere. So it is deflated: the residual is multiplied
by 1 + 1/d², where d is the distance from the values that unknowns keep along the curve (P. E. Farrell,
Á. Birkisson & S. W. Funke, SIAM J. Sci. Comput. 37 (2015) A2026–A2045).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from solver.facts import Beside, RankLoss
from solver.kernel.candidates import Candidates
from solver.kernel.outcome import BlockOutcome
from solver.kernel.question import Question
from solver.kernel.search.free_curve import curve_through
from solver.kernel.search.start_search import sizes_of, starts_of
from solver.numerics.newton import NewtonLimits, newton

STARTS = 16
MAX_UNKNOWNS = 12
NEAREST = 1e-30
"""The least square of a distance, so that a search may start on what is left out."""
LIMITS = NewtonLimits(iterations=40, escapes=2)


def with_isolated(question: Question, curve: BlockOutcome) -> BlockOutcome:
    """The isolated answers, if any are found, with the curve as a note; else the curve."""
    known = dict(curve.answers[0].values) if curve.answers else {}
    if not known or len(question.unknowns) > MAX_UNKNOWNS or not question.kernel.smooth:
        return curve
    found, deflated = Candidates(question), _Deflated(question)
    deflated.leave_out(known)
    for start in starts_of(question, sizes_of(question), 0, STARTS).tolist():
        sizes = [max(abs(v), s) for v, s in zip(start, question.scale(), strict=True)]
        end = newton(deflated.residual, deflated.jacobian, start, sizes, LIMITS)
        count = len(found.answers)
        if end.outcome.found:
            found.refine(end.x)
        for answer in found.answers[count:]:
            deflated.leave_out(answer.values)
    regular = [answer for answer in found.answers if answer.double is None]
    answers = tuple(answer for answer in regular if curve_through(question, answer.values) is None)
    return BlockOutcome(answers, facts=(beside(curve),), attempts=curve.attempts) if answers else curve


def beside(curve: BlockOutcome) -> Beside:
    """The note on a curve that there are other answers than those on it."""
    known = tuple(curve.answers[0].values.items()) if curve.answers else ()
    equations = next((f.equations for f in curve.facts if isinstance(f, RankLoss)), ())
    return Beside(equations, curve.free, known)


class _Deflated:
    """The residual of a block without what it has been told to leave out."""

    def __init__(self, question: Question) -> None:
        self.question = question
        self.scale = [size or 1.0 for size in question.scale()]
        self.out: list[list[tuple[int, float]]] = []

    def leave_out(self, values: Mapping[str, float]) -> None:
        """The points at which these unknowns have these values."""
        self.out.append([(k, values[n]) for k, n in enumerate(self.question.unknowns) if n in values])

    def residual(self, x: Sequence[float]) -> list[float]:
        factor = math.prod(1.0 + 1.0 / self._square(x, known) for known in self.out)
        return [factor * value for value in self.question.residual(x)]

    def jacobian(self, x: Sequence[float]) -> list[list[float]]:
        factor = math.prod(1.0 + 1.0 / self._square(x, known) for known in self.out)
        slopes = [0.0] * len(x)
        for known in self.out:
            square = self._square(x, known)
            for k, value in known:
                slopes[k] -= 2.0 * factor * (x[k] - value) / (self.scale[k] ** 2 * square * (square + 1.0))
        rows = zip(self.question.residual(x), self.question.jacobian(x), strict=True)
        return [
            [factor * a + value * slope for a, slope in zip(row, slopes, strict=True)] for value, row in rows
        ]

    def _square(self, x: Sequence[float], known: Sequence[tuple[int, float]]) -> float:
        return max(NEAREST, sum(((x[k] - value) / self.scale[k]) ** 2 for k, value in known))
