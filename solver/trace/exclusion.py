"""Ranges of the numbers known to a block for which it has no root, proved once.

The search over the tear of a block is run with the known numbers as intervals. Where it excludes a root,
there is none for any numbers within them. From one sample the ranges are grown, each side by itself, as long
as the proof succeeds; next to a fold it does not.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from typing import TypeAlias

from solver.kernel.block import BlockKernel, reduced
from solver.kernel.enclosure import Enclosure
from solver.numerics.isolation import IsolationLimits, isolate_roots

Ends: TypeAlias = tuple[float, float]

LIMITS = IsolationLimits(boxes=1500, alive=200, levels=30)
"""Less than a search of a solve may take: what is excluded here is excluded there."""
FIRST, GROWTH, SHRINKING = 1e-2, 3.0, 8.0
"""How far a side is moved first, relative to where it is, and how much farther or less far after that."""
STEPS, NARROWEST, WIDEST = 12, 1e-4, 7.0
"""Of each side; the least of them, and decades of e that sides come away from the sample."""
ORDINARY = 1e40
"""Numbers beyond this, or below 1 over it, have no ranges."""


def excluded(
    kernel: BlockKernel, sample: Sequence[float], varying: Sequence[bool], margins: Sequence[float]
) -> list[Ends] | None:
    """Ranges around the known numbers of a ``sample`` for which the block has no root.

    It has none either where numbers are outside of them by the ``margins``, or relatively by as much of an
    end as the margin is of the sample. Numbers that are not ``varying`` stay. None where nothing is proved.
    """
    if not all(v == 0.0 or 1.0 / ORDINARY <= abs(v) <= ORDINARY for v in sample):
        return None
    if any(not v and moves for v, moves in zip(sample, varying, strict=True)):
        return None
    for proves in _proofs(kernel, sample, margins):
        found = [(v, v) for v in sample]
        if proves(found):
            return _grown(found, [place for place, moves in enumerate(varying) if moves], proves)
    return None


def _proofs(
    kernel: BlockKernel, sample: Sequence[float], margins: Sequence[float]
) -> Iterator[Callable[[Sequence[Ends]], bool]]:
    """Of each tearing whose search covers the block, whether it excludes a root within ranges."""
    shares = [m / abs(v) if v else 0.0 for v, m in zip(sample, margins, strict=True)]
    for torn in (kernel, *kernel.others) if len(kernel.block.tears) == 1 else (reduced(kernel),):
        if torn is not None and torn.exhaustive:
            chains = [Enclosure(chain, (), torn.known) for chain in torn.chains]
            yield partial(_excludes, chains, torn.domain(torn.block.tears[0]), margins, shares)


def _excludes(
    chains: Sequence[Enclosure],
    domain: Ends,
    margins: Sequence[float],
    shares: Sequence[float],
    ranges: Sequence[Ends],
) -> bool:
    wider = [
        (low - max(m, s * abs(low)), high + max(m, s * abs(high)))
        for (low, high), m, s in zip(ranges, margins, shares, strict=True)
    ]
    return all(_has_no_root(chain, domain, wider) for chain in chains)


def _has_no_root(enclosure: Enclosure, domain: Ends, known: Sequence[Ends]) -> bool:
    ends = [end for pair in known for end in pair]

    def over(boxes: Sequence[Ends]) -> list[Ends]:
        return enclosure.ranges([(*box, *ends) for box in boxes], ())

    search = isolate_roots(over, None, lambda x: math.nan, *domain, LIMITS)
    return search.complete and not search.roots


def _grown(ranges: list[Ends], places: Sequence[int], proves: Callable[[Sequence[Ends]], bool]) -> list[Ends]:
    """The ranges with sides moved away from where they are, none across 0: what a side passes over is proved.

    A step that is proved is followed by a longer one, another one by a shorter one.
    """
    sample = [low for low, _ in ranges]
    shares = {(place, side): FIRST for place in places for side in (1, -1)}
    for _ in range(STEPS):
        for (place, side), share in shares.items():
            low, high = ranges[place]
            end = high if side > 0 else low
            number = end * (1.0 + share) ** (side if end > 0.0 else -side)
            if share < NARROWEST or abs(math.log(number / sample[place])) > WIDEST:
                continue
            passed = ranges.copy()
            passed[place] = (high, number) if side > 0 else (number, low)
            if proves(passed):
                ranges[place] = (low, number) if side > 0 else (number, high)
                shares[place, side] = GROWTH * share
            else:
                shares[place, side] = share / SHRINKING
    return ranges
