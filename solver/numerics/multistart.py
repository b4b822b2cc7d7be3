"""Damped Newton from many starts: the distinct roots that it reaches, in a fixed order.

Starts fill the ranges evenly by the additive recurrence of M. Roberts, *The unreasonable effectiveness of
quasirandom sequences* (2018): coordinate j of start k is frac(½ + k/φ^j) with φ^(n+1) = φ + 1. No random
numbers: the same question has the same answer. Nothing is proven about roots that were not reached.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from rulesheets.deadline import expect_time
from solver.numerics.newton import STANDARD_LIMITS, NewtonLimits, NewtonResult, newton
from solver.numerics.outcome import Outcome
from solver.numerics.system import Jacobian, Residual

Range = tuple[float, float]

DECADES = 3.0
"""An unbounded unknown is sought from 10⁻³ to 10³ times its scale, on both sides."""
SAME = 1e-9
SAME_SINGULAR = 1e-4
SINGULAR_LIMIT = 4


@dataclass(frozen=True, slots=True)
class MultiStart:
    """``roots`` in the order in which they were reached (that of the guess first), each inside the ranges.

    ``best`` is the end with the least residual among the failures, None where nothing failed.
    """

    roots: tuple[NewtonResult, ...]
    best: NewtonResult | None
    starts: int


def multistart(
    residual: Residual,
    jacobian: Jacobian,
    guess: Sequence[float],
    ranges: Sequence[Range] | None = None,
    scale: Sequence[float] | None = None,
    count: int = 32,
    offset: int = 0,
    enough: int | None = None,
    limits: NewtonLimits = STANDARD_LIMITS,
    guess_limits: NewtonLimits = STANDARD_LIMITS,
) -> MultiStart:
    """Newton from ``guess`` (n,) and from ``count`` further points of ``ranges`` (n pairs, ± inf allowed).

    ``scale`` (n,): typical magnitudes, else |guess| or 1. ``offset`` skips that many starts, so that a
    search can be continued; ``enough`` ends it at so many roots. Roots outside the ranges are dropped.
    ``limits`` are those of every start but the guess, which is worth a longer search.
    """
    within = ranges if ranges is not None else [(-math.inf, math.inf)] * len(guess)
    size = [abs(s) or 1.0 for s in (scale if scale is not None else guess)]
    roots: list[NewtonResult] = []
    best: NewtonResult | None = None
    starts = 0
    for start in starting_points(guess, within, size, count, offset):
        expect_time()
        here = guess_limits if starts == 0 and offset == 0 else limits
        result = newton(residual, jacobian, start, size, here)
        starts += 1
        if not result.outcome.found:
            best = _lower(best, result)
        elif _inside(result.x, within, size) and not any(same_root(result, root, size) for root in roots):
            roots.append(result)
        if _is_enough(roots, enough):
            break
    return MultiStart(tuple(roots), best, starts)


def same_root(one: NewtonResult, other: NewtonResult, scale: Sequence[float]) -> bool:
    """Whether two ends are one root: equal to 9 digits, or to 4 where a multiple root blurs them."""
    singular = Outcome.SINGULAR_JACOBIAN in (one.outcome, other.outcome)
    tolerance = SAME_SINGULAR if singular else SAME
    return all(
        abs(a - b) <= tolerance * max(abs(a), abs(b), 1e-6 * s)
        for a, b, s in zip(one.x, other.x, scale, strict=True)
    )


def _is_enough(roots: list[NewtonResult], enough: int | None) -> bool:
    """Several singular ends mostly lie on one curve of solutions, of which there is no end."""
    singular = sum(root.outcome is Outcome.SINGULAR_JACOBIAN for root in roots)
    return singular >= SINGULAR_LIMIT or (enough is not None and len(roots) >= enough)


def _lower(best: NewtonResult | None, result: NewtonResult) -> NewtonResult:
    return result if best is None or _size(result) < _size(best) else best


def _size(result: NewtonResult) -> float:
    return max(map(abs, result.residual), default=math.inf)


def _inside(x: Sequence[float], ranges: Sequence[Range], scale: Sequence[float]) -> bool:
    """Within every range, give or take the last bits."""
    slack = [1e-14 * max(abs(v), 1e-3 * s) for v, s in zip(x, scale, strict=True)]
    return all(low - d <= v <= high + d for v, (low, high), d in zip(x, ranges, slack, strict=True))


# -- where to start ---------------------------------------------------------------------------------------


def starting_points(
    guess: Sequence[float], ranges: Sequence[Range], scale: Sequence[float], count: int, offset: int = 0
) -> Iterator[list[float]]:
    """The guess, moved into the ranges, and ``count`` points that fill them; those alone after an offset."""
    if offset == 0:
        yield [min(max(g, low), high) for g, (low, high) in zip(guess, ranges, strict=True)]
    for shares in low_discrepancy(len(guess), count, offset):
        yield [place(u, *bounds, s) for u, bounds, s in zip(shares, ranges, scale, strict=True)]


def low_discrepancy(n: int, count: int, offset: int = 0) -> Iterator[list[float]]:
    """``count`` points of [0, 1)ⁿ that fill it evenly, after the first ``offset``."""
    ratios = _ratios(n)
    for k in range(offset + 1, offset + count + 1):
        yield [(0.5 + k * ratio) % 1.0 for ratio in ratios]


def _ratios(n: int) -> list[float]:
    """1/φ^j for j = 1 … n, with φ the positive root of φ^(n+1) = φ + 1."""
    phi = 2.0
    for _ in range(64):
        phi = (1.0 + phi) ** (1.0 / (n + 1))
    return [phi**-j for j in range(1, n + 1)]


def place(share: float, low: float, high: float, scale: float) -> float:
    """The point of a range at ``share`` in [0, 1): even over a finite range, or over its decades where it
    spans more than three; over the decades around ``scale`` from the finite end of an infinite one."""
    if math.isfinite(low) and math.isfinite(high):
        if low > 0 and high > 1e3 * low:
            return math.exp(math.log(low) + share * (math.log(high) - math.log(low)))
        if high < 0 and low < 1e3 * high:
            return -place(1.0 - share, -high, -low, scale)
        return low + share * (high - low)
    if math.isfinite(low):
        return low + _magnitude(share, scale)
    if math.isfinite(high):
        return high - _magnitude(share, scale)
    return _magnitude(2 * share - 1, scale) if share >= 0.5 else -_magnitude(1 - 2 * share, scale)


def _magnitude(share: float, scale: float) -> float:
    return float(scale * 10.0 ** (DECADES * (2.0 * share - 1.0)))
