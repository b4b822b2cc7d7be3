"""A column of a sweep as the caller gives it: numbers, symbols, and numbers that are lacking."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from solver.files.columns import Array

from rulesheets.inputs import is_symbol

_NUMBERS = "biuf"


def column_of(values: Any, name: str) -> Array:
    """Floats (n,), or objects where symbols are among them; a single value is a column of one.

    What is lacking is NaN, among symbols None.

    Raises ValueError for what is neither number nor symbol, and for what has more than one dimension.
    """
    column = _array(list(values) if isinstance(values, Iterator) else values, name)
    if column.ndim > 1:
        shape = "x".join(map(str, column.shape))
        raise ValueError(f"a column of a sweep has one dimension, and that of {name} is {shape}")
    column = np.atleast_1d(column)
    if column.dtype.kind in _NUMBERS:
        return column.astype(float, copy=False)
    plain = [_plain(value, name) for value in column.tolist()]
    if any(isinstance(value, str) for value in plain):
        return np.array(plain, dtype=object)
    return np.array([np.nan if value is None else value for value in plain], dtype=float)


def _array(values: Any, name: str) -> Array:
    """What the values are, numbers among symbols included (numpy would make texts of them)."""
    try:
        column = np.asarray(values)
        return column if column.dtype.kind in _NUMBERS else np.asarray(values, dtype=object)
    except ValueError:
        raise ValueError(f"the values of {name} are no column: there are lists among them") from None


def _plain(value: Any, name: str) -> float | str | None:
    if value is None:
        return None
    if isinstance(value, str):
        if not is_symbol(value):
            raise ValueError(
                f"{value!r} is no value for {name}: a text is read as a symbol, and this is none"
            )
        return value.removeprefix("'")
    try:
        return float(value)
    except (TypeError, ValueError):
        raise ValueError(f"{value!r} is no value for {name}: neither a number nor a symbol") from None
