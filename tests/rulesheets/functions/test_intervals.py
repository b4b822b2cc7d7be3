"""Interval forms contain every value on a box (mpmath is the judge), and not much more."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest

from rulesheets.evaluate.digits import Digits, context
from rulesheets.functions import INTERVALS, TABLE
from rulesheets.functions.intervals import add, divide, multiply, power, ratio

MP = context(40)
EXACT = Digits({}, 40).functions
INF = math.inf
BOXES = 40
SPECIAL = (
    -1000.0,
    -360.0,
    -90.0,
    -2.0,
    -1.0,
    -0.5,
    -0.0,
    0.0,
    1e-300,
    0.5,
    1.0,
    2.0,
    3.0,
    45.0,
    90.0,
    180.0,
    1e6,
)
WHOLE = ("jn", "yn")


def ends(random: np.random.Generator, boxes: int, tiny: bool) -> tuple[np.ndarray, np.ndarray]:
    """Random boxes of all sizes, some with ends where something happens."""
    middle = random.normal(size=boxes) * 10.0 ** random.uniform(-3, 2, boxes)
    width = np.abs(random.normal(size=boxes)) * 10.0 ** random.uniform(
        -12 if tiny else -3, 1, boxes
    )
    low, high = middle - width, middle + width
    special = random.choice(SPECIAL, boxes)
    low = np.where(random.random(boxes) < 0.2, special, low)
    high = np.where(random.random(boxes) < 0.2, random.choice(SPECIAL, boxes), high)
    return np.minimum(low, high), np.maximum(low, high)


def point_in(random: np.random.Generator, low: float, high: float) -> float:
    """A point of the box, an end as often as not."""
    choice = random.random()
    if choice < 0.25:
        return low
    return high if choice < 0.5 else min(max(random.uniform(low, high), low), high)


def assert_contains(
    name: str,
    form: Callable[..., tuple[float, float]],
    exact: Callable[..., object],
    count: int,
    seed: int,
    whole: bool = False,
) -> None:
    random = np.random.default_rng(seed)
    boxes = [ends(random, BOXES, tiny=seed % 2 == 0) for _ in range(count)]
    if whole:
        order = random.integers(-4, 5, BOXES).astype(float)
        boxes[0] = (order, order)
    for index in range(BOXES):
        low, high = form(*(float(end[index]) for box in boxes for end in box))
        for _ in range(3):
            point = [point_in(random, float(box[0][index]), float(box[1][index])) for box in boxes]
            try:
                value = exact(*map(MP.mpf, point))
            except (ValueError, ZeroDivisionError, OverflowError):
                continue
            assert MP.mpf(low) <= value <= MP.mpf(high), (name, point, low, high)


def real_power(x: object, y: object) -> object:
    if (x < 0 and y != int(y)) or (x == 0 and y < 0):  # type: ignore[operator, call-overload]
        raise ValueError
    return x**y  # type: ignore[operator]


@pytest.mark.parametrize("seed", [1, 2])
@pytest.mark.parametrize("name", TABLE)
def test_contains_every_value(name: str, seed: int) -> None:
    count = TABLE[name].arity[1]
    count = 3 if count is None else count
    assert_contains(name, INTERVALS[name], EXACT[name], count, seed, whole=name in WHOLE)


@pytest.mark.parametrize("seed", range(1, 9))
def test_arithmetic_contains_every_value(seed: int) -> None:
    assert_contains("add", add, lambda x, y: x + y, 2, seed)
    assert_contains("multiply", multiply, lambda x, y: x * y, 2, seed)
    assert_contains("divide", divide, lambda x, y: x / y, 2, seed)
    assert_contains("power", power, real_power, 2, seed)
    assert_contains("ratio", ratio, lambda x, y: x / MP.hypot(x, y), 2, seed)


@pytest.mark.parametrize("exponent", [-3.0, -2.0, -1.0, 0.0, 0.5, 1.0, 1.5, 2.0, 3.0, 4.0, -0.5])
def test_powers_contain_every_value(exponent: float) -> None:
    assert_contains(
        f"power {exponent}",
        lambda low, high: power(low, high, exponent, exponent),
        lambda x: real_power(x, MP.mpf(exponent)),
        1,
        3,
    )


@pytest.mark.parametrize(
    ("name", "arguments", "expected"),
    [
        ("sqrt", (-4.0, 9.0), (0.0, 3.0)),
        ("abs", (-4.0, 3.0), (0.0, 4.0)),
        ("sind", (0.0, 90.0), (0.0, 1.0)),
        ("sind", (10.0, 20.0), (math.sin(math.radians(10)), math.sin(math.radians(20)))),
        ("cosd", (-30.0, 60.0), (0.5, 1.0)),
        ("cosd", (100.0, 300.0), (-1.0, 0.5)),
        ("cos", (3.0, 3.2), (-1.0, math.cos(3.0))),
        ("sin", (-INF, 1.0), (-1.0, 1.0)),
        ("tand", (-45.0, 45.0), (-1.0, 1.0)),
        ("tand", (45.0, 90.0), (1.0, INF)),
        ("tand", (90.0, 135.0), (-INF, -1.0)),
        ("tand", (45.0, 135.0), (-INF, INF)),
        ("ln", (-1.0, 1.0), (-INF, 0.0)),
        ("exp", (-INF, 0.0), (0.0, 1.0)),
        ("acosd", (-2.0, 0.5), (60.0, 180.0)),
        ("atan2d", (-1.0, 1.0, 1.0, 2.0), (-45.0, 45.0)),
        ("atan2d", (1.0, 2.0, -1.0, 1.0), (45.0, 135.0)),
        ("atan2d", (-1.0, 1.0, -2.0, -1.0), (-180.0, 180.0)),
        ("atan2d", (0.0, 1.0, -2.0, -1.0), (135.0, 180.0)),
        ("cosh", (-1.0, 2.0), (1.0, math.cosh(2.0))),
        ("int", (-1.5, 2.5), (-1.0, 2.0)),
        ("frac", (3.25, 3.5), (0.25, 0.5)),
        ("frac", (-1.5, 0.25), (-1.0, 0.25)),
        ("mod", (370.0, 380.0, 360.0, 360.0), (10.0, 20.0)),
        ("step", (0.0, 1.0, 2.0, 3.0), (0.0, 0.0)),
        ("min", (0.0, 5.0, 2.0, 3.0), (0.0, 3.0)),
        ("erf", (-INF, INF), (-1.0, 1.0)),
        ("i0", (-1.0, 0.5), (1.0, 1.2660658777520084)),
    ],
)
def test_tight(name: str, arguments: tuple[float, ...], expected: tuple[float, float]) -> None:
    low, high = INTERVALS[name](*arguments)
    assert (low, high) == pytest.approx(expected, rel=1e-12, abs=1e-12)


@pytest.mark.parametrize(
    ("form", "arguments", "expected"),
    [
        (add, (1.0, 2.0, -1.0, 3.0), (0.0, 5.0)),
        (add, (-INF, 2.0, 1.0, 3.0), (-INF, 5.0)),
        (multiply, (0.0, 0.0, -INF, INF), (0.0, 0.0)),
        (multiply, (-2.0, 3.0, -5.0, 4.0), (-15.0, 12.0)),
        (divide, (1.0, 2.0, 4.0, 8.0), (0.125, 0.5)),
        (divide, (1.0, 2.0, 0.0, 4.0), (0.25, INF)),
        (divide, (1.0, 2.0, -4.0, 0.0), (-INF, -0.25)),
        (divide, (-1.0, 2.0, -4.0, 1.0), (-INF, INF)),
        (divide, (1.0, INF, 1.0, INF), (0.0, INF)),
        (power, (-2.0, 3.0, 2.0, 2.0), (0.0, 9.0)),
        (power, (-2.0, 3.0, 3.0, 3.0), (-8.0, 27.0)),
        (power, (2.0, 4.0, -1.0, -1.0), (0.25, 0.5)),
        (power, (-4.0, 9.0, 0.5, 0.5), (0.0, 3.0)),
        (power, (4.0, 9.0, -0.5, 0.5), (1 / 3, 3.0)),
        (power, (-4.0, 9.0, 0.0, 0.0), (1.0, 1.0)),
    ],
)
def test_arithmetic_is_tight(
    form: Callable[..., tuple[float, float]],
    arguments: tuple[float, ...],
    expected: tuple[float, float],
) -> None:
    low, high = form(*arguments)
    assert (low, high) == pytest.approx(expected, rel=1e-14, abs=1e-300)


@pytest.mark.parametrize(
    ("name", "arguments"),
    [
        ("sqrt", (-2.0, -1.0)),
        ("ln", (-2.0, -1.0)),
        ("asind", (1.5, 2.0)),
        ("acosh", (-1.0, 0.5)),
        ("atan2d", (0.0, 0.0, 0.0, 0.0)),
        ("tand", (90.0, 90.0)),
        ("mod", (1.0, 2.0, 0.0, 0.0)),
    ],
)
def test_empty_outside_the_domain(name: str, arguments: tuple[float, ...]) -> None:
    assert np.isnan(INTERVALS[name](*arguments)).all()


def test_division_by_zero_alone_is_empty() -> None:
    assert np.isnan(divide(1.0, 2.0, 0.0, 0.0)).all()
    assert np.isnan(power(0.0, 0.0, -1.0, -1.0)).all()
    assert np.isnan(power(-2.0, -1.0, 0.5, 0.5)).all()


@pytest.mark.parametrize("name", [name for name in TABLE if TABLE[name].arity != (0, 0)])
def test_empty_arguments_stay_empty(name: str) -> None:
    count = max(TABLE[name].arity[0], 1)
    for place in range(count):
        ends = [1.0] * (2 * count)
        ends[2 * place : 2 * place + 2] = [math.nan] * 2
        assert all(map(math.isnan, INTERVALS[name](*ends)))


def test_there_is_a_form_of_every_function() -> None:
    assert set(INTERVALS) == set(TABLE)


@pytest.mark.parametrize(
    ("name", "point"),
    [
        ("erfc", (26.63,)),
        ("erfc", (26.65,)),
        ("erfc", (27.0,)),
    ],
)
def test_contains_the_value_next_to_overflow_and_underflow(
    name: str, point: tuple[float, ...]
) -> None:
    """Where the libraries lose digits, or are infinite or 0 before the function is."""
    exact = EXACT[name](*map(MP.mpf, point))
    ends = [end for x in point for end in (x, x)]
    low, high = INTERVALS[name](*ends)
    assert MP.mpf(low) <= exact <= MP.mpf(high)


@pytest.mark.parametrize("name", ["pi", "e"])
def test_constants_lie_within(name: str) -> None:
    low, high = INTERVALS[name]()
    assert low < EXACT[name]() < high == math.nextafter(low, INF)


def test_an_end_that_nothing_is_known_of_leaves_no_false_bound() -> None:
    assert multiply(2.0, math.nan, 1.0, 1.0) == (-INF, INF)
    assert divide(1.0, 1.0, 2.0, math.nan) == (-INF, INF)
    assert INTERVALS["abs"](-1.0, math.nan) == (0.0, INF)
    assert INTERVALS["sin"](1.0, math.nan) == (-1.0, 1.0)


HOSTILE = (-INF, -1e308, -2.0, -1e-200, -5e-324, -0.0, 0.0, 5e-324, 1e-200, 0.5, 2.0, 1e308, INF)


@pytest.mark.parametrize("form", [multiply, divide], ids=["multiply", "divide"])
def test_contains_the_results_of_its_corners(form: Callable[..., tuple[float, float]]) -> None:
    """Ends that overflow, underflow or are zeros with a sign: signs of the operands are kept,
    too."""
    boxes = [
        (low, high)
        for low in HOSTILE
        for high in HOSTILE
        if low <= high and INF not in (low, -high)
    ]
    for a in boxes:
        for b in boxes:
            low, high = form(*a, *b)
            if form is divide and b[0] == b[1] == 0.0:
                assert math.isnan(low) and math.isnan(high)
                continue
            for x in map(MP.mpf, a):
                for y in map(MP.mpf, b):
                    if MP.isfinite(x) and MP.isfinite(y) and (y != 0 or form is multiply):
                        assert low <= (x * y if form is multiply else x / y) <= high
            assert low >= 0.0 or not ((a[0] >= 0 and b[0] >= 0) or (a[1] <= 0 and b[1] <= 0))
            assert high <= 0.0 or not ((a[0] >= 0 and b[1] <= 0) or (a[1] <= 0 and b[0] >= 0))
