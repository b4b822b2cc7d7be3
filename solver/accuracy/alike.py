"""The rule check for networks of thousands of rules: rules that differ only in names and numbers at
once.

The rules of a network have a few shapes. Those of one shape are rows of arrays, on which one walk
over the shape gives values, slopes and rounding bounds, operation by operation as
``rulesheets.evaluate`` for a single rule. A row with an exception (a subnormal number, an undefined
one, a function that jumps or selects) is left to the check of single rules. Where the rounding of
floats hides whether a rule holds, the long floats of numpy may tell.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from contextlib import suppress
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rulesheets.evaluate import Undefined
from rulesheets.evaluate.gradient import BY_BASE, CHOOSING, SMALLEST, Part, Traced
from rulesheets.evaluate.number import Arithmetic
from rulesheets.functions import TABLE, one_by_one
from rulesheets.model import Equation, Model, Values
from rulesheets.syntax.nodes import (
    Call,
    Expression,
    Name,
    Number,
    Power,
    Product,
    Quotient,
    Sum,
    terms,
)
from solver.accuracy.rule_sides import gross, leads_to_zero, sides, size
from solver.numerics.linear_algebra import Array
from solver.numerics.tolerances import BACKWARD, EPS, FAINTEST, ROUNDINGS
from solver.path.shapes import Alike, Family, shapes

FEWEST = 8
"""Rules of one shape from which on arrays are faster than one rule after another."""

LONG: dict[str, Any] = {
    "ln": np.log,
    **{name: getattr(np, name) for name in ("sqrt", "abs", "exp", "sin", "cos")},
}
"""Functions that numpy has for its long floats."""


# --- one walk for all of them ---------------------------------------------------


class _Columns(Arithmetic[Array]):
    """Columns of numbers, a row for each rule. ``plain`` are the rows without an exception so far.

    ``numbers`` are the columns of those in the text, in order; without them a number stands for
    itself. Functions and powers are those of floats, so that their last digits are those of a
    single rule. ``unit`` is the distance from 1 to the next number.
    """

    unit = EPS

    def __init__(self, columns: Mapping[str, Any], numbers: Array | None, count: int) -> None:
        self.columns, self.plain = columns, np.ones(count, dtype=bool)
        self.numbers = None if numbers is None else iter(numbers)

    def number(self, node: Number) -> Any:
        return node.value if self.numbers is None else next(self.numbers)

    def name(self, node: Name) -> Any:
        return self.columns[node.name]

    def divided(self, node: Quotient, above: Any, below: Any) -> Array:
        return self.finite(np.true_divide(above, below))

    def raised(self, node: Power, base: Any, exponent: Any) -> Array:
        return self.finite(one_by_one(math.pow)(base, exponent))

    def applied(self, node: Call, arguments: list[Any]) -> Array:
        return self.finite(one_by_one(TABLE[node.function].value)(*arguments))

    def finite(self, result: Array) -> Array:
        self.plain &= np.isfinite(result)
        return result


class _LongColumns(_Columns):
    """The same in the long floats of numpy, whose unit is 2⁻⁶³ on most machines."""

    unit = float(np.finfo(np.longdouble).eps)

    def __init__(self, columns: Mapping[str, Array], numbers: Array, count: int) -> None:
        longer = {name: column.astype(np.longdouble) for name, column in columns.items()}
        super().__init__(longer, numbers.astype(np.longdouble), count)

    def raised(self, node: Power, base: Any, exponent: Any) -> Array:
        return self.finite(np.power(base, exponent))

    def applied(self, node: Call, arguments: list[Any]) -> Array:
        if node.function not in LONG:
            raise Undefined(node.function, (), node)
        return self.finite(LONG[node.function](*arguments))


class _TracedColumns(Traced[Array]):
    """The parts of an expression with slopes and rounding, as in ``TracedFloats`` for one rule.

    Slopes of functions are those of floats. Rows with a subnormal number are not plain.
    """

    numbers: _Columns

    def slope(
        self, template: Expression, arguments: Sequence[Part[Array]], node: Expression
    ) -> Array:
        values = (np.asarray(part.value, dtype=float) for part in arguments)
        columns = {str(place): column for place, column in enumerate(values)}
        rows = _Columns(columns, None, len(self.numbers.plain))
        found = rows.of(template)
        return np.where(rows.plain & np.isfinite(found), found, np.nan)

    def by_base(self, base: Part[Array], exponent: Part[Array], node: Power) -> Array:
        return np.where(exponent.value == 0.0, 0.0, self.slope(BY_BASE, (base, exponent), node))

    def rounded(self, node: Expression, result: Array, parts: Sequence[Part[Array]]) -> Array:
        size, ulps, zero = np.abs(result), 1.0, np.zeros((), dtype=bool)
        first = parts[0] if parts else None
        match node:
            case Call(function):
                row = TABLE[function]
                if function in CHOOSING or row.jumps:
                    raise Undefined(function, (), node)
                ulps = row.ulps
            case _ if first is None:
                pass
            case Product():  # with two zeros, either may be lost below floats
                zero = (first.value == 0.0) ^ (parts[1].value == 0.0)
            case Power():
                zero = (first.value == 0.0) & np.asarray(first.exact or bool(first.name))
            case _:
                zero = first.value == 0.0
        self.numbers.plain &= (size >= SMALLEST) | ((size == 0.0) & zero)
        return size * ulps


# --- what comes of it -----------------------------------------------------------


class Evaluated(NamedTuple):
    """Rules (n,) at a point: ``miss`` = left - right with its rounding (``noise``), the size of
    their terms before they cancel (``gross``), and how far each moves with its values (``moves`` =
    Σ|∂F/∂v · v|).

    ``slopes``, ``rows`` and ``columns`` are triplets: ∂F/∂v, the place of the rule, and that of v
    among ``names``. ``holds`` if the check of single rules would accept it; others have to be
    checked one by one. Undefined values are nan.
    """

    names: tuple[str, ...]
    miss: Array
    noise: Array
    gross: Array
    moves: Array
    holds: NDArray[np.bool_]
    slopes: Array
    rows: NDArray[np.intp]
    columns: NDArray[np.intp]


def _point(known: Alike, values: Mapping[str, Any], kind: type = float) -> Array:
    """The values of names; nan for symbols."""
    numbers = (values.get(name) for name in known.names)
    told = (math.nan if v is None or isinstance(v, str) else v for v in numbers)
    return np.fromiter(told, dtype=kind, count=len(known.names))


def evaluated(
    model: Model, equations: Sequence[Equation], values: Mapping[str, Any], long: bool = False
) -> Evaluated:
    """All rules at once; those of rare shapes, or with exceptions, one by one, but in ``long``
    floats not at all."""
    known, columns_of = shapes(model).of(equations), _LongColumns if long else _Columns
    point = _point(known, values, np.longdouble if long else float)
    n = len(equations)
    miss, noise, grosses, moves = (np.full(n, np.nan, dtype=point.dtype) for _ in range(4))
    holds, left_over = np.zeros(n, dtype=bool), np.full(n, not long)
    none = np.empty(0, dtype=np.intp)
    triplets: list[tuple[Array, NDArray[np.intp], NDArray[np.intp]]] = [(np.empty(0), none, none)]
    for family in known.families:
        if len(family.places) < FEWEST and not long:
            continue
        here = point[family.columns]
        columns = dict(zip(family.first.names, here, strict=True))
        rows = columns_of(columns, family.numbers, len(family.places))
        rows.plain &= np.isfinite(here).all(axis=0)
        with np.errstate(all="ignore"), suppress(Undefined):
            side = _FamilySides(family.first, rows)
            plain, places = rows.plain, family.places[rows.plain]
            held = False if long else side.holds(family)
            found = (side.miss, side.noise, side.gross, side.moves, held)
            for store, column in zip((miss, noise, grosses, moves, holds), found, strict=True):
                store[places] = np.broadcast_to(column, plain.shape)[plain]
            for name, column in zip(family.first.names, family.columns, strict=True):
                if name in side.slopes:
                    slope = np.broadcast_to(side.slopes[name], plain.shape)[plain]
                    triplets.append((slope, places, column[plain]))
            left_over[places] = False
    column_of = {name: place for place, name in enumerate(known.names)}
    for place in np.flatnonzero(left_over).tolist():
        equation = equations[place]
        with suppress(Undefined, KeyError):
            left, right, slopes, noise[place] = sides(equation, values)
            miss[place] = left - right
            grosses[place], moves[place] = gross(equation, values), size(equation, values)
            read = np.array([column_of[name] for name in slopes], dtype=np.intp)
            triplets.append((np.array([*slopes.values()]), np.full(len(slopes), place), read))
    parts = (np.concatenate(column) for column in zip(*triplets, strict=True))
    return Evaluated(known.names, miss, noise, grosses, moves, holds, *parts)


class _FamilySides:
    """Both sides of the rules of a family: residuals, moves, rounding."""

    def __init__(self, rule: Equation, rows: _Columns) -> None:
        self.rows, traced = rows, _TracedColumns(rows)
        self.gross: Any = 0.0
        parts = []
        for side in rule.sides:
            added = [traced.of(term) for term in terms(side)]
            self.gross = self.gross + sum(np.abs(term.value) for term in added)
            parts.append(traced.added(added) if isinstance(side, Sum) else added[0])
        (self.slopes, noise), (others, more) = map(traced.gradient, parts)
        for name, slope in others.items():
            self.slopes[name] = self.slopes.get(name, 0.0) - slope
        left, right = (part.value for part in parts)
        self.size = np.abs(left) + np.abs(right)
        self.miss, self.noise = left - right, rows.unit * noise + rows.unit * more
        self.terms = [np.abs(slope * rows.columns[name]) for name, slope in self.slopes.items()]
        self.moves = sum(self.terms, 0.0 * self.miss)
        rows.plain &= (
            np.isfinite(self.size + self.noise) & (self.moves > FAINTEST) & (self.moves < np.inf)
        )

    def holds(self, family: Family) -> Any:
        """Whether the check of single rules accepts a rule by its slopes; the same on arrays."""
        bound, off = BACKWARD * self.moves, np.abs(self.miss) + self.noise
        within, gentle = off <= bound, leads_to_zero(np.abs(self.miss), off, self.terms, self.size)
        accepted = within & gentle | ((self.miss == 0.0) & (self.noise == 0.0))
        if (within & ~accepted).any():
            accepted |= within & self._straddles(family)
        near = np.abs(self.miss) <= bound + ROUNDINGS * self.noise
        chosen = self.rows.plain & near & ~accepted
        if chosen.any() and not isinstance(self.rows, _LongColumns):
            accepted[chosen] = self._hold_in_long_floats(family, chosen)
        return accepted

    def _hold_in_long_floats(self, family: Family, chosen: NDArray[np.bool_]) -> Any:
        """The same of some rows in numbers with more digits; of none that these do not have."""
        part = family._replace(numbers=family.numbers[:, chosen])
        columns = {name: column[chosen] for name, column in self.rows.columns.items()}
        rows = _LongColumns(columns, part.numbers, int(chosen.sum()))
        with suppress(Undefined):
            return _FamilySides(part.first, rows).holds(part) & rows.plain
        return False

    def _straddles(self, family: Family) -> NDArray[np.bool_]:
        """Whether F changes sign as all values move along its slopes, and against them, by twice
        the share of them that F is."""
        share = 2 * np.maximum(np.abs(self.miss) / np.where(self.moves > 0.0, self.moves, 1.0), EPS)
        count, rule = len(self.rows.plain), family.first
        plain = np.ones(count, dtype=bool)
        found = []
        for change in (share, -share):
            moved = dict(self.rows.columns)
            for name, slope in self.slopes.items():
                to = moved[name] + np.copysign(change * np.abs(moved[name]), change * slope)
                moved[name] = np.where(slope != 0.0, to, moved[name])
            rows = type(self.rows)(moved, family.numbers, count)
            found.append(rows.of(rule.left) - rows.of(rule.right))
            plain &= rows.plain & np.isfinite(found[-1])
        straddling: NDArray[np.bool_] = plain & (found[0] >= 0.0) & (found[1] <= 0.0)
        return straddling


def accepted(
    model: Model, equations: Sequence[Equation], values: Values
) -> tuple[float, tuple[Equation, ...]]:
    """Many rules checked at once: the largest scaled residual of those that hold, and the others,
    which are left to the check of single rules."""
    found = evaluated(model, equations, values)
    scaled = np.abs(found.miss) / np.where(found.moves > 0.0, found.moves, 1.0)
    left = tuple([equations[place] for place in np.flatnonzero(~found.holds).tolist()])
    return float(np.max(scaled[found.holds], initial=0.0)), left


def sizes_of(
    x: Array, terms: Array, slopes: Array, rows: NDArray[np.intp], columns: NDArray[np.intp]
) -> Array:
    """The sizes (n,) of the unknowns of a large block, given its Jacobian as triplets.

    An unknown near 0 may be a rounding error. It is measured by the change that moves one of its
    rules by the size of its ``terms`` (n,).
    """
    reach = np.full(len(x), np.inf)
    with np.errstate(all="ignore"):
        np.minimum.at(reach, columns, np.where(slopes, terms[rows] / np.abs(slopes), np.inf))
    size = np.maximum(np.abs(x), np.where(np.isfinite(reach), reach, 0.0))
    return np.where(size > 0.0, size, 1.0)
