"""A thousand random, ill-scaled, degenerate and hostile sheets: no crash, no hang, no false claim.

``benchmarks/hostile.py`` makes and judges them, and as many more as one has patience for.
"""

from __future__ import annotations

import warnings
from math import sin, sqrt

import pytest

from benchmarks import hostile_small
from benchmarks.brute_force import roots
from benchmarks.expressions import Undefined, evaluated
from benchmarks.hostile import _in_parts, examine, satisfied
from benchmarks.hostile_kinds import KINDS, sheet
from benchmarks.hostile_sheets import Dice, Sheet

UNLIMITED = 0.0
"""No alarm: what takes too long shows in the run of the suite."""
QUICK = 100
"""Seeds from here on are tried with ``-m slow``."""


@pytest.mark.parametrize(
    "first",
    [pytest.param(k, marks=() if k < QUICK else pytest.mark.slow) for k in range(0, 1000, 50)],
)
def test_hostile_sheets(first: int) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        outcomes = [examine(seed, UNLIMITED, most=2) for seed in range(first, first + 50)]
    assert [outcome.finding for outcome in outcomes if outcome.finding] == []


@pytest.mark.parametrize(
    "first",
    [
        30070,
        *(pytest.param(k, marks=pytest.mark.slow) for k in (30020, 30120, 30170, 31370, 31420)),
    ],
)
def test_small_sheets_at_special_points(first: int) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        outcomes = [
            examine(seed, UNLIMITED, 1, hostile_small.sheet) for seed in range(first, first + 50)
        ]
    assert [outcome.finding for outcome in outcomes if outcome.finding] == []


def test_there_are_small_sheets_of_every_kind() -> None:
    assert {hostile_small.sheet(seed).kind for seed in range(100)} == set(hostile_small.SMALL)


@pytest.mark.parametrize(
    ("rules", "expected"),
    [
        ((("", "x^2", "9.0"),), [-3.0, 3.0]),
        ((("", "1/x", "0.0"),), []),
        ((("", "(x - 3)^2", "0.0"),), [3.0]),
        ((("", "atand(cosh(x + 180))", "90.0"),), []),
        ((("", "int(x)", "2.5"),), []),
        ((("x > 0", "x^2", "4.0"), ("x <= 0", "x", "5.0")), [2.0]),
        ((("", "x^2", "4.0"), ("", "x + 1", "3.0")), [2.0]),
    ],
)
def test_brute_force_finds_roots_and_no_poles(
    rules: tuple[tuple[str, str, str], ...], expected: list[float]
) -> None:
    assert sorted(roots(Sheet("any", rules), "x")) == expected


def test_there_are_sheets_of_every_kind() -> None:
    assert {sheet(seed, 2).kind for seed in range(300)} == {
        KINDS[name](Dice(1, 2)).kind for name in KINDS
    }


def test_the_witness_sees_what_is_wrong() -> None:
    rule = ("", "x^2 + y", "7")
    assert satisfied(rule, {"x": 2.0, "y": 3.0})
    assert satisfied(rule, {"x": sqrt(5.0), "y": 2.0})
    assert not satisfied(rule, {"x": 2.0, "y": 3.0001})
    assert satisfied(("x < 0", "x^2 + y", "7"), {"x": 2.0, "y": 30.0})
    assert satisfied(("", "sind(x)", "z"), {"x": 180.0})
    assert not satisfied(("", "ln(x)", "1"), {"x": -2.0})
    assert satisfied(("", "(x - 2)^2", "tan(pi)"), {"x": 2.0})
    assert satisfied(
        ("", "(2/3 - x)^1.5", "0"), {"x": 2 / 3 + 2**-53}
    )  # the end lies between two floats
    assert not satisfied(("", "(2/3 - x)^1.5", "1e-5"), {"x": 2 / 3 + 2**-53})
    assert not satisfied(("", "ln(2/3 - x)", "0"), {"x": 2 / 3 + 2**-53})


@pytest.mark.parametrize(("y", "turns"), [(7.0, True), (2.0, False), (-8.0, True)])
def test_of_an_angle_that_is_read_in_parts_one_turn_is_listed(y: float, turns: bool) -> None:
    made = Sheet("planted", (("", "sin((y/3))", repr(sin(y / 3))),), planted={"y": y})
    assert _in_parts(made, "y") is turns
    plain = Sheet(
        "planted", (("", "sin(y)", repr(sin(y))), ("", "(y*y)", repr(y * y))), planted={"y": y}
    )
    assert not _in_parts(plain, "y")


def test_the_witness_refuses_what_is_not_real() -> None:
    for text in ("sqrt(-1)", "ln(0)", "1/0", "abs((-2)^0.5)", "acos(2)"):
        with pytest.raises(Undefined):
            evaluated(text, {})
    assert evaluated("sind(30) + 2^-1", {}) == 1
