"""Rows that cannot be asked at all: they get a status, and their neighbours never notice."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from rulesheets.model import Variable
from solver.files.columns import Array
from solver.result import CODES, Status


def refusals(columns: Sequence[Array], inputs: Sequence[Variable]) -> NDArray[np.int8]:
    """The status code of each row (n,), 0 where it can be asked.

    A row that lacks an input (blank, NaN, infinite) is ``partial``, one with an input outside the
    declared range ``infeasible``: no solution lies in the range.
    """
    codes = np.zeros(len(columns[0]) if columns else 1, dtype=np.int8)
    lacking = np.zeros(len(codes), dtype=bool)
    for column, variable in zip(columns, inputs, strict=True):
        numbers = _numbers(column)
        lacking |= ~np.isfinite(numbers) & ~_symbols(column)
        codes[_outside(numbers, variable)] = CODES[Status.INFEASIBLE]
    codes[lacking] = CODES[Status.PARTIAL]
    return codes


def _numbers(column: Array) -> Array:
    """The column as floats, NaN for nothing."""
    if column.dtype != object:
        return column
    return np.array([np.nan if v is None or isinstance(v, str) else v for v in column.tolist()])


def _symbols(column: Array) -> NDArray[np.bool_]:
    if column.dtype != object:
        return np.zeros(len(column), dtype=bool)
    return np.array([isinstance(value, str) for value in column.tolist()], dtype=bool)


def _outside(numbers: Array, variable: Variable) -> NDArray[np.bool_]:
    """A symbol lies outside of no range, nor does what is missing."""
    below = numbers <= variable.low if variable.low_open else numbers < variable.low
    above = numbers >= variable.high if variable.high_open else numbers > variable.high
    return np.asarray(below | above)
