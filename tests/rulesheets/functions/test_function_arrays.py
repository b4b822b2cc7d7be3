"""The array forms agree with the scalar ones."""

from __future__ import annotations

import math

import numpy as np
import pytest

from rulesheets.functions import ARRAYS, TABLE

POINTS = (-7.5, -2.5, -1.0, -0.5, -0.3, 0.0, 0.25, 0.5, 1.0, 1.5, 2.5, 3.7, 20.0)


@pytest.mark.parametrize("name", TABLE)
def test_agrees_with_the_scalar_form(name: str) -> None:
    count = max(TABLE[name].arity[0], 2 if TABLE[name].arity[1] is None else 0)
    grid = [axis.ravel() for axis in np.meshgrid(*[POINTS] * count)] if count else []
    with np.errstate(all="ignore"):
        results = np.broadcast_to(ARRAYS[name](*grid), grid[0].shape if grid else ())
    for row, result in zip(zip(*grid, strict=True), results.flat, strict=False):
        arguments = tuple(map(float, row))
        try:
            expected = TABLE[name].value(*arguments)
        except (ValueError, ZeroDivisionError, OverflowError):
            assert not math.isfinite(result), arguments
        else:
            assert result == pytest.approx(expected, rel=2e-14, abs=1e-300), arguments


def test_there_is_a_form_of_every_function() -> None:
    assert set(ARRAYS) == set(TABLE)
