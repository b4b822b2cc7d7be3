"""Prepared calls on sheets with requirements: the same answers as a solve, recorded."""

from __future__ import annotations

import math

import numpy as np
import pytest

import rulesheets
import solver

SHEET = """
variables
  a = 4
  x
  y
rules
  x^2 = a
  y = x + 1
  y > 0
"""


def test_answers_that_a_requirement_excludes_are_not_listed() -> None:
    plan = solver.prepare(rulesheets.loads(SHEET), ["a"], ["x", "y"])
    assert plan.all(4.0) == [(2.0, 3.0)]
    assert plan.records.programs
    assert plan.all(9.0) == [(3.0, 4.0)]


def test_an_answer_that_a_requirement_excluded_at_the_record_comes_back() -> None:
    """Below a = 1 both roots give a positive y."""
    plan = solver.prepare(rulesheets.loads(SHEET), ["a"], ["x", "y"])
    plan(4.0)
    assert [row[0] for row in plan.all(0.25)] == [0.5, -0.5]
    table = plan.sweep(np.linspace(0.2, 3.0, 200))
    assert table["answers"].tolist() == [2 if a < 1.0 else 1 for a in np.linspace(0.2, 3.0, 200)]


def test_a_requirement_that_is_broken_everywhere_is_infeasible_in_a_plan() -> None:
    text = "variables\n  a = 4\n  x > 0\nrules\n  x^2 = a\n  x < 3\n"
    plan = solver.prepare(rulesheets.loads(text), ["a"], ["x"])
    assert plan(4.0) == (2.0,)
    for a in (16.0, 17.0):
        with pytest.raises(solver.Unsolved) as refused:
            plan(a)
        assert str(refused.value.status) == "infeasible"
    assert math.isclose(plan(8.0)[0], math.sqrt(8.0))


def test_a_refusal_that_is_recorded_explains_itself_when_asked() -> None:
    text = "variables\n  a = 0.5\n  x\nrules\n  cosd(x) = a\n"
    plan = solver.prepare(rulesheets.loads(text), ["a"], ["x"])
    said = []
    for a in (2.0, 3.0):
        with pytest.raises(solver.Unsolved) as refused:
            plan(a)
        said.append([diagnosis.code for diagnosis in refused.value.diagnoses])
        assert "infeasible" in str(refused.value)
    assert said[0] == said[1] and said[0]
    assert plan.records.refusals


def test_a_row_just_beyond_the_end_of_a_stroke_refuses_none_inside() -> None:
    end = math.sqrt(21.0)
    model = rulesheets.load("offset_slider_crank")
    plan = solver.prepare(model, ["xB"], ["thetaAO"], {"thetaAO": None})
    plan(7.0)
    for beyond in (1e-3, 1e-6, 1e-7, 1e-8):
        with pytest.raises(solver.Unsolved):
            plan(end - beyond)
    for inside in (1e-6, 3e-5, 1e-4, 1e-3):
        assert len(plan.all(end + inside)) == 2


def test_a_refusal_tells_nothing_of_roots_that_its_row_had_not() -> None:
    """At y = -3 the only root is u = -3.3, which has no square root; at y = -1.5 there are three
    roots."""
    sheet = "variables\n  y = -3\n  u in [-4, 4]\n  z\nrules\n  u - 3*sin(u) = y\n  u = sqrt(z)\n"
    plan = solver.prepare(rulesheets.loads(sheet), ["y"], ["z"])
    with pytest.raises(solver.Unsolved) as refused:
        plan(-3.0)
    assert str(refused.value.status) == "infeasible"
    u = np.sqrt([z for (z,) in plan.all(-1.5)])
    assert len(u) == 2
    assert np.allclose(u - 3 * np.sin(u), -1.5)


@pytest.mark.parametrize(
    "exponents", [(2.5, 2.0, 3.0, 4.0, -2.0), (2.0, 2.5, -3.0, 0.4), (3.0, 2.0, 2.5)]
)
def test_an_even_exponent_has_two_bases_and_others_one(exponents: tuple[float, ...]) -> None:
    text = "y = c*a^x\n"
    plan = solver.prepare(rulesheets.loads(text), ["x", "y"], ["a"], {"c": 2.0})
    expected = {x: ([1.0, -1.0] if x % 2.0 == 0.0 else [1.0]) for x in exponents}
    for _ in range(2):
        for x in exponents:
            assert [a for (a,) in plan.all(x, 2.0 * 3.0**x)] == pytest.approx(
                [3.0 * s for s in expected[x]]
            )
    table = plan.sweep(list(exponents) * 3, [2.0 * 3.0**x for x in exponents] * 3)
    assert [int(count) for count in table.answers] == [len(expected[x]) for x in exponents] * 3
