"""Ranges of the numbers known to a block in which its roots neither appear nor vanish.

Along a curve of roots their number changes where the slope of the residual is 0 or unknown, or at an end of
the range that is searched. Boxes of the tear that may hold a root while the known numbers are anywhere in
their ranges are split until the slope of each excludes 0: then there are as many roots for any numbers within
as there are for one sample (implicit function theorem). From there the ranges are grown, each side by itself,
as long as the proof succeeds; next to a fold it does not.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from itertools import compress
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from solver.kernel.block import BlockKernel
from solver.kernel.enclosure import Enclosure
from solver.kernel.tear_search import reduced
from solver.numerics.isolation import HORIZON, presplit
from solver.numerics.one_unknown import split_point
from solver.trace.graph import Graph

Ends: TypeAlias = tuple[float, float]
Proof: TypeAlias = Callable[[Sequence[Ends]], bool]

BOXES, LEVELS = 500, 64
"""Of one proof: boxes in all, and how often one is split."""
SHARES = 0.3, 0.1, 0.03, 0.01, 1e-3, 1e-4
"""How far all sides are moved first, relative to the sample: the farthest that is proved."""
GROWTH, SHRINKING = 3.0, 8.0
"""How much farther or less far each side is moved after that."""
STEPS, NARROWEST, WIDEST = 8, 1e-4, 7.0
"""Of each side; the least of them, and powers of e that sides come away from the sample."""
ORDINARY = 1e40
"""Numbers beyond this, or below 1 over it, have no ranges."""
HOP = 0.1
"""How far beyond what is proved a solve of as many answers is believed, relative to where it is."""
FARTHER, PATIENCE = 0.25, 32
"""Share of its way by which a side is moved farther than asked, and how often one is moved in vain."""


class Unfolded:
    """Whether a block has as many roots for some numbers as it has for a ``sample``, as far as is proved.

    ``ends`` are those of the known numbers that are ``varying``, one range after the other; they are moved
    where a number outside is asked for. ``proved`` tells whether there is a proof for the sample.
    """

    def __init__(
        self,
        kernel: BlockKernel,
        sample: Sequence[float],
        varying: Sequence[bool],
        margins: Sequence[float] = (),
    ) -> None:
        self.places = [place for place, moves in enumerate(varying) if moves]
        self.weak = False
        """Whether numbers that are near are taken for proved: a solve has as many answers there."""
        self.ranges, self._vain = [(v, v) for v in sample], 0
        proofs = _proofs(kernel, sample, varying, margins or [0.0] * len(sample))
        self._proves = next((proves for proves in proofs if proves(self.ranges)), None)
        if self._proves is not None:
            self._grow(self._proves, list(sample))
        self.ends = self._ends()

    @property
    def proved(self) -> bool:
        return self._proves is not None

    def _ends(self) -> tuple[float, ...]:
        return tuple(end for place in self.places for end in self.ranges[place])

    def _grow(self, proves: Proof, sample: list[float]) -> None:
        """Move all sides as far as that is proved, then each by itself: a step that is proved is followed by
        a longer one, another one by a shorter one."""
        for share in SHARES:
            wider = self.ranges.copy()
            for place in self.places:
                wider[place] = _moved(sample[place], -1, share), _moved(sample[place], 1, share)
            if proves(wider):
                self.ranges = wider
                break
        shares = {(place, side): GROWTH * share for place in self.places for side in (1, -1)}
        for _ in range(STEPS):
            for (place, side), share in shares.items():
                number, here = _moved(self.ranges[place][side > 0], side, share), sample[place]
                if share >= NARROWEST and (not here or abs(math.log(number / here)) <= WIDEST):
                    reached = self._reaches(place, number)
                    shares[place, side] = GROWTH * share if reached else share / SHRINKING

    def _reaches(self, place: int, number: float) -> bool:
        """Move one side to a number outside, if that is proved of what it passes over."""
        low, high = self.ranges[place]
        passed = self.ranges.copy()
        passed[place] = (high, number) if number > high else (number, low)
        if self._proves is None or not self._proves(passed):
            return False
        self.ranges[place] = min(low, number), max(high, number)
        return True

    def __call__(self, *numbers: float) -> bool:
        """Whether numbers lie within the ranges, or these reach there."""
        for place, number in zip(self.places, numbers, strict=True):
            low, high = self.ranges[place]
            if low <= number <= high:
                continue
            if self._vain >= PATIENCE or not math.isfinite(number):
                return False
            if self.weak and abs(number - (low if number < low else high)) <= HOP * abs(number):
                self.ranges[place] = min(low, number), max(high, number)
                self.ends = self._ends()
                continue
            farther = number + FARTHER * (number - (low if number < low else high))
            if not any(self._reaches(place, end) for end in (farther, number)):
                self._vain += 1
                return False
            self.ends = self._ends()
        return True

    scalar = __call__

    def array(self, *columns: Any) -> NDArray[np.bool_]:
        """The same of rows (n,), as far as ranges that reach some of them go."""
        for end in (np.min, np.max):
            self(*(float(end(column)) for column in columns))
        pairs = zip(columns, self.ends[::2], self.ends[1::2], strict=True)
        held: NDArray[np.bool_] = np.all([(a <= column) & (column <= b) for column, a, b in pairs], axis=0)
        return held

    def unrolled(self, flow: Graph, known: Sequence[int]) -> int:
        """The same as nodes of a graph, by the ranges as they are."""
        pairs, holds = zip(known, self.ends[::2], self.ends[1::2], strict=True), flow.true
        for node, low, high in pairs:
            holds = flow.add("and", holds, flow.add("le", flow.constant(low), node))
            holds = flow.add("and", holds, flow.add("le", node, flow.constant(high)))
        return holds


def _moved(number: float, side: int, share: float) -> float:
    """A number moved up or down by a share of it, none to 0 or across; 0 by the share itself."""
    return number * (1.0 + share) ** math.copysign(side, side * number) if number else side * share


def _proofs(
    kernel: BlockKernel, sample: Sequence[float], varying: Sequence[bool], margins: Sequence[float]
) -> Iterator[Proof]:
    """Of each tearing whose search covers the block, whether no root appears or vanishes within ranges."""
    if not all(v == 0.0 or 1.0 / ORDINARY <= abs(v) <= ORDINARY for v in sample):
        return
    wide = [moves or margin > 0.0 for moves, margin in zip(varying, margins, strict=True)]
    fixed = [not one for one in wide]
    for torn in (kernel, *kernel.others) if len(kernel.block.tears) == 1 else (reduced(kernel),):
        if torn is not None and torn.exhaustive:
            names = list(compress(kernel.known, fixed)), list(compress(kernel.known, wide))
            chains = [Enclosure(chain, *names) for chain in torn.chains]
            if all(chain.smooth for chain in chains):
                numbers = list(compress(sample, fixed))
                shares = [m / abs(v) if v else 0.0 for v, m in zip(sample, margins, strict=True)]
                added = list(compress(zip(margins, shares, strict=True), wide))
                yield partial(_keeps_roots, torn, chains, numbers, added, wide)


def _keeps_roots(
    kernel: BlockKernel,
    chains: Sequence[Enclosure],
    numbers: Sequence[float],
    margins: Sequence[tuple[float, float]],
    wide: Sequence[bool],
    ranges: Sequence[Ends],
) -> bool:
    """Whether no root appears or vanishes within the ``wide`` ranges, widened by margins and shares."""
    ends = list[float]()
    for (low, high), (margin, share) in zip(compress(ranges, wide), margins, strict=True):
        ends += low - max(margin, share * abs(low)), high + max(margin, share * abs(high))
    (low, high), turn = kernel.domain(kernel.block.tears[0]), kernel.graph.turn(kernel.block.tears[0])
    edges = [(x, x) for x in (low, high) if math.isfinite(x) and high - low != turn]
    return all(
        not _open(chain, edges, numbers, ends) and _has_no_fold(chain, (low, high), numbers, ends)
        for chain in chains
    )


def _open(chain: Enclosure, boxes: list[Ends], numbers: Sequence[float], ends: Sequence[float]) -> list[Ends]:
    """The boxes that may hold a root."""
    found = zip(boxes, chain.ranges([(*box, *ends) for box in boxes], numbers), strict=True)
    return [box for box, f in found if not (f[0] > 0.0 or f[1] < 0.0 or all(map(math.isnan, f)))]


def _has_no_fold(chain: Enclosure, domain: Ends, numbers: Sequence[float], ends: Sequence[float]) -> bool:
    """Whether the slope is not 0 wherever the residual may be, as far as floats usually go."""
    boxes, left = presplit(*domain), BOXES
    for _ in range(LEVELS):
        left -= len(boxes)
        if left < 0:
            return False
        boxes = _open(chain, boxes, numbers, ends)
        slopes = zip(boxes, chain.slopes_over([(*b, *ends) for b in boxes], numbers), strict=True)
        boxes = [b for b, (low, high) in slopes if low <= 0.0 <= high and min(map(abs, b)) < HORIZON]
        if not boxes:
            return True
        cut = [(low, split_point(low, high), high) for low, high in boxes]
        boxes = [(low, x) for low, x, _ in cut] + [(x, high) for _, x, high in cut]
    return False
