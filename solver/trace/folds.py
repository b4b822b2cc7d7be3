"""Ranges of the numbers known to a block in which its roots neither appear nor vanish.

Along a curve of roots their number changes where the slope of the residual is 0 or unknown, or at an end of
the searched range. Boxes of the tear that may hold a root for known numbers in their ranges are split until
the slope of each excludes 0: then there are as many roots for any numbers within as for one sample (implicit
function theorem). From there the ranges are extended, each side by itself, as long as the proof succeeds;
next to a fold it does not.
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

Ends: TypeAlias = tuple[float, float]
Box: TypeAlias = tuple[float, ...]
"""The ends of the tear, then those of the known numbers that have ranges."""
Proof: TypeAlias = Callable[[Sequence[Ends]], bool]

BOXES, FINEST = 2500, 1.0 / 8.0
"""Of one proof: boxes in all, and the least share of a known number's range that one has."""
SHARES = 0.3, 0.1, 0.03, 0.01, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7
"""How far all sides are moved first, relative to where they are: the farthest that is proved."""
GROWTH, SHRINKING, NEXT, NARROWEST = 3.0, 8.0, 1e-2, 1e-3
"""How much farther or less far a side is moved after that, how far next to a solve, and the least step."""
ORDINARY = 1e40
"""Numbers beyond this, or below 1 over it, have no ranges."""
HOP, BEYOND = 0.1, 0.02
"""The relative distance from known numbers within which a solve of as many answers is trusted; and that
beyond such solves if nothing is proved."""


class ConstantRootCount:
    """Whether a block has as many roots for some numbers as for a ``sample``, as far as is proved.

    ``ends`` are those of the known numbers that are ``varying``, one range after the other; they are extended
    when a number outside is given. ``proved`` tells whether there is a proof for the sample; if there is none
    the ranges reach hardly beyond numbers with a solve of as many answers.
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
        self.ranges = [(v, v) for v in sample]
        self._shares = dict[tuple[int, bool], float]()
        """How far each side is moved next."""
        proofs = _proofs(kernel, sample, varying, margins or [0.0] * len(sample))
        found = next((proves for proves in proofs if proves(self.ranges)), None)
        self._proves, self.proved = found or (lambda _: False), found is not None
        if not self.proved:
            self.ranges = [(_moved(v, -BEYOND), _moved(v, BEYOND)) if v else (v, v) for v in sample]
        self.ends = self._ends()

    def _ends(self) -> tuple[float, ...]:
        return tuple(end for place in self.places for end in self.ranges[place])

    def _grow(self) -> None:
        """Extend all sides from the sample, as far as that is proved."""
        for share in SHARES:
            wider = self.ranges.copy()
            for place in self.places:
                wider[place] = _moved(wider[place][0], -share), _moved(wider[place][1], share)
            if self._proves(wider):
                self.ranges = wider
                break
        self._shares = {(place, up): GROWTH * share for place in self.places for up in (False, True)}

    def __call__(self, *numbers: float) -> bool:
        """Whether numbers lie within the ranges, extended if possible."""
        held = all(map(self._reaches, self.places, numbers))
        self.ends = self._ends()
        return held

    scalar = __call__

    def _reaches(self, place: int, number: float) -> bool:
        """Whether a number lies in its range, or the side next to it can be moved there: a successful
        step is followed by a longer one, a failed one by a shorter one."""
        while not self.ranges[place][0] <= number <= self.ranges[place][1]:
            if not self._shares and self.proved and math.isfinite(number):
                self._grow()
                continue
            (low, high), up = self.ranges[place], number > self.ranges[place][1]
            end, share = high if up else low, self._shares.get((place, up), 0.0)
            if self.weak and abs(number - end) <= HOP * abs(number):
                self._shares[place, up] = NEXT
                there = number if self.proved else _moved(number, BEYOND if up else -BEYOND)
            elif not self.proved or share < NARROWEST or not abs(number) <= ORDINARY:
                return False
            else:
                size = None if number * end > 0.0 else abs(number) + abs(end)
                there = _moved(end, share if up else -share, size)
                passed = self.ranges.copy()
                passed[place] = (end, there) if up else (there, end)
                proved = self._proves(passed)
                self._shares[place, up] = GROWTH * share if proved else share / SHRINKING
                there = there if proved else end
            self.ranges[place] = min(low, there), max(high, there)
        return True

    def array(self, *columns: Any) -> NDArray[np.bool_]:
        """The same for rows (n,), as far as ranges that cover some of them extend."""
        for end in (np.fmin, np.fmax):
            self(*(float(end.reduce(column)) for column in columns))
        pairs = zip(columns, self.ends[::2], self.ends[1::2], strict=True)
        held: NDArray[np.bool_] = np.all([(a <= column) & (column <= b) for column, a, b in pairs], axis=0)
        return held


def _moved(number: float, share: float, size: float | None = None) -> float:
    """A number moved up or down by a share: of a ``size``, or of itself and so neither to 0 nor across."""
    if size is None and number:
        factor = 1.0 + abs(share)
        return number * factor if share * number > 0.0 else number / factor
    return number + share * (size or 1.0)


def _proofs(
    kernel: BlockKernel, sample: Sequence[float], varying: Sequence[bool], margins: Sequence[float]
) -> Iterator[Proof]:
    """For each tearing with a complete search, whether its number of roots is constant."""
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
        not _open(chain, [(*edge, *ends) for edge in edges], numbers)
        and _has_no_fold(chain, (low, high), numbers, ends)
        for chain in chains
    )


def _open(chain: Enclosure, boxes: list[Box], numbers: Sequence[float]) -> list[Box]:
    """The boxes that may hold a root."""
    found = zip(boxes, chain.ranges(boxes, numbers), strict=True)
    return [box for box, f in found if not (f[0] > 0.0 or f[1] < 0.0 or all(map(math.isnan, f)))]


def _flat(chain: Enclosure, boxes: list[Box], numbers: Sequence[float]) -> list[Box]:
    """The boxes that may hold a root at which the slope is 0."""
    boxes = _open(chain, boxes, numbers)
    slopes = zip(boxes, chain.slopes_over(boxes, numbers), strict=True)
    return [b for b, (low, high) in slopes if low <= 0.0 <= high and min(map(abs, b[:2])) < HORIZON]


def _has_no_fold(chain: Enclosure, domain: Ends, numbers: Sequence[float], ends: Sequence[float]) -> bool:
    """Whether the slope is nonzero wherever the residual may be 0, within the usual range of floats.

    If both may be 0 at a single point of the tear, narrower boxes do not help: then the ranges of the
    known numbers are split, down to ``FINEST`` of themselves.
    """
    finest = FINEST * max(_widths((*domain, *ends)), default=0.0)
    waiting, left = [[(*box, *ends) for box in presplit(*domain)]], BOXES
    while waiting:
        boxes = waiting.pop()
        left -= len(boxes)
        cut = [(box, (split_point(*box[:2]),) * 2) for box in _flat(chain, boxes, numbers)]
        stuck = {*_flat(chain, [(*x, *box[2:]) for box, x in cut], numbers)}
        told, open_ = list[Box](), list[Box]()
        for box, (x, _) in cut:
            if (x, x, *box[2:]) not in stuck:
                told += _halves(box, 0, x)
                continue
            widths = _widths(box)
            if (widest := max(widths, default=0.0)) <= finest:
                return False
            place = 2 + 2 * widths.index(widest)
            open_ += _halves(box, place, box[place] + (box[place + 1] - box[place]) / 2.0)
        waiting += [some for some in (told, open_) if some]
        if left < 0:
            return False
    return True


def _widths(box: Box) -> list[float]:
    """The widths of the ranges of known numbers, relative to their larger ends."""
    return [(b - a) / (max(abs(a), abs(b)) or 1.0) for a, b in zip(box[2::2], box[3::2], strict=True)]


def _halves(box: Box, place: int, x: float) -> list[Box]:
    """A box cut where one of its numbers is x."""
    return [(*box[: place + 1], x, *box[place + 2 :]), (*box[:place], x, *box[place + 1 :])]
