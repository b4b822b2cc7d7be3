"""Rules rewritten for a search: no zero of a rule is lost, and what made it rough is gone."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

import rulesheets
from rulesheets.evaluate import value
from rulesheets.syntax.nodes import Call, Expression
from solver.path.isolate import smooth


def form_of(rule: str) -> Expression:
    equation = rulesheets.loads(rule).equations[0]
    return smooth(equation.left, equation.right)


def functions(expression: Expression) -> set[str]:
    below = {name for child in expression.parts for name in functions(child)}  # type: ignore[arg-type]
    return below | ({expression.function} if isinstance(expression, Call) else set())


@pytest.mark.parametrize(
    ("rule", "left"),
    [
        ("s = sqrt(x^2 + y^2)", set()),
        ("x - y = -sqrt(s)/3 + 2*y", set()),
        ("s = abs(x)*y", set()),
        ("t = atan2d(y, x)", {"sind", "cosd"}),
        ("90 - t = atan2(y, x - 3)", {"sin", "cos"}),
        ("m = x*tand(t)", {"sind", "cosd"}),
        ("x = y^2", set()),
        ("sqrt(x) + sqrt(y) = s", {"sqrt"}),
        ("sqrt(x)^2 = s", {"sqrt"}),
        ("2*atan2d(y, x) = t", {"atan2d"}),
        ("s = y/sqrt(x)", {"sqrt"}),
    ],
)
def test_what_is_left(rule: str, left: set[str]) -> None:
    assert functions(form_of(rule)) == left


NUMBERS = st.floats(-50, 50).map(lambda x: round(x, 3))


@given(x=NUMBERS, y=NUMBERS, c=NUMBERS.filter(bool))
def test_zeros_stay_zeros(x: float, y: float, c: float) -> None:
    t = math.degrees(math.atan2(y, x))
    points = {
        "s = sqrt(x^2 + y^2)": {"s": math.hypot(x, y)},
        "x - s = -sqrt(x^2 + 1)*y/3": {"s": x + math.sqrt(x**2 + 1) * y / 3},
        "s = x - c*abs(y)": {"s": x - c * abs(y)},
        "t = atan2d(y, x)": {"t": t},
        "90 - t = atan2d(y, x)": {"t": 90 - t},
        "s = c*tand(x)": {"s": c * math.tan(math.radians(x))},
    }
    for rule, more in points.items():
        at = {"x": x, "y": y, "c": c, **more}
        if abs(x) + abs(y) > 1e-3 and abs(math.cos(math.radians(x))) > 1e-3:
            size = 1 + max(abs(v) for v in at.values()) ** 3
            assert abs(value(form_of(rule), at)) <= 1e-11 * size, rule
