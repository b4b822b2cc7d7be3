"""Blocks with one tear and no formula: one root of a monotonic residual, for a box of known numbers at once.

Before any number is used, enclosures prove for a whole box of the known numbers that the residual rises
(or falls) wherever it may vanish over the range of the tear: then no row of the box has more than one
root, and a safeguarded Newton iteration that finds one has found all. Where that is not proven, there is
no number, and the step-by-step way has the word. (Neumaier, Interval Methods for Systems of Equations,
1990, section 5.1; Newton kept within a bracket as in Press et al., Numerical Recipes, section 9.4.)
"""

from __future__ import annotations

import math
from typing import Any

from rulesheets.nodes import Name
from rulesheets.record import replace
from solver.compiled.flow import Flow, NotCompilable
from solver.compiled.program import Ending, Program

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from solver.kernel.block import BlockKernel
    from solver.kernel.chain import Chain

HORIZON = 1e100
ROUNDS = 7
MAX_BOXES = 4000
MAX_ITERATIONS = 60
WIDTHS = (0.5, 0.1, 0.02)
"""Boxes around a point, relative to its numbers, that are tried for a proof, the widest first."""
MAX_PROOFS = 60
SPLITS = 5
"""How often the rows of a block are halved in search of boxes that can be proven."""


class RootFinder:
    """The tear of a block as a function of the ``known`` numbers, by name and in their order.

    Every search starts at ``start``, so that a root does not depend on what was asked before.
    """

    def __init__(self, kernel: BlockKernel, domain: tuple[float, float], start: float) -> None:
        chains = kernel.chains()
        if len(chains) != 1 or not kernel.exhaustive or kernel.jumps or len(chains[0].tears) != 1:
            raise NotCompilable
        self.chain, self.known = chains[0], kernel.known
        self.low, self.high = domain
        self.start = start
        self._proven: list[tuple[tuple[float, ...], tuple[float, ...], int]] = []
        self._proofs = 0
        self._enclosure: Any = None
        self._program = _program(self.chain, self.known)
        self._scalar: Callable[..., Any] | None = None
        self._array: Any = None

    # --- one row ---

    def scalar(self, *known: float) -> float:
        """The root at these numbers. Raises ValueError where there is none, or none proven to be alone."""
        sign = self._sign_at(known)
        if self._scalar is None:
            from solver.compiled.scalar import compile_scalar

            self._scalar = compile_scalar(self._program)
        x, low, high = self.start, self.low, self.high
        for _ in range(MAX_ITERATIONS):
            found = self._scalar(x, *known)
            if found is None:
                raise ValueError
            miss, slope = found
            if miss == 0.0:
                break
            low, high = (x, high) if miss * sign < 0.0 else (low, x)
            step = x - miss / slope if slope else math.nan
            new = step if low < step < high else _between(low, high)
            if abs(new - x) <= 2.0**-52 * abs(new):
                x = new
                break
            x = new
        else:
            raise ValueError
        return x

    def _sign_at(self, known: Sequence[float]) -> int:
        for lows, highs, sign in self._proven:
            if all(a <= v <= b for a, v, b in zip(lows, known, highs, strict=True)):
                return sign
        for width in WIDTHS:
            lows = tuple(v - width * abs(v) for v in known)
            highs = tuple(v + width * abs(v) for v in known)
            if sign := self._prove(lows, highs):
                return sign
        raise ValueError

    # --- the proof ---

    def _prove(self, lows: tuple[float, ...], highs: tuple[float, ...]) -> int:
        """1 or -1 where the residual rises or falls wherever it may vanish; 0 where that is not proven."""
        import numpy as np

        if self._proofs >= MAX_PROOFS:
            return 0
        self._proofs += 1
        if self._enclosure is None:
            from solver.kernel.enclosure import Enclosure

            boxed = replace(self.chain, tears=(*self.chain.tears, *self.known))
            self._enclosure = Enclosure(boxed, ())
        if self._enclosure.slopes is None:
            return 0
        ends = [end for pair in zip(lows, highs, strict=True) for end in pair]
        edges = _edges(self.low, self.high)
        lo, hi = edges[:-1], edges[1:]
        signs: set[int] = set()
        for _ in range(ROUNDS):
            hull = [np.full(lo.shape, end) for end in ends]
            below, above = self._enclosure.range_on(lo, hi, hull)
            undefined = np.isnan(below) & np.isnan(above)
            alive = ~undefined & ~((below > 0) | (above < 0))
            lo, hi = lo[alive], hi[alive]
            if not lo.size:
                break
            falls, rises = self._enclosure.slope_on(lo, hi, [end[alive] for end in hull])
            signs |= {s for s, found in ((1, (falls > 0).any()), (-1, (rises < 0).any())) if found}
            open_ = ~((falls > 0) | (rises < 0))
            lo, hi = lo[open_], hi[open_]
            if not lo.size or len(signs) > 1 or lo.size > MAX_BOXES:
                break
            middle = _middles(lo, hi)
            lo, hi = np.concatenate([lo, middle]), np.concatenate([middle, hi])
        if lo.size or len(signs) != 1:
            return 0
        (sign,) = signs
        self._proven.insert(0, (lows, highs, sign))
        return sign

    # --- many rows ---

    def array(self, *known: Any) -> Any:
        """The roots (n,); nan where there is none, or none proven to be alone."""
        import numpy as np

        columns = np.broadcast_arrays(*(np.asarray(column, dtype=float) for column in known))
        roots = np.full(columns[0].shape, np.nan)
        self._fill(list(columns), roots, SPLITS)
        return roots

    def _fill(self, columns: list[Any], roots: Any, splits: int) -> None:
        import numpy as np

        lows = tuple(float(np.fmin.reduce(column)) for column in columns)
        highs = tuple(float(np.fmax.reduce(column)) for column in columns)
        if not all(map(math.isfinite, (*lows, *highs))):
            return
        sign = self._known_sign(lows, highs) or self._prove(lows, highs)
        if sign:
            self._iterate(columns, roots, sign)
        elif splits and len(roots) > 1:
            half = len(roots) // 2
            for rows in (slice(0, half), slice(half, None)):
                self._fill([column[rows] for column in columns], roots[rows], splits - 1)

    def _known_sign(self, lows: tuple[float, ...], highs: tuple[float, ...]) -> int:
        for least, most, sign in self._proven:
            within = zip(least, lows, highs, most, strict=True)
            if all(a <= b and c <= d for a, b, c, d in within):
                return sign
        return 0

    def _iterate(self, columns: list[Any], roots: Any, sign: int) -> None:
        """Newton within brackets on every row that has not converged."""
        import numpy as np

        if self._array is None:
            from solver.compiled.array import ArrayKernel

            (ending,) = self._program.endings
            self._array = ArrayKernel(self._program.flow, _nodes(self._program, ending))
        count = len(roots)
        left = np.arange(count)
        x = np.full(count, self.start)
        low, high = np.full(count, self.low), np.full(count, self.high)
        with np.errstate(all="ignore"):
            for _ in range(MAX_ITERATIONS):
                known = [column[left] for column in columns]
                miss, slope, defined = np.empty(len(left)), np.empty(len(left)), np.empty(len(left), bool)
                self._array((x, *known), (miss, slope, defined))
                before = miss * sign < 0
                low, high = np.where(before, x, low), np.where(before, high, x)
                step = x - miss / slope
                new = np.where((low < step) & (step < high), step, _middles(low, high))
                new = np.where(miss == 0, x, new)
                done = (np.abs(new - x) <= 2.0**-52 * np.abs(new)) & defined
                roots[left[done]] = new[done]
                going = ~done & defined & np.isfinite(new)
                left, x, low, high = left[going], new[going], low[going], high[going]
                if not left.size:
                    break


def _program(chain: Chain, known: Sequence[str]) -> Program:
    """The residual and its slope by the tear, as a program of the tear and the known numbers."""
    from solver.kernel.enclosure import slopes_of

    slopes = slopes_of(chain)
    if slopes is None:
        raise NotCompilable
    flow = Flow(plain=True)
    values = {name: flow.input(place) for place, name in enumerate((*chain.tears, *known))}
    follow(flow, chain, values)
    for name, expression in slopes:
        values[name] = flow.expression(expression, values)
    residual = chain.residuals[0]
    results = (flow.expression(Name(residual), values), values[f"d {residual}"])
    for node in results:
        flow.bound(node)
    ending = Ending(results, tuple(flow.checks), tuple(flow.finite), flow.false, ())
    return Program(flow, 1 + len(known), (ending,))


def follow(flow: Flow, chain: Chain, values: dict[str, int]) -> None:
    """Add the values of a chain's assignments, and require what they require."""
    for item in chain.assignments:
        node = flow.expression(item.expression, values)
        values[item.name] = node
        if item.low > -math.inf:
            flow.require(flow.add("lt" if item.low_open else "le", flow.constant(item.low), node))
        if item.high < math.inf:
            flow.require(flow.add("lt" if item.high_open else "le", node, flow.constant(item.high)))


def _nodes(program: Program, ending: Ending) -> tuple[int, ...]:
    from solver.compiled.merge import primary

    merged = primary(program)
    return (*(node for node in ending.results if isinstance(node, int)), merged.holds)


def _between(low: float, high: float) -> float:
    """A point between the ends of a bracket, by size where an end is far."""
    if math.isinf(low) and math.isinf(high):
        return 0.0
    if math.isinf(high):
        return max(2.0 * low, 1.0)
    if math.isinf(low):
        return min(2.0 * high, -1.0)
    if low > 0.0 and high > 4.0 * low:
        return math.sqrt(low) * math.sqrt(high)
    return 0.5 * (low + high)


def _middles(low: Any, high: Any) -> Any:
    """The same for arrays; boxes that end at infinity are cut by size as well."""
    import numpy as np

    with np.errstate(all="ignore"):
        middle = 0.5 * (low + high)
        middle = np.where((low > 0) & (high > 4 * low), np.sqrt(low) * np.sqrt(high), middle)
        middle = np.where((high < 0) & (low < 4 * high), -np.sqrt(-low) * np.sqrt(-high), middle)
        middle = np.where(np.isinf(high), np.maximum(2 * low, 1.0), middle)
        middle = np.where(np.isinf(low), np.minimum(2 * high, -1.0), middle)
        return np.where(np.isinf(high) & np.isinf(low), 0.0, middle)


def _edges(low: float, high: float) -> Any:
    """The range of the tear cut into boxes: evenly where it is finite, by size where it is not."""
    import numpy as np

    if math.isfinite(low) and math.isfinite(high):
        return np.linspace(low, high, 129)
    sizes = 10.0 ** np.arange(-12, 13)
    edges = np.concatenate([[-HORIZON], -sizes[::-1], [0.0], sizes, [HORIZON]])
    inside = edges[(edges > low) & (edges < high)]
    ends = max(low, -HORIZON), min(high, HORIZON)
    return np.unique(np.concatenate([[ends[0]], inside, [ends[1]]]))


def root_values(flow: Flow, finder: RootFinder, values: Mapping[str, int]) -> dict[str, int]:
    """The unknowns of a block: the root as a node of its own, what follows from it by the chain."""
    known = [values[name] for name in finder.known]
    if all(flow.value_of(number) is not None for number in known):
        node = flow.constant(finder.start)  # the root that the step-by-step way found for these numbers
    else:
        flow.finders.append(finder)
        node = flow.node("root", len(flow.finders) - 1, *known)
        flow.bound(node)
    found = {**values, finder.chain.tears[0]: node}
    chain = replace(finder.chain, assignments=finder.chain.assignments[: -len(finder.chain.residuals)])
    follow(flow, chain, found)
    return found
