"""How small and how large the numbers of a program can be, told from its form alone.

Floats lose digits below 2^-1022, and hold nothing at all below 2^-1074: what is multiplied or divided may
come out as 0 and be none. Where the form of a program does not rule that out it is asked of the numbers. Of
a sum it is known how little two terms can leave: the difference of floats within a factor of two is exact, so
that it is 0 or no less than a unit of their last places (P. H. Sterbenz, Floating-Point Computation, 1974).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Mapping

    from solver.compiled.flow import Flow

SMALLEST = 2.0**-1022
"""The smallest float with all of its digits."""
LEAST, LEAST_WHOLE, MOST = -1074.0, -1022.0, 1024.0
"""Powers of two: of the smallest float, of the smallest with all digits, and beyond the largest."""
DIGITS = 54.0
"""Powers of two by which a difference that is not 0 can be smaller than its terms."""
CIRCULAR = -64.0
"""The power of two that sines and cosines of angles that are floats stay above where these are not tiny."""
FEW = 6.0
"""Binary digits of a float that may be lost at its lower end: the last places that the witness admits."""
HIDDEN = 1e-12
"""Share of a number below which what was added to it is lost with its last places."""
VANISHING = frozenset({"exp", "erfc"})
"""Functions that are never 0 and come out as 0."""


@dataclass(frozen=True, slots=True)
class Size:
    """Powers of two between which a number lies where it is not 0; ``zero``: whether it can be."""

    low: float = LEAST
    high: float = MOST
    zero: bool = True


ANY = Size()


def whole(flow: Flow, node: int) -> int:
    """The node that is true where a product or a quotient has all of its digits but a few, or is 0 because a
    factor or the dividend is; and so with what it is made of. What is lost in b/a at b = 1e-300, a = 1e16
    is not found again in (b/a)·a, and an a³ that came out as 0 is none. Sums count as a whole: what a term
    has lost is nothing beside one that is large enough."""
    operation, *parts = flow.nodes[node]
    match operation:
        case "neg":
            return whole(flow, int(parts[0]))
        case "mul" | "div":
            return _whole_product(flow, node, *(int(part) for part in parts))
        case "add" | "sub" if sizes(flow)[node].low <= LEAST_WHOLE:
            terms = flow.add("and", *(whole(flow, int(part)) for part in parts))
            return flow.true if terms == flow.true else flow.add("or", _enough(flow, node), terms)
        case "pow":
            nothing = flow.add("eq", int(parts[0]), flow.constant(0.0))
            return flow.add("or", _enough(flow, node), flow.add("and", nothing, whole(flow, int(parts[0]))))
        case "call" if parts[0] in VANISHING:
            return _enough(flow, node)
        case _:
            return flow.true


def _whole_product(flow: Flow, node: int, one: int, other: int) -> int:
    quotient = flow.nodes[node][0] == "div"
    known = sizes(flow)
    a, b = known[one], known[other]
    if quotient:
        least, shrinks = a.low - b.high, b.high
    else:
        least, shrinks = a.low + b.low, -max(a.low, b.low)
    parts = flow.add("and", whole(flow, one), whole(flow, other))
    if least > LEAST_WHOLE or shrinks <= FEW:
        return parts
    nothing = flow.add("eq", one, flow.constant(0.0))
    if not quotient:
        nothing = flow.add("or", nothing, flow.add("eq", other, flow.constant(0.0)))
    return flow.add("and", flow.add("or", _enough(flow, node), nothing), parts)


def vanishing(flow: Flow, node: int) -> bool:
    """Whether a number is a product with a function that comes out as 0 and never is."""
    operation, *parts = flow.nodes[node]
    if operation == "call":
        return parts[0] in VANISHING
    return operation in ("neg", "mul", "div") and any(vanishing(flow, int(part)) for part in parts)


def _enough(flow: Flow, node: int) -> int:
    return flow.add("le", flow.constant(SMALLEST), flow.add("abs", node))


def stands_out(flow: Flow, number: int, beside: int) -> int:
    """The node that is true where a number is not lost in floats that it is added to, or is 0."""
    known = sizes(flow)
    if known[number].low > known[beside].high + math.log2(HIDDEN):
        return flow.true
    share = flow.add("mul", flow.constant(HIDDEN), flow.add("abs", beside))
    apart = flow.add("le", share, flow.add("abs", number))
    return flow.add("or", apart, flow.add("eq", number, flow.constant(0.0)))


def sizes(flow: Flow) -> Mapping[int, Size]:
    """The sizes of all nodes there are."""
    known = flow.sizes
    for node in range(len(known), len(flow.nodes)):
        known[node] = _size(flow, node, known)
    return known


def _size(flow: Flow, node: int, known: Mapping[int, Size]) -> Size:
    operation, *rest = flow.nodes[node]
    if operation == "const":
        return _of_number(float(rest[0]))
    if operation in ("sind", "cosd", "sin", "cos"):
        angle = known[int(rest[0])]
        least = angle.low - 7.0 if operation in ("sind", "sin") else 0.0  # a degree is more than 2^-6
        return Size(max(LEAST, min(least, CIRCULAR)), 0.0)
    if operation in ("call", "root", "item", "input"):
        return ANY
    parts = [known[int(part)] for part in rest]
    match operation:
        case "neg" | "abs":
            return parts[0]
        case "add" | "sub":
            return _of_sum(*parts)
        case "mul":
            (a, b), zero = parts, any(part.zero for part in parts)
            return _held(a.low + b.low, a.high + b.high, zero)
        case "div":
            a, b = parts
            return _held(a.low - b.high, a.high - b.low, a.zero)
        case "sqrt":
            return Size(parts[0].low / 2.0 - 1.0, parts[0].high / 2.0 + 1.0, parts[0].zero)
        case "where" | "seldom":
            _, a, b = parts
            return Size(min(a.low, b.low), max(a.high, b.high), a.zero or b.zero)
        case _:
            return ANY


def _of_number(number: float) -> Size:
    if number == 0.0:
        return Size(MOST, LEAST)
    if not math.isfinite(number):
        return ANY
    power = float(math.frexp(number)[1])
    return Size(power - 1.0, power, zero=False)


def _of_sum(a: Size, b: Size) -> Size:
    least = [one.low for one, other in ((a, b), (b, a)) if not one.zero]
    low = max(least) if least else min(a.low, b.low)
    return Size(max(LEAST, low - DIGITS), min(MOST, max(a.high, b.high) + 1.0))


def _held(low: float, high: float, zero: bool) -> Size:
    """What floats hold of a product: one that is smaller than they hold is 0."""
    return Size(max(LEAST, low - 1.0), min(MOST, high + 1.0), zero or low - 1.0 < LEAST)
