"""How an answer moves with its inputs: the implicit function theorem on the active rules.

Where F(u, p) = 0 and ∂F/∂u is regular, du/dp = −(∂F/∂u)⁻¹ ∂F/∂p, solved block by block in the order of the
block triangular form. Everything is evaluated at the sharpened answer, so that the digits are right
wherever the derivative exists.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace

from rulesheets.evaluate import Undefined
from rulesheets.model import Model, Value
from solver.derivatives.kinks import kinks
from solver.derivatives.linearization import Linearization, linearize
from solver.derivatives.sharpening import Extended, Sharp, sharpened, slopes
from solver.numerics.elimination import solve_exactly
from solver.path.cases import Pair

AGREE = 1e-25
"""Share of its terms by which a total derivative may miss 0 and still be taken for it."""


@dataclass(frozen=True)
class Total:
    """``by[u][p]`` is du/dp; names of ``loose`` are not determined to first order, or lost.

    ``tied[p]`` is a rule that would no longer hold if input p moved alone. ``rough`` are rules
    without a slope there, and what they read. ``cornered[p]`` are the unknowns that a function of some rule
    has a corner or a jump for as p moves, each with that rule.
    """

    by: Mapping[str, Mapping[str, Extended]]
    loose: frozenset[str]
    tied: Mapping[str, int]
    rough: Mapping[int, frozenset[str]]
    sharp: Sharp
    cornered: Mapping[str, Mapping[str, int]] = field(default_factory=dict)

    def of(self, pair: Pair, parameter: str) -> Extended | None:
        """d(left − right)/dp of a comparison; None where it is not determined."""
        try:
            row = slopes(*pair, self.sharp.values)
        except Undefined:
            return None
        if any(name in self.loose for name in row):
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
    found = Total(by, sharp.lost, _ties(linear, sharp, by, parameters), rough, sharp)
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
        solved = solve_exactly(rows, columns) if columns else []
        for name, j in place.items():
            by[name] = {p: column[j] for p, column in zip(moving, solved, strict=True)}
    return by


def _chain(
    row: Mapping[str, Extended], by: Mapping[str, Mapping[str, Extended]], parameter: str
) -> list[Extended]:
    """The terms ∂F/∂v · dv/dp of a total derivative."""
    return [slope * by[name][parameter] for name, slope in row.items() if parameter in by.get(name, ())]


def _ties(
    linear: Linearization,
    sharp: Sharp,
    by: Mapping[str, Mapping[str, Extended]],
    parameters: Sequence[str],
) -> dict[str, int]:
    """Redundant rules that hold at the answer, but not beside it."""
    tied: dict[str, int] = {}
    for equation in linear.redundant:
        row = sharp.rows.get(equation, {})
        if sharp.lost.intersection(row):
            continue
        for parameter in parameters:
            terms = _chain(row, by, parameter)
            if abs(sum(terms)) > AGREE * sum(map(abs, terms)):
                tied.setdefault(parameter, equation)
    return tied
