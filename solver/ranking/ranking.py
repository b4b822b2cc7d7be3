"""Which of several answers comes first: a rule on their numbers, the same wherever answers are
listed.

In this order: nearest to the guesses; fewest angles of a given tangent beyond a right one, and
signs other than those of values in the sheet; fewest negative values (angles aside, and variables
whose declared range reaches below 0; a temperature, mass or pressure below its zero counts double),
a trivial zero counting as one; fewest trivial zeros, factors among them; the smoothest, where rules
of one form pass a quantity on from place to place; fewest angles beyond a right one, or beside the
values of the inverse function where their sine or cosine is known; sizes near to those that the
rules and the inputs suggest, within half a decade of the nearest; angles, and times and frequencies
inside periodic functions, nearest to 0; the nearest sizes; and for what is still alike, fewest
negative angles, and the variables one by one, in the order of their names. Away from guesses,
answers with a number of unlikely size come after all others, the farthest last. Nothing depends on
the order of rules or variables.

The sign of an angle says nothing, nor that of what follows from one alone or swings, nor of a kind
of quantity that has negative values anyhow, given or in every answer (``signs.py``): where a crank
turns clockwise, its pin has a negative velocity, and that of the slider may have either sign.

The rule is written once, over numbers or arrays of them.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from rulesheets.evaluate import value
from rulesheets.model import Model, Values
from solver.path import TARGET
from solver.path.graph import ModelGraph
from solver.path.planner import planner
from solver.ranking.signs import signs_of

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
CRITERIA = (
    "guessed",
    "unlikely",
    "reversed",
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
Figure = Any
"""A float, or an array (rows,) of floats."""
Key = list[Any]
_Suggested = tuple[Sequence[Any], Sequence[Any]]


LEAST = 1e-300
MOST = 1e300


class Arithmetic(NamedTuple):
    """``there``: the number, or another one for nan; ``decade``: its logarithm, within those of the
    ends."""

    there: Callable[[Any, float], Any]
    largest: Callable[[Sequence[Any]], Any]
    rounded: Callable[[Any], Any]
    decade: Callable[[Any], Any]


FLOATS = Arithmetic(
    lambda number, other: number if number == number else other,
    max,
    lambda number: round(number) if abs(number) < MOST else number,
    lambda number: math.log10(min(max(abs(number), LEAST), MOST)),
)


class Sizes:
    """The sizes that the rules and the ``known`` numbers of a model suggest, or guesses.

    ``read`` are the names that an answer is compared by: unknowns ``among`` its own (None: all),
    those of the sheet, ``names``, before those of its subsheets.
    """

    def __init__(
        self,
        model: Model,
        known: Collection[str],
        among: Collection[str] | None = None,
        guesses: Mapping[str, float] | None = None,
    ) -> None:
        self.model, self.signs = model, signs_of(model)
        self.known = tuple(sorted(name for name in known if name in model.variables))
        there = model.variables if among is None else among
        self.read = tuple(
            sorted((n for n in there if n not in known), key=lambda name: ("." in name, name))
        )
        self.names = tuple(name for name in self.read if "." not in name)
        self.guesses = {n: guess for n, guess in (guesses or {}).items() if n in self.read}
        self.angles = [name in self.signs.angles for name in self.names]

    def suggested(
        self, on: Arithmetic, given: Sequence[Figure], zero: tuple[bool, ...]
    ) -> _Suggested:
        """The suggested decade of each name, and whether it follows from the inputs; nan is one
        without a size."""
        pattern, kept = (self.known, self.names, zero), self.signs.suggestions
        if pattern not in kept:
            from solver.ranking.sizes import suggested  # mostly kept from an earlier run

            kept[pattern] = suggested(self.model, *pattern)
        slopes_of, constants, determined = kept[pattern]
        sizes = [on.decade(on.there(number, 1.0)) for number in given]
        decades = [
            sum((slope * sizes[place] for place, slope in slopes), constant)
            for slopes, constant in zip(slopes_of, constants, strict=True)
        ]
        guesses = map(self.guesses.get, self.names)
        return [
            FLOATS.decade(g) if g else d for g, d in zip(guesses, decades, strict=True)
        ], determined

    def apart(self, row: Sequence[Figure], sizes: _Suggested, on: Arithmetic) -> list[Figure]:
        """Decades from the suggested size for each name; 0 for angles and for zeros."""
        return [
            0.0 if angle else (on.decade(number) - decade) * (number != 0.0)
            for angle, number, decade in zip(self.angles, row, sizes[0], strict=False)
        ]


class Ranking(Sizes):
    """The ranking for one model and one set of ``known`` names, at any values of these."""

    def __init__(
        self,
        model: Model,
        known: Collection[str],
        among: Collection[str] | None = None,
        guesses: Mapping[str, float] | None = None,
    ) -> None:
        super().__init__(model, known, among, guesses)
        self.graph, signs, every = planner(model).graph, self.signs, (*self.read, *self.known)
        alike = {signs.kinds.get(n) for n in known if n in signs.radii}
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
        values = [model.variables[name].value for name in self.names]
        self._own = [value if isinstance(value, float) else 0.0 for value in values]
        self._phases = [name in signs.phases for name in self.names]
        self._trivial = [(name, 0.0) not in signs.codes for name in self.names]
        self._cancels = [name in signs.differences for name in self.names]
        places = {name: place for place, name in enumerate(every)}
        pairs = {pair for pairs in signs.series for pair in pairs if signs.aside.isdisjoint(pair)}
        self._neighbours = [
            [places[one] if isinstance(one, str) else one for one in pair]
            for pair in sorted(pairs, key=repr)
            if not set(self.names).isdisjoint(pair)
            and all(one in places for one in pair if isinstance(one, str))
        ]
        self._inclined = [name in signs.inclinations for name in self.names]
        self._right = [signs.angles.get(name, 0.0) / 4.0 for name in self.names]
        self._principal = [
            _principal(self.graph, name, self.known) if angle else None
            for name, angle in zip(self.names, self.angles, strict=True)
        ]
        self._floors = [signs.floors.get(name, -np.inf) for name in self.names]
        self._factors = [
            (
                factor.plain,
                [
                    (share, [places[n] for n in over], [places[n] for n in under])
                    for share, over, under in factor.terms
                ],
            )
            for factor in signs.factors
            for inside in [{n for _, over, under in factor.terms for n in (*over, *under)}]
            if inside <= places.keys() and signs.aside.isdisjoint(inside)
        ]

    def order(self, answers: Sequence[Values]) -> list[int]:
        """The places of the answers, inputs included, the first one first."""
        rows = [_numbers(answer, self.read) for answer in answers]
        keys = self.keys_of_rows(rows, _numbers(answers[0], self.known))
        return sorted(range(len(keys)), key=keys.__getitem__)

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
        sizes = self.suggested(on, given, zero)
        rough = [self._roughness([*row, *given], on) if self._neighbours else 0.0 for row in rows]
        told = zip(rows, factors, rough, strict=True)
        keys = [self._key(*row, most, tops, weights, sizes, on) for row in told]
        least = -on.largest([-key[SIZE] for key in keys])
        for key in keys:  # what is within half a decade of the best is of the same size
            key[SIZE] = on.rounded(GRAIN * on.largest([key[SIZE] - least - SLACK, 0.0]))
        return keys

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
        negatives = zeros = turned = minus = far = back = 0.0
        wide, distance, none = factors
        signs: list[Figure] = []
        apart = self.apart(row, sizes, on)
        for place, (angle, floor, right) in enumerate(
            zip(self.angles, self._floors, self._right, strict=True)
        ):
            number, least = row[place], ZERO * most[place]
            share = on.rounded(GRAIN * (number / most[place]))
            signs += [1.0 * (share < 0.0), abs(share)]
            if angle:
                turned, minus = turned + abs(number), minus + signs[-2]
                beyond = 1.0 * (abs(number) > right + least)
                back = back + beyond * self._inclined[place]
                if (principal := self._principal[place]) is not None:
                    low, high = principal
                    beyond = 1.0 * (number < low - least) + 1.0 * (number > high + least)
                wide = wide + beyond
                continue
            there = 1.0 * (abs(number) > least) * (apart[place] * sizes[1][place] > ROUNDED_AWAY)
            below = (number < -least) * there
            if self._cancels[place]:
                below = below * (apart[place] * sizes[1][place] > TAKEN_AWAY)
                apart[place] = on.largest([apart[place], 0.0])
            negatives = negatives + weights[place] * below
            if floor > -np.inf:
                negatives = negatives + (number < floor - least)
            if own := self._own[place]:
                back = back + (number > least if own < 0.0 else number < -least) * there
            zeros = zeros + (1.0 - there) * (tops[place] > least) * self._trivial[place]
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
            back,
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
        """The number of negative factors that are sums, if a number stands in them or no unknown in
        them is usually negative; by how many decades their terms are larger than they; and how many
        are 0. Neighbours, whose plain difference is taken, are alike."""
        crossed, lost, none = 0.0, 0.0, 0.0
        for plain, factor in self._factors:
            alone = sum(abs(share) for share, over, under in factor if not (over or under))
            weight, terms, signed = 1.0, [], range(0 if alone else len(self.read))
            for share, over, under in factor:
                term = share
                for place in over:
                    term = term * numbers[place]
                for place in under:
                    term = term / on.largest([abs(numbers[place]), LEAST])
                for place in {*over, *under}.intersection(signed):
                    weight = weight * counted[place]
                terms.append(term)
            total, size = sum(terms), on.largest([sum(map(abs, terms)), LEAST])
            crossed = crossed + weight * (total < -ZERO * size)
            none = none + weight * (abs(total) <= ZERO * size)
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


def settled(model: Model, inputs: Collection[str], answers: Sequence[Values]) -> Collection[str]:
    """The names that have one value in all answers: what was computed before these part says as
    much of sizes as the inputs, but where angles are unknown: a linkage goes anywhere."""
    first, *others = answers
    if not others or signs_of(model).turning - {*inputs}:
        return inputs
    return {n for n, value in first.items() if all(answer.get(n) == value for answer in others)}


def _principal(graph: ModelGraph, name: str, known: Collection[str]) -> tuple[float, float] | None:
    """The range of the inverse function for an angle whose sine or cosine, or that of a multiple, a
    rule gives by known names alone; None for another, and where the sheet's own value lies
    outside."""
    for index in graph.users[name]:
        others = {*graph.model.equations[index].names} - {name}
        isolation = graph.isolation(index, graph.number[name]) if others <= {*known} else None
        stages = () if isolation is None else isolation.stages
        place = next((k for k, stage in enumerate(stages) if len(stage.forms) == 2), None)
        if place is None or not (turn := stages[place].period):
            continue
        low = 0.0 if stages[place].operation.startswith("cos") else -turn / 4
        ends = [low, low + turn / 2]
        for stage in stages[place + 1 :]:
            if stage.operation not in ("negative", "product", "quotient"):
                break
            try:
                ends = [value(stage.forms[0], {TARGET.name: end}) for end in ends]
            except KeyError:
                break
        else:
            own = graph.model.variables[name].value
            outside = isinstance(own, float) and not min(ends) <= own <= max(ends)
            return None if outside else (min(ends), max(ends))
    return None


def _numbers(values: Values, names: Sequence[str]) -> tuple[float, ...]:
    return tuple([v if isinstance(v := values.get(name), float) else np.nan for name in names])


def is_measured(place: int) -> bool:
    """Whether a part of a key is a measure, not a count or a sign."""
    own = place - len(CRITERIA)
    return own % 2 == 1 if own >= 0 else CRITERIA[place] in MEASURED


SPAN = 1e9
"""Numbers of an only answer, and 1, that lie within this factor of one another are all of likely
size."""


def unlikely(
    model: Model, answers: Sequence[Values], inputs: Values, guesses: Mapping[str, float]
) -> list[tuple[str, ...]]:
    """The names of each answer whose numbers are of unlikely size; ``answers`` hold the inputs as
    well.

    A single answer, or one of only unlikely answers, has such a name only if its size follows from
    the inputs and is exceeded: a small number may be a difference of large ones.
    """
    if not answers:
        return []
    if len(answers) == 1:
        numbers = (1.0, *answers[0].values(), *guesses.values())
        sizes = [abs(number) for number in numbers if isinstance(number, float) and number]
        if max(sizes) / SPAN <= min(sizes):
            return [()]
    on = Sizes(model, inputs, {name for values in answers for name in values}, guesses)
    given = _numbers(inputs, on.known)
    suggested = on.suggested(FLOATS, given, tuple([number == 0.0 for number in given]))
    rows = [[FLOATS.there(n, 0.0) for n in _numbers(answer, on.read)] for answer in answers]
    apart = [list(zip(on.apart(r, suggested, FLOATS), suggested[1], strict=True)) for r in rows]
    # a small number is far from a suggested size only if that follows
    far = [[(abs(d) if determined else d) > UNLIKELY for d, determined in one] for one in apart]
    if all(map(any, far)):
        far = [[determined and d > UNLIKELY for d, determined in one] for one in apart]
    return [tuple(n for n, mark in zip(on.names, marks, strict=True) if mark) for marks in far]
