"""Calls of a plan with what it does not take: a TypeError that names the argument and says what is
right."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
import pytest

import rulesheets
import solver

MODEL = rulesheets.loads(
    "variables\n  x [deg]\n  y\n  mode\n  z\nrules\n  if mode = 'open then z = x + y else z = x - "
    "y\n"
)


class Cell:
    """A column of one number, as numpy before 2.4 has it: a number of it is deprecated."""

    ndim = 1

    def __len__(self) -> int:
        return 1

    def __float__(self) -> float:
        warnings.warn("a column is no number", DeprecationWarning, stacklevel=2)
        return 1.0


@pytest.fixture(params=[0, 3], ids=["at first", "once it is compiled"])
def plan(request: pytest.FixtureRequest) -> Any:
    prepared = solver.prepare(MODEL, ["x", "y"], ["z"], {"mode": "open"})
    for _ in range(request.param):
        prepared(1.0, 2.0)
    return prepared


@pytest.mark.parametrize(
    ("given", "named"),
    [
        ((1.0, 2.0), {}),
        ((1, np.float64(2)), {}),
        ((np.float32(1), True + True), {}),
        ((1.0,), {"y": 2.0}),
        ((), {"y": 2, "x": 1}),
    ],
)
def test_numbers_by_place_and_by_name(
    plan: Any, given: tuple[Any, ...], named: dict[str, Any]
) -> None:
    assert plan(*given, **named) == (3.0,)
    assert plan.all(*given, **named) == [(3.0,)]


@pytest.mark.parametrize(
    ("given", "named", "said"),
    [
        ((), {}, "no value is given for x, y; this plan takes x, y"),
        ((1.0,), {}, "no value is given for y"),
        ((1.0, 2.0, 3.0), {}, "takes 2 inputs (x, y), and 3 were given"),
        ((1.0, 2.0), {"y": 3.0}, "y is given twice"),
        ((1.0,), {"Y": 3.0}, "Y is no input of this plan, which takes x, y; did you mean y?"),
        ((1.0, 2.0), {"mode": "open"}, "mode is no input of this plan"),
        (("1.5", 2.0), {}, "'1.5' is not a valid value for x: a text is read as a symbol"),
        (("open", 2.0), {}, "x is a number, and 'open' a symbol"),
        ((None, 2.0), {}, "nan to have it solved"),
        (
            ([1.0], 2.0),
            {},
            "(nan to have it solved; sweep takes columns), not list",
        ),
        ((np.array([1.0]), 2.0), {}, "not ndarray"),
        ((Cell(), 2.0), {}, "not Cell"),
        ((1j, 2.0), {}, "not complex"),
    ],
)
def test_what_a_plan_does_not_take(
    plan: Any, given: tuple[Any, ...], named: dict[str, Any], said: str
) -> None:
    for call in (plan, plan.all):
        with pytest.raises(TypeError) as refused:
            call(*given, **named)
        assert said in str(refused.value)


def test_symbols_with_and_without_an_apostrophe() -> None:
    plan = solver.prepare(MODEL, ["x", "mode"], ["z"], {"y": 1.0})
    for _ in range(3):
        assert plan(1.0, "open") == plan(1.0, "'open") == plan(1.0, mode="open") == (2.0,)
        assert plan(1.0, "closed") == (0.0,)


def test_a_plan_without_inputs_takes_nothing() -> None:
    plan = solver.prepare(rulesheets.loads("a = 2\nb = a^2\n"), [], ["b"])
    for _ in range(3):
        assert plan() == (4.0,)
        with pytest.raises(TypeError, match="takes no input"):
            plan(1.0)


@pytest.mark.parametrize("given", [np.complex64(1 + 2j), np.complex128(1), b"3", bytearray(b"3")])
def test_numbers_with_two_parts_and_bytes_are_no_numbers(plan: Any, given: Any) -> None:
    with pytest.raises(TypeError, match="x takes a number"):
        plan(given, 2.0)


@pytest.mark.parametrize("infinite", [np.inf, -np.inf])
def test_an_infinite_number_is_no_missing_one(infinite: float) -> None:
    """What is nan is solved for, by the other rule: a is 6. A number that has overflowed is not."""
    model = rulesheets.loads("variables\n  a = 1\n  b = 2\nrules\n  c = a + b\n  a = 3*b\n")
    plan = solver.prepare(model, ["a"], ["c"])
    assert plan(6.0) == plan(np.nan) == (8.0,)
    for ask in (plan, plan.all):
        with pytest.raises(solver.Unsolved, match=r"a = -?inf is not finite") as refused:
            ask(infinite)
        assert str(refused.value.status) == "partial"
    table = plan.sweep([6.0, infinite, np.nan])
    assert table["c"].tolist() == pytest.approx([8.0, np.nan, 8.0], nan_ok=True)
    assert [int(code) for code in table.status] == [0, 1, 0]
