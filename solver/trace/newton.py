"""Newton's method on the rules of a block, started where a record has its answer.

The steps must shrink by ``CONTRACTION`` from one to the next: then the iteration stays on the branch of the
record (Deuflhard, Newton Methods for Nonlinear Problems, 2004, section 5.1.2: the first contraction factor).
Where they do not, the known numbers are moved from those of the record in smaller and smaller shares. At the
end the root is rounded to some of its digits and corrected from there, so that its last
ones do not depend on where the iteration came from.

The linear systems are eliminated in straight lines: the pivots are chosen once, at the numbers of the sample,
in the order of Markowitz (Management Science 3, 1957, 255-269) among those that are not small in their row.
Only entries that are there are computed, so that a sparse matrix costs what it holds.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from rulesheets.evaluate import differentiate, value
from rulesheets.syntax.nodes import names
from solver.kernel.block import BlockKernel
from solver.kernel.chain import jumps
from solver.trace.arrays import ArrayKernel
from solver.trace.flow import Flow
from solver.trace.graph import NotCompilable
from solver.trace.program import Ending, Program
from solver.trace.python import block_function

THRESHOLD = 0.05
"""Share of the largest entry of its row, each by the size of its column, that a pivot must have."""


@dataclass
class Matrix:
    """A sparse matrix of nodes, with the numbers that these have at the sample."""

    nodes: dict[tuple[int, int], int]
    numbers: dict[tuple[int, int], float]


@dataclass
class Elimination:
    """Solves linear systems of one matrix. ``steps`` are the row operations, ``pivots`` in their order."""

    flow: Flow
    size: int
    steps: list[tuple[int, int, int]] = field(default_factory=list)
    pivots: list[tuple[int, int]] = field(default_factory=list)
    upper: dict[tuple[int, int], int] = field(default_factory=dict)

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


def eliminate(flow: Flow, matrix: Matrix, scale: Sequence[float]) -> Elimination:
    """The elimination of a matrix (n, n) whose columns are of the sizes ``scale``.

    Raises NotCompilable where the matrix of the sample is singular.
    """
    size = len(scale)
    nodes, numbers = dict(matrix.nodes), dict(matrix.numbers)
    rows = {i: {j for (r, j) in nodes if r == i} for i in range(size)}
    columns = {j: {i for (i, c) in nodes if c == j} for j in range(size)}
    found = Elimination(flow, size)
    while rows:
        row, column = _pivot(rows, columns, numbers, scale)
        for other in sorted(columns[column] - {row}):
            factor = flow.add("div", nodes[other, column], nodes[row, column])
            share = numbers[other, column] / numbers[row, column]
            found.steps.append((other, row, factor))
            for at in sorted(rows[row] - {column}):
                product = flow.add("mul", factor, nodes[row, at])
                known = nodes.get((other, at))
                nodes[other, at] = (
                    flow.add("neg", product) if known is None else flow.add("sub", known, product)
                )
                numbers[other, at] = numbers.get((other, at), 0.0) - share * numbers[row, at]
                rows[other].add(at)
                columns[at].add(other)
            rows[other].discard(column)
        found.upper.update({(row, at): nodes[row, at] for at in rows[row]})
        found.pivots.append((row, column))
        for at in rows.pop(row):
            columns[at].discard(row)
        del columns[column]
    return found


def _pivot(
    rows: dict[int, set[int]],
    columns: dict[int, set[int]],
    numbers: dict[tuple[int, int], float],
    scale: Sequence[float],
) -> tuple[int, int]:
    """The entry that fills in least, of those that are not small in their row."""
    best: tuple[float, float, int, int] | None = None
    for row, places in rows.items():
        sizes = {at: abs(numbers[row, at]) * scale[at] for at in places}
        largest = max(sizes.values(), default=0.0)
        for at, size in sizes.items():
            if size > THRESHOLD * largest:
                fill = (len(places) - 1) * (len(columns[at]) - 1)
                best = min(best or (fill, -size / largest, row, at), (fill, -size / largest, row, at))
    if best is None:
        raise NotCompilable
    return best[2], best[3]


Array: TypeAlias = NDArray[Any]

MAX_UNKNOWNS = 60
"""Unknowns up to which a block is written as straight-line code."""
CONTRACTION = 0.25
ITERATIONS = 12
CONVERGED = 1e-7
"""Relative length of a step after which the next one is no more than rounding."""
LAST = 1e-9
"""Relative length that the correction of a rounded root may have."""
FINEST = 1.0 / 64.0
"""The least share of the way from the numbers of the record that is gone at once."""
SPLITTER = 2.0**17 + 1.0
"""Multiplied by this and taken away again, a float is rounded to 36 binary digits (Dekker, 1971)."""


class BlockNewton:
    """The root of a block next to a sample, as a function of the block's ``known`` numbers."""

    several = True

    def __init__(
        self,
        kernel: BlockKernel,
        start: Sequence[float],
        sample: Sequence[float],
        varying: Sequence[bool] = (),
    ) -> None:
        if len(start) > MAX_UNKNOWNS or not kernel.smooth or any(map(jumps, kernel.forms)):
            raise NotCompilable
        self.kernel, self.known = kernel, kernel.known
        self.start, self.sample = tuple(start), tuple(sample)
        least = 1e-6 * max(map(abs, self.start)) or 1.0
        self.scale = tuple(max(abs(x), least) for x in self.start)
        try:
            rows = kernel.jacobian(sample)(self.start)
        except (ArithmeticError, ValueError):
            raise NotCompilable from None
        self.slopes = [list(row) for row in rows]
        self.flow = Flow(plain=True)
        places = {name: self.flow.input(i) for i, name in enumerate((*kernel.unknowns, *kernel.known))}
        residual = [self.flow.expression(form, places) for form in kernel.forms]
        self.step = self.elimination(self.flow, self.matrix(self.flow, places)).solve(residual)
        ending = Ending(tuple(self.step), (), ())
        program = Program(self.flow, len(places), (ending,))
        self._newton: Callable[..., tuple[float, ...] | None] = block_function(
            program, _loop(len(self.start), self.scale)
        )
        self.tangent = np.zeros((len(self.start), len(sample)))
        self._predict: Callable[..., Sequence[float]] = lambda *known: self.start
        try:
            self.start = self.scalar(*sample)
            self.tangent = self._tangent(varying)
        except (ArithmeticError, ValueError):
            raise NotCompilable from None
        self._predict = _predictor(self.start, self.sample, self.tangent.tolist())

    def _tangent(self, varying: Sequence[bool]) -> Array:
        """How the root moves with each known number (unknowns, known), of those that are varying."""
        point = dict(zip((*self.kernel.unknowns, *self.known), (*self.start, *self.sample), strict=True))
        slopes = np.zeros(self.tangent.shape)
        for column, (name, moves) in enumerate(zip(self.known, varying, strict=False)):
            for row, form in enumerate(self.kernel.forms):
                if moves and name in names(form):
                    slopes[row, column] = value(differentiate(form, name), point)
        return np.linalg.solve(np.array(self.slopes), -slopes)

    def matrix(self, flow: Flow, values: dict[str, int]) -> dict[tuple[int, int], int]:
        """The nodes of the slopes that are not 0 throughout, by row and column."""
        count = len(self.kernel.unknowns)
        entries: dict[tuple[int, int], int] = {}
        for place, partial in enumerate(self.kernel.partials):
            assert partial is not None
            node = flow.expression(partial, values)
            if flow.value_of(node) != 0.0:
                entries[divmod(place, count)] = node
        return entries

    def elimination(self, flow: Flow, entries: dict[tuple[int, int], int]) -> Elimination:
        """The elimination of the slopes, with pivots that are large at the sample."""
        numbers = {(i, j): self.slopes[i][j] for i, j in entries}
        return eliminate(flow, Matrix(entries, numbers), self.scale)

    # --- one row ---

    def scalar(self, *known: float) -> tuple[float, ...]:
        """The root at these numbers. Raises ValueError where the branch of the record is not followed."""
        try:
            found = self._newton(*self._predict(*known), *known)
        except (ArithmeticError, ValueError):
            found = None
        return self._followed(known) if found is None else found

    def _followed(self, known: Sequence[float]) -> tuple[float, ...]:
        """The root by way of numbers between those of the record and these."""
        at, share, root = 0.0, 0.5, self.start
        while at < 1.0:
            to = min(1.0, at + share)
            pairs = zip(self.sample, known, strict=True)
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
    def _kernel(self) -> ArrayKernel:
        return ArrayKernel(self.flow, self.step)

    def array(self, *known: Any) -> Array:
        """The roots (unknowns, n); nan where the branch is not followed."""
        given = [np.atleast_1d(np.asarray(column, dtype=float)) for column in known]
        count = max(map(len, given), default=1)
        columns = np.array([np.broadcast_to(column, count) for column in given]).reshape(len(given), count)
        start = np.repeat(np.array(self.start)[:, None], count, axis=1)
        sample = np.repeat(np.array(self.sample)[:, None], count, axis=1)
        with np.errstate(all="ignore"):
            predicted = start.copy()
            for column in np.flatnonzero(self.tangent.any(axis=0)):
                predicted += self.tangent[:, column, None] * (columns[column] - self.sample[column])
            return self._rows(start, sample, columns, 1.0, predicted)

    def _rows(
        self, start: Array, before: Array, known: Array, share: float, predicted: Array | None = None
    ) -> Array:
        """Roots (unknowns, n) for known numbers (m, n) from those at others, by half the way if need be."""
        found = self._iterate(start if predicted is None else predicted, known)
        lost = np.flatnonzero(~np.isfinite(found[0]))
        if lost.size and share > FINEST:
            middle = 0.5 * (before[:, lost] + known[:, lost])
            between = self._rows(start[:, lost], before[:, lost], middle, 0.5 * share)
            on = np.isfinite(between[0])
            some = lost[on]
            if some.size:
                found[:, some] = self._rows(between[:, on], middle[:, on], known[:, some], 0.5 * share)
        return found

    def _iterate(self, start: Array, known: Array) -> Array:
        """As the loop of one row, on all rows that have not converged."""
        count = known.shape[1]
        roots = np.full(start.shape, np.nan)
        left, x, k = np.arange(count), start, known
        before = np.full(count, np.inf)
        weights = (1.0 / np.array(self.scale))[:, None]
        last = np.zeros(count, dtype=bool)
        for _ in range(ITERATIONS):
            step = self._steps(x, k)
            x = x - step
            step *= weights
            length = np.einsum("ij,ij->j", step, step)
            done = last & (length <= LAST**2)
            if done.any():
                roots[:, left[done]] = x[:, done]
            near = length < CONVERGED**2
            split = SPLITTER * x
            np.copyto(x, split - (split - x), where=near)
            going = ~last & (near | (length <= CONTRACTION**2 * before)) & np.isfinite(length)
            if going.all():
                before, last = length, near
                continue
            left, x, k, before, last = left[going], x[:, going], k[:, going], length[going], near[going]
            if not left.size:
                break
        return roots

    def _steps(self, x: Array, known: Array) -> Array:
        found = np.empty(x.shape)
        self._kernel([*x, *known], list(found))
        return found


def _predictor(
    start: Sequence[float], sample: Sequence[float], tangent: Sequence[Sequence[float]]
) -> Callable[..., Sequence[float]]:
    """Where the root is to first order, as a function of the known numbers."""
    terms = [
        " + ".join([repr(x), *(f"{t!r} * (a{j} - {sample[j]!r})" for j, t in enumerate(row) if t)])
        for x, row in zip(start, tangent, strict=True)
    ]
    arguments = ", ".join(f"a{j}" for j in range(len(sample)))
    namespace: dict[str, Any] = {"__builtins__": {}}
    exec(f"def predict({arguments}):\n    return ({', '.join(terms)},)\n", namespace)
    found: Callable[..., Sequence[float]] = namespace["predict"]
    return found


def _loop(count: int, scale: Sequence[float]) -> Callable[[list[str], Sequence[str]], list[str]]:
    """Writes the iteration around the statements that compute a step."""

    def written(body: list[str], steps: Sequence[str]) -> list[str]:
        names = [f"d{i}" for i in range(count)]
        assign = [f"{name} = {text}" for name, text in zip(names, steps, strict=True)]
        length = " + ".join(f"({name} * {1.0 / s!r}) ** 2" for name, s in zip(names, scale, strict=True))
        results = ", ".join(f"a{i} - d{i}" for i in range(count))
        moved = [f"a{i} = a{i} - d{i}" for i in range(count)]
        rounded = [f"c = a{i} * {SPLITTER!r}; a{i} = c - (c - a{i})" for i in range(count)]
        inside = [
            *body,
            *assign,
            f"length = {length}",
            f"if last: return ({results},) if length <= {LAST**2!r} else None",
            *moved,
            f"if length < {CONVERGED**2!r}:",
            "    last = True",
            *(f"    {line}" for line in rounded),
            "elif not length <= before: return None",
            f"before = length * {CONTRACTION**2!r}",
        ]
        head = ["last = False", "before = inf", f"for _ in ({', '.join('0' * ITERATIONS)}):"]
        return [*head, *(f"    {line}" for line in inside), "return None"]

    return written
