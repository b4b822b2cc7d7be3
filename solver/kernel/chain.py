"""A torn block as chains of assignments: from the tear to every other unknown and to the residual.

Every combination of preimages of the explicit steps gives one chain. A chain is evaluated on floats
(compiled) and on intervals, with its slope by forward accumulation.
"""

from __future__ import annotations

import itertools
import math
from collections import defaultdict
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from math import inf
from typing import Any, NamedTuple, TypeAlias

from rulesheets.evaluate import differentiate
from rulesheets.evaluate.digits import extended
from rulesheets.evaluate.gradient import CHOOSING, signed_root
from rulesheets.functions import TABLE
from rulesheets.functions.intervals import LINE
from rulesheets.model import Equation, Variable
from rulesheets.syntax import nodes
from rulesheets.syntax.nodes import (
    ONE,
    ZERO,
    Call,
    Expression,
    Name,
    Negative,
    Number,
    Power,
    Product,
    Quotient,
    Sum,
    add,
    call,
    calls,
    exchange,
    is_number,
    rebuilt,
    substitute,
    walk,
)
from solver.kernel.emitter import Emitter, enclose, factors, times, without
from solver.numerics.tolerances import SAME_VALUE
from solver.path import TARGET, Isolation, SolveBlock, Stage
from solver.path.graph import ModelGraph
from solver.path.polynomial import Monomial, NoForm, Polynomial, in_parts

MAX_CHAINS = 256
RESIDUAL = "#residual"
HALF = Number(0.5)


class Assignment(NamedTuple):
    """``name := expression``, with a value between ``low`` and ``high``.

    ``relational``: the expression is a quotient that stands for a product, so that 0/0 may be
    anything. ``reciprocal``: it is one by which some dividend is multiplied, and 1/0 may be
    anything. ``side``: beside a jump by 1, the value is the lower (-1) or the upper (1) one.
    """

    name: str
    expression: Expression
    low: float = -inf
    high: float = inf
    low_open: bool = False
    high_open: bool = False
    relational: bool = False
    reciprocal: bool = False
    side: int = 0


Ways: TypeAlias = tuple[tuple[Assignment, ...], ...]
"""The sequences of assignments, one for each preimage or branch."""


def assigned(variable: Variable, expression: Expression) -> Assignment:
    """The assignment of a variable, in its declared range."""
    ends = variable.low, variable.high, variable.low_open, variable.high_open
    return Assignment(variable.name, expression, *ends)


class Chain(NamedTuple):
    """Assignments that lead from the tears to the unknowns and to the residuals, in order."""

    tears: tuple[str, ...]
    assignments: tuple[Assignment, ...]
    residuals: tuple[str, ...]


def chains(graph: ModelGraph, block: SolveBlock) -> tuple[Chain, ...]:
    """One chain for every combination of preimages; at most ``MAX_CHAINS``."""
    rules = {f"{RESIDUAL}{number}": graph.model.equations[number] for number in block.residuals}
    parts = [_residual(name, rule) for name, rule in rules.items()]
    residuals = (*(step for *some, _ in parts for step in some), *(part[-1] for part in parts))
    found = []
    for combination in itertools.islice(
        itertools.product(*_alternatives(graph, block)), MAX_CHAINS
    ):
        every = _with_products([*itertools.chain.from_iterable(combination), *residuals])
        steps, own = every[: -len(residuals)], every[-len(residuals) :]
        like = _LikeTerms(block.tears, steps)
        own = [item._replace(expression=like.collected(item.expression)) for item in own]
        found.append(Chain(block.tears, (*steps, *own), tuple(rules)))
    return tuple(found)


def _residual(name: str, rule: Equation) -> list[Assignment]:
    """Left minus right; of the direction of a point, which jumps, the coordinate of that point
    across the direction, where the other one is positive and the angle no more than half a turn."""
    for angle, direction in (rule.sides, (rule.right, rule.left)):
        if isinstance(direction, Call) and (row := TABLE[direction.function]).direction:
            (y, x), (sine, cosine) = direction.arguments, row.sine_and_cosine
            s, c, half = call(sine, angle), call(cosine, angle), (row.angle or inf) / 2
            return [
                Assignment(f"{name} angle", angle, -half, half),
                Assignment(f"{name} along", x * c + y * s, low=0.0, low_open=True),
                Assignment(name, y * c - x * s),
            ]
    return [Assignment(name, rule.left - rule.right)]


def _with_products(items: Sequence[Assignment]) -> list[Assignment]:
    """The assignments with ``a`` for ``x*b`` after the step ``x := a/b``, which stands for the rule
    ``x*b = a``: that has a value where b is 0, too, and its bounds are narrower."""
    found, products = list[Assignment](), dict[Expression, tuple[Expression, list[Expression]]]()

    def rewritten(node: Expression) -> Expression:
        if not isinstance(node, Product):
            return rebuilt(node, tuple(map(rewritten, node.parts))) if node.parts else node
        own = factors(node)
        some = [rewritten(factor) for factor in own]
        for above, inside in [products[part] for part in own if part in products]:
            if not without(inside, some):
                some = [above, *without(some, inside)]
        return node if some == own else times(*some)

    for item in items:
        found.append(item._replace(expression=rewritten(item.expression)) if products else item)
        match found[-1]:
            case Assignment(name, Quotient(above, below), relational=True):
                products[Name(name)] = above, [Name(name), *factors(below)]
    return found


class _LikeTerms:
    """Sums without the terms that cancel in them once the steps of a chain are put in: ``w - (x +
    y)`` is ``f - y`` after the step ``w := f + x``. Far from 0 only these are narrow. (Where
    terms cancel beside a minimum, the eliminants of its cases count the roots.)"""

    def __init__(self, tears: Sequence[str], steps: Sequence[Assignment]) -> None:
        self._steps = {item.name: item.expression for item in steps}
        self._moving = {*tears, *self._steps}
        self._parts = dict[Expression, str]()

    def collected(self, node: Expression) -> Expression:
        """The sum; the node itself if nothing cancels."""
        try:
            terms = self._terms(node)
            whole = Polynomial.of(terms)
            return self._expression(whole) if self._cancels(terms) else node
        except (NoForm, ZeroDivisionError):
            return node

    def _terms(self, node: Expression) -> list[tuple[Monomial, Fraction]]:
        """The terms of a sum, those of the steps in it among them. Raises NoForm and
        ZeroDivisionError."""
        found = list[tuple[Monomial, Fraction]]()
        for monomial, factor in in_parts(node, _number, self._parts).items():
            step = next((n for n, power in monomial if power == 1 and n in self._steps), None)
            if step is None:
                found.append((monomial, factor))
                continue
            rest = Polynomial({tuple(item for item in monomial if item[0] != step): factor})
            for one, number in self._terms(self._steps[step]):
                found += (rest * Polynomial({one: number})).items()
            if len(found) > LONGEST:
                raise NoForm
        return found

    def _cancels(self, terms: Sequence[tuple[Monomial, Fraction]]) -> bool:
        """Whether unknowns cancel, and nothing that may be undefined."""
        lost = {monomial for monomial, _ in terms} - Polynomial.of(terms).keys()
        parts = [item for monomial in lost for item in monomial]
        defined = all(power > 0 and name not in self._parts.values() for name, power in parts)
        return defined and any(name in self._moving for name, _ in parts)

    def _expression(self, terms: Polynomial) -> Expression:
        meaning = {name: part for part, name in self._parts.items()}
        sums = list[Expression]()
        for monomial, factor in terms.items():
            powers = [(meaning.get(name, Name(name)), power) for name, power in monomial]
            above = times(*(base ** float(power) for base, power in powers if power > 0))
            below = times(*(base ** float(-power) for base, power in powers if power < 0))
            sums.append(_multiple(factor, above / below))
        return add(*sums)


def _number(part: Expression) -> Fraction | None:
    match part:
        case Negative(Number(value)):
            return -Fraction(value)
    return Fraction(part.value) if isinstance(part, Number) else None


def _multiple(factor: Fraction, expression: Expression) -> Expression:
    """A multiple, exactly. Raises NoForm if it needs a number that is no float."""
    above, below = map(float, factor.as_integer_ratio())
    if Fraction(above) / Fraction(below) != factor:
        raise NoForm
    scaled = abs(above) * expression / below
    return -scaled if above < 0.0 else scaled


def _alternatives(graph: ModelGraph, block: SolveBlock) -> Iterator[Ways]:
    """The preimages of each step of the order."""
    for number, step in enumerate(block.order):
        isolation = graph.isolation(step.equation, graph.number[step.unknown])
        assert isolation is not None
        yield alternatives(graph, isolation, f"#{number}")


def alternatives(graph: ModelGraph, isolation: Isolation, prefix: str) -> Ways:
    """The preimages of a step."""
    variable = graph.model.variables[isolation.unknown]
    turn = graph.turn(isolation.unknown) if isolation.period else None
    if turn is not None and not variable.ranged:
        variable = replace(variable, low=-turn * (0.5 + SAME_VALUE), high=turn * (0.5 + SAME_VALUE))
    return tuple(through(isolation, prefix, variable))


def exhaustive(graph: ModelGraph, block: SolveBlock) -> bool:
    """Whether the chains cover every preimage: none was left out, and whole turns make no
    difference."""
    isolations = (
        graph.isolation(step.equation, graph.number[step.unknown]) for step in block.order
    )
    return all(one is not None and is_exhaustive(graph, one) for one in isolations) and (
        math.prod(map(len, _alternatives(graph, block))) <= MAX_CHAINS
    )


def is_exhaustive(graph: ModelGraph, isolation: Isolation) -> bool:
    """Whether the forms of an isolation cover every preimage."""
    if isolation.proven and isolation.period:
        # every whole turn is covered where the unknown, or its negative, is the angle
        operations = [stage.operation for stage in isolation.stages]
        periodic = [place for place, stage in enumerate(isolation.stages) if stage.period]
        if len(periodic) > 1 or any(each != "negative" for each in operations[periodic[0] + 1 :]):
            return False
        variable = graph.model.variables[isolation.unknown]
        reach = max(abs(variable.low), abs(variable.high))
        free = not variable.ranged and graph.turn(variable.name) is not None
        return free or reach <= isolation.period
    return isolation.proven


def through(
    isolation: Isolation, prefix: str, variable: Variable
) -> Iterator[tuple[Assignment, ...]]:
    """The sequences of forms from the start of an isolation to its unknown."""

    if isolation.quadratic is not None or not isolation.stages:
        for form in isolation.forms():
            yield (assigned(variable, form)._replace(relational=isolation.quadratic is not None),)
        return
    ranged = variable.ranged
    for forms in itertools.product(*(_turned(stage, ranged) for stage in isolation.stages)):
        if ranged and isolation.period and _out_of_range(isolation.stages, forms, variable):
            continue
        steps: list[Assignment] = []
        expression = isolation.start
        for place, (stage, form) in enumerate(zip(isolation.stages, forms, strict=True)):
            bounded = stage.low > -inf or stage.high < inf
            target = expression
            if bounded or nodes.names(form).count(TARGET.name) > 1:
                name = f"{prefix}.{place}"
                steps.append(
                    Assignment(
                        name, expression, stage.low, stage.high, stage.low_open, stage.high_open
                    )
                )
                target = Name(name)
            expression = substitute(form, {TARGET.name: target})
            if isinstance(expression, Quotient) and stage.divides and not _number(expression.left):
                name = f"{prefix}.{place}q"
                steps.append(Assignment(name, expression, relational=True))
                expression = Name(name)
        if steps and steps[-1].relational and expression == Name(steps[-1].name):
            yield (*steps[:-1], assigned(variable, steps[-1].expression)._replace(relational=True))
        else:
            yield (*steps, assigned(variable, expression))


def _turned(stage: Stage, bounded: bool) -> tuple[Expression, ...]:
    """The forms of a stage; with a turn more and a turn less if the unknown has a range of its
    own."""
    if stage.period is None or not bounded:
        return stage.forms
    turns = (0.0, stage.period, -stage.period)
    return tuple(form + turn for turn in turns for form in stage.forms)


def _out_of_range(
    stages: tuple[Stage, ...], forms: tuple[Expression, ...], variable: Variable
) -> bool:
    """Whether a preimage of a periodic operation lies outside the range for any target."""
    at = next(i for i, stage in enumerate(stages) if stage.period)
    expression: Expression = TARGET
    for form in forms[at:]:
        expression = substitute(form, {TARGET.name: expression})
    if any(name != TARGET.name for name in nodes.names(expression)):
        return False
    low, high = enclose(expression, {TARGET.name: (stages[at].low, stages[at].high)})
    return high < variable.low or low > variable.high


def compile_chain(
    chain: Chain, known: tuple[str, ...], results: tuple[str, ...], arrays: bool = False
) -> Callable[..., Any]:
    """``f(*tears, *known)`` returns the values called ``results``; outside the domain it raises, or
    keeps ``arrays`` at its boundary."""
    emitter = Emitter((*chain.tears, *known), arrays)
    for item in chain.assignments:
        emitter.assign(item.name, emitter.of(item.expression))
        emitter.bound(item.name, item.low, item.high, item.low_open, item.high_open)
    return emitter.function(emitter.names[name] for name in results)


def followed(chain: Chain, values: Mapping[str, Any], digits: int) -> dict[str, Any]:
    """The values, and those of all assignments, in many digits. Raises Undefined and
    OverflowError."""
    found = dict(values)
    for item in chain.assignments:
        found[item.name] = extended(item.expression, found, digits)
    return found


def jumps(expression: Expression) -> bool:
    """Whether an expression has an operation that jumps at points that depend on its values."""
    return any(steps(expression))


def steps(expression: Expression) -> Iterator[Call]:
    """The operations in an expression that jump at points that depend on its values."""
    stack: list[Any] = [expression]
    while stack:
        node = stack.pop()
        if isinstance(node, Call) and TABLE[node.function].jumps:
            yield node
        inside = signed_root(node)
        stack.extend(node.parts if inside is None else (inside,))


def stepwise(expression: Expression) -> Expression:
    """The expression with remainders by their definition, so that what jumps is constant between
    jumps."""
    for part in steps(expression):
        row, inside = TABLE[part.function], part.arguments
        if row.definition is not None and set(row.partials(inside)) != {ZERO}:
            return stepwise(exchange(expression, part, row.definition(*inside)))
    return expression


def chosen(expression: Expression) -> Iterator[Expression]:
    """What functions choose among, whose slope may be that of another argument at a pole of one."""
    for part in calls(expression):
        if part.function in CHOOSING:
            yield from part.arguments


def directions(expression: Expression) -> Iterator[Call]:
    """The directions of points (x, y) in an expression: they jump where y changes sign and x is
    negative."""
    return (part for part in calls(expression) if TABLE[part.function].direction)


def limited(expression: Expression) -> Iterator[tuple[Expression, float, float, Expression]]:
    """Parts that an expression needs to be between two ends: arguments of functions; bases of
    powers, unless the exponent, which is the last, is whole."""
    for part in walk(expression):
        match part:
            case Call(function, (argument,)) if TABLE[function].domain != LINE:
                yield argument, *TABLE[function].domain, HALF
            case Power(base, exponent):
                yield base, 0.0, inf, exponent


# --- slopes by the tear ---


def slope_chain(chain: Chain) -> Chain:
    """The chain whose residual is the derivative of that of ``chain`` by its tear: the slopes of
    all assignments follow these (forward accumulation)."""
    moving: dict[str, Expression] = {chain.tears[0]: Number(1.0)}
    slopes: list[Assignment] = []
    for item in chain.assignments:
        used = [name for name in dict.fromkeys(nodes.names(item.expression)) if name in moving]
        if used:
            terms = [differentiate(item.expression, name) * moving[name] for name in used]
            slopes.append(Assignment(f"d {item.name}", add(*terms)))
            moving[item.name] = Name(slopes[-1].name)
    if chain.residuals[0] not in moving:  # it is constant
        slopes.append(Assignment(f"d {chain.residuals[0]}", ZERO))
    return Chain(chain.tears, (*chain.assignments, *slopes), (slopes[-1].name,))


# --- the residual with its denominators multiplied away ---

LONGEST = 300
"""Parts of an expression beyond which it is not brought to a common denominator."""


def cleared(chain: Chain) -> Chain | None:
    """The chain with the numerator of its residual in place of that, and quotients of quotients
    simplified; None if it divides by nothing that varies, or is too long.

    The numerator is 0 wherever the residual is, but at a pole it mostly is not. The divisor of a
    relational quotient gets a name of its own, so that nothing cancels with it: where it is 0,
    there may be an answer. Factors of it that have a name already keep that, so that quotients of
    quotients are not multiplied by them twice. The sums of a numerator get names as well: what is
    made of it stays short.
    """
    moving, parts = {chain.tears[0]}, dict[str, Ratio]()
    items, named = list[Assignment](), set[Expression]()
    for item in chain.assignments:
        if moving.isdisjoint(nodes.names(item.expression)):
            items.append(item)
            continue
        moving.add(item.name)
        above, below = _fraction(item.expression, moving, parts, item.relational)
        if not is_number(below, 1.0):
            above, sums = _with_named_sums(above, item.name)
            moving.update(part.name for part in sums)
            items += sums
        if len(walk(above, below)) > LONGEST:
            return None
        if item.relational and not moving.isdisjoint(nodes.names(below)):
            if is_number(above, 0.0):
                dividend = Assignment(f"{item.name} dividend", above)
                items.append(dividend)
                above = Name(dividend.name)
            known = [factor for factor in factors(below) if factor in named]
            divisor = Assignment(f"{item.name} divisor", times(*without(factors(below), known)))
            moving.add(divisor.name)
            named.add(Name(divisor.name))
            items.append(divisor)
            below = times(*known, Name(divisor.name))
        parts[item.name] = above, below
        items.append(Assignment(item.name, above / below))
    divided = any(
        isinstance(part, Quotient) and not moving.isdisjoint(nodes.names(part.right))
        for part in walk(item.expression)
    )
    if item.name not in moving or (not divided and is_number(below, 1.0)):
        return None
    return Chain(chain.tears, (*items[:-1], Assignment(item.name, above)), chain.residuals)


def _with_named_sums(product: Expression, name: str) -> tuple[Expression, list[Assignment]]:
    """A product whose sums have names, and these: what is made of it stays short."""
    sums, parts = list[Assignment](), list[Expression]()
    for factor in factors(product):
        if isinstance(factor, Sum):
            sums.append(Assignment(f"{name} sum {len(sums)}", factor))
            factor = Name(sums[-1].name)
        parts.append(factor)
    return times(*parts), sums


Ratio: TypeAlias = tuple[Expression, Expression]
"""Numerator and denominator."""


def _fraction(
    node: Expression, moving: set[str], known: Mapping[str, Ratio], relational: bool = False
) -> Ratio:
    """An expression as a numerator over its varying denominators.

    In a ``relational`` quotient nothing is cancelled: where a common factor is 0 its value may be
    anything.
    """
    if moving.isdisjoint(nodes.names(node)):
        return node, ONE
    match node:
        case Name(name) if name in known and not is_number(known[name][1], 1.0):
            return known[name]
        case Negative(operand):
            above, below = _fraction(operand, moving, known)
            return -above, below
        case Sum(terms):
            found = [_fraction(term, moving, known) for term in terms]
            common = list[Expression]()
            for _, below in found:
                common += without(factors(below), common)
            total = [above * times(*without(common, factors(below))) for above, below in found]
            return add(*total), times(*common)
        case Product(left, right):
            (above, below), (over, under) = (
                _fraction(part, moving, known) for part in (left, right)
            )
            return _reduced((above, over), (below, under), known)
        case Quotient(left, right):
            (above, below), (under, over) = (
                _fraction(part, moving, known) for part in (left, right)
            )
            if moving.isdisjoint(nodes.names(under)):
                return times(above, over, ONE / under), below
            if relational:
                return times(above, over), times(below, under)
            return _reduced((above, over), (below, under), known)
        case Power(base, Number(exponent)) if exponent == exponent // 1 and exponent:
            above, below = _fraction(base, moving, known)
            if exponent < 0:
                above, below = below, above
            above, below = (
                part if is_number(part, 1.0) else part ** abs(exponent) for part in (above, below)
            )
            return above, below
        case Power(base, Number(exponent)) if exponent:
            return _rooted(base, exponent, moving, known)
        case Call("sqrt", (base,)):
            return _rooted(base, 0.5, moving, known)
        case Call("tand" | "tan" as function, arguments):
            sine, cosine = ("sind", "cosd") if function == "tand" else ("sin", "cos")
            return Call(sine, arguments), Call(cosine, arguments)
        case Call():
            parts = (_fraction(part, moving, known) for part in node.parts)
            return rebuilt(node, tuple(above / below for above, below in parts)), ONE
        case _:
            return node, ONE


def _reduced(
    above: Sequence[Expression], below: Sequence[Expression], known: Mapping[str, Ratio]
) -> Ratio:
    """Two products without their common factors, those of the products that names stand for among
    them."""
    over, under = ([factor for part in side for factor in factors(part)] for side in (above, below))
    for side, other in ((over, under), (under, over)):
        for name in [part.name for part in side if isinstance(part, Name) and part.name in known]:
            inside = factors(known[name][0])
            if any(part in other for part in inside):
                side.remove(Name(name))
                side += inside
    over, under = _combined(without(over, under), without(under, over))
    return times(*over), times(*under)


def _combined(
    over: Sequence[Expression], under: Sequence[Expression]
) -> tuple[list[Expression], list[Expression]]:
    """The factors of a quotient with powers of one size as one."""
    found, powers = (list[Expression](), list[Expression]()), defaultdict[Expression, float](float)
    for below, side in enumerate((over, under)):
        for factor in side:
            match factor:
                case Power(Call("abs", (base,)), Number(exponent)):
                    powers[base] += -exponent if below else exponent
                case _:
                    found[below].append(factor)
    for base, exponent in powers.items():
        if exponent:
            found[exponent < 0.0].append(call("abs", base) ** abs(exponent))
    return found


def _rooted(
    base: Expression, exponent: float, moving: set[str], known: Mapping[str, Ratio]
) -> Ratio:
    """A power that is no whole one, by the sizes of the factors of its base."""
    above, below = (
        times(*(call("abs", factor) ** abs(exponent) for factor in _within(part, known)))
        for part in _fraction(base, moving, known)
    )
    return (above, below) if exponent > 0.0 else (below, above)


def _within(product: Expression, known: Mapping[str, Ratio]) -> Iterator[Expression]:
    """Its factors, those of products that names stand for among them."""
    for factor in without(factors(product), [ONE]):
        inside = known[factor.name][0] if isinstance(factor, Name) and factor.name in known else ONE
        if len(factors(inside)) > 1:
            yield from _within(inside, known)
        else:
            yield factor


# --- the residual far from 0, over the reciprocal of the tear ---

Scaled: TypeAlias = tuple[Expression, float]
"""A quantity q as q/|x|^d, and d."""


def reciprocal(chain: Chain, sign: float, order: float = 1.0) -> tuple[Chain, float]:
    """The chain over v = |x|^(-1/order) in place of its tear x of this sign, each quantity divided
    by a power of |x|; and the order, 2 where roots of x would leave half powers of v, else 1.

    The residual has the same zeros. Where quantities grow as powers of x, their bounds stay narrow
    over all of v from 0 on, as (a + b*x)/(c + d*x) = (a*v + b)/(c*v + d) shows.
    """
    v = Name(chain.tears[0])
    known: dict[str, Scaled] = {v.name: (Number(sign), order)}
    items = []
    for item in chain.assignments:
        expression, degree = _scaled(item.expression, v, known)
        known[item.name] = Name(item.name), degree
        if degree:
            signs = (0.0 if item.low >= 0.0 else -inf), (0.0 if item.high <= 0.0 else inf)
            item = item._replace(low=signs[0], high=signs[1])
        items.append(item._replace(expression=expression))
    if order == 1.0 and any(_is_half_power(part, v) for i in items for part in walk(i.expression)):
        return reciprocal(chain, sign, 2.0)
    return Chain(chain.tears, tuple(items), chain.residuals), order


def _is_half_power(part: Any, base: Expression) -> bool:
    match part:
        case Power(inside, Number(exponent)):
            return inside == base and exponent % 1.0 == 0.5
    return False


def _scaled(node: Expression, v: Expression, known: Mapping[str, Scaled]) -> Scaled:
    def over(scaled: Scaled, degree: float) -> Expression:
        """The quantity divided by another power of |x|."""
        part, own = scaled
        if own > degree:
            return part / v ** (own - degree)
        return part * v ** (degree - own) if own < degree else part

    parts = [_scaled(part, v, known) for part in node.parts]
    match node, parts:
        case Name(name), _ if name in known:
            return known[name]
        case Negative(), [(part, degree)]:
            return -part, degree
        case Sum(), _:
            most = max(degree for _, degree in parts)
            return add(*(over(part, most) for part in parts)), most
        case Product(), [(one, degree), (other, more)]:
            return one * other, degree + more
        case Quotient(), [(above, degree), (below, less)]:
            return above / below, degree - less
        case Power(_, Number(exponent)), [(base, degree), _]:
            return base**exponent, degree * exponent
        case Call("min" | "max" | "hypot" as function), _:
            most = max(degree for _, degree in parts)
            return call(function, *(over(part, most) for part in parts)), most
        case Call("sqrt" | "abs" as function), [(part, degree)]:
            return call(function, part), degree * (0.5 if function == "sqrt" else 1.0)
        case _:
            return rebuilt(node, tuple(over(part, 0.0) for part in parts)) if parts else node, 0.0


MOST_SIDES = 2
"""Jumps of a chain, of which every combination of sides is a chain of its own."""


def sides(chain: Chain) -> tuple[Chain, ...]:
    """One chain for every combination of the sides of its jumps; none without any, or for too many.

    The residual at every point is that of one of the chains, if it has a value there.
    """
    plain = [item._replace(expression=stepwise(item.expression)) for item in chain.assignments]
    jumping = list(dict.fromkeys(part for item in plain for part in steps(item.expression)))
    if not 0 < len(jumping) <= MOST_SIDES:
        return ()
    found = []
    for upper in itertools.product((1, -1), repeat=len(jumping)):
        assignments: list[Assignment] = []
        for item in plain:
            expression = item.expression
            for number, (jump, side) in enumerate(zip(jumping, upper, strict=True)):
                if jump in walk(expression):
                    assignments.append(Assignment(f"#side {number}", jump, side=side))
                    expression = exchange(expression, jump, Name(f"#side {number}"))
            assignments.append(item._replace(expression=expression))
        found.append(Chain(chain.tears, tuple(assignments), chain.residuals))
    return tuple(found)
