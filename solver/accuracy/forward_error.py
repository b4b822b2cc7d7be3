"""Error bars: estimates of the distance of an answer from the values that satisfy the rules
exactly.

The inputs are exact numbers. At the answer every rule that was solved with has a residual from the
rounding of its own operations; the Jacobian of these rules, in the order of the path, turns that
into errors of the unknowns: conditioning × rounding. Rounding errors have signs, and cancelling
ones must not be added up: the errors are propagated for a few choices of signs at once, and the
largest counts (small-sample condition estimation: C. S. Kenney & A. J. Laub, SIAM J. Sci. Comput.
15 (1994) 36–61).
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from rulesheets.evaluate import Undefined
from rulesheets.model import Equation, Model, Values
from solver.accuracy.rule_sides import MANY, perturbation, sides
from solver.accuracy.rule_sides import size as moved
from solver.facts import DoubleRoot
from solver.numerics.linear_algebra import Array, as_matrix, factorise, sparse_matrix
from solver.numerics.tolerances import BACKWARD, CANCELLED, HALF, UNIT_ROUNDOFF
from solver.path import SolveBlock, Step, given_by, solved_by

SAMPLES = 16
"""Errors are arrays (16,), one a choice of signs."""
DENSE = 400
"""Unknowns from which on a block is factored as a sparse matrix."""

UNKNOWN, NONE = np.full(SAMPLES, math.inf), np.zeros(SAMPLES)


class BlockCondition(NamedTuple):
    """A block at its answer: ``rank`` of its scaled Jacobian, and its ``condition`` (infinite if
    deficient).

    Unknowns are scaled by their values, rules by their largest term. In a large block an unknown
    near 0 is scaled by the change that moves one of its rules by the size of its terms.
    """

    unknowns: tuple[str, ...]
    rank: int
    condition: float


class ForwardErrors(NamedTuple):
    """``error``: an estimate of the absolute error of every variable that has a number, infinite if
    there is none. ``blocks``: the conditions of the blocks, by their unknowns. ``cancelled``: some
    variable is tiny relative to the terms that it was computed from."""

    error: Mapping[str, float]
    blocks: Mapping[tuple[str, ...], BlockCondition] = {}
    cancelled: bool = False


def forward_errors(
    model: Model,
    values: Values,
    steps: Sequence[Step],
    decided: Mapping[int, bool],
    doubles: Sequence[DoubleRoot] = (),
    inputs: Mapping[str, float] | None = None,
    held: bool = False,
) -> ForwardErrors:
    """The errors of the ``values`` that ``steps`` have led to, for conditions with the outcomes
    ``decided``.

    If answers coincide (``doubles``), half the digits are known; errors are infinite for unknowns
    that the rules do not determine at the double root. With ``inputs`` the result is the change of
    every number if these are off by so much, and the numbers in the rules by half a unit of their
    last places; rounding is left out. ``held``: every rule was found to hold, in as many digits as
    needed, so its error is at most its backward error, however large its rounding in floats.
    """
    errors = {n: error * _signs(-2 - k) for k, (n, error) in enumerate((inputs or {}).items())}
    at = {double.equations: double for double in doubles}
    return _Propagation(model, values, decided, at, errors, inputs is None, held).run(steps)


Row: TypeAlias = tuple[Mapping[str, float], Array]
"""A rule at the answer: its slopes, and by how much it may be off, for every choice of signs."""


@dataclass
class _Propagation:
    model: Model
    values: Values
    decided: Mapping[int, bool]
    doubles: Mapping[tuple[int, ...], DoubleRoot]
    errors: dict[str, Array]
    rounds: bool
    held: bool = False
    cancelled: bool = False
    blocks: dict[tuple[str, ...], BlockCondition] = field(default_factory=dict)

    def run(self, steps: Sequence[Step]) -> ForwardErrors:
        with np.errstate(all="ignore"):  # what is no number counts as infinite
            for step in dict.fromkeys(steps):
                rules = solved_by(self.model, step, self.decided)
                if isinstance(step, SolveBlock):
                    self._block(rules, step.unknowns)
                elif rules:
                    self._direct(rules[0], *given_by(step))
            # the largest error over the signs, and what rounding the value itself adds
            rows = np.reshape([*self.errors.values()], (-1, SAMPLES))
            worst = dict(zip(self.errors, np.abs(rows).max(axis=1).tolist(), strict=True))
            error = dict[str, float]()
            for name, number in self.values.items():
                if not isinstance(number, str):
                    off = worst.get(name, 0.0)
                    error[name] = off + UNIT_ROUNDOFF * abs(number) if off and self.rounds else off
        return ForwardErrors(error, self.blocks, self.cancelled)

    def _direct(self, equation: Equation, unknown: str) -> None:
        if not isinstance(self.values.get(unknown), float):
            return
        if (double := self.doubles.get((equation.index,))) is not None:
            self._spread(double, (unknown,))
            return
        self.errors[unknown] = UNKNOWN
        if (row := self._row(equation, (unknown,))) is None:
            return
        slopes, off = row
        if slope := slopes.get(unknown, 0.0):
            # an unknown that is not 0 may be next to nothing beside what its rule adds up
            terms = {
                n: abs(s * v)
                for n, s in slopes.items()
                if isinstance(v := self.values.get(n), float)
            }
            own = terms.pop(unknown)
            cancels = 0.0 < own <= CANCELLED * max(terms.values(), default=0.0)
            self.cancelled = self.cancelled or cancels
        if not off.any():
            self.errors[unknown] = NONE
        elif slope:
            self.errors[unknown] = _finite(-off / slope)

    def _row(self, equation: Equation, unknowns: Sequence[str]) -> Row | None:
        try:
            left, right, slopes, noise = sides(equation, self.values)
        except (Undefined, KeyError):
            return None
        size = noise + abs(left - right)
        if self.held:
            size = min(size, BACKWARD * moved(equation, self.values))
        if not self.rounds:
            size = perturbation([(1.0, equation.form, self.values)], {})
        off = size * _signs(equation.index) if size else NONE
        for name, slope in slopes.items():
            known = self.errors.get(name)
            if known is not None and name not in unknowns and known.any():
                off = off + slope * known
        return slopes, _finite(off)

    def _block(self, equations: Sequence[Equation], unknowns: Sequence[str]) -> None:
        if (double := self.doubles.get(tuple(e.index for e in equations))) is not None:
            self._spread(double, unknowns)
            return
        self.errors |= dict.fromkeys(unknowns, UNKNOWN)
        if not all(name in self.values for name in unknowns):
            return
        system = None
        if len(unknowns) > MANY and self.rounds:
            system = self._many_rows(equations, unknowns)
        else:
            rows = [self._row(equation, unknowns) for equation in equations]
            found = [row for row in rows if row and all(map(math.isfinite, row[0].values()))]
            if len(found) == len(rows):
                matrix = [[slopes.get(name, 0.0) for name in unknowns] for slopes, _ in found]
                sizes = np.array(
                    [abs(v) or 1.0 for n in unknowns if isinstance(v := self.values[n], float)]
                )
                system = (
                    as_matrix(matrix, len(unknowns)),
                    np.array([off for _, off in found]),
                    sizes,
                )
        if system is not None and (errors := self._solved(*system, unknowns)) is not None:
            self.errors |= zip(unknowns, errors, strict=True)

    def _many_rows(
        self, equations: Sequence[Equation], unknowns: Sequence[str]
    ) -> tuple[Any, Array, Array] | None:
        """The Jacobian (n, n) of a large block, the errors of its rules (n, samples), and the sizes
        (n,) of its unknowns."""
        from solver.accuracy.alike import evaluated, sizes_of  # of large blocks alone

        found = evaluated(self.model, equations, self.values)
        n, place = len(unknowns), {name: place for place, name in enumerate(unknowns)}
        size = found.noise + np.abs(found.miss)
        size = np.fmin(size, BACKWARD * found.moves) if self.held else size
        off = _signs_of([e.index for e in equations]) * size[:, None]
        columns = np.array([place.get(name, -1) for name in found.names], dtype=np.intp)[
            found.columns
        ]
        inside = columns >= 0
        known = np.array([self.errors.get(name, NONE) for name in found.names])
        moved = ~inside & np.asarray(known.any(axis=1))[found.columns]
        shifts = found.slopes[moved, None] * known[found.columns[moved]]
        np.add.at(off, found.rows[moved], shifts)
        if not np.isfinite(found.slopes).all():
            return None
        entries = found.slopes[inside], found.rows[inside], columns[inside]
        matrix = sparse_matrix(*entries, (n, n))
        x = np.array([v for name in unknowns if isinstance(v := self.values[name], float)])
        sizes = sizes_of(x, np.fmax(found.moves, found.gross), *entries)
        return (matrix if n > DENSE else matrix.toarray()), off, sizes

    def _solved(
        self, matrix: Any, off: Array, sizes: Array, unknowns: Sequence[str]
    ) -> Array | None:
        """The errors (n, samples) of unknowns of such ``sizes``; None if they are not
        determined."""
        factor, key = factorise(matrix, sizes), tuple(unknowns)
        regular = factor.rank == len(key)
        self.blocks[key] = BlockCondition(
            key, factor.rank, factor.condition() if regular else math.inf
        )
        if not regular or not np.isfinite(off).all():
            return None
        return _finite(factor.solution(-off))

    # --- at a double root ---

    def _spread(self, double: DoubleRoot, unknowns: Sequence[str]) -> None:
        """To first order the unknowns may lie anywhere along the direction, up to half the
        digits."""
        numbers = {n: v for n in unknowns if isinstance(v := self.values.get(n), float)}
        along = [abs(numbers[n] / d) for n, d in double.direction.items() if d and n in numbers]
        reach = HALF * max([1.0, *along])
        for name in unknowns:
            self.errors[name] = (
                reach * double.direction.get(name, 0.0) * _signs(double.equations[0])
            )


@lru_cache(maxsize=4096)
def _signs(index: int) -> Array:
    signs: Array = _signs_of([index])[0]
    return signs


def _signs_of(indices: Iterable[int]) -> Array:
    """Sixteen signs (n, 16) that depend only on a number (the bits of a multiplicative hash, D.
    Knuth)."""
    words = list[int]()
    for index in indices:
        bits = (index + 1) % 2**64 * 0x9E3779B97F4A7C15
        words.append((bits ^ (bits >> 29)) * 0xBF58476D1CE4E5B9 >> 24 & 0xFFFF)
    bits_of = np.array(words, dtype=np.int64)[:, None] >> np.arange(SAMPLES)
    return np.where(bits_of & 1, 1.0, -1.0)


def _finite(errors: Array) -> Array:
    return np.where(np.isnan(errors), np.inf, errors)
