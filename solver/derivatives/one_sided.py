"""Derivatives on one side of a point where the rules themselves have none: at corners and equality guards.

``vAB = sqrt(x^2 + y^2)`` has no slope at rest, though what is computed from it may have one. Beside the point
every rule has its slopes, and the derivatives at points that approach it are exact. So a polynomial
through them, taken at the point (E. H. Neville, "Iterative interpolation", 1934), is their limit to many
digits, where they have one.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from rulesheets.model import Model, Value
from solver.derivatives.sharpening import Extended, number
from solver.derivatives.total_derivatives import totals

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
            if output in total.loose or output not in total.by or given in total.tied:
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
    """The value at 0 of the polynomial through the samples; None where it depends on the farthest one."""
    whole, rest = _at_zero(nodes, samples), _at_zero(nodes[1:], samples[1:])
    size = max(map(abs, samples))
    if abs(whole - rest) > SETTLED * size:
        return None
    return whole if abs(whole) > NOUGHT * size else whole * 0


def _at_zero(nodes: Sequence[Extended], samples: Sequence[Extended]) -> Extended:
    """Neville's scheme."""
    row = list(samples)
    for step in range(1, len(row)):
        for i in range(len(row) - step):
            far, near = nodes[i], nodes[i + step]
            row[i] = (far * row[i + 1] - near * row[i]) / (far - near)
    return row[0]
