"""Answers of a block that are no isolated ones, but points of a curve along which all its rules hold."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from solver.attempts import Attempt, Method
from solver.kernel.candidates import Answer
from solver.kernel.outcome import BlockOutcome
from solver.kernel.question import Question

MOST = 12
"""Answers that are looked at; what is flat beyond these counts as what they are."""


def without_curves(question: Question, outcome: BlockOutcome) -> BlockOutcome:
    """The outcome without answers that lie on a curve; what the curve leaves free, where it has no others.

    A list of some points of a curve says nothing of the others, so that it is never complete.
    """
    suspects = [answer for answer in outcome.answers if answer.double]
    if not suspects or outcome.free or len(question.unknowns) == 1:
        return outcome
    from solver.kernel.search.free_curve import curve_through
    from solver.kernel.search.off_curve import beside

    found = [curve_through(question, answer.values) for answer in suspects[:MOST]]
    curves = [curve for curve in found if curve is not None]
    if not curves:
        return outcome
    points = [a for a, curve in zip(suspects, found, strict=False) if curve is not None] + suspects[MOST:]
    others = _but(outcome.answers, points)
    if others:
        facts = (*outcome.facts, beside(curves[0]))
        return replace(outcome, answers=others, complete=False, whole=False, stretches=(), facts=facts)
    return replace(curves[0], attempts=(*outcome.attempts, Attempt(Method.CURVE, 1)))


def _but(answers: Sequence[Answer], points: Sequence[Answer]) -> tuple[Answer, ...]:
    return tuple(answer for answer in answers if not any(answer is point for point in points))
