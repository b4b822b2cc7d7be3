"""Every row of the table against mpmath: value, derivatives, inverse."""

from __future__ import annotations

import itertools
import math

import mpmath
import numpy as np
import pytest

from rulesheets.evaluate import Undefined, value
from rulesheets.evaluate.digits import Digits, context
from rulesheets.functions import ARRAYS, PLANNED, TABLE
from rulesheets.functions.row import Inverse
from rulesheets.syntax.nodes import Call, Name, Number

# Arguments at which a function is smooth; those of one argument are tried at each, of two at each
# pair.
ANYWHERE = (-2.3, -0.4, 0.7, 3.1)
UNIT = (-0.9, -0.2, 0.3, 0.8)
POSITIVE = (0.2, 0.9, 1.7, 6.5)
SAMPLES: dict[str, tuple[tuple[float, ...], ...]] = {
    **dict.fromkeys(("pi", "e"), ((),)),
    **{
        name: tuple((x,) for x in ANYWHERE)
        for name in (
            *("abs", "sgn", "int", "frac", "round", "exp", "sin", "cos", "tan", "atan"),
            *("sinh", "cosh", "tanh", "asinh", "sind", "cosd", "tand", "atand"),
            *("gamma", "lgamma", "digamma", "erf", "erfc", "j0", "j1", "i0", "bessel_i1"),
        )
    },
    **{name: tuple((x,) for x in UNIT) for name in ("asin", "acos", "atanh", "asind", "acosd")},
    **{
        name: tuple((x,) for x in POSITIVE)
        for name in ("sqrt", "ln", "log", "log10", "y0", "y1", "k0", "bessel_k1")
    },
    "acosh": ((1.2,), (7.0,)),
    "erfinv": ((-0.9,), (0.3,)),
    "erfcinv": ((0.2,), (1.7,)),
    **{
        name: tuple((x, y) for x in ANYWHERE for y in (-1.9, 0.6, 5.2))
        for name in ("mod", "step", "min", "max", "atan2", "atan2d")
    },
    "beta": ((0.5, 2.5), (3.0, 4.0)),
    **dict.fromkeys(("jn", "yn"), ((0.0, 1.3), (1.0, 2.2), (3.0, 0.8), (-2.0, 4.0))),
}
EXACT = Digits({}, 50).functions
MP = context(50)
CASES = [(name, sample) for name in TABLE for sample in SAMPLES[name]]


@pytest.mark.parametrize(("name", "arguments"), CASES)
def test_value(name: str, arguments: tuple[float, ...]) -> None:
    exact = float(EXACT[name](*map(MP.mpf, arguments)))
    assert TABLE[name].value(*arguments) == pytest.approx(exact, rel=4e-15, abs=1e-16)


@pytest.mark.parametrize(("name", "arguments"), CASES)
def test_derivatives(name: str, arguments: tuple[float, ...]) -> None:
    trees = TABLE[name].partials(tuple(map(Number, arguments)))
    assert len(trees) == len(arguments)
    for place, tree in enumerate(trees):
        if name in ("jn", "yn") and place == 0:
            continue
        exact = central_difference(name, arguments, place)
        rounding = 1e-13 if TABLE[name].slopes else 1e-8
        assert value(tree, {}) == pytest.approx(float(exact), rel=rounding, abs=rounding)


def central_difference(name: str, arguments: tuple[float, ...], place: int) -> mpmath.mpf:
    """Slope to 25 digits from two values to 50."""
    step = MP.mpf(10) ** -13
    sides = []
    for sign in (1, -1):
        shifted = [MP.mpf(argument) for argument in arguments]
        shifted[place] += sign * step
        sides.append(EXACT[name](*shifted))
    return (sides[0] - sides[1]) / (2 * step)


@pytest.mark.parametrize("name", [name for name in TABLE if TABLE[name].inverse])
@pytest.mark.parametrize("target", [-1.4, -0.75, 0.25, 0.5, 1.25, 1.5])
def test_every_branch_is_a_solution(name: str, target: float) -> None:
    inverse = TABLE[name].inverse
    assert inverse is not None
    if _reaches(inverse, target):
        for branch in inverse.branches(Name("t")):
            assert TABLE[name].value(value(branch, {"t": target})) == pytest.approx(
                target, rel=1e-12
            )


@pytest.mark.parametrize(
    "name", [name for name, row in TABLE.items() if row.inverse and row.inverse.period]
)
def test_branches_are_all_solutions_of_a_period(name: str) -> None:
    row = TABLE[name]
    assert row.inverse is not None and row.inverse.period is not None
    period, target = row.inverse.period, 0.3
    found = sorted(
        value(branch, {"t": target}) % period for branch in row.inverse.branches(Number(target))
    )
    points = [period * (k + 0.01) / 3600 for k in range(3601)]
    crossings = [
        left
        for left, right in itertools.pairwise(points)
        if (row.value(left) - target) * (row.value(right) - target) < 0 and abs(row.value(left)) < 2
    ]
    assert found == pytest.approx(crossings, abs=period / 3000)


def test_images_are_exact() -> None:
    reached = {
        ("sqrt", 0.0): True,
        ("sqrt", -1e-300): False,
        ("exp", 0.0): False,
        ("cosh", 1.0): True,
        ("tanh", 1.0): False,
        ("cosd", -1.0): True,
        ("cosd", 1.0000000000000002): False,
        ("asind", 90.0): True,
        ("atand", 90.0): False,
        ("acosd", 180.0): True,
        ("ln", -1e9): True,
    }
    for (name, target), expected in reached.items():
        inverse = TABLE[name].inverse
        assert inverse is not None and _reaches(inverse, target) is expected, name


@pytest.mark.parametrize(
    "name", [name for name, row in TABLE.items() if row.domain != (-math.inf, math.inf)]
)
def test_domains(name: str) -> None:
    low, high = TABLE[name].domain
    for outside in (math.nextafter(low, -math.inf), math.nextafter(high, math.inf)):
        if math.isfinite(outside):
            with pytest.raises(ValueError):
                TABLE[name].value(outside)
    inside = low + 0.5 if math.isinf(high) else 0.5 * (low + high)
    assert math.isfinite(TABLE[name].value(inside))


def test_conventions_of_the_parts_of_a_number() -> None:
    value_of = {name: TABLE[name].value for name in TABLE}
    assert [value_of["int"](x) for x in (-2.7, 2.7)] == [-2.0, 2.0]
    assert [value_of["frac"](x) for x in (-2.75, 2.75)] == [-0.75, 0.75]
    assert [value_of["round"](x) for x in (-2.5, -0.5, 0.5, 0.49999999999999994, 1.5, 2.5)] == [
        *(-3.0, -1.0, 1.0, 0.0, 2.0, 3.0)
    ]
    assert [value_of["mod"](*pair) for pair in ((7.0, 3.0), (-7.0, 3.0), (7.0, -3.0))] == [
        1.0,
        -1.0,
        1.0,
    ]
    assert [value_of["sgn"](x) for x in (-0.1, 0.0, 9.0)] == [-1.0, 0.0, 1.0]
    assert [value_of["step"](*pair) for pair in ((1.0, 1.0), (0.9, 1.0))] == [1.0, 0.0]
    assert value_of["max"](1.0, 4.0, 2.0) == 4.0


@pytest.mark.parametrize(
    ("name", "arguments"),
    [
        ("sqrt", (-1.0,)),
        ("ln", (0.0,)),
        ("exp", (1000.0,)),
        ("mod", (1.0, 0.0)),
        ("atan2", (0.0, 0.0)),
        ("gamma", (-1.0,)),
        ("beta", (-1.0, 0.5)),
        ("jn", (0.5, 1.0)),
        ("y0", (0.0,)),
        ("k0", (-1.0,)),
    ],
)
def test_outside_the_domain_there_is_no_value(name: str, arguments: tuple[float, ...]) -> None:
    with pytest.raises(Undefined) as caught:
        value(Call(name, tuple(map(Number, arguments))), {})
    assert caught.value.operation == name
    assert caught.value.arguments == arguments


def test_the_table_is_whole() -> None:
    assert set(SAMPLES) == set(TABLE) == set(EXACT)
    assert all(name == row.name == name.lower() for name, row in TABLE.items())
    assert not PLANNED & set(TABLE)
    assert TABLE["max"].accepts(5) and not TABLE["max"].accepts(0) and not TABLE["atan2"].accepts(1)


def test_no_function_of_the_language_is_computed_number_by_number_on_arrays() -> None:
    """As it would be under a name that numpy does not have."""
    slow = [name for name in TABLE if isinstance(ARRAYS[name], np.vectorize)]
    assert slow == ["pi", "e"]


@pytest.mark.parametrize("x", [2.0**20, 2.0**20 + 0.5, -(2.0**20) - 3, -(2.0**22)])
def test_powers_of_e_to_large_whole_numbers(x: float) -> None:
    with mpmath.workdps(70):
        exact = {name: getattr(mpmath, name)(mpmath.mpf(x)) for name in ("exp", "sinh", "cosh")}
        for name, expected in exact.items():
            found = Digits({}, 50).functions[name](context(50).mpf(x))
            assert abs(found / expected - 1) < mpmath.mpf(10) ** -48


@pytest.mark.parametrize("digits", [50, 200, 400])
@pytest.mark.parametrize("x", [-60.0, -27.3, -4.1, 3.9, 4.1, 9.7, 26.5, 41.0])
def test_error_functions_to_many_digits(x: float, digits: int) -> None:
    with mpmath.workdps(digits + 30 + round(x * x / 2)):
        exact = {"erf": mpmath.erf(mpmath.mpf(x)), "erfc": mpmath.erfc(mpmath.mpf(x))}
        for name, expected in exact.items():
            found = Digits({}, digits).functions[name](context(digits).mpf(x))
            assert abs(found / expected - 1) < mpmath.mpf(10) ** -(digits - 1)


def _reaches(inverse: Inverse, target: float) -> bool:
    """Whether the target lies in the image."""
    above = target > inverse.low if inverse.low_open else target >= inverse.low
    return above and (target < inverse.high if inverse.high_open else target <= inverse.high)
