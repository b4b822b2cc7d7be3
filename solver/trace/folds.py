"""Ranges of the numbers known to a block in which its roots neither appear nor vanish.

Along a curve of roots their number changes where the slope of the residual is 0 or unknown, or at
an end of the searched range. Boxes of the tear that may hold a root for known numbers in their
ranges are split until the slope of each excludes 0: then there are as many roots for any numbers
within as for one sample (implicit function theorem). From there the ranges are extended along the
way of the numbers, as long as the proof succeeds; next to a fold it does not. Of a block whose
rules hold in one case alone, only the roots in this case count: the boxes of the tear end where the
case does.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from functools import partial
from itertools import compress
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from rulesheets.evaluate import value
from rulesheets.model import Values
from rulesheets.syntax import nodes
from rulesheets.syntax.nodes import Number, add, call, subtract
from solver.kernel.block import BlockKernel
from solver.kernel.chain import Assignment, Chain
from solver.kernel.enclosure import Enclosure
from solver.kernel.nesting import nested
from solver.numerics.isolation import HORIZON, presplit
from solver.numerics.one_unknown import split_point
from solver.path.cases import EQUAL, GREATER, LESS, Pair, Sign

Ends: TypeAlias = tuple[float, float]
Ranges: TypeAlias = list[Ends]
"""Those of the numbers known to a block."""
Ways: TypeAlias = tuple[int, ...]
"""For each varying number whether it is moved up (1), down (-1), or not at all."""
Box: TypeAlias = tuple[float, ...]
"""The ends of the tear, then those of the known numbers that have ranges."""
Proof: TypeAlias = Callable[..., bool]

MOST = 500, 2500
"""Boxes in all of a proof: the second number if that for the sample takes more than the first."""
SHARES = 0.3, 0.1, 0.03, 0.01, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7
"""How far all sides are moved first, relative to where they are: the farthest that is proved."""
FIRST, GROWTH, SHRINKING, NEXT, NARROWEST = 0.3, 3.0, 8.0, 1e-2, 1e-3
"""The share of themselves that numbers are moved first, how much farther or less far after that,
how far next to a solve, and the least step."""
STEPS, MANY_STEPS = 12, 30
"""Of one call, and of an extreme row of an array."""
ROUNDED = 2e-9
"""How far outside a case, relative to the compared numbers, a solve may take a root for one
inside."""
ORDINARY = 1e40
"""Numbers beyond this, or below 1 over it, have no ranges."""
HOP, BEYOND = 0.1, 0.02
"""The relative distance from known numbers within which a solve of as many answers is trusted at
first; and that beyond such solves if nothing is proved."""
FARTHER = 0.5, 0.3
"""The same for a block of which no search finds all roots: another solve tells little more. After
each solve that agrees twice the distance is trusted, up to the first of these."""


class Case(NamedTuple):
    """A part of the numbers of a block: the ``limits`` that they satisfy, and names ``known`` to
    these alone."""

    limits: tuple[Assignment, ...] = ()
    known: tuple[str, ...] = ()

    def of(self, chain: Chain) -> Chain:
        """A chain without the values outside."""
        *steps, residual = chain.assignments
        return chain._replace(assignments=(*steps, *self.limits, residual))

    def excludes(self, values: Values) -> bool:
        """Whether numbers are outside."""
        return any(not one.low <= value(one.expression, values) <= one.high for one in self.limits)


NO_CASE = Case()


def case_of(kernel: BlockKernel, signs: Mapping[Pair, Sign], known: Collection[str]) -> Case:
    """The case of a block in which differences have the assumed ``signs``, or miss them by
    rounding, as far as they depend on its unknowns, and else on ``known`` numbers."""
    limits, read = list[Assignment](), dict[str, None]()
    for pair, sign in signs.items():
        names = dict.fromkeys(nodes.names(*pair))
        inside = not names.keys().isdisjoint(kernel.unknowns) and names.keys() <= {
            *kernel.unknowns,
            *known,
        }
        turning = any(kernel.graph.turn(name) is not None for name in names)
        if inside and not turning and sign - EQUAL in (LESS, GREATER):
            size = add(*(call("abs", side) for side in pair))
            low, high = (0.0, math.inf) if sign >= GREATER else (-math.inf, 0.0)
            moved = subtract(*pair) + (
                Number(ROUNDED) * size if sign >= GREATER else -Number(ROUNDED) * size
            )
            limits.append(Assignment(f"#case{len(limits)}", moved, low, high))
            read |= names
    own = {*kernel.unknowns, *kernel.known}
    return Case(tuple(limits), tuple(name for name in read if name not in own))


class ConstantRootCount:
    """Whether a block has as many roots for some numbers as for a ``sample``, as far as is proved:
    of those in a ``case``, if there is one, whose numbers follow those known to the block.

    The numbers that are ``varying`` lie in one of the ``boxes``, which touch one another; ``ends``
    are those of the one that was asked last. Boxes are added when numbers outside are given.
    ``proved`` tells whether there is a proof for the sample; if there is none they reach hardly
    beyond numbers with a solve of as many answers.
    """

    def __init__(
        self,
        kernel: BlockKernel,
        sample: Sequence[float],
        varying: Sequence[bool],
        margins: Sequence[float] = (),
        case: Case = NO_CASE,
    ) -> None:
        self.places = [place for place, moves in enumerate(varying) if moves]
        self.weak = False
        """Whether numbers that are near are taken for proved: a solve has as many answers there."""
        self.boxes: list[Ranges] = [[(v, v) for v in sample]]
        self._shares = dict[tuple[int, Ways], float]()
        """How far numbers are moved next from a box, in each direction."""
        proofs = [*_proofs(kernel, case, sample, varying, margins or [0.0] * len(sample))]
        tried: Iterator[Proof] = (partial(p, most=most) for most in MOST for p in proofs)
        found = next((proves for proves in tried if proves(self.boxes[0])), None)
        self._proves, self.proved = found or (lambda _: False), found is not None
        self._hop, self._beyond = (HOP, BEYOND) if proofs else FARTHER
        if not self.proved:
            self.boxes[0] = self._around(self._beyond)
        self.ends = self._ends(self.boxes[0])
        self._grown = not self.proved

    def _ends(self, box: Ranges) -> tuple[float, ...]:
        return tuple(end for place in self.places for end in box[place])

    def _around(self, share: float) -> Ranges:
        """The box around the sample up to a share of its numbers."""
        sizes = [share * (abs(v) or float(self.proved)) for v, _ in self.boxes[0]]
        moving = [size * (place in self.places) for place, size in enumerate(sizes)]
        return [(a - size, b + size) for (a, b), size in zip(self.boxes[0], moving, strict=True)]

    def __call__(self, *numbers: float) -> bool:
        """Whether numbers lie in a box, also after some steps towards them."""
        return self._reaches(numbers, STEPS)

    scalar = __call__

    def _reaches(self, numbers: Sequence[float], steps: int) -> bool:
        for _ in range(steps):
            for ends in map(self._ends, self.boxes):
                if all(a <= v <= b for v, a, b in zip(numbers, ends[::2], ends[1::2], strict=True)):
                    self.ends = ends
                    return True
            if not self._extended(numbers):
                return False
        return False

    def _extended(self, numbers: Sequence[float]) -> bool:
        """Whether another step towards numbers was made, or a shorter one may be: after a
        successful step comes a longer one."""
        asked = np.array(numbers)
        sides = np.array([[box[place] for place in self.places] for box in self.boxes])
        distances = _distances(np.clip(asked, sides[..., 0], sides[..., 1]), asked).max(axis=1)
        at = int(np.argmin(distances))
        ways: Ways = tuple((1 * (asked > sides[at, :, 1]) - (asked < sides[at, :, 0])).tolist())
        share, distance = self._shares.get((at, ways), FIRST), float(distances[at])
        near = self.weak and distance <= self._hop
        usual = self.proved and all(abs(v) <= ORDINARY for v in numbers)
        if usual and not self._grown:
            self.boxes[0] = next(filter(self._proves, map(self._around, SHARES)), self.boxes[0])
            self._grown = True
            return True
        if not distance or not (near or (usual and share >= NARROWEST)):
            return False
        part = 1.0 + (not self.proved) * self._beyond / distance if near else share / distance
        moved = self.boxes[at].copy()
        for place, number, way in zip(self.places, numbers, ways, strict=True):
            end = moved[place][way > 0]
            if way:
                there = _between(end, number, part)
                moved[place] = min(end, there), max(end, there)
        if near:
            self._hop = min(2.0 * self._hop, FARTHER[0])
            self._beyond = min(2.0 * self._beyond, FARTHER[1])
        elif not self._proves(moved):
            self._shares[at, ways] = share / SHRINKING
            return True
        if sum(map(abs, ways)) == 1:  # together they are one box
            pairs = zip(self.boxes[at], moved, strict=True)
            self.boxes[at] = [(min(a, c), max(b, d)) for (a, b), (c, d) in pairs]
            self._shares[at, ways] = NEXT if near else GROWTH * share
        else:
            self.boxes.append(moved)
            self._shares[len(self.boxes) - 1, ways] = NEXT if near else GROWTH * share
        return True

    def array(self, *columns: Any) -> NDArray[np.bool_]:
        """The same for rows (n,), as far as boxes can be added."""
        rows = np.broadcast_arrays(*columns)
        held, usual = self.covers(rows, rows), np.isfinite(np.add.reduce(rows))
        for extreme in (np.argmin, np.argmax):
            if (left := np.flatnonzero(usual & ~held)).size:
                row = left[extreme(rows[0][left])]
                self._reaches([float(column[row]) for column in rows], MANY_STEPS)
                held = self.covers(rows, rows)
        return held

    def covers(self, lows: Sequence[Any], highs: Sequence[Any]) -> NDArray[np.bool_]:
        """Whether the ranges (n,) of numbers each lie in one box."""
        columns = list(zip(self.places, lows, highs, strict=True))
        each = (
            [(box[k][0] <= low) & (high <= box[k][1]) for k, low, high in columns]
            for box in self.boxes
        )
        found: NDArray[np.bool_] = np.logical_or.reduce(
            [np.logical_and.reduce(some) for some in each]
        )
        return found


@np.errstate(all="ignore")
def _distances(some: NDArray[Any], others: NDArray[Any]) -> NDArray[Any]:
    """How far numbers are apart: in exponents, or by their sizes if they are on both sides of 0."""
    sizes = abs(some), abs(others)
    exponents = abs(np.log(sizes[1]) - np.log(sizes[0]))
    apart = np.where(some == others, 0.0, abs(others - some) / np.add(*sizes))
    return np.where(some * others > 0.0, exponents, apart)


def _between(one: float, other: float, part: float) -> float:
    """The number a part of the way from one to another, in exponents if possible."""
    if one * other > 0.0:
        start, end = math.log(abs(one)), math.log(abs(other))
        return math.copysign(math.exp(start + part * (end - start)), one)
    return one + part * (other - one)


def _proofs(
    kernel: BlockKernel,
    case: Case,
    sample: Sequence[float],
    varying: Sequence[bool],
    margins: Sequence[float],
) -> Iterator[Proof]:
    """For each tearing with a complete search, whether its number of roots is constant."""
    if not all(v == 0.0 or 1.0 / ORDINARY <= abs(v) <= ORDINARY for v in sample):
        return
    wide = [moves or margin > 0.0 for moves, margin in zip(varying, margins, strict=True)]
    fixed = [not one for one in wide]
    for torn in (kernel, *kernel.others) if len(kernel.block.tears) == 1 else nested(kernel):
        if torn.exhaustive:
            known = *kernel.known, *case.known
            names = list(compress(known, fixed)), list(compress(known, wide))
            chains = [Enclosure(case.of(chain), *names) for chain in torn.chains]
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
    *,
    most: int,
) -> bool:
    """Whether no root appears or vanishes within the ``wide`` ranges, widened by margins and
    shares."""
    ends = list[float]()
    for (low, high), (margin, share) in zip(compress(ranges, wide), margins, strict=True):
        ends += low - max(margin, share * abs(low)), high + max(margin, share * abs(high))
    (low, high), turn = (
        kernel.domain(kernel.block.tears[0]),
        kernel.graph.turn(kernel.block.tears[0]),
    )
    # where a search ends, too, a root may come from infinity
    ends_of_search = max(low, -HORIZON), min(high, HORIZON)
    edges = [(x, x) for x in ends_of_search if high - low != turn]
    return all(
        not _open(chain, [(*edge, *ends) for edge in edges], numbers)
        and _has_no_fold(chain, (low, high), numbers, ends, most)
        for chain in chains
    )


def _open(chain: Enclosure, boxes: list[Box], numbers: Sequence[float]) -> list[Box]:
    """The boxes that may hold a root."""
    found = zip(boxes, chain.ranges(boxes, numbers), strict=True)
    return [box for box, f in found if not (f[0] > 0.0 or f[1] < 0.0 or all(map(math.isnan, f)))]


def _flat(chain: Enclosure, boxes: list[Box], numbers: Sequence[float]) -> list[Box]:
    """The boxes that may hold a root at which the slope is 0, of the sizes for which a search is
    complete."""
    boxes = _open(chain, boxes, numbers)
    slopes = zip(boxes, chain.slopes_over(boxes, numbers), strict=True)
    flat = [b for b, (low, high) in slopes if low <= 0.0 <= high and min(map(abs, b[:2])) < HORIZON]
    return [
        b for b in flat if max(map(abs, b[:2])) > 1.0 / HORIZON or _has_root_at(chain, b, numbers)
    ]


def _has_root_at(chain: Enclosure, box: Box, numbers: Sequence[float]) -> bool:
    """Whether there may be a root at an end of a box, or at 0 inside."""
    points = {*box[:2], min(max(box[0], 0.0), box[1])}
    return bool(_open(chain, [(x, x, *box[2:]) for x in points], numbers))


def _has_no_fold(
    chain: Enclosure, domain: Ends, numbers: Sequence[float], ends: Sequence[float], most: int
) -> bool:
    """Whether the slope is nonzero wherever the residual may be 0, within the usual range of
    floats.

    If both may be 0 next to a single point of the tear, narrower boxes do not help.
    """
    boxes: list[Box] = [(*box, *ends) for box in presplit(*domain)]
    points = [box[0] for box in boxes[1:]]
    while boxes and (most := most - len(boxes)) >= 0:
        if _flat(chain, [(*_around(x), *ends) for x in points], numbers):
            return False
        flat = _flat(chain, boxes, numbers)
        if any(max(map(abs, box[:2])) <= 1.0 / HORIZON for box in flat):
            return False  # a root may come from a pole at 0, or go there
        points = [split_point(*box[:2]) for box in flat]
        halves = zip(flat, points, strict=True)
        boxes = [half for box, x in halves for half in ((box[0], x, *ends), (x, box[1], *ends))]
    return not boxes


def _around(x: float) -> Ends:
    """The floats next to a number: a root may end there, where rules are defined on one side."""
    return math.nextafter(x, -math.inf), math.nextafter(x, math.inf)
