"""The functions of the language on numpy arrays.

Arguments broadcast; outside its domain a function gives nan or inf. Callers silence numpy's
floating point warnings (``numpy.errstate``).
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from importlib import import_module
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from rulesheets.functions import TABLE
from rulesheets.functions.row import Forms, Function

Array: TypeAlias = NDArray[np.float64]


def _form(row: Function) -> Callable[..., Array]:
    if row.array is None:
        return partial(_one_by_one, row.value)
    if callable(row.array):
        return partial(row.array, np)
    module, _, name = row.array.rpartition(".")  # special.… is scipy's, imported on demand
    form: Callable[..., Array]
    form = getattr(import_module(f"scipy.{module}") if module else np, name)
    return form


def _one_by_one(value: Callable[..., float], *arguments: Any) -> Array:
    """A function of floats on arrays, nan where it raises."""

    def at(*numbers: float) -> float:
        try:
            return value(*numbers)
        except (ArithmeticError, ValueError):
            return np.nan

    if not arguments:
        return np.asarray(value())
    arrays = np.broadcast_arrays(*arguments)
    rows = zip(*(np.ravel(array).tolist() for array in arrays), strict=True)
    return np.array([at(*row) for row in rows], dtype=float).reshape(arrays[0].shape)


ARRAYS = Forms(TABLE, _form)
"""Every function of the table on arrays, by name."""
