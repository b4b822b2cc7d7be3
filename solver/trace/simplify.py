"""What an operation of a graph comes down to, by what its operands are; None where it stays itself."""

from __future__ import annotations

import math
from collections.abc import Callable

from solver.trace.graph import Graph


def _negative(flow: Graph, a: int) -> int | None:
    kind, *parts = flow.nodes[a]
    if kind == "neg":
        return int(parts[0])
    number = flow.factor(a)
    return None if number is None else flow.add("mul", flow.constant(-number[0]), number[1])


def _add(flow: Graph, a: int, b: int) -> int | None:
    if flow.value_of(a) == 0.0:
        return b
    if flow.value_of(b) == 0.0:
        return a
    if flow.nodes[b][0] == "neg":
        return flow.add("sub", a, int(flow.nodes[b][1]))
    if flow.nodes[a][0] == "neg":
        return flow.add("sub", b, int(flow.nodes[a][1]))
    for one, other in ((a, b), (b, a)):
        number = flow.factor(other)
        if number is not None and number[0] < 0.0:
            return flow.add("sub", one, flow.add("mul", flow.constant(-number[0]), number[1]))
        value = flow.value_of(other)
        if isinstance(value, float) and value < 0.0:
            return flow.add("sub", one, flow.constant(-value))
        kind, *parts = flow.nodes[one]
        if kind == "sub" and parts[1] == other and not (flow.plain or flow.reported):
            return int(parts[0])
    return flow.node("add", b, a) if b < a else None


def _subtract(flow: Graph, a: int, b: int) -> int | None:
    if a == b:
        return flow.constant(0.0)
    if flow.value_of(b) == 0.0:
        return a
    if flow.value_of(a) == 0.0:
        return flow.add("neg", b)
    if flow.nodes[b][0] == "neg":
        return flow.add("add", a, int(flow.nodes[b][1]))
    number = flow.factor(b)
    if number is not None and number[0] < 0.0:
        return flow.add("add", a, flow.add("mul", flow.constant(-number[0]), number[1]))
    if (left := _cancelled(flow, a, b)) is not None:
        return left
    if flow.value_of(a) == 1.0 and (growth := _growth(flow, b)) is not None:
        return flow.add("neg", growth)
    if flow.value_of(b) == 1.0 and (growth := _growth(flow, a)) is not None:
        return growth
    return flow.node("neg", flow.node("sub", b, a)) if b < a else None


def _growth(flow: Graph, power: int) -> int | None:
    """``(1 + x)^n - 1`` without the cancellation that leaves nothing of it for a small x."""
    if flow.plain or flow.nodes[power][0] != "pow":
        return None
    base, exponent = (int(part) for part in flow.nodes[power][1:])
    x = flow.beside_one(base)
    if x is not None and flow.at is not None and not flow.at(x) > -1.0:
        return None  # a negative base, with whole exponents only
    return None if x is None else flow.add("expm1", flow.add("mul", exponent, flow.add("log1p", x)))


def not_negative(flow: Graph, node: int) -> bool:
    """Whether a node cannot be less than zero."""
    kind, *parts = flow.nodes[node]
    if kind == "const":
        return float(parts[0]) >= 0.0
    if kind in ("abs", "sqrt"):
        return True
    if kind == "max":
        return any(not_negative(flow, int(part)) for part in parts)
    if kind == "mul" and parts[0] == parts[1]:
        return True
    return kind in ("mul", "add") and all(not_negative(flow, int(part)) for part in parts)


def _cancelled(flow: Graph, a: int, b: int) -> int | None:
    """``(x + y) - y`` and its like: what was added and is taken away again is not rounded twice."""
    if flow.plain or flow.reported:
        return None
    kind, *parts = flow.nodes[a]
    if kind == "add" and b in parts:
        return int(parts[1] if parts[0] == b else parts[0])
    if kind == "sub" and parts[0] == b:
        return flow.add("neg", int(parts[1]))
    kind, *parts = flow.nodes[b]
    if kind == "add" and a in parts:
        return flow.add("neg", int(parts[1] if parts[0] == a else parts[0]))
    return int(parts[1]) if kind == "sub" and parts[0] == a else None


def _multiply(flow: Graph, a: int, b: int) -> int | None:
    for one, other in ((a, b), (b, a)):
        match flow.value_of(one):
            case 0.0:
                return flow.constant(0.0)
            case 1.0:
                return other
            case -1.0:
                return flow.add("neg", other)
    for one, other in ((a, b), (b, a)):
        number, value = flow.factor(other), flow.value_of(one)
        if number is not None and isinstance(value, float):
            whole = flow.add("mul", flow.constant(value), flow.constant(number[0]))
            return flow.add("mul", whole, number[1])
    if a == b:
        square = _square(flow, a)
        if square is not None:
            return square
    if flow.nodes[a][0] == "neg":
        return flow.add("neg", flow.add("mul", int(flow.nodes[a][1]), b))
    if flow.nodes[b][0] == "neg":
        return flow.add("neg", flow.add("mul", a, int(flow.nodes[b][1])))
    return flow.node("mul", b, a) if b < a else None


def _square(flow: Graph, a: int) -> int | None:
    """The square of a root, of a number of roots, of a number whose sign was chosen."""
    kind, *parts = flow.nodes[a]
    if kind == "neg":
        return flow.add("mul", int(parts[0]), int(parts[0]))
    if kind == "where":
        one, other = int(parts[1]), int(parts[2])
        if flow.nodes[one] == ("neg", other):
            return flow.add("mul", other, other)
        return flow.add("mul", one, one) if flow.nodes[other] == ("neg", one) else None
    if flow.plain or flow.reported:
        return None
    if kind == "sqrt":
        inside = int(parts[0])
        flow.require(flow.add("le", flow.constant(0.0), inside))
        return inside
    if kind == "mul":
        for one, other in ((int(parts[0]), int(parts[1])), (int(parts[1]), int(parts[0]))):
            size = _size(flow, one)
            if size is not None and flow.nodes[other][0] == "sqrt":
                square = flow.add("mul", flow.constant(size), flow.constant(size))
                return flow.add("mul", square, flow.add("mul", other, other))
    return None


def _size(flow: Graph, node: int) -> float | None:
    """The absolute value of a number, or of two that a selection is between."""
    kind, *parts = flow.nodes[node]
    values = [flow.value_of(int(part)) for part in parts[1:]] if kind == "where" else [flow.value_of(node)]
    sizes = {abs(v) if isinstance(v, float) else None for v in values}
    return sizes.pop() if len(sizes) == 1 else None


def _divide(flow: Graph, a: int, b: int) -> int | None:
    if flow.value_of(b) == 1.0:
        return a
    if flow.value_of(b) == -1.0:
        return flow.add("neg", a)
    if flow.nodes[a][0] == "neg":
        return flow.add("neg", flow.add("div", int(flow.nodes[a][1]), b))
    if flow.nodes[b][0] == "neg":
        return flow.add("neg", flow.add("div", a, int(flow.nodes[b][1])))
    number = flow.value_of(b)
    if isinstance(number, float) and math.frexp(number)[0] in (0.5, -0.5) and 1e-100 < abs(number) < 1e100:
        return flow.add("mul", flow.constant(1.0 / number), a)  # a power of two: nothing is rounded
    below = flow.nodes[b]
    if below[0] == "div" and flow.value_of(int(below[1])) == 1.0:
        return flow.add("mul", a, int(below[2]))
    if below[0] == "div" and not flow.plain:
        return flow.add("div", flow.add("mul", a, int(below[2])), int(below[1]))
    return None


def _joined(flow: Graph, a: int, b: int, decisive: bool) -> int | None:
    if (outcome := flow.constant(decisive)) in (a, b):
        return outcome
    neutral = flow.constant(not decisive)
    if a in (neutral, b):
        return b
    return a if b == neutral else None


def _where(flow: Graph, c: int, a: int, b: int) -> int | None:
    if c == flow.true or a == b:
        return a
    if flow.nodes[c][0] == "not":
        return flow.add("where", int(flow.nodes[c][1]), b, a)
    return b if c == flow.false else flow.selected(c, a, b)


def _absolute(flow: Graph, a: int) -> int | None:
    node = flow.nodes[a]
    if node[0] == "neg":
        return flow.add("abs", int(node[1]))
    number = flow.factor(a)
    if number is not None and number[0] < 0.0:
        return flow.add("abs", flow.add("mul", flow.constant(-number[0]), number[1]))
    return a if not_negative(flow, a) else None


def _larger(flow: Graph, a: int, b: int) -> int | None:
    if a == b:
        return a
    for one, other in ((a, b), (b, a)):
        number = flow.value_of(one)
        if number is not None and (number == -math.inf or (number <= 0.0 and not_negative(flow, other))):
            return other
    return flow.node("max", b, a) if b < a else None


SIMPLIFY: dict[str, Callable[..., int | None]] = {
    "neg": _negative,
    "add": _add,
    "sub": _subtract,
    "mul": _multiply,
    "div": _divide,
    "and": lambda flow, a, b: _joined(flow, a, b, False),
    "or": lambda flow, a, b: _joined(flow, a, b, True),
    "not": lambda flow, a: int(flow.nodes[a][1]) if flow.nodes[a][0] == "not" else None,
    "where": _where,
    "abs": _absolute,
    "max": _larger,
}
