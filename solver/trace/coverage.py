"""What the rounding of an expression is worth, told from its form alone: no number is looked at.

A rule is satisfied if a small change of its variables satisfies it, so that rounding is harmless where the
variables explain it: of ``a*b``, of ``x - y``. It is not where a number that is no variable is large beside
them: ``x + 90`` at a small x, ``cos(1) - sqrt(x)`` at a smaller one. (Mixed stability: Higham, Accuracy and
Stability of Numerical Algorithms, 2002, section 1.5.)
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import reduce

from rulesheets.model import Equation
from rulesheets.syntax import nodes
from rulesheets.syntax.nodes import Call, Expression, Name, Negative, Number, Power, Product, Quotient, Sum
from solver.path.isolate import Isolation

HARMLESS = 32.0
"""Units in the last place of its variables that a rule may be missed by for rounding, with no look at it."""
LIBRARY = 4.0
"""Units in the last place that a function of the library may be off by."""


@dataclass(frozen=True, slots=True)
class Cover:
    """How well the variables of an expression explain its rounding; S is the sum of the sizes of its slope by
    each variable times that variable.

    In units of the last place rounding is at most ``own`` times the size of the value and ``carried`` times
    S; that size is at most ``large`` times S.
    """

    own: float
    carried: float
    large: float

    @property
    def passed(self) -> float:
        """What of S the rounding is worth for who reads the value."""
        return self.carried + (self.own * self.large if self.own else 0.0)


def covered(equation: Equation, turns: bool) -> float:
    """How many units of the last place of its variables the evaluation of a rule may cost at most.

    ``turns``: right angles that are added to the angle of a function are no rounding, but another function.
    """
    known = _variables((equation.left, equation.right))
    left, right = (_cover(side, known, turns) for side in (equation.left, equation.right))
    own = left.own + right.own
    # Where the rule holds, its sides are of one size.
    return max(left.carried, right.carried) + (own * min(left.large, right.large) if own else 0.0)


def steep(equation: Equation) -> bool:
    """Whether a rule may go far within a small change of its variables: where these stand in a sum that a
    function or a divisor reads, which may be far smaller than they are."""
    return any(_steep(side) for side in (equation.left, equation.right))


def _steep(expression: Expression) -> bool:
    match expression:
        case Negative(operand):
            return _steep(operand)
        case Sum(terms):
            return any(map(_steep, terms))
        case Product(left, right):
            return _steep(left) or _steep(right)
        case Quotient(left, right):
            return _steep(left) or _steep(right) or _has_sum(right)
        case Power(base, Number(exponent)) if exponent > 0.0:
            return _steep(base)
        case Call("sqrt" | "abs", (operand,)):
            return _steep(operand)
        case Power() | Call():
            return bool(nodes.names(expression))
        case _:
            return False


def _has_sum(expression: Expression) -> bool:
    match expression:
        case Number() | Name():
            return False
        case Product(left, right) | Quotient(left, right):
            return _has_sum(left) or _has_sum(right)
        case _:
            return True


def inverted(isolation: Isolation, turns: bool) -> float:
    """How many units of the last place of its variables a rule may be missed by for the rounding of the
    unknown that it is solved for, by one inverse operation after another; ``turns`` as in ``covered``."""
    if isolation.quadratic is not None or any(len(stage.forms) != 1 for stage in isolation.stages):
        return math.inf
    forms = [stage.forms[0] for stage in isolation.stages]
    known = _variables((isolation.start, *forms))
    found = _cover(isolation.start, known, turns)
    for form in forms:
        found = _cover(form, {**known, "#": found}, turns)
    return max(found.own, found.carried)


def _variables(expressions: Iterable[Expression]) -> Mapping[str, Cover]:
    """Every variable; of one that occurs twice the slopes may cancel, so that it explains nothing."""
    every = [name for expression in expressions for name in nodes.names(expression)]
    return {name: Cover(0.0, 0.0, 1.0 if every.count(name) == 1 else math.inf) for name in every}


def _cover(expression: Expression, known: Mapping[str, Cover], turns: bool) -> Cover:
    match expression:
        case Number(value):
            return Cover(0.0, 0.0, math.inf if value else 0.0)
        case Name(name):
            return known[name]
        case Negative(operand):
            return _cover(operand, known, turns)
        case Sum(terms):
            return reduce(_added, (_cover(term, known, turns) for term in terms))
        case Product(one, other) | Quotient(one, other):
            return _multiplied(_cover(one, known, turns), _cover(other, known, turns))
        case Power(base, Number(exponent)) if exponent:
            inside, size = _cover(base, known, turns), abs(exponent)
            return Cover(inside.own * size + LIBRARY, inside.carried, inside.large / size)
        case Call("sind" | "cosd" | "tand", (Sum((angle, Number(shift))),)) if turns and shift % 90.0 == 0.0:
            return Cover(LIBRARY, _cover(angle, known, turns).passed, math.inf)
        case Call(function, arguments):
            found = [_cover(argument, known, turns) for argument in arguments]
            carried = max((inside.passed for inside in found), default=0.0)
            large = {"sqrt": 2.0, "abs": 1.0}.get(function)
            return Cover(LIBRARY, carried, math.inf if large is None else large * found[0].large)
        case _:
            return Cover(0.0, math.inf, math.inf)


def _added(one: Cover, other: Cover) -> Cover:
    return Cover(1.0, max(one.passed, other.passed), max(one.large, other.large))


def _multiplied(one: Cover, other: Cover) -> Cover:
    large = min(one.large, other.large)
    if 0.0 < one.large < math.inf and 0.0 < other.large < math.inf:
        large = 1.0 / (1.0 / one.large + 1.0 / other.large)
    return Cover(one.own + other.own + 1.0, max(one.carried, other.carried), large)
