"""Error bars: how far the values of an answer may be from those that satisfy the rules exactly.

The inputs are taken as the exact numbers that they are. At the answer every rule that was solved with is
off by the rounding of its own operations; the Jacobian of these rules, followed in the order of the path,
turns that into errors of the unknowns: conditioning × rounding. Rounding errors have signs, and what
cancels must not be added up: the errors are followed for a few choices of signs at once, and the largest
counts (small-sample condition estimation: C. S. Kenney & A. J. Laub, SIAM J. Sci. Comput. 15 (1994) 36–61).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from rulesheets.evaluate import Undefined, derivatives
from rulesheets.model import Equation, Model, Value
from rulesheets.syntax.nodes import subtract
from solver.accuracy.alike import Evaluated, evaluated
from solver.accuracy.rule_check import blur, sides
from solver.facts import DoubleRoot
from solver.numerics.linear_algebra import Factor, as_matrix, factorise, sparse_matrix
from solver.numerics.tolerances import CANCELLED, HALF, UNIT_ROUNDOFF
from solver.path.steps import Evaluate, Select, SolveBlock, Step

SAMPLES = 16
DENSE = 400
"""Unknowns from which on a block is factored as a sparse matrix."""
MANY = 30
"""Unknowns beyond which the rules of a block are evaluated at once."""

Errors = list[float]
"""One error a choice of signs."""


class BlockCondition(NamedTuple):
    """A block at its answer: ``rank`` of its scaled Jacobian, and its ``condition`` (infinite if deficient).

    Unknowns count in units of their values, rules in units of their largest term.
    """

    unknowns: tuple[str, ...]
    rank: int
    condition: float


@dataclass(frozen=True)
class ForwardErrors:
    """``error``: an estimate of the absolute error of every variable that has a number, infinite where
    nothing can be said. ``blocks``: the conditions of the blocks, by their unknowns. ``cancelled``: some
    variable is next to nothing beside the terms that it was computed from."""

    error: Mapping[str, float]
    blocks: Mapping[tuple[str, ...], BlockCondition] = field(default_factory=dict)
    cancelled: bool = False


def forward_errors(
    model: Model,
    values: Mapping[str, Value],
    steps: Sequence[Step],
    active: Callable[[Equation], bool | None],
    doubles: Sequence[DoubleRoot] = (),
) -> ForwardErrors:
    """The errors of the ``values`` that ``steps`` have led to; ``active`` tells which guarded rules apply.

    Where answers coincide (``doubles``), half the digits are known; errors are infinite then of what the
    rules do not determine at the double root itself.
    """
    return _Propagation(model, values, active, doubles).run(steps)


def input_errors(
    model: Model,
    values: Mapping[str, Value],
    steps: Sequence[Step],
    active: Callable[[Equation], bool | None],
    inputs: Mapping[str, float],
) -> Mapping[str, float]:
    """How far every number moves as the ``inputs`` are off by these errors, and the numbers in the rules by
    half a unit of their last places; rounding left aside."""
    propagation = _Propagation(model, values, active, ())
    propagation.rounds = False
    for place, (name, error) in enumerate(inputs.items()):
        propagation.errors[name] = [error * sign for sign in _signs(-2 - place)]
    return propagation.run(steps).error


class _Row(NamedTuple):
    """A rule at the answer: its slopes, and by how much it may be off, for every choice of signs."""

    slopes: Mapping[str, float]
    off: Errors


class _Propagation:
    def __init__(
        self,
        model: Model,
        values: Mapping[str, Value],
        active: Callable[[Equation], bool | None],
        doubles: Sequence[DoubleRoot],
    ) -> None:
        self.model, self.values, self.active = model, values, active
        self.doubles = {double.equations: double for double in doubles}
        self.rounds = True
        self.cancelled = False
        self.errors: dict[str, Errors] = {}
        self.blocks: dict[tuple[str, ...], BlockCondition] = {}

    def run(self, steps: Sequence[Step]) -> ForwardErrors:
        for step in dict.fromkeys(steps):
            match step:
                case Evaluate(equation=equation, unknown=unknown):
                    self._direct(self.model.equations[equation], unknown)
                case Select(equations=equations, unknown=unknown):
                    chosen = [e for i in equations if self.active(e := self.model.equations[i])]
                    if chosen:
                        self._direct(chosen[0], unknown)
                case SolveBlock(equations=equations, unknowns=unknowns):
                    self._block([self.model.equations[i] for i in equations], unknowns)
        return ForwardErrors(dict(self._largest()), self.blocks, self.cancelled)

    def _largest(self) -> Iterator[tuple[str, float]]:
        """The largest error over the signs, and what rounding the value itself adds."""
        for name, number in self.values.items():
            if isinstance(number, str):
                continue
            errors = self.errors.get(name)
            if errors is None:
                yield name, 0.0
            else:
                worst = max(map(abs, errors))
                yield name, worst + UNIT_ROUNDOFF * abs(number) if worst and self.rounds else worst

    def _direct(self, equation: Equation, unknown: str) -> None:
        if not isinstance(self.values.get(unknown), float):
            return
        if (double := self.doubles.get((equation.index,))) is not None:
            self._spread(double, (unknown,))
            return
        row = self._row(equation, (unknown,))
        slope = 0.0 if row is None else row.slopes.get(unknown, 0.0)
        if row is not None and slope and self._cancels(row, unknown):
            self.cancelled = True
        if row is None or not any(row.off):
            self.errors[unknown] = [0.0 if row else math.inf] * SAMPLES
        elif slope == 0.0 or math.isnan(slope):
            self.errors[unknown] = [math.inf] * SAMPLES
        else:
            self.errors[unknown] = [_finite(-off / slope) for off in row.off]

    def _cancels(self, row: _Row, unknown: str) -> bool:
        """Whether an unknown that is not 0 is next to nothing beside what its rule adds up."""
        terms = {n: abs(s * v) for n, s in row.slopes.items() if isinstance(v := self.values.get(n), float)}
        own = terms.pop(unknown)
        return 0.0 < own <= CANCELLED * max(terms.values(), default=0.0)

    def _row(self, equation: Equation, unknowns: Sequence[str]) -> _Row | None:
        """None where the rule cannot be evaluated."""
        try:
            (left, slopes, noise), (right, others, more) = sides(equation, self.values)
        except (Undefined, KeyError):
            return None
        slopes = dict(slopes)
        for name, slope in others.items():
            slopes[name] = slopes.get(name, 0.0) - slope
        size = (
            noise + more + abs(left - right)
            if self.rounds
            else blur(subtract(equation.left, equation.right), self.values, {})
        )
        off = [size * sign for sign in _signs(equation.index)] if size else [0.0] * SAMPLES
        for name, slope in slopes.items():
            known = self.errors.get(name)
            if known is not None and name not in unknowns and any(known):
                off = [a + slope * b for a, b in zip(off, known, strict=True)]
        return _Row(slopes, [_finite(number) for number in off])

    def _block(self, equations: Sequence[Equation], unknowns: Sequence[str]) -> None:
        if (double := self.doubles.get(tuple(e.index for e in equations))) is not None:
            self._spread(double, unknowns)
            return
        present = [name for name in unknowns if name in self.values]
        if len(unknowns) > MANY and len(present) == len(unknowns) and self.rounds:
            self._large_block(equations, unknowns)
            return
        rows = (
            [self._row(equation, unknowns) for equation in equations] if len(present) == len(unknowns) else []
        )
        solved = self._solved([row for row in rows if row], unknowns) if rows and all(rows) else None
        for place, name in enumerate(unknowns):
            self.errors[name] = [math.inf] * SAMPLES if solved is None else [s[place] for s in solved]

    def _large_block(self, equations: Sequence[Equation], unknowns: Sequence[str]) -> None:
        """The same on arrays."""
        found = evaluated(self.model, equations, self.values)
        solved = self._solved_at_once(found, [e.index for e in equations], unknowns)
        errors = [[math.inf] * SAMPLES] * len(unknowns) if solved is None else solved.tolist()
        self.errors.update(zip(unknowns, errors, strict=True))

    def _solved_at_once(self, found: Evaluated, indices: Sequence[int], unknowns: Sequence[str]) -> Any:
        """The errors (n, samples) of the unknowns; None where they are not determined."""
        n, place = len(unknowns), {name: place for place, name in enumerate(unknowns)}
        off = (found.noise + np.abs(found.miss))[:, None] * _many_signs(indices)
        columns = np.array([place.get(name, -1) for name in found.names], dtype=np.intp)[found.columns]
        inside = columns >= 0
        for share, row, column in zip(
            found.slopes[~inside].tolist(), found.rows[~inside], found.columns[~inside], strict=True
        ):
            known = self.errors.get(found.names[column])
            if known is not None and any(known):
                off[row] += share * np.array(known)
        if not (np.isfinite(off).all() and np.isfinite(found.slopes).all()):
            return None
        matrix = sparse_matrix(found.slopes[inside], found.rows[inside], columns[inside], (n, n))
        factor = self._factored(matrix if n > DENSE else matrix.toarray(), unknowns)
        if factor is None:
            return None
        errors = np.column_stack([factor.solution(-column) for column in off.T])
        return np.where(np.isnan(errors), np.inf, errors)

    # --- at a double root ---

    def _spread(self, double: DoubleRoot, unknowns: Sequence[str]) -> None:
        """To first order the unknowns may lie anywhere along the direction, as far as half the digits go."""
        numbers = {n: v for n in unknowns if isinstance(v := self.values.get(n), float)}
        along = [abs(numbers[n] / d) for n, d in double.direction.items() if d and n in numbers]
        reach = HALF * max([1.0, *along])
        for name in unknowns:
            far = reach * double.direction.get(name, 0.0)
            self.errors[name] = [far * sign for sign in _signs(double.equations[0])]

    def _solved(self, rows: Sequence[_Row], unknowns: Sequence[str]) -> list[list[float]] | None:
        """The errors of the unknowns for every choice of signs; None where they are not determined."""
        if not all(math.isfinite(slope) for row in rows for slope in row.slopes.values()):
            return None
        matrix = [[row.slopes.get(name, 0.0) for name in unknowns] for row in rows]
        factor = self._factored(as_matrix(matrix, len(unknowns)), unknowns)
        if factor is None or not all(math.isfinite(off) for row in rows for off in row.off):
            return None
        columns = ([-row.off[k] for row in rows] for k in range(SAMPLES))
        return [[_finite(e) for e in factor.solve(column)] for column in columns]

    def _factored(self, matrix: Any, unknowns: Sequence[str]) -> Factor | None:
        """The Jacobian of a block in units of its unknowns; None where it is deficient."""
        weights = [abs(v) or 1.0 for name in unknowns if isinstance(v := self.values[name], float)]
        factor, key = factorise(matrix, weights), tuple(unknowns)
        regular = factor.rank == len(key)
        self.blocks[key] = BlockCondition(key, factor.rank, factor.condition() if regular else math.inf)
        return factor if regular else None


def slopes(equation: Equation, values: Mapping[str, Value]) -> dict[str, float]:
    """The derivatives of left minus right. Raises Undefined as ``derivatives`` does."""
    found = derivatives(equation.left, values)[1]
    for name, slope in derivatives(equation.right, values)[1].items():
        found[name] = found.get(name, 0.0) - slope
    return found


def _signs(index: int) -> Iterator[float]:
    """Sixteen signs that depend on a number alone (the bits of a multiplicative hash, D. Knuth)."""
    bits = _hashed(index)
    return (1.0 if bits >> k & 1 else -1.0 for k in range(SAMPLES))


def _many_signs(indices: Sequence[int]) -> Any:
    """The same (n, samples) of many numbers."""
    bits = np.array([_hashed(index) % 2**SAMPLES for index in indices])
    return np.where(bits[:, None] >> np.arange(SAMPLES) & 1, 1.0, -1.0)


def _hashed(index: int) -> int:
    bits = (index + 1) % 2**64 * 0x9E3779B97F4A7C15
    return ((bits ^ (bits >> 29)) * 0xBF58476D1CE4E5B9) >> 24


def _finite(number: float) -> float:
    return number if not math.isnan(number) else math.inf
