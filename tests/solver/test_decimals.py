"""Texts of floats, a whole array at once, against ``repr`` one by one."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from solver.files.columns import Columns
from solver.files.csv_table import csv_rows
from solver.files.decimals import WIDTH, decimals


def texts(numbers: np.ndarray) -> list[str]:
    cells = np.zeros((len(numbers) + 1) * WIDTH, dtype=np.uint8)
    starts = np.arange(len(numbers)) * WIDTH
    lengths = decimals(numbers, cells, starts)
    return [
        cells[start : start + n].tobytes().decode() for start, n in zip(starts, lengths.tolist(), strict=True)
    ]


def expected(numbers: np.ndarray) -> list[str]:
    return ["" if x != x else repr(x + 0.0).removesuffix(".0") for x in numbers.tolist()]


@given(st.lists(st.floats(), min_size=1, max_size=50))
def test_any_float(numbers: list[float]) -> None:
    assert texts(np.array(numbers)) == expected(np.array(numbers))


@given(st.integers(-(10**17), 10**17), st.integers(0, 20), st.integers(-3, 3))
def test_short_decimals_and_their_neighbours(digits: int, places: int, steps: int) -> None:
    number = np.array([digits / 10.0**places])
    for _ in range(abs(steps)):
        number = np.nextafter(number, np.copysign(np.inf, steps))
    assert texts(number) == expected(number)


DRAW = np.random.default_rng(1)
MANY = {
    "all magnitudes": DRAW.standard_normal(20_000) * 10.0 ** DRAW.integers(-7, 19, 20_000),
    "all bits": DRAW.integers(0, 2**64, 20_000, dtype=np.uint64).view(float),
    "thousandths": np.arange(-10_000, 10_000) / 1000,
    "large integers": DRAW.integers(2**51, 10**16, 20_000).astype(float),
    "powers of two": np.concatenate([s * 2.0 ** np.arange(-40, 70) for s in (1, -1)]),
    "beside powers of two": np.nextafter(2.0 ** np.arange(-40, 70), 0),
    "beside powers of ten": np.nextafter(10.0 ** np.arange(-9, 20), [[0], [np.inf]]).ravel(),
}


@pytest.mark.parametrize("kind", MANY)
def test_many(kind: str) -> None:
    assert texts(MANY[kind]) == expected(MANY[kind])


@pytest.mark.parametrize("rows", [0, 1, 4095, 4096, 4097, 9000])
def test_lines_are_the_texts_joined(rows: int) -> None:
    values = {name: DRAW.standard_normal(rows) * 10.0 ** DRAW.integers(-6, 6, rows) for name in "abc"}
    values["b"][::7] = np.nan
    values["n"] = DRAW.integers(0, 5, rows)
    words = ("solved", "infeasible")
    status = DRAW.integers(0, 2, rows).astype(np.int8)
    cells = [expected(column.astype(float)) for column in values.values()]
    lines = (
        ",".join(row) + f",{words[code]}\n"
        for row, code in zip(zip(*cells, strict=True), status, strict=True)
    )
    assert csv_rows(Columns(values, status, words)).decode() == "".join(lines)
