"""Which of several answers comes first: a rule on their numbers, the same wherever answers are
listed.

In this order: nearest to the guesses; fewest negative values (angles aside, and variables whose
declared range reaches below 0; a temperature, mass or pressure below its zero counts double), a
trivial zero counting as one; fewest trivial zeros, factors among them; the smoothest, where rules
of one form pass a quantity on from place to place; fewest angles beyond a right one; sizes near to
those that the rules and the inputs suggest, within half a decade of the nearest; angles, and times
and frequencies inside periodic functions, nearest to 0; the nearest sizes; and for what is still
alike, fewest negative angles, and the variables one by one, in the order of their names. Away from
guesses, answers with a number of unlikely size come after all others, the farthest last. Nothing
depends on the order of rules or variables.

The sign of an angle says nothing, nor that of what follows from one alone or swings, nor of a kind
of quantity that has negative values anyhow, given or in every answer: where a crank turns
clockwise, its pin has a negative velocity, and that of the slider may have either sign. Variables
are angles by their unit or by the functions that they stand in.

The rule is written once, over numbers or arrays of them.
"""

from __future__ import annotations

import itertools
from collections import defaultdict
from collections.abc import Collection, Iterator, Mapping, Sequence, Set
from fractions import Fraction
from functools import cached_property
from math import pi
from typing import Any

import numpy as np

from rulesheets.library import ANGLE
from rulesheets.model import Equation, Model, Value, once
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
)
from rulesheets.syntax.nodes import names as names_in
from rulesheets.syntax.program import walk
from solver.path.graph import angle_evidence, by_shape, phases
from solver.path.planner import planner
from solver.path.polynomial import Monomial, NoForm, Polynomial, in_parts
from solver.ranking.sizes import FLOATS, LEAST, MANY, Arithmetic, Scalings, Suggestions, added

UNLIKELY = 9.0
"""Decades from the suggested size beyond which a number is of unlikely size."""
ZERO = 1e-12
"""A share of the largest value among the answers that counts as 0."""
ROUNDED_AWAY = -12.0
"""Decades from the suggested size below which a number is 0 but for rounding."""
TAKEN_AWAY = -1.0
"""Decades from the suggested size below which a difference has all but cancelled: it may have
either sign."""
DIFFERENCE = 3.0
"""Decades by which neighbours are larger than their difference, beyond which it is a rest as any
other."""
GRAIN = 1e6
"""Parts of a decade, or of the largest value among the answers, below which numbers count as
alike."""

SLACK = 0.5
"""Decades by which sizes may be farther from the suggested ones than the best are, and count
alike."""
LINKS = 3
"""The least number of steps of a series."""
CRITERIA = (
    "guessed",
    "unlikely",
    "negative",
    "trivial",
    "rough",
    "wide",
    "size",
    "angle",
    "exact size",
    "negative angles",
)
"""The parts of a key in their order; whether each number is negative, and its size, follow, name by
name."""
MEASURED = frozenset({"guessed", "rough", "size", "angle", "exact size"})
"""Those that are measures, not counts."""
SIZE = CRITERIA.index("size")
WAVES = frozenset({"sin", "cos", "sind", "cosd"})
DIGITS = 6
"""Decimals of the exponents by which a kind of quantity is known."""
ABSOLUTE = frozenset({"bar", "mbar", "atm", "psia", "torr", "Torr", "mmHg", "inHg"})
"""Units of pressure in which no stress is given."""

Figure = Any
"""A float, or an array (rows,) of floats."""
Key = list[Any]
_Suggested = tuple[Sequence[Any], Sequence[Any]]


class Signs:
    """The role of signs of the variables of a model: ``angles``, with their full turns, and the
    names whose signs do not count, ``aside``; the suggested sizes are kept here too, by the known
    and wanted names."""

    def __init__(self, model: Model) -> None:
        self.model = model
        self.angles = _angles(model)
        self.suggestions: dict[tuple[Sequence[str], Sequence[str]], Suggestions] = {}
        found = set(self.angles)  # and what rules tell from one of them alone
        rules = [e for e in model.equations if len(e.names) == 2] if found else []
        before = -1
        while len(found) > before:
            before = len(found)
            for rule in rules:
                told = set(rule.names) - found
                if len(told) == 1 and any(
                    _has_odd_power(side, *told) for side in (rule.left, rule.right)
                ):
                    found |= told
        ranged = (
            n
            for n, v in model.variables.items()
            if v.low < 0.0 and (v.low > -np.inf or v.high < np.inf)
        )
        self.aside = frozenset(found.union(ranged, self._swinging))

    @cached_property
    def phases(self) -> Set[str]:
        """Names by which arguments of periodic functions grow, and which are no angles, as a time
        or a frequency: the first of the periods is meant."""
        inside, under = set[str](), set[str]()
        for argument in (argument for e in self._periodic for argument in phases(e.left, e.right)):
            inside.update(names_in(argument))
            under.update(
                n for q in walk(argument) if isinstance(q, Quotient) for n in names_in(q.right)
            )
        return inside - under - self.angles.keys()

    @cached_property
    def _swinging(self) -> Set[str]:
        """Names that a rule gives as a swing of a phase: these have either sign."""
        sides = [sides for e in self._periodic for sides in ((e.left, e.right), (e.right, e.left))]
        return {
            one.name
            for one, other in sides
            if isinstance(one, Name) and _swings(other, self.phases)
        }

    @cached_property
    def _periodic(self) -> Sequence[Equation]:
        """The rules that call periodic functions; of too large a model none."""
        if len(self.model.variables) > MANY:
            return ()
        shapes = ((rules, rules[0]) for rules in by_shape(self.model))
        return [
            rule for rules, first in shapes if phases(first.left, first.right) for rule in rules
        ]

    @cached_property
    def kinds(self) -> Mapping[str, int]:
        """Quantities that the rules scale alike have one number; dimensionless ones have none."""
        names = list(self.model.variables)
        if len(names) > MANY:
            return {}
        equations = self.model.equations  # one that only gives a number is no rule
        rules = [e for e in equations if list(names_in(e.right)) or not isinstance(e.left, Name)]
        exponents = np.round(Scalings(rules, names).exponents, DIGITS) + 0.0
        number: dict[bytes, int] = {}
        return {
            name: number.setdefault(row.tobytes(), len(number))
            for name, row in zip(names, exponents, strict=True)
            if row.any()
        }

    @cached_property
    def differences(self) -> frozenset[str]:
        """Names that a rule gives as a difference: their sign says nothing about their kind."""
        found = set[str]()
        for rules in by_shape(self.model):
            sides = rules[0].left, rules[0].right
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
        for equation in self.model.equations if len(self.model.variables) <= MANY else ():
            if not self.angles.keys() & set(equation.names):  # a linkage goes anywhere
                form, leaves = _form(equation.left, equation.right)
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
    def factors(self) -> Collection[Polynomial]:
        """Sums that rules multiply by, divide by or raise to a power, as ``1 - x``: such a
        factor is seldom negative, and seldom a small rest of large terms.

        A plain difference that occurs only squared may be one of coordinates.
        """
        if len(self.model.variables) > MANY:
            return ()
        found = dict[frozenset[tuple[Monomial, Fraction]], Polynomial]()
        for equation in self.model.equations:
            for node in walk(equation.left, equation.right):
                square = isinstance(node, Power) and is_number(node.exponent, 2.0)
                for part in (
                    factors_of(node) if isinstance(node, Power | Product | Quotient) else ()
                ):
                    factor = _in_names(part)
                    if factor and not (square and _is_plain(factor)):
                        found[frozenset(factor.items())] = factor
        return tuple(found.values())

    @cached_property
    def radii(self) -> Mapping[str, bool]:
        """Names that are never a term by themselves: whether they multiply a sine or a cosine."""
        found, terms = dict[str, bool](), set[str]()
        for equation in self.model.equations if len(self.model.variables) <= MANY else ():
            terms |= _terms(equation.left, equation.right)
            found = dict.fromkeys(equation.names, False) | found
            for node in walk(equation.left, equation.right):
                match node:
                    case Product(Name(name), Call(wave)) | Product(Call(wave), Name(name)) if (
                        wave in WAVES
                    ):
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
        case Call():
            return any(not known.isdisjoint(names_in(argument)) for argument in phases(node))
        case Product():
            return any(_swings(part, known) for part in node.parts)
        case Negative() | Sum():
            return all(_swings(part, known) for part in node.parts)
        case Quotient(left, _):
            return _swings(left, known)
    return False


def _angles(model: Model) -> dict[str, float]:
    """The full turns of variables in degrees or radians, arguments of sines, results of their
    inverses, and what is added to any of these."""
    found = {
        n: 2.0 * pi ** (1 - v.measure.pi) / float(v.measure.factor)
        for n, v in model.variables.items()
        if v.measure is not None and v.measure.bases == {ANGLE: 1}
    }
    found = {name: turn for name, turn, _ in angle_evidence(model) if turn} | found
    sums = [_terms(equation.left, equation.right) for equation in model.equations] if found else []
    before = -1
    while len(found) > before:
        before = len(found)
        for names in sums:
            if turn := next((found[name] for name in sorted(names) if name in found), None):
                found |= {name: turn for name in names if name not in found}
    return found


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


def _is_plain(factor: Polynomial) -> bool:
    """Whether names alone are added and subtracted."""
    return all(abs(c) == 1 and [e for _, e in monomial] == [1] for monomial, c in factor.items())


def _in_names(total: Sum) -> Polynomial:
    """A sum as a polynomial in names; empty if it is none."""
    parts = dict[Expression, str]()
    try:
        found = in_parts(total, lambda _: None, parts)
    except (NoForm, ArithmeticError):
        return Polynomial()
    return Polynomial() if parts else found


class Ranking:
    """The ranking for one model and one set of ``known`` names, at any values of these.

    ``read`` are the names that an answer is compared by: unknowns ``among`` its own (None: all),
    those of the sheet before those of its subsheets.
    """

    def __init__(
        self,
        model: Model,
        known: Collection[str],
        among: Collection[str] | None = None,
        guesses: Mapping[str, float] | None = None,
    ) -> None:
        self.graph, signs = planner(model).graph, signs_of(model)
        self.known = tuple(sorted(name for name in known if name in model.variables))
        there = model.variables if among is None else among
        self.read = tuple(
            sorted((n for n in there if n not in known), key=lambda name: ("." in name, name))
        )
        self.names = tuple(name for name in self.read if "." not in name)
        self.guesses = {n: guess for n, guess in (guesses or {}).items() if n in self.read}
        pattern = self.known, self.names
        if pattern not in signs.suggestions:
            signs.suggestions[pattern] = Suggestions(model, *pattern)
        self._suggestions = signs.suggestions[pattern]
        every, alike = (
            (*self.read, *self.known),
            {signs.kinds.get(n) for n in known if n in signs.radii},
        )
        positive = {
            n for n, multiplies in signs.radii.items() if multiplies and signs.kinds.get(n) in alike
        }
        apart = signs.differences | positive
        self._kinds = [None if name in apart else signs.kinds.get(name) for name in every]
        absolute = {k for n, k in zip(every, self._kinds, strict=True) if n in signs.floors}
        self._groups = [(k, n * (k in absolute)) for n, k in zip(every, self._kinds, strict=True)]
        self._own_kinds = [
            None if name in positive else signs.kinds.get(name) for name in self.names
        ]
        self._aside = [name in signs.aside for name in self.names]
        self._phases = [name in signs.phases for name in self.names]
        self._cancels = [name in signs.differences for name in self.names]
        self.angles = [name in signs.angles for name in self.names]
        places = {name: place for place, name in enumerate(every)}
        pairs = {pair for pairs in signs.series for pair in pairs if signs.aside.isdisjoint(pair)}
        self._neighbours = [
            [places[one] if isinstance(one, str) else one for one in pair]
            for pair in sorted(pairs, key=repr)
            if not set(self.names).isdisjoint(pair)
            and all(one in places for one in pair if isinstance(one, str))
        ]
        self._right = [signs.angles.get(name, 0.0) / 4.0 for name in self.names]
        self._floors = [signs.floors.get(name, -np.inf) for name in self.names]
        self._factors = [
            (
                _is_plain(factor),
                [
                    (
                        float(c),
                        [places[n] for n, exponent in monomial for _ in range(exponent)],
                        [places[n] for n, exponent in monomial for _ in range(-exponent)],
                    )
                    for monomial, c in factor.items()
                ],
            )
            for factor in signs.factors
            if factor.generators <= places.keys() and signs.aside.isdisjoint(factor.generators)
        ]

    def order(
        self, answers: Sequence[Mapping[str, Value]], given: Mapping[str, Value]
    ) -> list[int]:
        """The places of the answers, the first one first. ``given`` are the values of the known
        names."""
        if len(answers) < 2:
            return list(range(len(answers)))
        rows = [_numbers(answer, self.read) for answer in answers]
        return sorted(
            range(len(rows)), key=self.keys_of_rows(rows, _numbers(given, self.known)).__getitem__
        )

    def keys_of_rows(self, rows: Sequence[Sequence[float]], given: Sequence[float]) -> list[Key]:
        """The keys of tuples of the numbers of ``read``, with a tuple of those of ``known``.

        nan stands for a symbol, and for a missing number.
        """
        return self.keys_on(FLOATS, rows, given, tuple([number == 0.0 for number in given]))

    def keys_on(
        self,
        on: Arithmetic,
        answers: Sequence[Sequence[Figure]],
        given: Sequence[Figure],
        zero: tuple[bool, ...],
    ) -> list[Key]:
        """The sort key of each answer, in any arithmetic; ``zero`` marks the known numbers that are
        0."""
        tops = [
            on.largest([on.there(n, -np.inf) for n in column])
            for column in zip(*answers, strict=True)
        ]
        rows = [[on.there(number, 0.0) for number in answer] for answer in answers]
        most = [on.largest([LEAST, *map(abs, column)]) for column in zip(*rows, strict=True)]
        # what a negative value of each name counts: nothing where its kind has negative values
        # anyhow
        crossed, positive = dict[tuple[int | None, str], Figure](), dict[int | None, Figure]()
        for answer in answers:
            clear = dict[tuple[int | None, str], Figure]()
            least = [
                on.there(n, -np.inf) + ZERO * size for n, size in zip(answer, most, strict=True)
            ]
            signs = [(low < 0.0) & (top > -np.inf) for low, top in zip(least, tops, strict=True)]
            for group, negative in zip(self._groups, signs + [n < 0.0 for n in given], strict=True):
                clear[group] = clear.get(group, 1.0) * (1.0 - negative)
            crossed = {
                group: crossed.get(group, 1.0) * (1.0 - none) for group, none in clear.items()
            }
        for (kind, _), every in crossed.items():
            positive[kind] = positive.get(kind, 1.0) * (1.0 - every)
        kinds = zip(self._own_kinds, self._aside, strict=True)
        positive[None] = 1.0  # dimensionless numbers are of no kind
        weights = [0.0 if aside else positive.get(kind, 1.0) for kind, aside in kinds]
        counted = [positive[kind] for kind in self._kinds]
        factors = [self._factored([*row, *given], counted, on) for row in rows]
        sizes = self._suggested(on, given, zero)
        rough = [self._roughness([*row, *given], on) if self._neighbours else 0.0 for row in rows]
        told = zip(rows, factors, rough, strict=True)
        keys = [self._key(*row, most, tops, weights, sizes, on) for row in told]
        least = -on.largest([-key[SIZE] for key in keys])
        for key in keys:  # what is within half a decade of the best is of the same size
            key[SIZE] = on.rounded(GRAIN * on.largest([key[SIZE] - least - SLACK, 0.0]))
        return keys

    def unlikely(
        self, answers: Sequence[Mapping[str, Value]], given: Mapping[str, Value]
    ) -> list[tuple[str, ...]]:
        """The names of each answer whose numbers are of unlikely size.

        A single answer, or one of only unlikely answers, has such a name only if its size follows
        from the inputs and is exceeded: a small number may be a difference of large ones.
        """
        numbers = _numbers(given, self.known)
        sizes = self._suggested(FLOATS, numbers, tuple([number == 0.0 for number in numbers]))
        rows = [[FLOATS.there(n, 0.0) for n in _numbers(answer, self.read)] for answer in answers]
        apart = [list(zip(self._apart(row, sizes, FLOATS), sizes[1], strict=True)) for row in rows]
        # a small number is far from a suggested size only if that follows
        far = [[(abs(d) if determined else d) > UNLIKELY for d, determined in one] for one in apart]
        if all(map(any, far)):
            far = [[determined and d > UNLIKELY for d, determined in one] for one in apart]
        return [
            tuple(n for n, mark in zip(self.names, marks, strict=True) if mark) for marks in far
        ]

    # --- keys ---

    def _key(
        self,
        row: Sequence[Figure],
        factors: tuple[Figure, Figure, Figure],
        rough: Figure,
        most: Sequence[Figure],
        tops: Sequence[Figure],
        weights: Sequence[Figure],
        sizes: _Suggested,
        on: Arithmetic,
    ) -> Key:
        negatives = zeros = turned = minus = far = 0.0
        wide, distance, none = factors
        signs: list[Figure] = []
        apart = self._apart(row, sizes, on)
        for place, (angle, floor, right) in enumerate(
            zip(self.angles, self._floors, self._right, strict=True)
        ):
            number, least = row[place], ZERO * most[place]
            share = on.rounded(GRAIN * (number / most[place]))
            signs += [1.0 * (share < 0.0), abs(share)]
            if angle:
                turned, minus = turned + abs(number), minus + signs[-2]
                wide = wide + 1.0 * (abs(number) > right + least)
                continue
            there = 1.0 * (abs(number) > least) * (apart[place] * sizes[1][place] > ROUNDED_AWAY)
            below = (number < -least) * there
            if self._cancels[place]:
                below = below * (apart[place] * sizes[1][place] > TAKEN_AWAY)
                apart[place] = on.largest([apart[place], 0.0])
            negatives = negatives + weights[place] * below
            if floor > -np.inf:
                negatives = negatives + (number < floor - least)
            zeros = zeros + (1.0 - there) * (tops[place] > least)
            steps = (abs(apart[place]) if sizes[1][place] else apart[place]) / UNLIKELY
            far = on.largest([far, on.rounded(steps - 0.5) * there])
            if self._phases[place]:
                turned = turned + abs(number)
            else:
                distance = distance + abs(apart[place]) * there * sizes[1][place]
        size, angle = on.rounded(GRAIN * distance), on.rounded(GRAIN * turned)
        guessed, trivial = self._guessed(row, on) if self.guesses else 0.0, zeros + none
        return [
            guessed,
            far,
            negatives + zeros,
            trivial,
            rough,
            wide,
            distance,
            angle,
            size,
            minus,
            *signs,
        ]

    def _factored(
        self, numbers: Sequence[Figure], counted: Sequence[Figure], on: Arithmetic
    ) -> tuple[Figure, Figure, Figure]:
        """The number of negative factors that are sums, if no unknown in them is usually negative;
        by how many decades their terms are larger than they; and how many are 0. Neighbours, whose
        plain difference is taken, are alike."""
        crossed, lost, none = 0.0, 0.0, 0.0
        for plain, factor in self._factors:
            weight, terms = 1.0, []
            for share, over, under in factor:
                term = share
                for place in over:
                    term = term * numbers[place]
                for place in under:
                    term = term / on.largest([abs(numbers[place]), LEAST])
                for place in {*over, *under}.intersection(range(len(self.read))):
                    weight = weight * counted[place]
                terms.append(term)
            total, size = sum(terms), on.largest([sum(map(abs, terms)), LEAST])
            crossed = crossed + weight * (total < -ZERO * size)
            none = none + weight * (abs(total) <= ZERO * size)
            alone = sum(abs(share) for share, over, under in factor if not (over or under))
            rest = abs(total) if not alone else -on.largest([-abs(total), -alone])
            decades = on.decade(size) - on.decade(on.largest([rest, ZERO * size]))
            lost = lost + weight * decades * (decades > (DIFFERENCE if plain else 0.0))
        return crossed, lost, none

    def _roughness(self, numbers: Sequence[Figure], on: Arithmetic) -> Figure:
        """The decade of the sum of the squares of differences between neighbours."""
        ends = [
            [numbers[n] if isinstance(n, int) else n for n in pair] for pair in self._neighbours
        ]
        return on.rounded(GRAIN * on.decade(sum((a - b) * (a - b) for a, b in ends)))

    def _apart(self, row: Sequence[Figure], sizes: _Suggested, on: Arithmetic) -> list[Figure]:
        """Decades from the suggested size for each name; 0 for angles and for zeros."""
        return [
            0.0 if angle else (on.decade(number) - decade) * (number != 0.0)
            for angle, number, decade in zip(self.angles, row, sizes[0], strict=False)
        ]

    def _guessed(self, row: Sequence[Figure], on: Arithmetic) -> Figure:
        """The distance from the guesses, on a scale on which nearly equal distances are equal."""
        total = 0.0
        for name, guess in self.guesses.items():
            apart = abs(row[self.read.index(name)] - guess)
            if (turn := self.graph.turn(name)) is not None:
                apart = abs(apart - turn * on.rounded(apart / turn))
            share = apart / max(abs(guess), 1.0)
            total = total + share * share
        return on.rounded(GRAIN * on.decade(total))

    def _suggested(
        self, on: Arithmetic, given: Sequence[Figure], zero: tuple[bool, ...]
    ) -> _Suggested:
        """The suggested decade of each name, and whether it follows from the inputs."""
        decades, determined = self._suggestions.over(on, given, zero)
        guesses = map(self.guesses.get, self.names)
        return [
            FLOATS.decade(g) if g else d for g, d in zip(guesses, decades, strict=True)
        ], determined


def _numbers(values: Mapping[str, Value], names: Sequence[str]) -> tuple[float, ...]:
    return tuple([v if isinstance(v := values.get(name), float) else np.nan for name in names])


def is_measured(place: int) -> bool:
    """Whether a part of a key is a measure, not a count or a sign."""
    own = place - len(CRITERIA)
    return own % 2 == 1 if own >= 0 else CRITERIA[place] in MEASURED


SPAN = 1e9
"""Numbers of an only answer, and 1, that lie within this factor of one another are all of likely
size."""


def unlikely(
    model: Model,
    answers: Sequence[Mapping[str, Value]],
    inputs: Mapping[str, Value],
    guesses: Mapping[str, float],
) -> list[tuple[str, ...]]:
    """The names of each answer whose numbers are of unlikely size; ``answers`` hold the inputs as
    well."""
    if len(answers) == 1:
        numbers = (1.0, *answers[0].values(), *guesses.values())
        sizes = [abs(number) for number in numbers if isinstance(number, float) and number]
        if max(sizes) / SPAN <= min(sizes):
            return [()]
    among = {name for values in answers for name in values}
    return Ranking(model, inputs, among, guesses).unlikely(answers, inputs) if answers else []
