"""What the signs of the variables of a model say: nothing of angles, of what swings, and of kinds
of quantities that have negative values anyhow.

Variables are angles by their unit or by the functions that they stand in. Quantities are of one
kind if the rules scale them alike.
"""

from __future__ import annotations

import itertools
from collections import defaultdict
from collections.abc import Collection, Iterator, Mapping, Sequence, Set
from functools import cached_property
from math import pi
from typing import Any, NamedTuple

import numpy as np

from rulesheets.library import ANGLE
from rulesheets.model import Equation, Model, once
from rulesheets.syntax.nodes import (
    Call,
    Expression,
    Name,
    Negative,
    Number,
    Power,
    Product,
    Quotient,
    Sum,
    is_number,
    terms,
    walk,
)
from rulesheets.syntax.nodes import names as names_in
from solver.path.graph import STEPS, angle_evidence, by_shape, phases

MANY = 200
"""Variables of a model beyond which kinds, and what follows from these, are not looked for."""
LINKS = 3
"""The least number of steps of a series."""
WAVES = frozenset({"sin", "cos", "sind", "cosd"})
DIGITS = 6
"""Decimals of the exponents by which a kind of quantity is known."""
ABSOLUTE = frozenset({"bar", "mbar", "atm", "psia", "torr", "Torr", "mmHg", "inHg"})
"""Units of pressure in which no stress is given."""


class Factor(NamedTuple):
    """A sum by which rules multiply, as terms: the coefficient of each, the names that it is a
    product of, and those that divide it. A ``plain`` one only adds and subtracts names."""

    plain: bool
    terms: Sequence[tuple[float, Sequence[str], Sequence[str]]]


class Signs:
    """The role of signs of the variables of a model. The suggested sizes are kept here, too: see
    ``Sizes`` of ``ranking.py``."""

    def __init__(self, model: Model) -> None:
        self.model, self.large = model, len(model.variables) > MANY
        self.suggestions: dict[Any, Any] = {}

    @cached_property
    def aside(self) -> Set[str]:
        """The names whose signs do not count."""
        found = set(self.angles)  # and what rules tell from one of them alone
        rules = [e for e in self.model.equations if len(e.names) == 2] if found else []
        before = -1
        while len(found) > before:
            before = len(found)
            for rule in rules:
                told = set(rule.names) - found
                if len(told) == 1 and any(_has_odd_power(side, *told) for side in rule.sides):
                    found |= told
        ranged = (n for n, v in self.model.variables.items() if v.low < 0.0 and v.ranged)
        sides = [sides for e in self._periodic for sides in (e.sides, (e.right, e.left))]
        swinging = (  # what a rule gives as a swing of a phase, or by components, has either sign
            one.name
            for one, other in sides
            if isinstance(one, Name)
            and (_swings(other, self.phases) or all(map(_is_component, terms(other))))
        )
        codes = (name for name, number in self.codes if number < 0.0)
        return found.union(ranged, swinging, self._opposed(), codes)

    @cached_property
    def codes(self) -> Set[tuple[str, float]]:
        """Names with the numbers that guarded rules give them, as a class, or 0 without a fee."""
        pairs = (pair for e in self.model.equations if e.guard for pair in e.definitions)
        return {(name, side.value) for name, side in pairs if isinstance(side, Number)}

    @cached_property
    def angles(self) -> Mapping[str, float]:
        """The full turns of variables in degrees or radians, arguments of sines, results of their
        inverses, and what is added to any of these."""
        model = self.model
        found = {
            n: 2.0 * pi ** (1 - v.measure.pi) / float(v.measure.factor)
            for n, v in model.variables.items()
            if v.measure is not None and v.measure.bases == {ANGLE: 1}
        }
        found = {name: turn for name, turn, _ in angle_evidence(model) if turn} | found
        sums = [_terms(*equation.sides) for equation in model.equations] if found else []
        before = -1
        while len(found) > before:
            before = len(found)
            for names in sums:
                if turn := next((found[name] for name in sorted(names) if name in found), None):
                    found |= {name: turn for name in names if name not in found}
        return found

    @cached_property
    def turning(self) -> Set[str]:
        """Angles in rules that call periodic functions."""
        return {name for e in self._periodic for name in e.names} & self.angles.keys()

    @cached_property
    def inclinations(self) -> Set[str]:
        """Angles whose tangent a rule gives, as ``tand(slope) = rise/run`` or ``run*tand(slope) =
        rise``: beyond a right angle lies what the same tangent turns about."""
        sides = [side for e in self._periodic for side in e.sides]
        return {
            angle.name
            for side in sides
            for call in (side, *side.parts)
            if isinstance(call, Call) and call.function in ("tan", "tand")
            for angle in call.arguments
            if isinstance(angle, Name)
        } & self.angles.keys()

    @cached_property
    def phases(self) -> Set[str]:
        """Names by which arguments of periodic functions grow, and which are no angles, as a time
        or a frequency: the first of the periods is meant."""
        inside, under = set[str](), set[str]()
        for argument in (argument for e in self._periodic for argument in phases(*e.sides)):
            inside.update(names_in(argument))
            under.update(
                n for q in walk(argument) if isinstance(q, Quotient) for n in names_in(q.right)
            )
        return inside - under - self.angles.keys()

    @cached_property
    def _periodic(self) -> Sequence[Equation]:
        """The rules that call periodic functions; of too large a model none."""
        if self.large:
            return ()
        shapes = ((rules, rules[0]) for rules in by_shape(self.model))
        return [rule for rules, first in shapes if phases(*first.sides) for rule in rules]

    @cached_property
    def kinds(self) -> Mapping[str, int]:
        """Quantities that the rules scale alike have one number; dimensionless ones have none."""
        if self.large:
            return {}
        from solver.ranking.sizes import Scalings  # kinds are mostly kept from an earlier run

        names = list(self.model.variables)
        equations = self.model.equations  # one that only gives a number is no rule
        rules = [e for e in equations if names_in(e.right) or not isinstance(e.left, Name)]
        exponents = np.round(Scalings(rules, names).exponents, DIGITS) + 0.0
        number: dict[bytes, int] = {}
        return {
            name: number.setdefault(row.tobytes(), len(number))
            for name, row in zip(names, exponents, strict=True)
            if row.any()
        }

    def _opposed(self) -> Iterator[str]:
        """Names one of which a rule makes negative: M of ``M = -F*a``, and those that are terms of
        a sum that is 0, as R of ``F1*sind(a) + R = 0``."""
        from solver.ranking.sizes import added

        for rules in by_shape(self.model):
            sides = rules[0].sides
            for side, other in (sides, sides[::-1]):
                told = [side] if isinstance(other, Negative) else []
                if isinstance(other, Sum) and is_number(side, 0.0):
                    both = added(other)
                    told = [term for term, _ in both] if len({m for _, m in both}) == 1 else []
                for name in (term.name for term in told if isinstance(term, Name)):
                    place = rules[0].names.index(name)
                    yield from (rule.names[place] for rule in rules)

    @cached_property
    def differences(self) -> frozenset[str]:
        """Names that a rule gives as a difference: their sign says nothing about their kind."""
        found = set[str]()
        for rules in by_shape(self.model):
            sides = rules[0].sides
            for side, other in (sides, sides[::-1]):
                if isinstance(side, Name) and isinstance(other, Sum):
                    negative = sum(isinstance(term, Negative) for term in other.terms)
                    if 0 < negative < len(other.terms):
                        place = rules[0].names.index(side.name)
                        found.update(rule.names[place] for rule in rules)
        return frozenset(found)

    @cached_property
    def series(self) -> Sequence[Sequence[tuple[str | float, str | float]]]:
        """Neighbours, names or numbers, of quantities that rules of one form pass on, each to the
        next of them: those of ``H3 = H2 + m3``, or of ``u0 - 2*u1 + u2 = f*u1``."""
        forms = defaultdict[Sequence[object], list[Sequence[_Leaf]]](list)
        for equation in () if self.large else self.model.equations:
            if not self.angles.keys() & set(equation.names):  # a linkage goes anywhere
                form, leaves = _form(*equation.sides)
                forms[form].append(leaves)
        found = []
        many = (rules for rules in forms.values() if len(rules) >= LINKS)
        for places in (list(map(_column, zip(*rules, strict=True))) for rules in many):
            for one, other in itertools.combinations(places, 2):
                pairs = list(zip(one, other, strict=True))
                if _passed_on(pairs) and all(map(self._are_alike, pairs)):
                    found.append(pairs)
        return found

    def _are_alike(self, pair: tuple[str | float, str | float]) -> bool:
        """Whether two names are different quantities of one kind, unless one is a number."""
        numbers = isinstance(pair[0], float) or isinstance(pair[1], float)
        return numbers or (
            pair[0] != pair[1] and len({self.kinds.get(str(name)) for name in pair}) == 1
        )

    @cached_property
    def factors(self) -> Collection[Factor]:
        """Sums that rules multiply by, divide by or raise to a power, as ``1 - x``: such a
        factor is seldom negative, and seldom a small rest of large terms.

        A plain difference that occurs only squared may be one of coordinates.
        """
        from solver.path.polynomial import NoForm, in_parts

        found = dict[object, Factor]()
        for equation in () if self.large else self.model.equations:
            nodes = walk(*equation.sides)
            for node in (one for one in nodes if isinstance(one, Power | Product | Quotient)):
                square = isinstance(node, Power) and is_number(node.exponent, 2.0)
                for part in factors_of(node):
                    parts = dict[Expression, str]()
                    try:
                        total = in_parts(part, lambda _: None, parts)
                    except (NoForm, ArithmeticError):
                        continue
                    powers = [[e for _, e in monomial] for monomial in total]
                    plain = powers == [[1]] * len(total) and {*map(abs, total.values())} == {1}
                    if not total or parts or (square and plain):
                        continue  # it is no sum of products of names, or a difference
                    terms = [
                        (
                            float(coefficient),
                            [name for name, power in monomial for _ in range(power)],
                            [name for name, power in monomial for _ in range(-power)],
                        )
                        for monomial, coefficient in total.items()
                    ]
                    found[frozenset(total.items())] = Factor(plain, terms)
        return tuple(found.values())

    @cached_property
    def radii(self) -> Mapping[str, bool]:
        """Names that are never a term by themselves: whether they are squared, or multiply a sine
        or a cosine."""
        found, terms = dict[str, bool](), set[str]()
        for equation in () if self.large else self.model.equations:
            terms |= _terms(*equation.sides)
            found = dict.fromkeys(equation.names, False) | found
            for node in walk(*equation.sides):
                match node:
                    case Product(Name(name), Call(wave)) | Product(Call(wave), Name(name)) if (
                        wave in WAVES
                    ):
                        found[name] = True
                    case Power(Name(name), Number(2.0)):
                        found[name] = True
        return {name: multiplies for name, multiplies in found.items() if name not in terms}

    @cached_property
    def floors(self) -> Mapping[str, float]:
        """The least readings of absolute temperatures, masses and absolute pressures.

        Pa and its multiples are also units of stress, which has either sign.
        """
        found = dict[str, float]()
        for name, variable in self.model.variables.items():
            unit = None if variable.difference else variable.measure
            if unit and (
                unit.offset or unit.bases in ({"K": 1}, {"kg": 1}) or variable.unit in ABSOLUTE
            ):
                found[name] = float(-unit.offset / unit.factor)
        return found


signs_of = once(Signs)


def _swings(node: Any, known: Set[str]) -> bool:
    """Whether an expression, or each of its terms, has a function of ``known`` phases as a
    factor."""
    match node:
        case Call(function) if function not in STEPS:
            return any(not known.isdisjoint(names_in(argument)) for argument in phases(node))
        case Product():
            return any(_swings(part, known) for part in node.parts)
        case Negative() | Sum():
            return all(_swings(part, known) for part in node.parts)
        case Quotient(left, _):
            return _swings(left, known)
    return False


def _is_component(node: Expression) -> bool:
    """Whether an expression is a product with a sine or a cosine, as ``-I*sind(phi)``."""
    match node:
        case Call(function):
            return function in WAVES
        case Product() | Negative():
            return any(map(_is_component, node.parts))
    return False


_Leaf = tuple[str | float, bool]
"""A name or a number, and whether it is subtracted."""


def _form(*sides: Expression) -> tuple[tuple[object, ...], list[_Leaf]]:
    """The common form of rules that differ only in names, numbers and signs, and their names and
    numbers.

    Looser than a ``Shape``: at the ends of a row of nodes numbers replace names.
    """
    form, leaves = list[object](), list[_Leaf]()
    nodes: list[tuple[Any, bool]] = [(side, False) for side in sides]
    while nodes:
        node, negative = nodes.pop()
        match node:
            case Name(leaf) | Number(leaf):
                leaves.append((leaf, negative))
            case Negative(operand):
                nodes.append((operand, not negative))
            case _:
                form += len(leaves), type(node), getattr(node, "function", len(node.parts))
                nodes += [(part, False) for part in node.parts]
    return (*form, len(leaves)), leaves


def _column(leaves: Sequence[_Leaf]) -> Sequence[str | float]:
    """The entries at one place of rules of one form; numbers with their sign."""
    negative = next((sign for leaf, sign in leaves if isinstance(leaf, str)), False)
    return [
        -leaf if isinstance(leaf, float) and sign != negative else leaf for leaf, sign in leaves
    ]


def _passed_on(pairs: Collection[tuple[str | float, str | float]]) -> bool:
    """Whether ``LINKS`` pairs in a row lead from name to name, without a circle."""
    onward = dict(pairs)
    for start in onward:
        path = [start]
        while (
            len(path) <= LINKS and (after := onward.get(path[-1])) is not None and after not in path
        ):
            path.append(after)
        if len(path) > LINKS and all(isinstance(name, str) for name in path[1:-1]):
            return True
    return False


def _has_odd_power(node: Any, name: str) -> bool:
    """Whether a name occurs other than in even powers."""
    match node:
        case Name(read):
            return read == name
        case Power(_, Number(exponent)) if exponent % 2.0 == 0.0:
            return False
    return any(_has_odd_power(part, name) for part in node.parts)


def _terms(*sides: Expression) -> set[str]:
    """The variables that are terms of sums by themselves, without signs and numerical factors."""
    from solver.ranking.sizes import added

    found, waiting = set[str](), [*sides]
    while waiting:
        for part, _ in added(waiting.pop()):
            match part:
                case (
                    Product(Number(), inner) | Product(inner, Number()) | Quotient(inner, Number())
                ):
                    waiting.append(inner)
                case Name(name):
                    found.add(name)
    return found


def factors_of(node: Expression) -> Iterator[Sum]:
    """The sums of which an expression is a product, quotient or power."""
    match node:
        case Sum():
            yield node
        case Product(left, right) | Quotient(left, right):
            yield from factors_of(left)
            yield from factors_of(right)
        case Negative(base) | Power(base):
            yield from factors_of(base)
