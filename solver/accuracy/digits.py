"""As many equations as unknowns, in many decimal digits: residual, Jacobian, Newton's method."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from copy import copy
from dataclasses import dataclass
from functools import partial
from itertools import repeat
from math import inf
from typing import Any, TypeAlias

import numpy as np

from rulesheets.deadline import expect_time
from rulesheets.evaluate import Undefined, derivatives
from rulesheets.evaluate.digits import context, extended_derivatives
from rulesheets.model import Equation
from rulesheets.syntax.nodes import Expression, walk
from solver.accuracy.rule_check import in_decimals
from solver.accuracy.rule_sides import gross, half_unit, perturbation
from solver.numerics.elimination import Singular, eliminate_rows
from solver.numerics.linear_algebra import are_alike
from solver.numerics.tolerances import CLOSE, FOLD, REFINED, SMALL, SPARE, SUSPECT

MAX_ITERATIONS = 40
MAX_WORK = 60_000
"""Operations."""


class Unresolved(Exception):
    """The equations are undecided in many digits."""


@dataclass
class DigitWork:
    """The remaining operations in many digits, for all systems of a path together."""

    left: int = MAX_WORK

    def spend(self, count: int) -> None:
        """Raises Unresolved if nothing is left."""
        self.left -= count
        if self.left < 0:
            raise Unresolved


def linearized(
    forms: Sequence[Expression],
    unknowns: Sequence[str],
    values: Mapping[str, Any],
    digits: int | None = None,
) -> tuple[list[list[Any]], list[Any]]:
    """Jacobian (m, n) of as many forms by the unknowns, and their values (m,): in floats, or in so
    many ``digits``. Raises Undefined."""
    swept: Any = derivatives
    if digits is not None:
        swept = partial(extended_derivatives, digits=digits, along=unknowns)
    found = [swept(form, values) for form in forms]
    return [[slopes.get(n, 0.0) for n in unknowns] for _, slopes in found], [f for f, _ in found]


class ManyDigits:
    """F(x) = 0, with the ``known`` values exact. Points are lists (n,) of mpmath numbers."""

    def __init__(
        self,
        equations: Sequence[Equation],
        unknowns: Sequence[str],
        known: Mapping[str, Any],
        digits: int,
        work: DigitWork,
    ) -> None:
        self.equations, self.unknowns = equations, tuple(unknowns)
        self.forms = tuple(equation.form for equation in equations)
        names = {name for equation in equations for name in equation.names} - set(unknowns)
        self.known = {name: known[name] for name in names}
        self.digits, self.work, self.mp = digits, work, context(digits)
        # the operations of a residual and its square Jacobian
        operations = sum(len(walk(*e.sides)) for e in equations)
        self.cost = 3 * operations + len(equations) ** 3
        self.tiny = self.mp.mpf(10) ** (SPARE - digits)
        self.small = self.mp.mpf(10) ** (-7 * digits // 10)

    def in_decimals(self) -> ManyDigits | None:
        """The same with given numbers, and those in the rules, as decimals; None if floats hold
        them all."""
        system = copy(self)
        system.forms, system.known = in_decimals(self.forms, self.known)
        return None if all(v == float(v) for v in system.known.values()) else system

    def point(self, x: Sequence[Any]) -> dict[str, Any]:
        return dict(zip(self.unknowns, x, strict=True))

    def linearised(self, x: Sequence[Any]) -> tuple[list[list[Any]], list[Any]]:
        """Jacobian (n, n) and residual (n,).

        Raises Undefined outside the domain, and if a slope has no value.
        """
        values = {**self.known, **self.point(x)}
        self.work.spend(self.cost)
        return linearized(self.forms, self.unknowns, values, self.digits)

    def newton(self, start: Sequence[Any], sizes: Sequence[float] = ()) -> list[Any] | None:
        """The root that Newton's method reaches from ``start``; None if it reaches none.

        ``sizes`` (n,) of the terms of the unknowns: an unknown that is 0 is computed only to their
        rounding.
        """
        x, before = [self.mp.mpf(v) for v in start], self.mp.inf
        for _ in range(MAX_ITERATIONS):
            expect_time()
            try:
                jacobian, misses = self.linearised(x)
                rows = [{j: slope for j, slope in enumerate(row) if slope} for row in jacobian]
                step = eliminate_rows(rows, [misses], self.tiny)[0]
                x = [v - d for v, d in zip(x, step, strict=True)]
                scales = sizes or [float(max(map(abs, x)))] * len(x)
            except (Undefined, Singular, OverflowError):
                return None
            sized = (
                (d, max(abs(v), self.tiny * size))
                for v, d, size in zip(x, step, scales, strict=True)
            )
            length = max(abs(d) / (size or abs(d)) if d else 0 for d, size in sized)
            # the next step, which is quadratically smaller, would be lost in rounding; or this one
            # is
            if length <= self.small or REFINED >= length >= before:
                return x
            before = length
        return None


# --- two roots that floats cannot tell apart: a fold of the equations ---
#
# Near a fold the Jacobian has one small singular value, with null vectors v and u. The bordered
# system F(x) + μ u = 0, v·(x − x₀) = t stays regular there and leaves a scalar equation μ(t) = 0
# (Lyapunov–Schmidt reduction; W. Govaerts, Numerical Methods for Bifurcations of Dynamical
# Equilibria, 2000, chapter 3). Its extreme value says whether there are two roots, one double root,
# or none.

FOLD_ITERATIONS = 60


Fold: TypeAlias = tuple[list[list[Any]], list[Any] | None]
"""Roots, two or none, and the point where the two coincide, as far as the precision tells, or as
far as the known values can: to half a unit of the last place of each that is no short number; or
where numbers are the decimals as which they are written."""


def resolve_fold(system: ManyDigits, start: Sequence[float], scale: Sequence[float]) -> Fold | None:
    """The fold near ``start``; None if there is none, or if it cannot be followed.

    Near is relative to the unknowns; if there is none, to their typical sizes ``scale``: relative
    to its own size, a fold at 0 is not near to its roots.
    """
    own = _sizes(start)
    typical = [max(size, s) for size, s in zip(own, scale, strict=True)]
    for sizes in (own, typical) if typical != own else (own,):
        vectors = null_vectors(system, start, sizes)
        with suppress(Undefined, OverflowError, Singular, ZeroDivisionError):
            if vectors and (fold := _Reduction(system, start, vectors, sizes).resolve()):
                decimals = None if fold[1] else system.in_decimals()
                with suppress(Undefined, OverflowError, Singular, ZeroDivisionError):
                    if decimals and (
                        touching := _Reduction(decimals, start, vectors, sizes).touching()
                    ):
                        return [], touching
                return fold
    return None


def _sizes(x: Sequence[float]) -> list[float]:
    """The sizes of the unknowns; a tiny one gets that of the largest."""
    largest = max(abs(v) for v in x) or 1.0
    return [abs(v) if abs(v) > SMALL * largest else largest for v in x]


def null_vectors(
    system: ManyDigits, x: Sequence[float], sizes: Sequence[float] | None = None
) -> tuple[list[float], list[float]] | None:
    """Null vectors (v, u) of the Jacobian, scaled by the ``sizes`` of the unknowns; None if it is
    regular."""
    x = [float(v) for v in x]
    sizes = sizes or _sizes(x)
    try:
        jacobian = np.array(system.linearised(x)[0], dtype=float)
        values = {name: float(v) for name, v in {**system.known, **system.point(x)}.items()}
    except (Undefined, OverflowError):
        return None
    with np.errstate(all="ignore"):  # what overflows is refused
        scaled = jacobian * sizes
    rows = np.maximum(
        np.abs(scaled).max(axis=1), [gross(equation, values) for equation in system.equations]
    )
    if not (np.isfinite(scaled).all() and np.isfinite(rows).all() and rows.all()):
        return None
    left, singular, right = np.linalg.svd(scaled / rows[:, None])
    if singular[-1] > SUSPECT or (len(singular) > 1 and singular[-2] <= SUSPECT * SUSPECT):
        return None
    return right[-1].tolist(), (left[:, -1] * rows).tolist()


class _Reduction:
    """μ(t) along the null direction, by Newton on the bordered system; ``vectors`` are v and u."""

    def __init__(
        self,
        system: ManyDigits,
        start: Sequence[float],
        vectors: tuple[Sequence[float], Sequence[float]],
        sizes: Sequence[float],
    ) -> None:
        self.system, self.mp, self.tiny, self.sizes = system, system.mp, system.tiny, sizes
        self.start, self.across = (
            list(map(self.mp.mpf, numbers)) for numbers in (start, vectors[1])
        )
        self.along = [self.mp.mpf(v / s) for v, s in zip(vectors[0], sizes, strict=True)]
        self.x, self.mu = self.start, self.mp.zero

    def touching(self) -> list[Any] | None:
        """The point at which two roots coincide to all the digits; None if they do not."""
        extreme = self._extreme()
        return self.x if extreme and abs(extreme[2]) <= self.tiny * abs(extreme[1]) else None

    def resolve(self) -> Fold | None:
        if (extreme := self._extreme()) is None:
            return None
        t, curvature, height = extreme
        if abs(height) <= self.tiny * abs(curvature) + self._fuzz():
            return [], self.x
        if height / curvature > 0:
            return ([], None) if self._explained(()) else None
        reach = self.mp.sqrt(-2 * height / curvature)
        if reach > FOLD:
            return None
        found = []
        # from the estimate by Newton on the block itself, which is regular there
        for side in (-1, 1):
            self.at(t + side * reach)
            if (root := self.system.newton(self.x)) is None:
                return None
            found.append(root)
        if not self._explained(found):
            return None
        pairs = zip(*found, self.sizes, strict=True)
        return (
            (found, None) if any(abs(a - b) > self.tiny * 1000 * s for a, b, s in pairs) else None
        )

    def _explained(self, found: Sequence[Sequence[Any]]) -> bool:
        """Whether a regular root at the start, if there is one, is among those of this fold: else
        it is another fold, farther away."""
        root = self.system.newton(self.start)
        if root is None or not are_alike(root, self.start, CLOSE):
            return True
        return any(are_alike(root, one, CLOSE) for one in found)

    def at(self, t: Any) -> tuple[Any, Any]:
        """μ and its slope at t; leaves the point on the curve in ``x``. Raises Singular."""
        n = len(self.start)
        for _ in range(FOLD_ITERATIONS):
            jacobian, residual = self.system.linearised(self.x)
            offset = sum(
                v * (x - s) for v, x, s in zip(self.along, self.x, self.start, strict=True)
            )
            miss = [f + self.mu * u for f, u in zip(residual, self.across, strict=True)]
            step, rise = self._bordered(
                jacobian, [*miss, offset - t], [self.mp.zero] * n + [self.mp.one]
            )
            self.x = [x - d for x, d in zip(self.x, step[:n], strict=True)]
            self.mu -= step[n]
            small = self.system.small  # the next step, quadratically smaller, would be rounding
            if all(abs(d) <= small * s for d, s in zip(step[:n], self.sizes, strict=True)):
                return self.mu, rise[n]
        raise Singular("no point of the curve is reached")

    def _fuzz(self) -> float:
        """The change of μ as the known values move by half a unit of their last places."""
        system, n = self.system, len(self.start)
        values = {n: float(v) for n, v in {**system.known, **system.point(self.x)}.items()}
        # the share of every rule in μ
        columns = zip(*self._matrix(system.linearised(self.x)[0]), strict=True)
        last = [*[self.mp.zero] * n, self.mp.one]
        shares = eliminate_rows([dict(enumerate(column)) for column in columns], [last], self.tiny)
        rules = zip(map(float, shares[0]), system.forms, repeat(values), strict=False)
        off = {name: half_unit(values[name]) for name in system.known}
        if (moved := perturbation(rules, off, 0.0)) == inf:
            raise Singular("a rule has no value")
        return moved

    def _matrix(self, jacobian: Sequence[Sequence[Any]]) -> list[list[Any]]:
        rows = [[*row, u] for row, u in zip(jacobian, self.across, strict=True)]
        return [*rows, [*self.along, self.mp.zero]]

    def _bordered(
        self, jacobian: Sequence[Sequence[Any]], *columns: Sequence[Any]
    ) -> list[list[Any]]:
        """The solution of the bordered system for these right-hand sides. Raises Singular."""
        rows = [dict(enumerate(row)) for row in self._matrix(jacobian)]
        return eliminate_rows(rows, columns, self.tiny)

    def _extreme(self) -> tuple[Any, Any, Any] | None:
        """The zero of the slope of μ, by the secant method, with the curvature and μ there."""
        a, b = self.mp.zero, self.mp.mpf(1e-9)
        at_a, at_b = self.at(a)[1], self.at(b)[1]
        curvature = self.mp.zero
        for _ in range(FOLD_ITERATIONS):
            if at_b == at_a:
                break
            curvature = (at_b - at_a) / (b - a)
            a, at_a, b = b, at_b, b - at_b / curvature
            if abs(b) > FOLD:
                return None
            if abs(b - a) <= self.system.small:
                break
            at_b = self.at(b)[1]
        else:
            return None
        return (b, curvature, self.at(b)[0]) if curvature else None
