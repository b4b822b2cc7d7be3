"""One answer of a large block, the sensible one: Newton's method on all unknowns at once, none of them torn.

It starts from the guesses where there are any, else from 0, where its first step solves the linearised rules,
from positive numbers of the sizes that balance the rules, and from 1. An answer with no negative number ends
the search; one with some is kept, and looked for is one that keeps to positive numbers.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from solver.kernel.candidates import Candidates
from solver.kernel.question import MANY, Question
from solver.numerics.linear_algebra import Array
from solver.numerics.sparse_newton import sparse_newton
from solver.ranking.sizes import nearly_balanced

MOST, POSITIVE_ITERATIONS = 100, 40


def search_sparsely(question: Question, candidates: Candidates, every: bool = False) -> None:
    """Try starts in turn until an answer stands that none is to be preferred to, or ``every`` one."""
    if question.sparse is None:
        return
    residual, jacobian = question.sparse
    for start, sizes, positive, most in _starts(question):
        if candidates.answers and not (positive or every):
            continue
        root = sparse_newton(residual, jacobian, start, sizes, positive, most)
        if not np.isfinite(root.x).all():
            continue
        point = question.named(root.x.tolist())
        if root.converged and len(point) <= MANY:
            candidates.refine(root.x.tolist())
        elif root.converged and question.holds(point):
            candidates.keep(point)
        else:
            candidates.note(point)
        if candidates.answers and not every and (question.guesses or not _negative(question, candidates)):
            return


def _starts(question: Question) -> Iterator[tuple[Array, Array | None, bool, int]]:
    """Points, sizes, whether unknowns that are positive are kept so, and the most iterations."""
    if not question.guesses:
        yield defined(question, _inside(question, np.zeros(len(question.unknowns)))), None, False, MOST
    turns = np.array([question.turn(name) or math.nan for name in question.unknowns])
    sizes, turning = _sizes(question, turns), ~np.isnan(turns)
    inside = _inside(question, np.where(turning, 0.0, sizes))
    if question.guesses:
        guesses = question.guesses
        named = [guesses.get(n, v) for n, v in zip(question.unknowns, inside.tolist(), strict=True)]
        yield np.array(named), sizes, False, MOST
        yield defined(question, _inside(question, np.zeros(len(sizes)))), sizes, False, MOST
    yield inside, sizes, True, POSITIVE_ITERATIONS
    yield _inside(question, np.where(turning, 0.0, 1.0)), sizes, False, MOST
    yield inside, sizes, False, MOST


def defined(question: Question, x: Array) -> Array:
    """The point with every unknown that a rule tells outright as that has it."""
    system = question.kernel.sparse
    return x if system is None else _inside(question, system.with_told(x, question.known))


def _inside(question: Question, x: Array) -> Array:
    """The point with every unknown in its range."""
    low, high = np.array([(v.low, v.high) for v in question.variables]).T
    return np.asarray(np.clip(x, low, high))


def _sizes(question: Question, turns: Array) -> Array:
    """Of a guess its own size; of an angle a quarter of its turn; else that which balances the rules."""
    names = question.kernel.known
    known = {name: v for name in names if isinstance(v := question.here[name], float)}
    balanced = nearly_balanced(question.kernel.alike, question.unknowns, known)
    guessed = np.abs([question.guesses.get(name, 0.0) for name in question.unknowns])
    return np.where(guessed > 0.0, guessed, np.where(np.isnan(turns), balanced, turns / 4))


def _negative(question: Question, candidates: Candidates) -> bool:
    """Whether every answer so far has a negative number where none is declared or turns."""
    free = {v.name for v in question.variables if v.low == -math.inf and question.turn(v.name) is None}
    return all(any(v < 0.0 and n in free for n, v in a.values.items()) for a in candidates.answers)
