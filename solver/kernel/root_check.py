"""Whether there is a root of a block within the error bars of a point.

A rule holds if values within a few ulp of those reported satisfy it. Next to a removable 0/0 the
slopes are so large that anything passes: ``(a - b)/(x - 1)`` takes any value as its differences
round. A block that is not ordinary is therefore solved again from the answer in many digits. The
answer is accepted if this ends at a root within the error bar, and if moving the unknowns by that
bar does not reach a place where a rule divides by zero. For a large block, residuals in long floats
do, if their rounding is certainly small.

If a rule loses digits as it is evaluated (``1 - cos(x)`` at a small x), residuals in floats end the
search some roundings away from the root. Computed to many digits they lead on: iterative refinement
with the slopes of floats (N. J. Higham, *Accuracy and Stability of Numerical Algorithms*, 2002,
section 25.2).
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from enum import Enum, auto
from typing import Any

import numpy as np

from rulesheets.evaluate import Undefined
from rulesheets.evaluate.digits import context, extended
from solver.accuracy.alike import evaluated
from solver.accuracy.digits import linearized
from solver.accuracy.rule_check import absorbs
from solver.accuracy.rule_sides import gross, sides
from solver.kernel.problem import BlockProblem, Point, Uncertainty, is_beside_pole, uncertainty
from solver.numerics.elimination import eliminate
from solver.numerics.tolerances import (
    ASTRAY,
    BACKWARD,
    EPS,
    FAST,
    HIDDEN,
    ORDINARY,
    REFINED,
    SAFETY,
    SETTLED,
    SPARE,
)


def is_clearly_violated(problem: BlockProblem, point: Point) -> bool:
    """Whether a computed point is clearly not an answer: the residual of an equation exceeds a
    share of its terms, and the rounding of the point. A number that cancellation has left without
    digits does not count against the others."""
    x, here = list(point.values()), {**problem.here, **point}
    try:
        misses = problem.residual(x)
        equations = problem.kernel.equations
        far = [abs(m) > ASTRAY * gross(e, here) for m, e in zip(misses, equations, strict=True)]
        if not any(far):
            return False
        jacobian = problem.jacobian(x)
    except (ArithmeticError, ValueError):
        return False
    off = uncertainty(problem, point).errors
    explained = [sum(abs(s) * e for s, e in zip(row, off, strict=True) if s) for row in jacobian]
    return any(is_far and abs(m) > e for is_far, m, e in zip(far, misses, explained, strict=True))


REFINED_DIGITS = 60
REFINEMENTS = 8


def sharp_root(
    problem: BlockProblem, start: Sequence[float], sizes: Sequence[float]
) -> list[float] | None:
    """The root near ``start`` (n,), to the last place; None if the steps do not converge.

    ``sizes`` (n,) of the unknowns measure steps for unknowns that are 0.
    """
    mp, names = context(REFINED_DIGITS), problem.unknowns
    try:
        factor = problem.factor(start, sizes)
        if factor.rank < factor.columns:
            return None
        x = [mp.mpf(v) for v in start]
        for _ in range(REFINEMENTS):
            at = {**problem.here, **dict(zip(names, x, strict=True))}
            misses = [extended(form, at, REFINED_DIGITS) for form in problem.kernel.forms]
            # brought to unit size for the floats that solve for the step
            largest = max(map(abs, misses))
            floats = [float(miss / largest) if largest else 0.0 for miss in misses]
            step = [largest * d for d in factor.solution(floats).tolist()]
            x = [v - d for v, d in zip(x, step, strict=True)]
            if all(
                abs(d) <= REFINED * max(abs(v), size)
                for v, d, size in zip(x, step, sizes, strict=True)
            ):
                return [float(v) for v in x]
    except (Undefined, ArithmeticError, ValueError):
        return None
    return None


DIGITS = 60
ITERATIONS = 40
NEAR = 2e-4
"""The largest error bar of a point, relative to the size of its unknowns, that is followed
``FAR``."""
NUDGE = 1e-5
"""The share of an error bar by which another start differs from a point."""
HALVINGS = 12
SHRUNK = 1e-3
"""The share of its first residual that steps to a root leave."""
FAR = 100.0
"""The distance from an answer, in error bars, up to which a root is followed."""


class RootCheck(Enum):
    """The result of solving on from an answer."""

    STANDS = auto()
    NO_ROOT = auto()
    BESIDE_POLE = auto()


def check_root(
    problem: BlockProblem, point: Point, found: Uncertainty
) -> tuple[RootCheck, dict[str, float]]:
    """Solve on from a point at which every rule holds to rounding, with this uncertainty; return
    the result and the end point."""
    start = list(point.values())
    if found.relative is not None:  # a large block: its slopes stay those of floats
        there = dict(point)
        if found.relative > ORDINARY * EPS:
            sharp = root_in_long_floats(problem, start, found.errors)
            sharp = sharp or sharp_root(problem, start, problem.sizes_at(start))
            if sharp is None or not _within(start, sharp, found.errors, SAFETY):
                return RootCheck.NO_ROOT, there
            there = problem.named(sharp)
        # a rule that is steep because differences cancel in it is harmless
        beside = is_beside_pole(problem, there, found)
        return (RootCheck.BESIDE_POLE if beside else RootCheck.STANDS), there
    limits = [NEAR * size for size in problem.sizes_at(start)]
    bars = [*map(min, found.errors, limits)] if any(found.errors) else limits
    end: tuple[list[float] | None, bool] = None, False
    for nudge in (0.0, NUDGE, -NUDGE):  # at a fold steps are long however close two roots are
        try:
            end = _solved_on(problem, start, bars, nudge)
        except (Undefined, ValueError, OverflowError):
            if _vanishes(problem, start):
                return RootCheck.STANDS, dict(point)  # a rule has no slope there, and needs none
        if end[0]:
            break
    root, settled = end
    if root is None:
        return RootCheck.NO_ROOT, dict(point)
    there = problem.named(root)
    bars = [*map(max, found.errors, uncertainty(problem, there).errors)]
    if not _within(start, root, bars, SAFETY):
        return RootCheck.NO_ROOT, there
    if not settled:  # at a double root bars have no meaning
        bars = [*map(min, bars, limits)]
    if not is_beside_pole(problem, there, Uncertainty(bars)):
        return RootCheck.STANDS, there
    return (RootCheck.BESIDE_POLE if settled else RootCheck.NO_ROOT), there


def root_in_long_floats(
    problem: BlockProblem, start: Sequence[float], bars: Sequence[float]
) -> list[float] | None:
    """The end of steps of one Jacobian with residuals in long floats, if each is much shorter than
    the one before and the last much shorter than the error bars."""
    factor, before = problem.factor(start, problem.sizes_at(start)), 1.0 / FAST
    x: Any = np.array(start, dtype=np.longdouble)
    if factor.rank < factor.columns or not np.isfinite(bars).all():
        return None
    for _ in range(REFINEMENTS):
        at = {**problem.here, **dict(zip(problem.unknowns, x, strict=True))}
        found = evaluated(problem.graph.model, problem.kernel.equations, at, long=True)
        admitted = np.maximum(BACKWARD * found.moves, EPS * found.gross)
        if not (found.noise <= HIDDEN * admitted).all():
            return None
        step = factor.solution(found.miss.astype(float))
        length = float((np.abs(step) / bars).max())
        if not length <= FAST * before:
            return None
        x, before = x - step, length
        if length <= FAST * FAST:
            return [float(v) for v in x]
    return None


def _vanishes(problem: BlockProblem, x: Sequence[float]) -> bool:
    """Whether rules hold at the very point, and not only next to it, up to their rounding."""
    here = {**problem.here, **problem.named(x)}
    rules = zip(problem.kernel.forms, problem.kernel.equations, strict=True)
    with suppress(Undefined):
        return all(
            abs(extended(form, here, DIGITS)) <= BACKWARD * gross(rule, here)
            for form, rule in rules
        )
    return False


def root_beside(
    problem: BlockProblem, point: Point, reach: float = NEAR * FAR, most: int = ITERATIONS
) -> tuple[dict[str, float] | None, bool]:
    """The root at which Newton's method converges, in a few steps, within a reach relative to the
    unknowns; and whether it leads away. Then no root is near, although other rules derived from the
    block's hold there. At 0/0 the method starts next to the point."""
    start = list(point.values())
    bars = [reach / FAR * size for size in problem.sizes_at(start)]
    for nudge in (0.0, NUDGE):
        try:
            root, settled = _solved_on(problem, start, bars, nudge, most)
        except Undefined as error:
            if error.hole:
                continue
            return None, False
        except (ValueError, OverflowError):
            return None, False
        if root is not None:
            return (problem.named(root) if settled else None), False
    return None, True


def _solved_on(
    problem: BlockProblem,
    start: Sequence[float],
    bars: Sequence[float],
    nudge: float,
    most: int = ITERATIONS,
) -> tuple[list[float] | None, bool]:
    """The end of Newton's method in many digits, started at this distance, and whether it
    converges: between two close roots it may not. None if it leaves the neighbourhood, or the
    domain of a rule.

    Raises Undefined if a slope has no value at the beginning.
    """
    mp, unknowns = context(DIGITS), problem.unknowns

    def at(x: Sequence[Any]) -> tuple[list[list[Any]], list[Any]]:
        """Jacobian (n, n) and residual (n,)."""
        values = {**problem.here, **dict(zip(unknowns, x, strict=True))}
        return linearized(problem.kernel.forms, unknowns, values, DIGITS)

    x = [
        mp.mpf(v) + (k + 1) * nudge * bar
        for k, (v, bar) in enumerate(zip(start, bars, strict=True))
    ]
    rows, residual = at(x)
    first, before, lengths = residual, mp.inf, []
    for count in range(most):
        step = eliminate(rows, residual) if any(residual) else None
        if step is None and not any(residual) and _is_lost(problem, start, x, rows, bars):
            return None, False
        if step is None:
            return [float(v) for v in x], count > 0 and not any(residual)
        for halving in range(HALVINGS):  # while it leaves the domain of a rule
            ahead = [v - d / 2**halving for v, d in zip(x, step, strict=True)]
            try:
                rows, residual = at(ahead)
                break
            except Undefined:
                continue
        else:
            return None, False
        if not _within(start, ahead, bars, FAR):
            return None, False
        x = ahead
        length = max(abs(d) / (abs(v) or abs(d)) if d else 0 for v, d in zip(x, step, strict=True))
        if length <= SETTLED or REFINED >= length >= before:  # or rounding ends the contraction
            end = [float(v) for v in x]
            return (end, True) if _reached(problem, end, residual, first) else (None, False)
        before = length
        lengths.append(length)
    leads_away = lengths[-1] > max(lengths) / 2  # towards a multiple root steps become shorter
    return (None if leads_away else [float(v) for v in x]), False


def _is_lost(
    problem: BlockProblem,
    start: Sequence[float],
    x: Sequence[Any],
    rows: list[list[Any]],
    bars: Sequence[float],
) -> bool:
    """Whether residuals are 0 only for want of digits: rounding moves the root out of the
    neighbourhood."""
    here = {**problem.here, **problem.named(x)}
    tiny = context(DIGITS).mpf(10) ** (SPARE - DIGITS) / EPS
    step = eliminate(rows, [tiny * sides(rule, here).noise for rule in problem.kernel.equations])
    if step is None:
        return any(absorbs(form, here, DIGITS) for form in problem.kernel.forms)
    return not _within(start, [v - d for v, d in zip(x, step, strict=True)], bars, FAR)


def _reached(
    problem: BlockProblem, x: Sequence[float], residual: Sequence[Any], first: Sequence[Any]
) -> bool:
    """Whether steps have converged to a root, and not merely run out of digits: every residual is
    negligible relative to its terms, or to its value at the ``first``."""
    here, equations = {**problem.here, **problem.named(x)}, problem.kernel.equations
    return all(
        abs(miss) <= SHRUNK * abs(before) or abs(miss) <= EPS * gross(equation, here)
        for miss, before, equation in zip(residual, first, equations, strict=True)
    )


def _within(start: Sequence[float], x: Sequence[Any], bars: Sequence[float], factor: float) -> bool:
    return all(
        abs(v - w) <= factor * (bar + EPS * abs(v))
        for v, w, bar in zip(start, x, bars, strict=True)
    )
