"""Numbers of a record with what rounding has taken from them, to first order.

A sum, a product, a quotient and a square root tell their rounding errors exactly (T. J. Dekker,
Numerische Mathematik 18, 1971, 224-242); what follows from these is linear (P. Langlois, BIT 41,
2001, 515-539).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from functools import partial, reduce
from typing import NamedTuple

from rulesheets.evaluate import Undefined, differentiate
from rulesheets.model import Equation
from rulesheets.syntax import nodes
from solver.accuracy.rule_sides import moves_of, sides
from solver.numerics.tolerances import BACKWARD
from solver.trace.flow import LIBRARY, Flow, Numbers
from solver.trace.graph import NotCompilable

SPLITTER = 2.0**27 + 1.0
"""Multiplied by this and taken away again, a float is rounded to 26 binary digits."""


NOISY = 0.5
"""The share of what a rule admits from which its own rounding is compensated."""


def noise(rule: Equation, points: Sequence[Mapping[str, float]]) -> float:
    """The rounding of a rule in a record, as a share of what its check admits: the largest at some
    points, the first of them the sample."""
    doubtful = list[tuple[Mapping[str, float], float]]()
    inner = nodes.walk(*rule.left.parts, *rule.right.parts)
    if len(rule.names) == len(nodes.names(*rule.sides)) and not any(
        isinstance(one, nodes.Sum) for one in inner
    ):
        return 0.0  # what is rounded is no larger than what is varied
    for values in points:
        with suppress(Undefined):
            found = sides(rule, values)
            size = BACKWARD * sum(moves_of(found.slopes, values))
            doubtful += [(values, size)] if found.noise > NOISY * size / LIBRARY > 0.0 else []
    if not doubtful:
        return 0.0
    flow, shares = Flow(), [0.0]
    flow.at = Numbers(flow, dict(enumerate(points[0].values())))
    places = {name: flow.input(place) for place, name in enumerate(points[0])}
    with suppress(NotCompilable):  # the record may be more exact than the rule as written
        both = [flow.expression(side, places) for side in rule.sides]
        for values, size in doubtful:
            there = Numbers(flow, dict(enumerate(values.values())))
            shares.append(sum(map(there.error, both)) / size)
    return max(shares)


class Pair(NamedTuple):
    """A node, and one of what its number lacks; None for nothing."""

    number: int
    rest: int | None = None


def residual(flow: Flow, form: nodes.Expression, values: Mapping[str, int]) -> int:
    """What a rule misses at numbers that are exact, its own rounding made up for."""
    number, rest = compensated(flow, form, values)
    return number if rest is None else flow.raw("add", number, rest)


def compensated(flow: Flow, expression: nodes.Expression, values: Mapping[str, int]) -> Pair:
    """An expression of numbers that are exact."""
    found = _compensated(flow, expression, values)
    if any(flow.value_of(values[name]) is None for name in nodes.names(expression)):
        return found
    at = Numbers(flow, {})
    rest = 0.0 if found.rest is None else float(at(found.rest))
    return Pair(flow.constant(float(at(found.number))), flow.constant(rest) if rest else None)


def _compensated(flow: Flow, expression: nodes.Expression, values: Mapping[str, int]) -> Pair:
    pair = partial(compensated, flow, values=values)
    match expression:
        case nodes.Number(value):
            return Pair(flow.constant(value))
        case nodes.Name(name):
            return Pair(values[name])
        case nodes.Negative(operand):
            number, rest = pair(operand)
            return Pair(flow.raw("neg", number), None if rest is None else flow.raw("neg", rest))
        case nodes.Sum(terms):
            return reduce(partial(_sum, flow), map(pair, terms))
        case nodes.Product(left, right):
            return _product(flow, pair(left), pair(right))
        case nodes.Power(base, nodes.Number(2.0)):
            return _product(flow, pair(base), pair(base))
        case nodes.Quotient(left, right):
            return _quotient(flow, pair(left), pair(right))
        case nodes.Power(base, nodes.Number() as exponent):
            return _linear(flow, nodes.Power(nodes.Name("0"), exponent), pair(base))
        case nodes.Power(base, exponent):
            return _linear(
                flow, nodes.Power(nodes.Name("0"), nodes.Name("1")), pair(base), pair(exponent)
            )
        case nodes.Call("sqrt", (argument,)):
            return _root(flow, pair(argument))
        case nodes.Call("cos" | "cosd" | "cosh" | "exp" as function, (argument,)):
            return _beside_one(flow, function, pair(argument))
        case nodes.Call(function, arguments):
            own = tuple(nodes.Name(str(place)) for place in range(len(arguments)))
            return _linear(flow, nodes.Call(function, own), *map(pair, arguments))
    raise NotCompilable


def _sum(flow: Flow, a: Pair, b: Pair) -> Pair:
    raw, total = flow.raw, flow.raw("add", a.number, b.number)
    second = raw("sub", total, a.number)
    first = raw("sub", total, second)
    lost = raw("add", raw("sub", a.number, first), raw("sub", b.number, second))
    return Pair(total, _added(flow, lost, a.rest, b.rest))


def _product(flow: Flow, a: Pair, b: Pair) -> Pair:
    total = flow.raw("mul", a.number, b.number)
    lost = _lost(flow, a.number, b.number, total)
    rests = (
        None if one.rest is None else flow.raw("mul", one.rest, other.number)
        for one, other in ((a, b), (b, a))
    )
    return Pair(total, _added(flow, lost, *rests))


def _quotient(flow: Flow, a: Pair, b: Pair) -> Pair:
    raw, total = flow.raw, flow.raw("div", a.number, b.number)
    back = raw("mul", total, b.number)
    left = raw("sub", raw("sub", a.number, back), _lost(flow, total, b.number, back))
    less = None if b.rest is None else raw("neg", raw("mul", total, b.rest))
    return Pair(total, raw("div", _added(flow, left, a.rest, less), b.number))


def _root(flow: Flow, a: Pair) -> Pair:
    raw, root = flow.raw, flow.raw("sqrt", a.number)
    back = raw("mul", root, root)
    left = raw("sub", raw("sub", a.number, back), _lost(flow, root, root, back))
    return Pair(root, raw("div", _added(flow, left, a.rest), raw("mul", 2.0, root)))


def _beside_one(flow: Flow, function: str, a: Pair) -> Pair:
    """Near 1 what a function lacks follows from sines of half its argument: ``cos(x)`` is
    ``1 - 2*sin(x/2)^2``, ``exp(x)`` is ``1 + 2*exp(x/2)*sinh(x/2)``."""
    raw, (number, rest) = flow.raw, _linear(flow, nodes.Call(function, (nodes.Name("0"),)), a)
    half = raw("mul", 0.5, a.number)
    sine = flow.call("sinh" if function == "exp" else function.replace("cos", "sin"), half)
    other = flow.call("exp", half) if function == "exp" else sine
    above = raw("mul", 2.0 if function in ("cosh", "exp") else -2.0, raw("mul", other, sine))
    return Pair(number, _added(flow, raw("add", raw("sub", 1.0, number), above), rest))


def _lost(flow: Flow, a: int, b: int, product: int) -> int:
    """What a product lacks."""
    raw = flow.raw
    (a_high, a_low), (b_high, b_low) = (_halves(flow, node) for node in (a, b))
    lost = raw("sub", raw("mul", a_high, b_high), product)
    for one, other in ((a_high, b_low), (a_low, b_high), (a_low, b_low)):
        lost = raw("add", lost, raw("mul", one, other))
    return lost


def _halves(flow: Flow, node: int) -> tuple[int, int]:
    raw, large = flow.raw, flow.raw("mul", node, SPLITTER)
    high = raw("sub", large, raw("sub", large, node))
    return high, raw("sub", node, high)


def _added(flow: Flow, lost: int, *rests: int | None) -> int:
    return reduce(partial(flow.raw, "add"), [rest for rest in rests if rest is not None], lost)


def _linear(flow: Flow, function: nodes.Expression, *arguments: Pair) -> Pair:
    """A function of names 0, 1, …, whose own rounding is left out."""
    values = {str(place): pair.number for place, pair in enumerate(arguments)}
    moves = [
        flow.raw("mul", flow.expression(differentiate(function, str(place)), values), pair.rest)
        for place, pair in enumerate(arguments)
        if pair.rest is not None
    ]
    rest = _added(flow, *moves) if moves else None
    return Pair(flow.expression(function, values), rest)
