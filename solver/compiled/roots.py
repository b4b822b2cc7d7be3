"""Blocks with one tear and no formula: every root of the residual, for a box of known numbers at once.

Before any number is used, brackets are proven for a whole box of the known numbers (``brackets.py``): how
many roots a row has, and between which ends each of them lies alone. A Newton iteration with the exact
slope, kept within its bracket, then finds each root and no other. Where that is not proven, or where the
number of roots is another one, there is no number, and the step-by-step way has the word. (Newton kept
within a bracket as in Press et al., Numerical Recipes, section 9.4.)
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from rulesheets.nodes import Name
from solver.compiled.brackets import Brackets, between, middles
from solver.compiled.flow import Flow, NotCompilable
from solver.compiled.program import Ending, Program

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from solver.compiled.brackets import Bracket
    from solver.kernel.code.block import BlockKernel
    from solver.kernel.code.chain import Chain

MAX_ITERATIONS = 60
MAX_ROOTS = 8
WIDTHS = (0.5, 0.1, 0.02, 0.002)
"""Boxes around a point, relative to its numbers, that are tried for a proof, the widest first."""
SPLITS = 5
"""How often the rows of a block are halved in search of boxes that can be proven."""


class Roots:
    """What the roots of one block have in common: the residual, the proofs, and where searches start.

    ``sample`` are the known numbers of a row that was solved, ``varying`` which of them rows differ in.
    Every search of a root starts where the sample has it, so that it does not depend on what was asked
    before. Raises NotCompilable where the roots of the sample are not proven to be all.
    """

    def __init__(
        self,
        kernel: BlockKernel,
        domain: tuple[float, float],
        sample: Sequence[float],
        varying: Sequence[bool],
    ) -> None:
        chains = kernel.chains()
        if len(chains) != 1 or not kernel.exhaustive or kernel.jumps or len(chains[0].tears) != 1:
            raise NotCompilable
        self.chain, self.known = chains[0], kernel.known
        self.varying = tuple(varying)
        self.program = _program(self.chain, self.known)
        self._brackets = Brackets(self.chain, self.known, domain)
        self._scalar: Callable[..., Any] | None = None
        self._array: Any = None
        brackets = self._brackets_at(tuple(sample))
        if not brackets or len(brackets) > MAX_ROOTS:
            raise NotCompilable
        try:
            starts = [self.newton(b, between(b.low, b.high), sample) for b in brackets]
        except ValueError:
            raise NotCompilable from None
        self.starts = tuple(starts)

    @property
    def count(self) -> int:
        """How many roots a row has, where it counts."""
        return len(self.starts)

    # --- one row ---

    def bracket(self, place: int, known: Sequence[float]) -> Bracket:
        """The bracket of one of the roots at these numbers. Raises ValueError where it is not proven."""
        brackets = self._brackets_at(known)
        if brackets is None or len(brackets) != self.count:
            raise ValueError
        return brackets[place]

    def _brackets_at(self, known: Sequence[float]) -> tuple[Bracket, ...] | None:
        brackets = self._brackets.around(known, known)
        if brackets is not None:
            return brackets
        for width in WIDTHS:
            reach = [width * abs(v) if moves else 0.0 for v, moves in zip(known, self.varying, strict=True)]
            lows = tuple(v - r for v, r in zip(known, reach, strict=True))
            highs = tuple(v + r for v, r in zip(known, reach, strict=True))
            brackets = self._brackets.prove(lows, highs)
            if brackets is not None:
                return brackets
        return None

    def newton(self, bracket: Bracket, start: float, known: Sequence[float]) -> float:
        """The root within a bracket. Raises ValueError where there is none."""
        if self._scalar is None:
            from solver.compiled.scalar import compile_scalar

            self._scalar = compile_scalar(self.program)
        low, high, sign = bracket.low, bracket.high, bracket.sign
        x = start if low <= start <= high else between(low, high)
        for _ in range(MAX_ITERATIONS):
            found = self._scalar(x, *known)
            if found is None:
                raise ValueError
            miss, slope = found
            if miss == 0.0:
                return x
            low, high = (x, high) if miss * sign < 0.0 else (low, x)
            step = x - miss / slope if slope else math.nan
            new = step if low < step < high else between(low, high)
            if abs(new - x) <= 2.0**-52 * abs(new):
                return new
            x = new
        raise ValueError

    # --- many rows ---

    def fill(self, place: int, columns: list[Any], roots: Any, splits: int = SPLITS) -> None:
        """Put the roots (n,) of rows with the known numbers ``columns`` (n,) where there are any."""
        import numpy as np

        lows = tuple(float(np.fmin.reduce(column)) for column in columns)
        highs = tuple(float(np.fmax.reduce(column)) for column in columns)
        if not all(map(math.isfinite, (*lows, *highs))):
            return
        brackets = self._brackets.around(lows, highs) or self._brackets.prove(lows, highs)
        if brackets is not None and len(brackets) == self.count:
            self._iterate(columns, roots, brackets[place], self.starts[place])
        elif splits and len(roots) > 1:
            half = len(roots) // 2
            for rows in (slice(0, half), slice(half, None)):
                self.fill(place, [column[rows] for column in columns], roots[rows], splits - 1)

    def _iterate(self, columns: list[Any], roots: Any, bracket: Bracket, start: float) -> None:
        """Newton within brackets on every row that has not converged."""
        import numpy as np

        if self._array is None:
            from solver.compiled.array import ArrayKernel

            (ending,) = self.program.endings
            self._array = ArrayKernel(self.program.flow, _nodes(self.program, ending))
        count = len(roots)
        left = np.arange(count)
        inside = bracket.low <= start <= bracket.high
        x = np.full(count, start if inside else between(bracket.low, bracket.high))
        low, high = np.full(count, bracket.low), np.full(count, bracket.high)
        with np.errstate(all="ignore"):
            for _ in range(MAX_ITERATIONS):
                known = [column[left] for column in columns]
                miss, slope, defined = np.empty(len(left)), np.empty(len(left)), np.empty(len(left), bool)
                self._array((x, *known), (miss, slope, defined))
                before = miss * bracket.sign < 0
                low, high = np.where(before, x, low), np.where(before, high, x)
                step = x - miss / slope
                new = np.where((low < step) & (step < high), step, middles(low, high))
                new = np.where(miss == 0, x, new)
                done = (np.abs(new - x) <= 2.0**-52 * np.abs(new)) & defined
                roots[left[done]] = new[done]
                going = ~done & defined & np.isfinite(new)
                left, x, low, high = left[going], new[going], low[going], high[going]
                if not left.size:
                    break


class RootFinder:
    """One root of a block as a function of the ``known`` numbers, by name and in their order."""

    several = False

    def __init__(self, roots: Roots, place: int) -> None:
        self.roots, self.place, self.known = roots, place, roots.known

    def scalar(self, *known: float) -> float:
        """The root at these numbers. Raises ValueError where it is not proven to be there alone."""
        roots = self.roots
        return roots.newton(roots.bracket(self.place, known), roots.starts[self.place], known)

    def array(self, *known: Any) -> Any:
        """The roots (n,); nan where they are not proven to be there alone."""
        import numpy as np

        columns = np.broadcast_arrays(*(np.asarray(column, dtype=float) for column in known))
        found = np.full(columns[0].shape, np.nan)
        self.roots.fill(self.place, list(columns), found)
        return found


def root_values(flow: Flow, roots: Roots, place: int, values: Mapping[str, int]) -> dict[str, int]:
    """The unknowns of a block: a root as a node of its own, what follows from it by the chain."""
    known = [values[name] for name in roots.known]
    if all(flow.value_of(number) is not None for number in known):
        node = flow.constant(roots.starts[place])
    else:
        flow.finders.append(RootFinder(roots, place))
        node = flow.node("root", len(flow.finders) - 1, *known)
        flow.bound(node)
    found = {**values, roots.chain.tears[0]: node}
    chain = replace(roots.chain, assignments=roots.chain.assignments[: -len(roots.chain.residuals)])
    follow(flow, chain, found)
    return found


def _program(chain: Chain, known: Sequence[str]) -> Program:
    """The residual and its slope by the tear, as a program of the tear and the known numbers."""
    from solver.kernel.code.enclosure import slopes_of

    slopes = slopes_of(chain)
    if slopes is None:
        raise NotCompilable
    flow = Flow()
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
    from solver.compiled.merge import states

    holds, known = states(program.flow, program.endings[0])
    told = program.flow.add("and", holds, known)
    return (*(node for node in ending.results if isinstance(node, int)), told)
