"""Next to a jump: is a rule satisfied there, or is what satisfies it just beyond the edge?

Between its jumps a rule with ``int(x)`` in it is continuous, and may come as near to equality as one likes
towards an edge that belongs to the other side: ``int(x) + x = 3`` below 2. No value within the last places
of such a one satisfies it, although its slopes promise one.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

from rulesheets.construct import divide, subtract
from rulesheets.evaluate import Undefined, derivatives
from rulesheets.nodes import Call, Expression, children, names

if TYPE_CHECKING:
    from rulesheets.model import Equation, Value

DIGITS = 50
MARGIN = 1e-3
"""Share of its distance from an edge by which a value must stay away from it as a rule is satisfied."""


def attained(equation: Equation, values: Mapping[str, Value], share: float) -> bool:
    """Whether changes of the values by that share of them, which are enough for a rule by its slopes, are
    enough without a jump."""
    close = [
        edge for function, height in heights(equation) if (edge := _near(function, height, values, share))
    ]
    if not close:
        return True
    from rulesheets.evaluate import extended  # dear to import, and rarely needed

    try:
        slopes = derivatives(subtract(equation.left, equation.right), values)[1]
        miss = extended(equation.left, values, DIGITS) - extended(equation.right, values, DIGITS)
        moves = {n: abs(s * v) for n, s in slopes.items() if isinstance(v := values[n], float)}
        if not miss or abs(miss) > share * sum(moves.values()):
            return True  # exactly there, or not seen as floats see it
        tied = {name for height, _ in close for name in names(height)}
        if abs(miss) <= share * sum(move for name, move in moves.items() if name not in tied):
            return True
        part = miss / sum(moves.values())
        there = {
            n: v - part * abs(v) * math.copysign(1.0, slopes[n])
            if isinstance(v, float) and slopes.get(n)
            else v
            for n, v in values.items()
            if n in equation.names
        }
        return all(_stays(height, edge, values, there) for height, edge in close)
    except Undefined:
        return True


def heights(equation: Equation) -> Iterator[tuple[str, Expression]]:
    """The functions that jump, each with the expression that says how far from its edges."""
    stack: list[Any] = [equation.left, equation.right]
    while stack:
        node = stack.pop()
        match node:
            case Call("int" | "frac" | "round" | "sgn" as function, (x,)):
                yield function, x
            case Call("mod", (x, y)):
                yield "int", divide(x, y)
            case Call("step", (x, a)):
                yield "step", subtract(x, a)
        stack.extend(children(node))


def _near(
    function: str, height: Expression, values: Mapping[str, Value], share: float
) -> tuple[Expression, float] | None:
    """The edge that is within twice that change of the values, if it belongs to its other side."""
    try:
        at, slopes = derivatives(height, values)
    except Undefined:
        return None
    reach = 2.0 * share * sum(abs(s * v) for n, s in slopes.items() if isinstance(v := values[n], float))
    edge = _edge(function, at)
    return None if edge is None or not abs(at - edge) <= reach else (height, edge)


def _edge(function: str, at: float) -> float | None:
    """The next edge that a value is on the open side of; none where there is no such edge."""
    size = abs(at)
    whole = math.floor(size) if math.isfinite(size) else size
    edge = None
    match function:
        case "int" | "frac":
            edge = None if size == whole else whole + 1.0
        case "round":
            edge = whole + (0.5 if size - whole < 0.5 else 1.5)
        case "sgn":
            edge = 0.0 if at else None
        case "step":
            edge = 0.0 if at < 0.0 else None
    return None if edge is None else math.copysign(edge, at)


def _stays(height: Expression, edge: float, values: Mapping[str, Value], there: Mapping[str, Any]) -> bool:
    from rulesheets.evaluate import extended

    before, after = (extended(height, at, DIGITS) - edge for at in (values, there))
    return bool(after / before >= MARGIN) if before else True
