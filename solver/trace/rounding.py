"""How much of a result rounding can have changed: running error analysis, beside the program.

Every operation adds a unit in the last place to what the errors of its operands make of it, to first
order (Higham, Accuracy and Stability of Numerical Algorithms, 2002, section 3.3). The bound is that of the
way in which a result is computed; the problem itself may be better conditioned. What products, quotients and
roots of exact numbers are off by is known beforehand, as a share of the result: that costs nothing.

What the rounding of a rule is worth is told from its form alone. A rule is satisfied if a small change of its
variables satisfies it, so that rounding is harmless where the variables explain it: of ``a*b``, of ``x - y``.
It is not where a number that is no variable is large beside them: ``x + 90`` at a small x, ``cos(1) -
sqrt(x)`` at a smaller one (mixed stability: section 1.5).
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import reduce
from typing import NamedTuple

from rulesheets.evaluate import NotDifferentiable, differentiate
from rulesheets.model import Equation
from rulesheets.syntax import nodes
from rulesheets.syntax.nodes import Call, Expression, Name, Negative, Number, Power, Product, Quotient, Sum
from solver.numerics.tolerances import EPS
from solver.path.isolate import Isolation
from solver.trace.flow import Flow
from solver.trace.graph import LEAVES, LOGICAL, NotCompilable, operands, schedule
from solver.trace.simplify import not_negative

CANCELLED = 1e-12
"""Share of its terms that a difference, or of its angle that a sine, may be no more of than rounding."""
RADIAN = 0.017453292519943295
LIBRARY = 4.0
"""Units in the last place that a function of the library may be off by."""
LARGE_ANGLE = 1e9
_ARGUMENTS = ("#0", "#1")
_WAVES = frozenset({"sin", "cos", "sind", "cosd"})
_CIRCULAR = frozenset({"sin", "cos", "sind", "cosd", "tan", "tand"})


class Bound(NamedTuple):
    """A node is off by at most ``share`` units in its last place and the value of the node ``rest``."""

    share: float = 0.0
    rest: int | None = None

    @property
    def exact(self) -> bool:
        return self.share == 0.0 and self.rest is None


def quiet(flow: Flow, node: int, known: Iterable[int], share: float) -> int:
    """The node that is true where the rounding on the way from ``known`` nodes moves a result by no more
    than that share of itself. Raises NotCompilable as ``accurate`` does."""
    return Analysis(flow, known).within(node, share)


def apart_from_edges(flow: Flow, results: Sequence[int]) -> Iterator[int]:
    """Nodes that are true where what the results are computed from is farther from the end of a domain, or
    from a pole, than last places reach: on which side it lies is left to be told step by step."""
    for node in schedule(flow, results).order:
        operation, *rest = flow.nodes[node]
        match operation, rest[0]:
            case "div", _:
                yield from _apart_from_zero(flow, operands(flow, node)[1], positive=False)
            case "sqrt", _:
                yield from _apart_from_zero(flow, int(rest[0]))
            case "pow", _:
                power = flow.value_of(int(rest[1]))
                if power is None or power < 0.0 or power % 1.0:
                    yield from _apart_from_zero(flow, int(rest[0]))
            case "call", "tan" | "tand":
                yield _away_from_its_pole(flow, node, int(rest[1]))
            case "call", str(function) if flow.nodes[int(rest[1])][0] not in LEAVES:
                yield from _inside_the_domain(flow, function, int(rest[1]))


def _away_from_its_pole(flow: Flow, tangent: int, angle: int) -> int:
    across = flow.add("mul", flow.constant(CANCELLED), flow.add("mul", angle, tangent))
    return flow.add("lt", flow.add("abs", across), flow.constant(1.0))


def away_from_zero(flow: Flow, circular: int) -> int:
    """The node that is true where the sine of an angle (its cosine) is more than the angle's last places."""
    angle = int(flow.nodes[circular][1])
    least = flow.add("mul", flow.constant(CANCELLED), flow.add("abs", angle))
    return flow.add("lt", least, flow.add("abs", circular))


def known_angles(flow: Flow, divisor: int) -> Iterator[int]:
    """Nodes that are true where the sines and cosines that a divisor is made of are no matter of the last
    places of their angles: as factors these are more than what such a change makes of them, and elsewhere the
    angles are not large. Else what the divisor divides is not determined."""
    kind, *parts = flow.nodes[divisor]
    if kind in ("neg", "mul", "div"):
        for part in dict.fromkeys(parts):
            yield from known_angles(flow, int(part))
    elif kind in ("sin", "cos"):
        yield away_from_zero(flow, divisor)
    elif kind not in LEAVES:
        for node in schedule(flow, [divisor]).order:
            kind, *parts = flow.nodes[node]
            if kind in _CIRCULAR or (kind == "call" and parts[0] in _CIRCULAR):
                angle = flow.add("abs", int(parts[-1]))
                yield flow.add("lt", angle, flow.constant(LARGE_ANGLE))


def _inside_the_domain(flow: Flow, function: str, argument: int) -> Iterator[int]:
    match function:
        case "ln" | "log" | "log10":
            yield from _apart_from_zero(flow, argument)
        case "acos" | "asin" | "acosd" | "asind" | "atanh":
            yield flow.add("lt", flow.add("abs", argument), flow.constant(1.0 - CANCELLED))
        case "acosh":
            yield flow.add("lt", flow.constant(1.0 + CANCELLED), argument)


def _apart_from_zero(flow: Flow, node: int, positive: bool = True) -> Iterator[int]:
    """Whether sums, and sines of angles, that a node is a product of are more than the last places of what
    they are made of. ``positive``: what is less than 0 is refused anyway."""
    kind, *parts = flow.nodes[node]
    match kind:
        case "neg":
            yield from _apart_from_zero(flow, int(parts[0]), False)
        case "mul":
            for part in dict.fromkeys(parts):
                yield from _apart_from_zero(flow, int(part), False)
        case "div":
            yield from _apart_from_zero(flow, int(parts[0]), False)
        case "add" | "sub":
            one, other = operands(flow, node)
            if kind == "add" and not_negative(flow, one) and not_negative(flow, other):
                return
            size = node if positive else flow.add("abs", node)
            number = flow.value_of(one)
            if kind == "sub" and number is not None and number > 0.0 and not_negative(flow, other):
                yield flow.add("lt", flow.constant(2.0 * CANCELLED * number), size)
                return
            terms = flow.add("add", flow.add("abs", one), flow.add("abs", other))
            yield flow.add("lt", flow.add("mul", flow.constant(CANCELLED), terms), size)
        case "sin" | "cos":
            yield away_from_zero(flow, node)
        case "sind" | "cosd" if flow.nodes[int(parts[0])][0] not in LEAVES:
            yield away_from_zero(flow, node)


class Analysis:
    """The nodes of the error bounds; what is ``known`` has no errors.

    Its methods raise NotCompilable where an operation has no known effect on errors.
    """

    def __init__(self, flow: Flow, known: Iterable[int] = ()) -> None:
        self.flow = flow
        self.bounds: dict[int, Bound] = {}
        for node in known:
            self.bounds[node] = Bound()
            for part in flow.circle(node):  # sine and cosine of an angle that is known
                self.bounds.setdefault(part, Bound(LIBRARY))

    def bound(self, node: int) -> Bound:
        """The error bound of a node."""
        for one in (*schedule(self.flow, [node]).order, node):
            if one not in self.bounds:
                self.bounds[one] = self._bound(one)
        return self.bounds[node]

    def error(self, node: int) -> int:
        """The node of the error bound of a node, in absolute terms."""
        return self._total(node, self.bound(node))

    def within(self, node: int, share: float) -> int:
        """The node that is true where a node is off by no more than that share of itself."""
        flow, bound = self.flow, self.bound(node)
        left = share - bound.share * EPS
        if left < 0.0:
            return flow.false
        if bound.rest is None:
            return flow.true
        return flow.add("le", bound.rest, flow.add("mul", flow.constant(left), flow.add("abs", node)))

    def _total(self, node: int, bound: Bound) -> int:
        flow = self.flow
        rest = flow.constant(0.0) if bound.rest is None else bound.rest
        if not bound.share:
            return rest
        own = flow.add("mul", flow.constant(EPS * bound.share), flow.add("abs", node))
        return flow.add("add", own, rest)

    def _bound(self, node: int) -> Bound:
        flow = self.flow
        operation, *rest = flow.nodes[node]
        if operation == "const":
            return Bound(0.0, flow.constant(off)) if (off := flow.off(node)) else Bound()
        if operation in LEAVES or operation in LOGICAL:
            return Bound()
        parts = operands(flow, node)
        bounds = [self.bounds.get(part) or self._bound(part) for part in parts]
        name = str(rest[0]) if operation == "call" else str(operation)
        return self._carried(node, name, parts, bounds)

    def _carried(self, node: int, name: str, parts: tuple[int, ...], bounds: list[Bound]) -> Bound:
        """What the errors of the operands make of the result, and its own rounding."""
        flow = self.flow
        shares, rests = [b.share for b in bounds], [b.rest for b in bounds]
        match name:
            case "add" | "sub":
                if name == "add" and all(not_negative(flow, part) for part in parts):
                    return Bound(max(shares) + 1.0, self._sum(*rests))
                totals = [None if b.exact else self._total(p, b) for p, b in zip(parts, bounds, strict=True)]
                return Bound(1.0, self._sum(*totals))
            case "neg" | "abs":
                return bounds[0]
            case "rint":
                return Bound()
            case "mul":
                one, other = (self._times(rests[k], parts[1 - k]) for k in (0, 1))
                return Bound(sum(shares) + 1.0, self._sum(one, other))
            case "div":
                above = self._sum(rests[0], self._times(rests[1], node))
                return Bound(sum(shares) + 1.0, self._over(above, flow.add("abs", parts[1])))
            case "sqrt":
                twice = flow.add("mul", flow.constant(2.0), node)
                return Bound(shares[0] / 2.0 + 1.0, self._over(rests[0], twice))
            case "where":
                zero = flow.constant(0.0)
                one, other = (zero if r is None else r for r in rests[1:])
                rest = None if one == other == zero else flow.add("where", parts[0], one, other)
                return Bound(max(shares[1:]), rest)
            case "direction" | "directiond" | "atan2" | "atan2d":
                scale = 1.0 if name in ("direction", "atan2") else 1.0 / RADIAN
                return Bound(LIBRARY, self._turned(parts, bounds, scale))
            case _ if all(bound.exact for bound in bounds):
                return Bound(LIBRARY)
            case _:
                slopes = [self._slope(node, name, parts, k) for k in range(len(parts))]
                moved = (
                    None if b.exact else self._times(self._total(part, b), slope)
                    for part, b, slope in zip(parts, bounds, slopes, strict=True)
                )
                return Bound(LIBRARY, self._sum(*moved))

    def _slope(self, node: int, name: str, parts: tuple[int, ...], place: int) -> int:
        """The derivative of a function by one of its arguments."""
        flow = self.flow
        match name:
            case "sind" | "cosd":
                return flow.constant(RADIAN)
            case "sin" | "cos":
                return flow.constant(1.0)
            case "expm1":
                return flow.add("add", flow.constant(1.0), node)
            case "log1p":
                return flow.add("div", flow.constant(1.0), flow.add("add", flow.constant(1.0), parts[0]))
            case "pow" if place == 0:
                return flow.add("div", flow.add("mul", parts[1], node), parts[0])
            case "pow":
                return flow.add("mul", node, flow.call("ln", parts[0]))
            case "root" | "item":
                raise NotCompilable
        if len(parts) > len(_ARGUMENTS):
            raise NotCompilable
        names = _ARGUMENTS[: len(parts)]
        try:
            slope = differentiate(Call(name, tuple(map(Name, names))), names[place])
        except NotDifferentiable:
            raise NotCompilable from None
        return flow.expression(slope, dict(zip(names, parts, strict=True)))

    def _turned(self, parts: tuple[int, ...], bounds: list[Bound], scale: float) -> int | None:
        add = self.flow.add
        totals = [None if b.exact else self._total(p, b) for p, b in zip(parts, bounds, strict=True)]
        y, x = parts
        across = self._sum(self._times(totals[0], x), self._times(totals[1], y))
        square = add("add", add("mul", x, x), add("mul", y, y))
        return self._over(self._times(across, self.flow.constant(scale)), square)

    # Errors that are 0 are None.

    def _sum(self, *errors: int | None) -> int | None:
        some = [error for error in errors if error is not None]
        if not some:
            return None
        total = some[0]
        for error in some[1:]:
            total = self.flow.add("add", total, error)
        return total

    def _times(self, error: int | None, factor: int) -> int | None:
        return None if error is None else self.flow.add("mul", error, self.flow.add("abs", factor))

    def _over(self, error: int | None, divisor: int) -> int | None:
        return None if error is None else self.flow.add("div", error, divisor)


HARMLESS = 32.0
"""Units in the last place of its variables that a rule may be missed by for rounding, with no look at it."""


class Cover(NamedTuple):
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
    function or a divisor reads, which may be far smaller than they are. Sines and cosines do not: they are
    straight within so small a change of an angle that is not large."""
    return any(_steep(side) for side in (equation.left, equation.right))


def turned_by(equation: Equation) -> Iterator[Expression]:
    """The angles whose sines and cosines a rule reads."""
    waiting = [equation.left, equation.right]
    while waiting:
        expression = waiting.pop()
        waiting.extend(nodes.operands(expression))
        match expression:
            case Call(function, (angle,)) if function in _WAVES:
                yield angle


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
        case Call(function, (operand,)) if function in _WAVES:
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
