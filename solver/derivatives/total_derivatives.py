"""Total derivatives of an answer by its inputs, from one side and from both."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import combinations

from rulesheets.evaluate import Undefined, value
from rulesheets.evaluate.number import equal
from rulesheets.model import Equation, Model, Value
from rulesheets.syntax import nodes
from rulesheets.syntax.nodes import Call, Expression, Number, Quotient
from rulesheets.syntax.program import walk
from solver.derivatives.linearization import Extended, Sharp, linearize, number, precise_slopes, sharpened
from solver.numerics.linear_algebra import eliminate_rows
from solver.path.cases import Pair, comparisons

ZERO = Number(0.0)


def active_comparisons(model: Model, values: Mapping[str, Value]) -> tuple[Pair, ...]:
    """The pairs of numbers that guards compare, that are equal at ``values`` and can move."""
    guards = {premise.condition for equation in model.equations for premise in equation.guard}
    found: dict[Pair, None] = {}
    for index in sorted(guards):
        for atom in comparisons(model.conditions[index]):
            pair = atom.left, atom.right
            varies = any(True for side in pair for _ in nodes.names(side))
            if varies and pair[::-1] not in found and _even(pair, values):
                found[pair] = None
    return tuple(found)


def kinks(equation: Equation, values: Mapping[str, Value]) -> Iterator[Pair]:
    """Pairs that are equal at a kink or a jump of some function in the equation, and come apart beside it."""
    met: list[Pair] = []
    for call in (node for node in walk(equation.left, equation.right) if isinstance(node, Call)):
        match call.function, call.arguments:
            case "abs" | "sgn", (x,):
                met.append((x, ZERO))
            case "min" | "max", arguments:
                extreme = _number(call, values)
                ends = [a for a in arguments if extreme is not None and _number(a, values) == extreme]
                met += combinations(ends, 2)
            case "step", (x, at):
                met.append((x, at))
            case "int" | "frac", (x,):
                met += _whole(x, 0.0, values)
            case "round", (x,):
                met += _whole(x, 0.5, values)
            case "mod", (x, y):
                met += _whole(Quotient(x, y), 0.0, values)
    return (pair for pair in met if _even(pair, values))


def _whole(argument: Expression, offset: float, values: Mapping[str, Value]) -> Iterator[Pair]:
    """The argument and the nearest number at which the function jumps."""
    number = _number(argument, values)
    if number is not None:
        yield argument, Number(round(number - offset) + offset)


def _even(pair: Pair, values: Mapping[str, Value]) -> bool:
    left, right = (_number(side, values) for side in pair)
    return left is not None and right is not None and equal(left, right)


def _number(expression: Expression, values: Mapping[str, Value]) -> float | None:
    try:
        return value(expression, values)
    except (Undefined, KeyError, TypeError):
        return None


AGREE = 1e-25
"""Share of its terms by which a total derivative may miss 0 and still be taken for it."""


@dataclass(frozen=True)
class Total:
    """``by[u][p]`` is du/dp; names of ``underdetermined`` are not determined to first order, or lost.

    ``tied[p]`` is a rule that would no longer hold if input p moved alone. ``rough`` are rules
    without a slope there, and what they read. ``cornered[p]`` are the unknowns that a function of some rule
    has a corner or a jump for as p moves, each with that rule.
    """

    by: Mapping[str, Mapping[str, Extended]]
    underdetermined: frozenset[str]
    tied: Mapping[str, int]
    rough: Mapping[int, frozenset[str]]
    sharp: Sharp
    cornered: Mapping[str, Mapping[str, int]] = field(default_factory=dict)

    def of(self, pair: Pair, parameter: str) -> Extended | None:
        """d(left − right)/dp of a comparison; None where it is not determined."""
        try:
            row = precise_slopes(*pair, self.sharp.values)
        except Undefined:
            return None
        if any(name in self.underdetermined for name in row):
            return None
        return sum(_chain(row, self.by, parameter))


def totals(
    model: Model,
    values: Mapping[str, Value],
    inputs: Collection[str],
    parameters: Sequence[str],
    prefer: Iterable[int] = (),
) -> Total:
    """Total derivatives by ``parameters`` at an answer."""
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
    found = Total(by, sharp.lost, tied, rough, sharp)
    return replace(found, cornered=_cornered(model, values, found, parameters))


def _cornered(
    model: Model, values: Mapping[str, Value], found: Total, parameters: Sequence[str]
) -> dict[str, dict[str, int]]:
    """The unknowns of every rule at a corner that comes apart with a parameter, and all that follows."""
    sharp = found.sharp
    corner_of = {e: pairs for e in sharp.rows if (pairs := [*kinks(model.equations[e], values)])}
    if not corner_of:
        return {}
    lost: dict[str, dict[str, int]] = {}
    for parameter in parameters:
        met = {e for e, pairs in corner_of.items() if any(found.of(p, parameter) != 0 for p in pairs)}
        names: dict[str, int] = {}
        for block in sharp.blocks:
            blamed = [e for e in block.equations if e in met]
            blamed += [names[n] for e in block.equations for n in sharp.rows[e] if n in names]
            if blamed:
                names.update(dict.fromkeys(block.unknowns, blamed[0]))
        lost[parameter] = names
    return lost


def _solved(sharp: Sharp, parameters: Sequence[str]) -> dict[str, dict[str, Extended]]:
    """du/dp block by block; parameters that an unknown does not depend on are left out."""
    by: dict[str, dict[str, Extended]] = {p: {p: 1} for p in parameters}
    for block in sharp.blocks:
        place = {name: j for j, name in enumerate(block.unknowns)}
        rows = [
            {place[n]: slope for n, slope in sharp.rows[e].items() if n in place} for e in block.equations
        ]
        read = {name for e in block.equations for name in sharp.rows[e]}
        known = {p for name in read for p in by.get(name, ())}
        moving = [p for p in parameters if p in known]
        columns = [[-sum(_chain(sharp.rows[e], by, p)) for e in block.equations] for p in moving]
        solved = eliminate_rows(rows, columns) if columns else []
        for name, j in place.items():
            by[name] = {p: column[j] for p, column in zip(moving, solved, strict=True)}
    return by


def _chain(
    row: Mapping[str, Extended], by: Mapping[str, Mapping[str, Extended]], parameter: str
) -> list[Extended]:
    """The terms ∂F/∂v · dv/dp of a total derivative."""
    return [slope * by[name][parameter] for name, slope in row.items() if parameter in by.get(name, ())]


Near = Callable[[Mapping[str, Value], Mapping[str, float]], Mapping[str, Value] | None]
"""The answer for some inputs that is nearest to guesses; None where there is none."""

NODES = 8
FARTHEST = 2.0**-10
"""Distance of the farthest node, in units of the input (or 1); each next one is half as far."""

SETTLED = 1e-12
"""Change of the limit by its farthest node, relative, at which it is one."""

CONTINUOUS, NOUGHT = 1e-9, 1e-15
"""Relative distance of an output from its limit, and of a limit from 0, at which they are taken for one."""


def one_sided(
    model: Model,
    values: Mapping[str, Value],
    inputs: Mapping[str, Value],
    outputs: Sequence[str],
    given: str,
    way: int,
    near: Near,
) -> dict[str, float]:
    """Limits of the derivatives by ``given`` from above (``way`` 1) or below (-1), where there are any.

    An output that is not continuous there has none, and nothing has where there is no answer on that side.
    """
    middle = inputs[given]
    assert isinstance(middle, float)
    guesses = {n: v for n, v in values.items() if isinstance(v, float) and n not in inputs}
    reach = FARTHEST * max(abs(middle), 1.0)
    nodes: list[Extended] = []
    slopes: dict[str, list[Extended]] = {output: [] for output in outputs}
    levels: dict[str, list[Extended]] = {output: [] for output in outputs}
    for k in range(NODES):
        moved = {**inputs, given: middle + way * reach * 2.0**-k}
        answer = near(moved, guesses)
        if answer is None:
            return {}
        total = totals(model, answer, moved, (given,))
        nodes.append(number(moved[given]) - number(middle))  # type: ignore[arg-type]
        for output in [*slopes]:
            if output in total.underdetermined or output not in total.by or given in total.tied:
                del slopes[output], levels[output]
                continue
            slopes[output].append(total.by[output].get(given, number(0.0)))
            levels[output].append(total.sharp.values[output])
    found = {}
    for output, samples in slopes.items():
        slope, level = _limit(nodes, samples), _limit(nodes, levels[output])
        here = values[output]
        if slope is None or level is None or not isinstance(here, float):
            continue
        if abs(level - here) <= CONTINUOUS * max(abs(here), *map(abs, levels[output])):
            found[output] = float(slope)
    return found


def _limit(nodes: Sequence[Extended], samples: Sequence[Extended]) -> Extended | None:
    """The value at 0 of the polynomial through the samples, by Neville's scheme; None where it depends on the
    farthest one."""
    row, rest = list(samples), samples[-1]
    for step in range(1, len(row)):
        rest = row[1]
        for i in range(len(row) - step):
            far, near = nodes[i], nodes[i + step]
            row[i] = (far * row[i + 1] - near * row[i]) / (far - near)
    size = max(map(abs, samples))
    if abs(row[0] - rest) > SETTLED * size:
        return None
    return row[0] if abs(row[0]) > NOUGHT * size else row[0] * 0
