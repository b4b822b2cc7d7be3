"""Answers at a kink, where equal capacity rates meet, and at the boundary of a case."""

from __future__ import annotations

from itertools import product

import pytest

import rulesheets
import solver
from tests.sampling import sampled

EXCHANGER = """
R = min(C, D)/max(C, D)
N = UA/min(C, D)
if R = 1 then e = N/(1 + N) else e = (1 - exp(-N*(1 - R)))/(1 - R*exp(-N*(1 - R)))
q = e*min(C, D)*(Th - Tc)
"""
MODEL = rulesheets.loads(EXCHANGER)
GIVEN = {"D": 4.0, "UA": 3.0, "Th": 150.0, "Tc": 25.0}
BALANCED = 3 / 7 * 4 * 125
"""The heat at C = D, where N = 3/4."""


@pytest.mark.parametrize("want", [None, ["C"], ["C", "R", "e"]])
def test_equal_capacity_rates_are_no_double_root(want: list[str] | None) -> None:
    """The quotient of the rates has its greatest value there, at a kink."""
    result = solver.solve(MODEL, {**GIVEN, "q": BALANCED}, want)
    assert result.status is solver.Status.SOLVED
    assert [s["C"] for s in result.solutions] == [pytest.approx(4.0)]


@pytest.mark.parametrize(
    ("want", "share"), sampled([*product([None, ["C"], ["C", "R", "e"]], [0.98, 1.02, 1.5])], 2)
)
def test_a_case_that_gives_an_unknown_is_refuted_by_rules_that_nothing_needs(
    want: list[str] | None, share: float
) -> None:
    """R = 1 gives C = D, and then e = N/(1 + N) says that the heat is another."""
    heat = share * BALANCED
    result = solver.solve(MODEL, {**GIVEN, "q": heat}, want)
    assert 4.0 not in [s["C"] for s in result.solutions]
    plan = solver.prepare(MODEL, ["q"], want, given=GIVEN)
    place = plan.want.index("C")
    for q in (BALANCED, heat, BALANCED, heat):
        found = [row[place] for row in plan.all(q)]
        assert (4.0 in found) is (q == BALANCED)


def test_a_fold_is_a_double_root_beside_a_kink_elsewhere() -> None:
    model = rulesheets.loads("y = x*exp(-x) - max(0, x - 3)")
    result = solver.solve(model, {"y": 0.36787944117144233})
    assert result.status is solver.Status.SINGULAR


def test_a_balance_in_which_every_unknown_cancels_contradicts_nothing_by_its_rounding() -> None:
    rules = "a*(b - c) = m*(d - h) + a*(d - c) - m*(d - h) + a*(b - d)\nm*(1 - h/9) = a\nh = 2*T"
    result = solver.solve(rulesheets.loads(rules), {"a": 1.3, "b": 3.7, "c": 0.1, "d": 1.9})
    assert result.status is solver.Status.PARTIAL
    assert {"m", "h"} <= set(result.undetermined)
