"""The active rules of a model at a point, linearized, and the total derivatives that follow.

At an answer the active rules are F(u, p) = 0, u the unknowns and p the inputs. Sensitivities, error
estimates and the tangent of a curve of answers follow from their Jacobian. They need as many
independent rows as unknowns, in blocks that are solved one after another.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Any, NamedTuple, TypeAlias

from rulesheets.evaluate import Undefined, value
from rulesheets.evaluate.digits import context, extended_derivatives, in_many_digits
from rulesheets.evaluate.number import equal
from rulesheets.model import Equation, Model, Values
from rulesheets.syntax import nodes
from rulesheets.syntax.nodes import ZERO, Expression, Number, Quotient, calls, subtract
from solver.accuracy.digits import DigitWork, ManyDigits, Unresolved
from solver.accuracy.rule_sides import sides, symbol_of
from solver.numerics.elimination import eliminate_rows, independent_rows
from solver.numerics.linear_algebra import factorise
from solver.numerics.tolerances import ASTRAY, DRIFT
from solver.path import known_rules
from solver.path.cases import Pair, comparisons, outcomes
from solver.structure.decomposition import Incidence, block_triangular, maximum_matching

Rows: TypeAlias = Mapping[int, Mapping[str, float]]
"""The slopes of equations by variable."""


class SquareBlock(NamedTuple):
    """As many rules as unknowns, independent at the point."""

    equations: tuple[int, ...]
    unknowns: tuple[str, ...]


class Linearization(NamedTuple):
    """Slopes of the active rules at a point, in the user's own units.

    ``rows[e]`` are ∂(left − right)/∂v of equation e by variable, unknowns and inputs alike.
    ``blocks`` are a regular square part in block lower triangular order: each needs only the blocks
    before it. ``redundant`` are the other active equations, ``rough`` those with a slope that does
    not exist there. ``free`` are the unknowns that the rules do not determine to first order. Some
    of them are in no block: with these held the rest is regular.
    """

    rows: Rows
    blocks: tuple[SquareBlock, ...]
    redundant: tuple[int, ...]
    free: tuple[str, ...]
    rough: tuple[int, ...]

    @property
    def equations(self) -> tuple[int, ...]:
        """The square part, in order of the blocks."""
        return tuple(e for block in self.blocks for e in block.equations)

    @property
    def unknowns(self) -> tuple[str, ...]:
        """The unknowns of the square part, in order of the blocks."""
        return tuple(name for block in self.blocks for name in block.unknowns)


def active_equations(model: Model, values: Values, inputs: Collection[str]) -> tuple[Equation, ...]:
    """Equations of numbers whose guards hold at ``values`` and all of whose variables have one."""
    known = known_rules(model, outcomes(model, values, inputs), values)
    symbols = ((e, symbol_of(e.left, values), symbol_of(e.right, values)) for e in known)
    return tuple(equation for equation, *found in symbols if found == [None, None])


def linearize(
    model: Model, values: Values, inputs: Collection[str], prefer: Iterable[int] = ()
) -> Linearization:
    """Linearize the active rules at ``values``, an answer for ``inputs`` (names).

    If rules repeat one another, those of ``prefer`` (such as the rules that a path solved with) are
    taken first. Never raises for a singular point: see ``free`` and ``rough``.
    """
    every = {e.index: slopes(e, values) for e in active_equations(model, values, inputs)}
    rows = {index: row for index, row in every.items() if row is not None}
    names = {name for row in rows.values() for name in row}
    unknowns = tuple(name for name in model.variables if name in names and name not in inputs)
    first = [e for e in dict.fromkeys(prefer) if e in rows]
    order = [*first, *(e for e in rows if e not in set(first))]
    blocks, free = _square(rows, order, unknowns, values)
    used = {e for block in blocks for e in block.equations}
    redundant = tuple(e for e in rows if e not in used)
    undetermined = tuple(name for name in unknowns if name in free)
    rough = tuple(e for e in every if e not in rows)
    return Linearization(rows, blocks, redundant, undetermined, rough)


def slopes(equation: Equation, values: Values) -> dict[str, float] | None:
    """∂(left − right)/∂v by variable; None if one of them does not exist."""
    try:
        row = dict(sides(equation, values).slopes)
    except Undefined:
        return None
    return row if all(map(math.isfinite, row.values())) else None


# --- the regular square part ----------------------------------------------------------


def _square(
    rows: Rows, order: Sequence[int], unknowns: Sequence[str], values: Values
) -> tuple[tuple[SquareBlock, ...], set[str]]:
    """Blocks of independent rows, and the free unknowns. The rows are the first of ``order`` if
    these are regular; else some unknowns are held so that the rest is regular, and are in no
    block."""
    matching = maximum_matching(_incidence(rows, order, unknowns, moving=True))
    taken = [e for place, e in enumerate(order) if matching.unknown_of[place] is not None]
    if len(taken) == len(unknowns):
        blocks = _blocks(rows, taken, unknowns)
        factors = (factorise(*_matrix(rows, *block, values)) for block in blocks)
        if all(factor.rank == factor.columns for factor in factors):
            return blocks, set()
    found = independent_rows(*_matrix(rows, order, unknowns, values))
    taken = [order[i] for i in found.rows]
    kept = [name for j, name in enumerate(unknowns) if j not in found.held]
    return _blocks(rows, taken, kept), {unknowns[j] for j in found.free}


def _blocks(rows: Rows, taken: Sequence[int], unknowns: Sequence[str]) -> tuple[SquareBlock, ...]:
    """Blocks in lower triangular form, by everything that occurs in the rows."""
    found = []
    for block in block_triangular(_incidence(rows, taken, unknowns, moving=False)):
        names = tuple(unknowns[u] for u in block.unknowns)
        found.append(SquareBlock(tuple(taken[e] for e in block.equations), names))
    return tuple(found)


def _incidence(
    rows: Rows, order: Sequence[int], unknowns: Sequence[str], *, moving: bool
) -> Incidence:
    """Equations by place in ``order``; ``moving`` leaves out variables whose slope is 0."""
    place = {name: i for i, name in enumerate(unknowns)}
    seen = (
        [n for n, slope in rows[e].items() if n in place and (slope or not moving)] for e in order
    )
    occurs = tuple(tuple(sorted(place[name] for name in names)) for names in seen)
    return Incidence(occurs, tuple({} for _ in occurs), len(unknowns))


def _matrix(
    rows: Rows, order: Sequence[int], unknowns: Sequence[str], values: Values
) -> tuple[list[list[float]], list[float]]:
    """The slopes of these rows by the unknowns, and the sizes of the unknowns."""
    sizes = [abs(v) if isinstance(v := values[name], float) and v else 1.0 for name in unknowns]
    return [[rows[e].get(name, 0.0) for name in unknowns] for e in order], sizes


Extended: TypeAlias = Any
"""A number of mpmath."""

DIGITS = 100
"""Digits that are computed with."""

MAX_WORK = 10**12


class Sharp(NamedTuple):
    """``values`` to many digits (symbols unchanged); ``rows[e]`` are ∂(left − right)/∂v there.

    ``blocks`` are those that were refined. ``lost`` are the other unknowns: free ones, those of
    rough rules, and all that is computed from lost ones, even with a slope of 0 (``y = x^2`` with x
    free at 0: an unbounded change times 0 is not 0).
    """

    values: Mapping[str, Any]
    rows: Mapping[int, Mapping[str, Extended]]
    blocks: tuple[SquareBlock, ...]
    lost: frozenset[str]


def sharpened(
    model: Model, linear: Linearization, values: Values, inputs: Collection[str]
) -> Sharp:
    """The answer near ``values`` for ``inputs`` (names) in many digits, and the slopes of its
    rules.

    A block with a function that is known in floats only is unchanged.
    """
    exact: dict[str, Any] = {n: v if isinstance(v, str) else number(v) for n, v in values.items()}
    rows: dict[int, Mapping[str, Extended]] = {}
    blocks: list[SquareBlock] = []
    read = {name for e in linear.rough for name in model.equations[e].names}
    lost = {*linear.free, *read.difference(inputs, linear.unknowns)}
    for block in linear.blocks:
        equations = [model.equations[e] for e in block.equations]
        try:
            if any(lost.intersection(equation.names) for equation in equations):
                raise Unresolved
            if all(in_many_digits(side) for e in equations for side in e.sides):
                _settle(equations, linear.rows, block, exact)
                rows.update((e.index, precise_slopes(e.left, e.right, exact)) for e in equations)
            else:
                slopes_of = ((e, linear.rows[e]) for e in block.equations)
                rows.update((e, {n: number(by) for n, by in row.items()}) for e, row in slopes_of)
            blocks.append(block)
        except (Undefined, Unresolved):
            lost.update(block.unknowns)
            numbers = ((n, v) for n in block.unknowns if isinstance(v := values[n], float))
            exact.update((name, number(v)) for name, v in numbers)
    for index in linear.redundant:
        rule = model.equations[index]
        try:
            rows[index] = precise_slopes(rule.left, rule.right, exact)
        except Undefined:
            continue
    return Sharp(exact, rows, tuple(blocks), frozenset(lost))


def number(value: float) -> Extended:
    """A float as the exact number that it is."""
    return context(DIGITS).mpf(value)


def precise_slopes(
    left: Expression, right: Expression, values: Mapping[str, Any]
) -> dict[str, Extended]:
    """∂(left − right)/∂v for every variable in them. Raises Undefined."""
    return extended_derivatives(subtract(left, right), values, DIGITS)[1]


def _settle(
    equations: Sequence[Equation], rows: Rows, block: SquareBlock, exact: dict[str, Any]
) -> None:
    """The root of a block near its float values. Raises Unresolved if there is none."""
    start = {name: float(exact[name]) for name in block.unknowns}
    # the terms that an unknown is made of: the largest Σ|∂F/∂v·v| / |∂F/∂u| of its rules
    terms = dict.fromkeys(block.unknowns, 0.0)
    for row in (rows[equation.index] for equation in equations):
        total = sum(abs(slope * float(exact[name])) for name, slope in row.items())
        for name in terms.keys() & row.keys():
            if row[name]:
                terms[name] = max(terms[name], total / abs(row[name]))
    sizes = list(terms.values())
    system = ManyDigits(equations, block.unknowns, exact, DIGITS, DigitWork(MAX_WORK))
    root = system.newton(list(start.values()), sizes)
    if root is None or any(
        abs(v - x) > DRIFT * abs(x) + ASTRAY * size
        for v, x, size in zip(root, start.values(), sizes, strict=True)
    ):
        raise Unresolved
    exact.update(zip(block.unknowns, root, strict=True))


# --- total derivatives by the inputs ---


def active_comparisons(model: Model, values: Values) -> tuple[Pair, ...]:
    """The pairs of numbers compared by guards that are equal at ``values`` and can move."""
    guards = {premise.condition for equation in model.equations for premise in equation.guard}
    found: dict[Pair, None] = {}
    for index in sorted(guards):
        for atom in comparisons(model.conditions[index]):
            pair = atom.left, atom.right
            varies = any(True for side in pair for _ in nodes.names(side))
            if varies and pair[::-1] not in found and _even(pair, values):
                found[pair] = None
    return tuple(found)


def kinks(equation: Equation, values: Values) -> Iterator[Pair]:
    """Pairs that are equal at a kink or a jump of a function in the equation, but not near it."""
    met: list[Pair] = []
    for call in calls(*equation.sides):
        match call.function, call.arguments:
            case "abs" | "sgn", (x,):
                met.append((x, ZERO))
            case "min" | "max", arguments:
                if (extreme := _number(call, values)) is not None:
                    met += combinations((a for a in arguments if _number(a, values) == extreme), 2)
            case "step", (x, at):
                met.append((x, at))
            case "int" | "frac", (x,):
                met += _whole(x, 0.0, values)
            case "round", (x,):
                met += _whole(x, 0.5, values)
            case "mod", (x, y):
                met += _whole(Quotient(x, y), 0.0, values)
    return (pair for pair in met if _even(pair, values))


def _whole(argument: Expression, offset: float, values: Values) -> Iterator[Pair]:
    """The argument and the nearest number at which the function jumps."""
    number = _number(argument, values)
    if number is not None:
        yield argument, Number(round(number - offset) + offset)


def _even(pair: Pair, values: Values) -> bool:
    left, right = (_number(side, values) for side in pair)
    return left is not None and right is not None and equal(left, right)


def _number(expression: Expression, values: Values) -> float | None:
    try:
        return value(expression, values)
    except (Undefined, KeyError, TypeError):
        return None


AGREE = 1e-25
"""Share of its terms by which a total derivative may miss 0 and still be taken for it."""


@dataclass(frozen=True)
class Total:
    """``by[u][p]`` is du/dp at the ``sharp`` answer; lost unknowns are not determined to first
    order.

    ``tied[p]`` is a rule that would no longer hold if input p moved alone. ``rough`` are rules
    without a slope there, and the names in them.
    """

    by: Mapping[str, Mapping[str, Extended]]
    tied: Mapping[str, int]
    rough: Mapping[int, frozenset[str]]
    sharp: Sharp

    def of(self, pair: Pair, parameter: str) -> Extended | None:
        """d(left − right)/dp of a comparison; None if it is not determined."""
        try:
            row = precise_slopes(*pair, self.sharp.values)
        except Undefined:
            return None
        if not self.sharp.lost.isdisjoint(row):
            return None
        return sum(_chain(row, self.by, parameter))


def totals(
    model: Model,
    values: Values,
    inputs: Collection[str],
    parameters: Sequence[str],
    prefer: Iterable[int] = (),
) -> Total:
    linear = linearize(model, values, inputs, prefer)
    sharp = sharpened(model, linear, values, inputs)
    by = _solved(sharp, parameters)
    rough = {e: frozenset(model.equations[e].names) for e in linear.rough}
    tied: dict[str, int] = {}  # redundant rules that hold at the answer, but not beside it
    for equation in linear.redundant:
        row = sharp.rows.get(equation, {})
        for parameter in parameters if sharp.lost.isdisjoint(row) else ():
            terms = _chain(row, by, parameter)
            if abs(sum(terms)) > AGREE * sum(map(abs, terms)):
                tied.setdefault(parameter, equation)
    return Total(by, tied, rough, sharp)


def _solved(sharp: Sharp, parameters: Sequence[str]) -> dict[str, dict[str, Extended]]:
    """du/dp block by block; parameters that an unknown does not depend on are left out."""
    by: dict[str, dict[str, Extended]] = {p: {p: 1} for p in parameters}
    for block in sharp.blocks:
        place = {name: j for j, name in enumerate(block.unknowns)}
        every = [sharp.rows[e] for e in block.equations]
        rows = [{place[n]: slope for n, slope in row.items() if n in place} for row in every]
        known = {p for row in every for name in row for p in by.get(name, ())}
        moving = [p for p in parameters if p in known]
        columns = [[-sum(_chain(row, by, p)) for row in every] for p in moving]
        solved = eliminate_rows(rows, columns) if columns else []
        for name, j in place.items():
            by[name] = {p: column[j] for p, column in zip(moving, solved, strict=True)}
    return by


def _chain(
    row: Mapping[str, Extended], by: Mapping[str, Mapping[str, Extended]], parameter: str
) -> list[Extended]:
    """The terms ∂F/∂v · dv/dp of a total derivative."""
    moving = ((slope, by[n]) for n, slope in row.items() if parameter in by.get(n, ()))
    return [slope * each[parameter] for slope, each in moving]
