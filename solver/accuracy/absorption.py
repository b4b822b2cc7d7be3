"""Tells a true equality from a residual below the working precision.

``erf(x) = 1`` is satisfied by no number, ``exp(-x^2) + 1 = 1`` by none; at 1e100 they miss by less than any
digits show. If both sides agree in all of these, what tells is whether an operation lost an operand: a term
beside a larger one, a slope beside the value that it leads away from.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from rulesheets.evaluate import Undefined, extended, extended_derivatives
from rulesheets.functions.extended import context
from rulesheets.syntax.nodes import Call, Expression, Name, Power, Sum, children

SPARE = 8
"""Digits of the working precision that rounding may take."""


def absorbs(expression: Expression, values: Mapping[str, Any], digits: int) -> bool:
    """Whether some operation of an expression loses all of one operand at the values, in that many digits."""
    stack: list[Any] = [expression]
    while stack:
        node = stack.pop()
        try:
            match node:
                case Sum(terms) if _absorbs([extended(term, values, digits) for term in terms], digits):
                    return True
                case Call(_, (operand,)) if _saturates(node, extended(operand, values, digits), digits):
                    return True
                case Call("atan2" | "atan2d", sides) if _absorbs(
                    [extended(side, values, digits) for side in sides], digits
                ):
                    return True
                case Power(base, exponent) if _next_to_one(
                    extended(base, values, digits), extended(exponent, values, digits), digits
                ):
                    return True
        except Undefined:
            continue
        finally:
            stack.extend(children(node))
    return False


def _absorbs(terms: list[Any], digits: int) -> bool:
    """Whether a term is not 0, and nothing beside the largest."""
    sizes = [abs(term) for term in terms if term]
    return len(sizes) > 1 and min(sizes) < max(sizes) * _nothing(digits)


def _next_to_one(base: Any, exponent: Any, digits: int) -> bool:
    """Whether a power is not 1, and nothing beside 1 tells it from that."""
    return bool(base > 0 and 0 < abs(exponent * context(digits).log(base)) < _nothing(digits))


def _saturates(call: Call, at: Any, digits: int) -> bool:
    """Whether a function goes on changing there, but by nothing beside its value."""
    argument = Name("0")
    result, slopes = extended_derivatives(Call(call.function, (argument,)), {argument.name: at}, digits)
    move = abs(slopes[argument.name] * at)
    flat = call.function == "tanh" and abs(result) == 1  # its slope is computed as 1 - tanh^2
    return bool(flat or 0 < move < abs(result) * _nothing(digits))


def _nothing(digits: int) -> Any:
    return context(digits).mpf(10) ** (SPARE - digits)
