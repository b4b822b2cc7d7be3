"""Scalings of rules, and the sizes that follow from them."""

from __future__ import annotations

import math

import pytest

import rulesheets
from solver.ranking.sizes import Scalings


def scalings(*rules: str) -> Scalings:
    model = rulesheets.loads("\n".join(rules))
    return Scalings(model.equations, list(model.variables))


MOTION = (
    "v = omega*r",
    "a = omega^2*r",
    "x = r*cosd(t)",
    "d = sqrt(x^2 + y^2)",
    "phi = atan2d(y, x)",
)


def test_length_and_time_are_found_from_the_rules() -> None:
    found = scalings(*MOTION)
    assert found.exponents.shape[1] == 2
    sizes = found.sizes({"r": 3.0, "omega": -20.0})
    assert {name: sizes[name] for name in "vaxyd"} == pytest.approx(
        {"v": 60.0, "a": 1200.0, "x": 3.0, "y": 3.0, "d": 3.0}
    )
    assert (sizes["t"], sizes["phi"]) == pytest.approx((1.0, 1.0))


def test_known_numbers_of_one_kind_meet_in_their_geometric_mean() -> None:
    assert scalings(*MOTION).sizes({"r": 2.0, "x": 8.0, "y": 0.0})["d"] == pytest.approx(4.0)


def test_what_no_known_number_tells_has_size_one() -> None:
    assert scalings("a = b", "c = d").sizes({"a": 50.0}) == pytest.approx(
        {"a": 50, "b": 50, "c": 1, "d": 1}
    )
    assert scalings("a = b").sizes({}) == pytest.approx({"a": 1, "b": 1})


@pytest.mark.parametrize("rule", ["x = exp(y)", "x + 1 = y", "x^y = 2", "x = y^2 + y"])
def test_rules_that_nothing_scales(rule: str) -> None:
    assert scalings(rule).exponents.shape[1] == 0


@pytest.mark.parametrize(
    ("rule", "power"),
    [
        ("x = 2*y^3", 3),
        ("x*y = 4*z", -1),
        ("x - abs(y) = 0", 1),
        ("x^2 = max(y, z)", 0.5),
        ("1/x = y/z", -1),
    ],
)
def test_a_scaling_leaves_the_rule_true(rule: str, power: float) -> None:
    """Where y and z alone are ten times as large, x is 10^power times as large."""
    found = scalings(rule)
    known = {"y": 10.0, "z": 10.0 if "max" in rule else 1.0}
    sizes = found.sizes({name: v for name, v in known.items() if name in found.places})
    assert math.log10(sizes["x"]) == pytest.approx(power)
