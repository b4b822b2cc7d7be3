"""Newton's method on the rules of a block, started at the recorded answer.

The steps must shrink by ``CONTRACTION`` from one to the next: then the iteration stays on the
branch of the record (Deuflhard, Newton Methods for Nonlinear Problems, 2004, section 5.1.2: the
first contraction factor). If they do not, the known numbers are moved from those of the record in
smaller and smaller shares. At the end the root is rounded to some of its digits and corrected from
there, so that its last ones do not depend on the start of the iteration.

The linear systems are eliminated in straight-line code: the pivots are chosen once, at the numbers
of the sample, in the order of Markowitz (Management Science 3, 1957, 255-269) among those that are
not small in their row. Only nonzero entries are computed.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from functools import cached_property
from itertools import chain
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from rulesheets.evaluate import Undefined, derivatives, differentiate
from rulesheets.syntax.nodes import Expression, Quotient, names, walk
from solver.kernel.block import BlockKernel, partials_of
from solver.kernel.chain import jumps
from solver.path.isolate import without_logarithm
from solver.trace.arrays import ArrayKernel
from solver.trace.flow import Flow, Numbers
from solver.trace.graph import Graph, NotCompilable, copied
from solver.trace.program import Ending, Program
from solver.trace.python import block_function

THRESHOLD = 0.05
"""Share of the largest entry of its row, each by the size of its column, that a pivot must have."""

Entries: TypeAlias = dict[tuple[int, int], Any]
"""The entries of a sparse matrix by (row, column)."""


@dataclass
class Elimination:
    """Solves linear systems of one matrix. ``steps`` are the row operations, ``pivots`` in their
    order."""

    flow: Flow
    size: int
    steps: list[tuple[int, int, int]] = field(default_factory=list)
    pivots: list[tuple[int, int]] = field(default_factory=list)
    upper: Entries = field(default_factory=dict)

    def solve(self, right: Sequence[int]) -> list[int]:
        """The nodes of the solution for a right-hand side (n,)."""
        add, rest = self.flow.add, list(right)
        for row, pivot, factor in self.steps:
            rest[row] = add("sub", rest[row], add("mul", factor, rest[pivot]))
        found = [0] * self.size
        done: list[int] = []
        for row, column in reversed(self.pivots):
            total = rest[row]
            for other in done:
                if (row, other) in self.upper:
                    total = add("sub", total, add("mul", self.upper[row, other], found[other]))
            found[column] = add("div", total, self.upper[row, column])
            done.append(column)
        return found


def eliminate(flow: Flow, nodes: Entries, numbers: Entries, scale: Sequence[float]) -> Elimination:
    """The elimination of a matrix (n, n) of nodes whose columns are of the sizes ``scale``;
    ``numbers`` are those of the nodes at the sample. Both are overwritten.

    Raises NotCompilable if the matrix of the sample is singular.
    """
    found = Elimination(flow, len(scale))
    rows = {i: {j for r, j in nodes if r == i} for i in range(len(scale))}
    while rows:
        row, column = _pivot(rows, numbers, scale)
        places = rows.pop(row)
        for other in sorted(i for i, some in rows.items() if column in some):
            factor = flow.add("div", nodes[other, column], nodes[row, column])
            share = numbers[other, column] / numbers[row, column]
            found.steps.append((other, row, factor))
            for at in sorted(places - {column}):
                product = flow.add("mul", factor, nodes[row, at])
                known = nodes.get((other, at))
                nodes[other, at] = (
                    flow.add("neg", product) if known is None else flow.add("sub", known, product)
                )
                numbers[other, at] = numbers.get((other, at), 0.0) - share * numbers[row, at]
            rows[other] |= places
            rows[other].discard(column)
        found.upper.update({(row, at): nodes[row, at] for at in places})
        found.pivots.append((row, column))
    return found


def _pivot(rows: dict[int, set[int]], numbers: Entries, scale: Sequence[float]) -> tuple[int, int]:
    """The entry with the least fill-in, of those that are not small in their row."""
    counts = Counter(at for places in rows.values() for at in places)
    found = list[tuple[float, float, int, int]]()
    for row, places in rows.items():
        sizes = {at: abs(numbers[row, at]) * scale[at] for at in places}
        largest = max(sizes.values(), default=0.0)
        for at, size in sizes.items():
            if size > THRESHOLD * largest:
                found.append(((len(places) - 1) * (counts[at] - 1), -size / largest, row, at))
    if not found:
        raise NotCompilable
    return min(found)[2:]


Array: TypeAlias = NDArray[Any]

MAX_UNKNOWNS = 60
"""Unknowns up to which a block is written as straight-line code."""
CONTRACTION = 0.25
ITERATIONS = 12
CONVERGED = 1e-7
"""Relative length of a step after which the next one is no more than the correction of a rounded
root."""
LAST = 3e-10
"""Relative length that this correction may have."""
CONDITION = 1e6
"""The largest error of the unknowns that a record answers for, in units of the last place."""
ZERO, CANCELLED = 1e-12, 1e-3
"""Share of the terms of its rule below which an unknown is 0 to rounding, and that it is measured
by then."""
VANISHING = 1e-6
"""The least share of its size at the sample that a divisor may have."""
QUIET = 0.1
"""Share of ``CONDITION`` below which a record does not ask again next to where it was made."""
NEXT, BESIDE = 0.05, 5e-3
"""Next to it: known numbers within so much of themselves, that move no unknown by more than itself.
How far beside the record its roots are computed, to see how they bend."""
MOST_STEPS = 4
"""Steps that are written one after the other."""
POWERS = 4
"""The order of the start of the iteration if a single number is known."""
FINEST = 1.0 / 64.0
"""The least share of the distance from the numbers of the record that is taken at once."""
FEWER = 32
"""Rows along a line of many that are followed one after another; the others start between these."""
SPLITTER = 2.0**17 + 1.0
"""Multiplied by this and taken away again, a float is rounded to 36 binary digits (Dekker,
1971)."""
BACK = 1e-13
"""Relative distance within which Newton's method at the sample returns to its root."""


class BlockNewton:
    """The root of a block next to a sample, as a function of the ``known`` numbers that are
    varying."""

    def __init__(
        self,
        kernel: BlockKernel,
        start: Sequence[float],
        sample: Sequence[float],
        varying: Sequence[bool] = (),
    ) -> None:
        if len(start) > MAX_UNKNOWNS or any(map(jumps, kernel.forms)):
            raise NotCompilable
        self.kernel, self.start = kernel, tuple(start)
        given = list(zip(kernel.known, sample, varying or (True,) * len(sample), strict=True))
        self.known = tuple(name for name, _, varies in given if varies)
        self.sample = tuple(number for _, number, varies in given if varies)
        self.fixed = {name: number for name, number, varies in given if not varies}
        self.tangent: Array = np.zeros((len(self.start), len(self.sample)))
        """The slopes of the root by each known number (unknowns, known)."""
        self.bends: list[Array] = []
        self._last: tuple[float, ...] | None = None
        """The root of the last call, if the predicted start did not lead there."""
        try:
            self.start = self._settled()
            slopes = [[some.get(name, 0.0) for name in self.known] for some in self.gradients]
            self.tangent = -np.linalg.solve(self.slopes, slopes)
            self._predict()
            self.bends = self._bends()
            self._predict()
        except (ArithmeticError, ValueError):
            raise NotCompilable from None

    def _settled(self) -> tuple[float, ...]:
        """The root at the sample, by the rules as they are or, if these do not lead back to it,
        without their logarithms: next to a pole of one a root cannot be rounded. Raises
        ValueError."""
        kernel = self.kernel
        found, near = self._led_to(kernel.forms, kernel.partials)
        if not near:
            forms = list(map(without_logarithm, kernel.forms))
            if any(one is not other for one, other in zip(forms, kernel.forms, strict=True)):
                other, near = self._led_to(forms, partials_of(forms, kernel.unknowns))
                found = other if near else self._led_to(kernel.forms, kernel.partials)[0]
        if found is None:
            raise ValueError
        return found

    def _led_to(
        self, forms: Sequence[Expression], partials: Sequence[Expression]
    ) -> tuple[tuple[float, ...] | None, bool]:
        """The root that forms of the rules lead to at the sample, and whether it is that of the
        record."""
        every, unknowns = (*self.kernel.unknowns, *self.known), self.kernel.unknowns
        point = {**dict(zip(every, (*self.start, *self.sample), strict=True)), **self.fixed}
        self.forms, self.partials = forms, partials
        with suppress(ArithmeticError, ValueError, Undefined):
            found = [derivatives(form, point)[1] for form in forms]
            self.slopes = [[some.get(name, 0.0) for name in unknowns] for some in found]
            if not np.isfinite(self.slopes).all():
                raise ValueError
            # by a whole exponent of a negative base there is no slope
            self.gradients = [
                {n: slope for n, slope in some.items() if math.isfinite(slope)} for some in found
            ]
            least = 1e-6 * max(map(abs, self.start)) or 1.0
            sizes = tuple(max(abs(x), least) for x in self.start)
            self.scale = tuple(map(max, sizes, self._terms_of_zeros(point)))
            self._write()
            self._predict()
            root = self.scalar(*self.sample)
            off = np.subtract(root, self.start) / self.scale
            return root, bool(np.linalg.norm(off) <= BACK)
        return None, False

    def _write(self) -> None:
        """The operations of a step, of the root that it leads to (rounded, corrected by its
        slopes), and of the rounding errors of the unknowns: an inverse of the slopes times the
        sizes of the rules, with signs drawn once (Higham, Accuracy and Stability, ch. 15)."""
        self.flow = flow = Flow(plain=True)
        unknowns, every = self.kernel.unknowns, (*self.kernel.unknowns, *self.known)
        places = {name: flow.input(i) for i, name in enumerate(every)}
        places.update({name: flow.constant(number) for name, number in self.fixed.items()})
        slopes = self._slopes(flow, places)
        numbers = {(i, j): self.slopes[i][j] for i, j in slopes}
        inverse = eliminate(flow, dict(slopes), numbers, self.scale)
        self.step = inverse.solve([flow.expression(form, places) for form in self.forms])
        ends = (flow.raw("sub", places[x], d) for x, d in zip(unknowns, self.step, strict=True))
        near = places.copy()
        for x, end in zip(unknowns, ends, strict=True):  # without its last binary digits
            large = flow.raw("mul", end, SPLITTER)
            near[x] = flow.raw("sub", large, flow.raw("sub", large, end))
        last = inverse.solve([flow.expression(form, near) for form in self.forms])
        moved = inverse.solve([*self._sizes(flow, places, slopes)])
        self.root = [flow.raw("sub", near[x], d) for x, d in zip(unknowns, last, strict=True)]
        self.lengths = [self._length(some) for some in (self.step, last, moved)]
        if vanishing := self._vanishing(flow, places):
            self.lengths[2] = flow.raw("where", vanishing, math.inf, self.lengths[2])
        self._tell_quiet([inverse.upper[place] for place in inverse.pivots])
        parts = (
            [*self.step, self.lengths[0]],
            [*self.root, self.lengths[1]],
            [self.alike],
            self.lengths[2:],
        )
        self._newton: Callable[..., tuple[float, ...] | None] = block_function(
            Program(flow, len(every), (Ending(tuple(chain(*parts)), ()),)),
            ", ".join([*_names(len(every)), "near=False"]),
            list(map(len, parts)),
            self._loop,
        )

    def _vanishing(self, flow: Flow, places: dict[str, int]) -> int | None:
        """Whether a divisor that depends on the unknowns all but vanishes; None without one. There
        rounding may satisfy a rule that has no root."""
        at_sample = Numbers(flow, dict(enumerate((*self.start, *self.sample))))
        unknowns, small = set(self.kernel.unknowns), dict[int, None]()
        for part in walk(*self.forms):
            if isinstance(part, Quotient) and not unknowns.isdisjoint(names(part.right)):
                divisor = flow.expression(part.right, places)
                size = VANISHING * abs(float(at_sample(divisor)))
                small[flow.raw("le", flow.raw("abs", divisor), size)] = None
        return flow.over("or", small) if small else None

    def _tell_quiet(self, pivots: Sequence[int]) -> None:
        """Whether rounding hardly moves the root at the sample, and so wherever ``pivots`` are
        similar."""
        flow, raw = self.flow, self.flow.raw
        at_sample = Numbers(flow, dict(enumerate((*self.start, *self.sample))))
        sizes = {node: float(at_sample(node)) for node in pivots if flow.value_of(node) is None}
        self.quiet = at_sample(self.lengths[2]) <= (QUIET * CONDITION) ** 2 and all(sizes.values())
        shares = (raw("mul", node, 1.0 / size) for node, size in sizes.items() if self.quiet)
        alike = (raw("le", raw("abs", raw("sub", share, 1.25)), 0.75) for share in shares)
        self.alike = flow.over("and", alike) if self.quiet else flow.false

    def _length(self, steps: Sequence[int]) -> int:
        """The square of the length of a step, in units of the unknowns."""
        raw = self.flow.raw
        shares = [raw("mul", d, 1.0 / s) for d, s in zip(steps, self.scale, strict=True)]
        return self.flow.total(raw("mul", share, share) for share in shares)

    def _slopes(self, flow: Flow, places: dict[str, int]) -> Entries:
        """The nodes of the slopes that are not always 0, by row and column."""
        count = len(self.kernel.unknowns)
        entries: Entries = {}
        for place, slope in enumerate(self.partials):
            node = flow.expression(slope, places)
            if flow.value_of(node) != 0.0:
                entries[divmod(place, count)] = node
        return entries

    def _sizes(self, flow: Flow, places: dict[str, int], slopes: Entries) -> Iterator[int]:
        """Σ|∂F/∂v · v| of each rule over all variables, every third with a minus."""
        for row, form in enumerate(self.forms):
            terms = list[int]()
            for name in dict.fromkeys(names(form)):
                column = self.kernel.unknowns.index(name) if name in self.kernel.unknowns else -1
                slope = slopes.get((row, column))
                if column < 0 and name in self.gradients[row]:
                    slope = flow.expression(differentiate(form, name), places)
                if slope is not None:
                    terms.append(flow.add("abs", flow.add("mul", slope, places[name])))
            total = flow.over("add", terms)
            yield flow.add("neg", total) if row * row % 3 == 1 else total

    def _terms_of_zeros(self, point: Mapping[str, float]) -> Iterator[float]:
        """For an unknown that is 0 to rounding a share of its cancelling terms; else 0."""
        sizes = [
            sum(abs(slope * point[name]) for name, slope in some.items()) for some in self.gradients
        ]
        for x, column in zip(self.start, zip(*self.slopes, strict=True), strict=True):
            shares = (size / abs(slope) for size, slope in zip(sizes, column, strict=True) if slope)
            terms = min(shares, default=0.0)
            yield CANCELLED * terms if abs(x) <= ZERO * terms else 0.0

    def _bends(self) -> list[Array]:
        """The coefficients (unknowns,) of the second and higher powers of a move of the known
        number; none of several, or if the roots next to the sample are not found."""
        if len(self.sample) != 1:
            return []
        (number,) = self.sample
        move, powers = BESIDE * (abs(number) or 1.0), range(1, POWERS + 1)
        shares = [float(share) for share in range(-POWERS // 2, POWERS // 2 + 1) if share]
        try:
            roots = [self.scalar(number + share * move) for share in shares]
            matrix = [[share**power for power in powers] for share in shares]
            found = np.linalg.solve(matrix, np.subtract(roots, self.start))
        except (ArithmeticError, ValueError):
            return []
        found[abs(found) <= LAST * np.array(self.scale)] = 0.0
        return [row / move**power for power, row in zip(powers, found, strict=True)][1:]

    def _predicted(self, flow: Graph, known: Sequence[int]) -> list[int]:
        """The root as predicted by the tangent and the higher powers."""
        found, pairs = [], zip(known, self.sample, strict=True)
        moves = [flow.raw("sub", node, number) for node, number in pairs]
        for i, x in enumerate(self.start):
            terms, bent = [flow.constant(x)], [float(row[i]) for row in self.bends[::-1]]
            for j, move in enumerate(moves):
                share = flow.horner([*bent, float(self.tangent[i, j])], move)
                if flow.value_of(share) != 0.0:
                    terms.append(flow.raw("mul", share, move))
            found.append(flow.total(terms))
        return found

    def _predict(self) -> None:
        """Write the start of the iteration of one row, and whether it is close to the record."""
        flow, count = Flow(plain=True), len(self.sample)
        predicted = self._predicted(flow, [flow.input(j) for j in range(count)])
        self.prediction = flow, predicted
        within = [str(self.quiet)]
        for j, number in enumerate(self.sample):
            share = max(
                abs(t) / s for t, s in zip(self.tangent[:, j].tolist(), self.scale, strict=True)
            )
            reach = min(NEXT * abs(number), 1.0 / share if share else math.inf)
            within.append(f"{number - reach!r} <= a{j} <= {number + reach!r}")
        near = " and ".join(within)
        self._start: Callable[..., tuple[float, ...]] = block_function(
            Program(flow, count, (Ending((*predicted,), ()),)),
            ", ".join(_names(count)),
            [len(self.start)],
            lambda part: [*part[0], f"return {', '.join([*part[1], *_names(count), near])}"],
        )

    def _loop(self, *parts: tuple[list[str], list[str]]) -> list[str]:
        """The iteration around the statements of a step, and those of the root after it: steps
        until one is shorter; the last of them is not taken."""
        (steps, (*off, length)), (below, (*root, last)), (pivots, (alike,)), (error, (moved,)) = (
            parts
        )
        names = _names(len(off))
        return [
            "before = inf",
            f"for _ in ({', '.join('0' * ITERATIONS)}):",
            *(f"    {line}" for line in steps),
            f"    length = {length}",
            f"    if length < {CONVERGED**2!r}: break",
            "    if not length <= before: return None",
            f"    if length > {QUIET**2!r}: near = False",
            f"    before = length * {CONTRACTION**2!r}",
            f"    {', '.join(names)} = "
            f"{', '.join(f'{a} - {d}' for a, d in zip(names, off, strict=True))}",
            "else: return None",
            *below,
            f"if not {last} <= {LAST**2!r}: return None",
            *pivots,
            f"if not (near and {alike}):",
            *(f"    {line}" for line in error),
            f"    if not {moved} <= {CONDITION**2!r}: return None",
            f"return ({', '.join(root)},)",
        ]

    def unrolled(self, flow: Graph, known: Sequence[int]) -> list[int]:
        """The root as nodes of another graph, by as many steps as are needed near the record; nan
        if these are not enough."""
        x = self._predicted(flow, known)
        for _ in range(1, self._enough):
            step = copied(self.flow, flow, self.step, [*x, *known])
            x = [flow.raw("sub", a, d) for a, d in zip(x, step, strict=True)]
        return copied(self.flow, flow, self._found(self._alike), [*x, *known])

    def _found(self, alike: bool) -> list[int]:
        """The root that a last step leads to; nan if that is far, or if rounding may lead far. With
        ``alike``, pivots like those of the record show that it does not."""
        raw, limits = self.flow.raw, (CONVERGED, LAST, CONDITION)
        asked = [
            raw("le", length, limit**2) for length, limit in zip(self.lengths, limits, strict=True)
        ]
        good = raw("and", raw("and", *asked[:2]), self.alike if alike else asked[2])
        return [raw("where", good, root, math.nan) for root in self.root]

    def _beside(self) -> Iterator[list[float]]:
        """Known numbers slightly outside the range in which the powers were fitted."""
        for j, number in enumerate(self.sample):
            for share in (-2.5 * BESIDE, 2.5 * BESIDE):
                yield [
                    *self.sample[:j],
                    number + share * (abs(number) or 1.0),
                    *self.sample[j + 1 :],
                ]

    @cached_property
    def _alike(self) -> bool:
        """Whether the pivots are similar to those of the record, which rounding hardly moves."""
        try:
            roots = (
                [(*self.scalar(*known), *known) for known in self._beside()] if self.quiet else []
            )
        except ValueError:
            return False
        return self.quiet and all(
            Numbers(self.flow, dict(enumerate(root)))(self.alike) for root in roots
        )

    @cached_property
    def _enough(self) -> int:
        """The number of steps from the predicted root."""
        most = 1
        for known in self._beside():
            x = np.array(self._start(*known)[: len(self.start)])
            for count in range(1, MOST_STEPS + 1):
                here = Numbers(self.flow, dict(enumerate((*x.tolist(), *known))))
                most, x = max(most, count), x - [float(here(node)) for node in self.step]
                if here(self.lengths[0]) < CONVERGED**2:
                    break
        return most

    # --- one row ---

    def scalar(self, *known: float) -> tuple[float, ...]:
        """The root at these numbers. Raises ValueError if the branch of the record is lost.

        The iteration starts as predicted, or at the root of the last call if that was not enough
        there.
        """
        last = self._last
        try:
            found = self._newton(*(self._start(*known) if last is None else (*last, *known)))
        except (ArithmeticError, ValueError):
            found = None
        if found is None and last is not None:
            self._last = None
            return self.scalar(*known)
        if found is None:
            found = self._followed(known, self.sample, self.start, 0.5)
        elif last is None:
            return found
        self._last = found
        return found

    def _followed(
        self,
        known: Sequence[float],
        before: Sequence[float],
        root: tuple[float, ...],
        share: float = 1.0,
    ) -> tuple[float, ...]:
        """The root, by way of numbers between those ``before`` and these."""
        at = 0.0
        while at < 1.0:
            to = min(1.0, at + share)
            pairs = zip(before, known, strict=True)
            there = known if to == 1.0 else [a + to * (b - a) for a, b in pairs]
            try:
                found = self._newton(*root, *there)
            except (ArithmeticError, ValueError):
                found = None
            if found is not None:
                at, root, share = to, found, 2.0 * share
            elif (share := 0.25 * share) < FINEST:
                raise ValueError
        return root

    # --- many rows ---

    @cached_property
    def _kernels(self) -> tuple[ArrayKernel, ...]:
        """The kernels for the predicted roots, for steps and their lengths, and for the final
        root."""
        steps = *self.step, self.lengths[0]
        pairs = self.prediction, (self.flow, steps), (self.flow, self._found(False))
        return tuple(ArrayKernel(flow, wanted) for flow, wanted in pairs)

    def _run(self, kernel: int, *columns: Array) -> Array:
        """The results (k, n) of one of the kernels."""
        found = np.empty((len(self._kernels[kernel].wanted), columns[0].shape[1]))
        self._kernels[kernel]([row for some in columns for row in some], list(found))
        return found

    def array(self, *known: Any) -> Array:
        """The roots (unknowns, n); nan where the branch is lost."""
        given = [np.atleast_1d(np.asarray(column, dtype=float)) for column in known]
        count = max(map(len, given), default=1)
        columns = np.array([np.broadcast_to(column, count) for column in given]).reshape(
            len(given), count
        )
        with np.errstate(all="ignore"):
            steps = np.diff(columns, axis=1)
            in_line = ((steps >= 0.0).all(axis=1) | (steps <= 0.0).all(axis=1)).all()
            if given and in_line:
                return self._along(columns)
            return self._iterate(self._run(0, columns), columns)  # each from the record

    def _along(self, columns: Array) -> Array:
        """The roots (unknowns, n) along a line of known numbers (m, n): of some rows one after
        another, of those between from these. If two such rows next to one another are lost, so are
        all between."""
        count = columns.shape[1]
        moves = abs(columns[:, -1] - columns[:, 0]) / np.maximum(
            abs(columns[:, -1]), abs(columns[:, 0])
        )
        place = int(np.argmax(np.nan_to_num(moves)))
        rows = np.linspace(0, count - 1, min(count, FEWER)).astype(np.intp)
        known = self._walked(columns[:, rows], place)
        if len(rows) == count:
            return known
        found = self._iterate(_between(columns[place], rows, known), columns)
        there = np.isfinite(known[0])
        after = np.clip(np.searchsorted(rows, np.arange(count)), 1, len(rows) - 1)
        lost = np.flatnonzero(~np.isfinite(found[0]) & (there[after] | there[after - 1]))
        if lost.size:
            left = columns[:, lost]
            few = lost.size < count / 2
            found[:, lost] = self._along(left) if few else self._iterate(self._run(0, left), left)
        return found

    def _walked(self, columns: Array, place: int) -> Array:
        """The roots (unknowns, n) of rows (m, n), each from that before it, away from the record by
        the known number of a place; none after one that is lost."""
        found = np.full((len(self.start), columns.shape[1]), np.nan)
        off = columns[place] - self.sample[place]
        order = np.argsort(abs(off), kind="stable")
        for side in (order[off[order] >= 0.0], order[off[order] < 0.0]):
            root, before = None, self.sample
            for row in side.tolist():
                there = tuple(columns[:, row].tolist())
                try:
                    root = (
                        self.scalar(*there) if root is None else self._followed(there, before, root)
                    )
                except ValueError:
                    break
                found[:, row], before = root, there
        return found

    def _iterate(self, x: Array, known: Array) -> Array:
        """The loop of one row, on all rows that have not converged."""
        roots, left = np.full(x.shape, np.nan), np.arange(known.shape[1])
        before = np.full(known.shape[1], np.inf)
        for _ in range(ITERATIONS):
            if not left.size:
                break
            *step, length = self._run(1, x, known)
            near = length < CONVERGED**2
            if near.any():
                here = slice(None) if near.all() else near
                roots[:, left[here]] = self._run(2, x[:, here], known[:, here])
            going = ~near & (length <= before)
            x, before = x - step, CONTRACTION**2 * length
            if not going.all():
                left, x, known, before = left[going], x[:, going], known[:, going], before[going]
        return roots


def _between(at: Array, rows: Array, roots: Array) -> Array:
    """The roots (unknowns, n) at numbers (n,) by cubic interpolation of those (unknowns, k) of some
    rows."""
    first = np.clip(np.searchsorted(rows, np.arange(len(at))) - 2, 0, len(rows) - 4)
    near = [at[rows[first + k]] for k in range(4)]
    found = np.zeros((len(roots), len(at)))
    for k, there in enumerate(near):
        others = (other for other in near if other is not there)
        found += roots[:, first + k] * math.prod((at - other) / (there - other) for other in others)
    return found


def _names(places: int) -> list[str]:
    return [f"a{place}" for place in range(places)]
