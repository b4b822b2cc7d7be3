"""Chains over the reciprocal of their tear, with which boxes far from 0 are searched."""

from __future__ import annotations

import mpmath
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import rulesheets
from rulesheets.syntax.nodes import Name, substitute
from solver.kernel.chain import Assignment, Chain, followed, reciprocal
from solver.kernel.enclosure import Enclosure

RESIDUALS = [
    "(2*x - 3)/(5*x + 1) - x^2/(x - 7)^2",
    "12 - 40*((95 - x) - (20 + x/3))/ln((95 - x)/(20 + x/3))",
    "sqrt(x^2 + 4*x + 9) - abs(x) + x^1.5/1000",
    "-x^3 + 5*x^2*sqrt(abs(x) + 3) - exp(-x/1e6)",
    "1/sqrt(0.02) + 2*log(0.0001/3.7 + 2.51/(abs(x)*sqrt(0.02)))",
    "x*(1 - 1/(1 + x)^3) - sgn(x)*abs(x)^0.9 + atan(x)",
    "(x^2 - 4)^(-2) - cos(x)/x^5",
    "max(x, 3)^2 - x*abs(x - 5)",
]


def chain(residual: str) -> Chain:
    """From x through z = x, another name that grows, to the residual."""
    (rule,) = rulesheets.loads(f"y = {residual}\n").equations
    steps = Assignment("z", Name("x")), Assignment("f", substitute(rule.right, {"x": Name("z")}))
    return Chain(("x",), steps, ("f",))


@pytest.mark.parametrize("residual", RESIDUALS)
@settings(max_examples=30, deadline=None)
@given(st.floats(4096, 1e60), st.sampled_from([1.0, -1.0]))
def test_the_residual_has_its_sign_over_the_reciprocal(
    residual: str, size: float, sign: float
) -> None:
    """... of 80 digits, and a box around the reciprocal does not exclude a value that it holds."""
    original, x = chain(residual), sign * size
    with mpmath.workdps(80):
        try:
            f = followed(original, {"x": mpmath.mpf(x)}, 80)["f"]
        except ArithmeticError:
            return
        over, order = reciprocal(original, sign)
        far = followed(over, {"x": mpmath.mpf(size) ** (-1 / order)}, 80)["f"]
        assert mpmath.sign(f) == mpmath.sign(far)
    around = sorted((0.5 * x, 2.0 * x))
    v = sorted(abs(end) ** (-1 / order) for end in around)
    ((low, high),) = Enclosure(over, ()).ranges([(v[0], v[1])], ())
    assert not (low > 0.0 and f < 0.0) and not (high < 0.0 and f > 0.0)
    ((low, high),) = Enclosure(original, ()).ranges([(around[0], around[1])], ())
    assert low != low or low <= f <= high  # nan where there is no root in the box


@pytest.mark.parametrize(
    ("residual", "root"),
    [
        ("(x - 1e5)/(x + 3)", 1e5),
        ("ln(x/7e8)*x", 7e8),
        ("sqrt(x) - 3e4", 9e8),
        ("x^2/(x + 1) - 5e40", 5e40),
        ("x^3 + 1e66", -1e22),
    ],
)
def test_a_box_with_a_root_is_kept(residual: str, root: float) -> None:
    enclosure = Enclosure(chain(residual), ())
    for reach in (1e-12, 1e-3, 0.5):
        box = tuple(sorted((root * (1 - reach), root * (1 + reach))))
        ((low, high),) = enclosure.ranges([box], ())
        assert low <= 0.0 <= high
