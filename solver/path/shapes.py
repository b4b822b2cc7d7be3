"""Rules of one shape, with their names and numbers on arrays: for blocks of many rules."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rulesheets.model import Equation, Model, once
from solver.numerics.linear_algebra import Array
from solver.path.graph import by_shape, occurrences, shape_of


class Family(NamedTuple):
    """Rules of one shape: their ``places`` (m,) among all rules, the first of them, the ``columns``
    (k, m) of its names, in order of first appearance, as places among all names, and their
    ``numbers`` (c, m), in the order of the text."""

    places: NDArray[np.intp]
    first: Equation
    columns: NDArray[np.intp]
    numbers: Array


def same_columns(
    pattern: NDArray[np.bool_],
) -> Iterator[tuple[NDArray[np.bool_], NDArray[np.intp]]]:
    """The different columns of a pattern (k, m), each with its places."""
    packed = np.ascontiguousarray(np.packbits(pattern, axis=0).T)
    groups: dict[bytes, list[int]] = {}
    for place, key in enumerate(
        packed.view(f"V{packed.shape[1]}").ravel().tolist() if packed.size else ()
    ):
        groups.setdefault(key, []).append(place)
    for places in groups.values():
        yield pattern[:, places[0]], np.array(places, dtype=np.intp)


class Alike(NamedTuple):
    """Rules by their shapes, in order of first appearance, and the names that they read."""

    names: tuple[str, ...]
    families: tuple[Family, ...]


class Shapes:
    """All rules of a model by shape, with the ``family`` of each and its place in ``member``."""

    def __init__(self, model: Model) -> None:
        self.equations, self.names = model.equations, tuple(model.variables)
        occurs = occurrences(model)
        self.family, self.member = np.empty((2, len(self.equations)), dtype=np.intp)
        self.families = []
        for number, rules in enumerate(by_shape(model)):
            places, count = [rule.index for rule in rules], len(rules)
            self.family[places], self.member[places] = number, np.arange(count)
            read = np.array([occurs[place] for place in places], dtype=np.intp).reshape(count, -1).T
            told = np.array([shape_of(rule)[1] for rule in rules], dtype=float).reshape(count, -1).T
            self.families.append(Family(np.array(places, dtype=np.intp), rules[0], read, told))
        self.kept: dict[tuple[int, ...], Alike] = {}

    def of(self, equations: Sequence[Equation]) -> Alike:
        key = tuple([equation.index for equation in equations])
        if key in self.kept:
            return self.kept[key]
        chosen = np.array(key, dtype=np.intp)
        order = np.argsort(of := self.family[chosen], kind="stable")
        numbers, starts = np.unique(of[order], return_index=True)
        families = []
        for number, places in zip(numbers.tolist(), np.split(order, starts[1:]), strict=True):
            every, members = self.families[number], self.member[chosen[places]]
            first = self.equations[chosen[places[0]]]
            families.append(
                Family(places, first, every.columns[:, members], every.numbers[:, members])
            )
        columns = [family.columns.ravel() for family in families]
        read = np.unique(np.concatenate([np.empty(0, dtype=np.intp), *columns]))
        names = tuple([self.names[column] for column in read.tolist()])
        within = (
            family._replace(columns=np.searchsorted(read, family.columns)) for family in families
        )
        self.kept[key] = Alike(names, tuple(within))
        return self.kept[key]


shapes = once(Shapes)
