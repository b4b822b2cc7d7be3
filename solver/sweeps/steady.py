"""A plan that solves pieces of a sweep alike, whatever it has solved before.

A plan makes records of the rows that it meets, and a row comes out of a record with other last
bits than out of the full solve that it was made from. So records are made of ``lessons``, some rows
of the whole sweep, before the first piece, and what a piece teaches beyond is forgotten after it: its
numbers depend on nothing but itself.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from rulesheets.model import Model, Value
from solver.files.columns import Array
from solver.plan import Plan
from solver.result import Status
from solver.trace.rows import Answers


@dataclass(frozen=True)
class Pattern:
    """What is the same for all rows of a plan: its inputs and outputs, and the inputs that are fixed.

    With ``jit`` its records are compiled to machine code.
    """

    model: Model
    inputs: tuple[str, ...]
    want: tuple[str, ...]
    given: Mapping[str, Value]
    guesses: Mapping[str, float]
    jit: bool = False


class SteadyPlan:
    """Solves pieces of one pattern, every one by the same records."""

    def __init__(self, pattern: Pattern, lessons: Sequence[Array]) -> None:
        self._plan = Plan(pattern.model, pattern.inputs, pattern.want, pattern.given, pattern.guesses)
        self._jit = pattern.jit
        if lessons and len(lessons[0]):
            self._plan.sweep(*lessons, jit=pattern.jit)
        self._known = self._plan.records.mark()

    def _forget(self) -> None:
        """Go back to what the lessons taught."""
        self._plan.records.forget(self._known)

    def every(self, columns: Sequence[Array]) -> tuple[NDArray[np.int8], Answers]:
        """The status codes of the rows and all their answers, for one or more columns (n,) of numbers."""
        self._forget()
        return self._plan.sweep_all(*columns, jit=self._jit)

    def alone(self) -> tuple[Status, list[tuple[Value, ...]]]:
        """The status of the one row of a plan without inputs, and its answers, the primary first."""
        self._forget()
        return self._plan.outcome(())


class SteadyPlans:
    """Plans by the symbols of a row: a symbol that is swept is fixed in a plan of its own."""

    def __init__(self, pattern: Pattern, lessons: Sequence[Array]) -> None:
        self._pattern = pattern
        self._lessons = tuple(lessons) or tuple(np.zeros(0) for _ in pattern.inputs)
        self._plans: dict[tuple[str | None, ...], SteadyPlan] = {}

    @property
    def want(self) -> tuple[str, ...]:
        return self._pattern.want

    def groups(self, columns: Sequence[Array]) -> list[tuple[SteadyPlan, NDArray[np.intp], list[Array]]]:
        """The rows by their plans: which they are, and their columns of numbers."""
        symbols = _symbols(columns)
        if symbols is None:
            everything = np.arange(len(columns[0]) if columns else 1)
            return [(self._plan((None,) * len(columns)), everything, list(columns))]
        rows: dict[tuple[str | None, ...], list[int]] = {}
        for row, key in enumerate(symbols):
            rows.setdefault(key, []).append(row)
        return [(self._plan(k), np.array(found), _numbers(columns, k, found)) for k, found in rows.items()]

    def _plan(self, key: tuple[str | None, ...]) -> SteadyPlan:
        if key not in self._plans:
            symbols = _symbols(self._lessons)
            if symbols is None:
                symbols = [(None,) * len(key)] * len(self._lessons[0])
            lessons = _numbers(self._lessons, key, [row for row, other in enumerate(symbols) if other == key])
            fixed = {n: s for n, s in zip(self._pattern.inputs, key, strict=True) if s is not None}
            names = tuple(name for name in self._pattern.inputs if name not in fixed)
            given = {**self._pattern.given, **fixed}
            self._plans[key] = SteadyPlan(replace(self._pattern, inputs=names, given=given), lessons)
        return self._plans[key]


def _symbols(columns: Sequence[Array]) -> list[tuple[str | None, ...]] | None:
    """The symbols of each row, None at the place of a number; None where no column has any."""
    if all(column.dtype != object for column in columns):
        return None
    kinds = [
        [value if isinstance(value, str) else None for value in column.tolist()]
        if column.dtype == object
        else [None] * len(column)
        for column in columns
    ]
    return list(zip(*kinds, strict=True))


def _numbers(columns: Sequence[Array], key: tuple[str | None, ...], rows: list[int]) -> list[Array]:
    return [column[rows].astype(float) for column, symbol in zip(columns, key, strict=True) if symbol is None]
