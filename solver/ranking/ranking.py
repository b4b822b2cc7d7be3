"""Which of several answers comes first: a rule on their numbers, the same wherever answers are listed.

In this order: nearest to the guesses; fewest negative values (angles aside, and variables whose declared
range reaches below 0; a temperature, mass or pressure below its zero counts double), a trivial zero counting
as one; fewest trivial zeros; fewest angles beyond a right one; sizes near to those that the rules and the
inputs suggest, within half a decade of the nearest; angles nearest to 0; the nearest sizes; and for what is
still alike, the variables one by one, in the order of their names. Answers with a number of unlikely size
come after all others. Nothing depends on the order of rules or variables.

It is written once, over numbers or arrays of them.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import Any

import numpy as np

from rulesheets.model import Model, Value
from solver.path.planner import planner
from solver.ranking.signs import signs_of
from solver.ranking.sizes import FLOATS, LEAST, Arithmetic

UNLIKELY = 9.0
"""Decades from the suggested size beyond which a number is of unlikely size."""
ZERO = 1e-12
"""A share of the largest value among the answers that counts as 0."""
NOTHING = -12.0
"""Decades from the suggested size below which a number is 0 but for rounding."""
GRAIN = 1e6
"""Parts of a decade, or of the largest value among the answers, below which numbers count as alike."""

SLACK = 0.5
"""Decades by which sizes may be farther from the suggested ones than the best are, and count alike."""
SIZE = 5
"""The place of the size in a key."""

Number = Any
"""A float, or an array (rows,) of floats."""
Key = list[Any]
_Suggested = tuple[Sequence[Any], Sequence[Any]]


class Ranking:
    """The rule for one model and one set of ``known`` names; it holds at any values of these.

    ``read`` are the names that an answer is given by: unknowns ``among`` those it has (None: all).
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
        self.read = tuple(sorted((name for name in there if name not in known), key=_own_first))
        self.names = tuple(name for name in self.read if "." not in name)
        self.guesses = {n: guess for n, guess in (guesses or {}).items() if n in self.read}
        self._suggestions = self.signs.suggestions(self.known, self.names)
        graph = planner(model).graph
        self._kinds = [self.signs.kinds.get(name) for name in (*self.read, *self.known)]
        self._differences = [name in self.signs.differences for name in (*self.read, *self.known)]
        self._aside = [name in self.signs.aside for name in self.names]
        self.angles = [name in self.signs.angles for name in self.names]
        self._right = [(graph.single_turn(name) or 360.0) / 4.0 for name in self.names]
        self._floors = [self.signs.floor(name) for name in self.names]

    def order(self, answers: Sequence[Mapping[str, Value]], given: Mapping[str, Value]) -> list[int]:
        """The places of the answers, the first one first. ``given`` are the values of the known names."""
        return self.order_of_rows([self._row(answer) for answer in answers], self._given(given))

    def order_of_rows(self, rows: Sequence[Sequence[float]], given: Sequence[float]) -> list[int]:
        """The same for tuples of the numbers of ``read``, and a tuple of those of ``known``.

        nan stands for a symbol, and for a number that is not there.
        """
        if len(rows) < 2:
            return list(range(len(rows)))
        return sorted(range(len(rows)), key=self.keys_of_rows(rows, given).__getitem__)

    def keys_of_rows(self, rows: Sequence[Sequence[float]], given: Sequence[float]) -> list[Key]:
        """The keys that such tuples are sorted by."""
        return self._keys(rows, given, self._suggested(given), FLOATS)

    def unlikely(
        self, answers: Sequence[Mapping[str, Value]], given: Mapping[str, Value]
    ) -> list[tuple[str, ...]]:
        """Of each answer the names whose numbers are of unlikely size.

        A single answer, or where they all are, has such a name only if its size follows from the inputs and
        is exceeded: a small number may be a difference of large ones.
        """
        sizes = self._suggested(self._given(given))
        rows = [self._row(answer) for answer in answers]
        apart = [self._apart([FLOATS.there(number, 0.0) for number in row], sizes, FLOATS) for row in rows]
        far = [[_away(d, fixed) > UNLIKELY for d, fixed in zip(one, sizes[1], strict=True)] for one in apart]
        if all(map(any, far)):
            far = [[fixed and d > UNLIKELY for d, fixed in zip(one, sizes[1], strict=True)] for one in apart]
        return [tuple(n for n, mark in zip(self.names, marks, strict=True) if mark) for marks in far]

    def _row(self, answer: Mapping[str, Value]) -> tuple[float, ...]:
        return tuple(_number(answer.get(name)) for name in self.read)

    def _given(self, given: Mapping[str, Value]) -> tuple[float, ...]:
        return tuple(_number(given.get(name)) for name in self.known)

    def keys_on(
        self,
        on: Arithmetic,
        answers: Sequence[Sequence[Number]],
        given: Sequence[Number],
        zero: tuple[bool, ...],
    ) -> list[Key]:
        """The keys of answers in another arithmetic; ``zero`` tells the known numbers that are 0."""
        sizes = self._suggestions.over(on, given, zero)
        return self._keys(answers, given, (self._guessed_sizes(sizes[0]), sizes[1]), on)

    # --- keys ---

    def _keys(
        self,
        answers: Sequence[Sequence[Number]],
        given: Sequence[Number],
        sizes: _Suggested,
        on: Arithmetic,
    ) -> list[Key]:
        """The key that each answer is sorted by, numbers or arrays."""
        tops = [on.largest([on.there(n, -np.inf) for n in column]) for column in zip(*answers, strict=True)]
        rows = [[on.there(number, 0.0) for number in answer] for answer in answers]
        most = [on.largest([LEAST, *map(abs, column)]) for column in zip(*rows, strict=True)]
        weights = self._weights(tops, most, given)
        keys = [self._key(row, most, tops, weights, sizes, on) for row in rows]
        least = -on.largest([-key[SIZE] for key in keys])
        for key in keys:  # what is within half a decade of the best is of the same size
            key[SIZE] = on.rounded(GRAIN * on.largest([key[SIZE] - least - SLACK, 0.0]))
        return keys

    def _weights(
        self, tops: Sequence[Number], most: Sequence[Number], given: Sequence[Number]
    ) -> list[Number]:
        """What a negative value of each name counts: nothing where its kind has negative values anyhow.

        ``tops`` are the largest values among the answers, ``most`` the largest magnitudes.
        """
        positive = dict[int | None, Number]()
        found = [(top + ZERO * size < 0.0) & (top > -np.inf) for top, size in zip(tops, most, strict=True)]
        below = found + [number < 0.0 for number in given]
        for kind, difference, negative in zip(self._kinds, self._differences, below, strict=True):
            if kind is not None and not difference:
                positive[kind] = positive.get(kind, 1.0) * (1.0 - negative)
        return [
            0.0 if aside else positive.get(kind, 1.0)
            for kind, aside in zip(self._kinds, self._aside, strict=False)
        ]

    def _key(
        self,
        row: Sequence[Number],
        most: Sequence[Number],
        tops: Sequence[Number],
        weights: Sequence[Number],
        sizes: _Suggested,
        on: Arithmetic,
    ) -> Key:
        negatives, zeros, turned, wide, far, distance = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        signs: list[Number] = []
        apart = self._apart(row, sizes, on)
        for place, (angle, floor, right) in enumerate(
            zip(self.angles, self._floors, self._right, strict=True)
        ):
            number, least = row[place], ZERO * most[place]
            share = on.rounded(GRAIN * (number / most[place]))
            signs += [1.0 * (share < 0.0), abs(share)]
            if angle:
                turned = turned + abs(number)
                wide = wide + 1.0 * (abs(number) > right + least)
                continue
            there = 1.0 * (abs(number) > least) * (apart[place] * sizes[1][place] > NOTHING)
            below = (number < -least) * there + (number < floor - least)
            negatives = negatives + weights[place] * below
            zeros = zeros + (1.0 - there) * (tops[place] > least)
            far = on.largest([far, 1.0 * (_away(apart[place], sizes[1][place]) > UNLIKELY) * there])
            distance = distance + abs(apart[place]) * there * sizes[1][place]
        size, angle = on.rounded(GRAIN * distance), on.rounded(GRAIN * turned)
        return [far, self._guessed(row, on), negatives + zeros, zeros, wide, distance, angle, size, *signs]

    def _apart(self, row: Sequence[Number], sizes: _Suggested, on: Arithmetic) -> list[Number]:
        """Decades from the suggested size, one a name; 0 of angles and of what is 0."""
        return [
            0.0 if angle else (on.decade(number) - decade) * (number != 0.0)
            for angle, number, decade in zip(self.angles, row, sizes[0], strict=False)
        ]

    def _guessed(self, row: Sequence[Number], on: Arithmetic) -> Number:
        """How far an answer is from the guesses, on a scale on which what is all but as far is as far."""
        if not self.guesses:
            return 0.0
        graph, total = planner(self.model).graph, 0.0
        for name, guess in self.guesses.items():
            apart = abs(row[self.read.index(name)] - guess)
            if (turn := graph.turn(name)) is not None:
                apart = abs(apart - turn * on.rounded(apart / turn))
            share = apart / max(abs(guess), 1.0)
            total = total + share * share
        return on.rounded(GRAIN * on.decade(total))

    def _suggested(self, given: Sequence[float]) -> _Suggested:
        """The decade that is suggested for each name, and whether it follows from the inputs."""
        decades, determined = self._suggestions.at(given)
        return self._guessed_sizes(decades), determined

    def _guessed_sizes(self, decades: Sequence[Number]) -> list[Number]:
        guessed = [self.guesses.get(name) for name in self.names]
        return [FLOATS.decade(g) if g else d for g, d in zip(guessed, decades, strict=True)]


def _away(apart: Number, determined: bool) -> Number:
    """How far a number is from the suggested size: a small one only from a size that follows."""
    return abs(apart) if determined else apart


def is_measured(place: int) -> bool:
    """Whether a part of a key is a measure, and not a count or a sign."""
    return place in (1, SIZE, 6, 7) or (place > 7 and place % 2 == 1)


def _own_first(name: str) -> tuple[bool, str]:
    """Names of the sheet before those of its subsheets."""
    return "." in name, name


def _number(value: Value | None) -> float:
    return value if isinstance(value, float) else np.nan


SPAN = 1e9
"""Numbers of an only answer, and 1, that lie within this factor of one another are all of likely size."""


def unlikely(
    model: Model,
    answers: Sequence[Mapping[str, Value]],
    inputs: Mapping[str, Value],
    guesses: Mapping[str, float],
) -> list[tuple[str, ...]]:
    """Of each answer the names whose numbers are of unlikely size; ``answers`` hold the inputs as well."""
    if not answers or (len(answers) == 1 and not _spans(answers[0], guesses)):
        return [()] * len(answers)
    among = {name for values in answers for name in values}
    return Ranking(model, inputs, among, guesses).unlikely(answers, inputs)


def _spans(answer: Mapping[str, Value], guesses: Mapping[str, float]) -> bool:
    """Whether the largest number exceeds the smallest, or 1, by more than ``SPAN``."""
    numbers = [value for value in answer.values() if isinstance(value, float)]
    sizes = [abs(number) for number in (1.0, *numbers, *guesses.values()) if number]
    return max(sizes) / SPAN > min(sizes)
