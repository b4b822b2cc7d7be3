"""A case in which an equality is assumed has one equation more than the question: its answers must
satisfy every rule, whatever is wanted."""

from __future__ import annotations

import random

import pytest

import rulesheets
import solver
from benchmarks.hostile_plans import broken

JOINED = """
if x = 2 then y = 3 else y = x + 1
if x = 2 then x = u else x = u + 1
z = u*y
"""
KINKED = """
p = a*t + b
if p = c then q = 0 else q = (p - c)*k
s = q + p
"""


@pytest.mark.parametrize("wanted", ["x", "y", "u", None])
@pytest.mark.parametrize(("z", "at_two"), [(9.0, False), (6.0, True)])
def test_what_is_wanted_does_not_change_the_answers(
    wanted: str | None, z: float, at_two: bool
) -> None:
    """(x - 1)(x + 1) = z beside x = 2, where u*y = 6."""
    want = None if wanted is None else [wanted]
    result = solver.solve(rulesheets.loads(JOINED), {"z": z}, want=want)
    root = (z + 1) ** 0.5
    expected = sorted([-root, root, *([2.0] if at_two else [])])
    assert result.complete
    assert sorted(s["x"] for s in result.solutions) == pytest.approx(expected, rel=1e-14)


@pytest.mark.parametrize("seed", range(12))
def test_every_answer_satisfies_every_rule(seed: int) -> None:
    draw = random.Random(seed)
    given = {name: round(draw.uniform(-5.0, 5.0), 2) for name in "abcks"}
    model = rulesheets.loads(KINKED)
    for wanted in ("t", "p", "q"):
        result = solver.solve(model, given, want=[wanted])
        whole = solver.solve(model, given)
        assert len(result.solutions) == len(whole.solutions)
        for answer in result.solutions:
            values = {**whole.solutions[0], **answer}
            assert not list(broken(model, values, given))


def test_a_refusal_names_the_rule_that_refuses() -> None:
    """Not a contradiction of a case that was only tried."""
    rules = "if x = 2 then y = 0 else y = sqrt(3 - w)\nw = x^2 + 4\nx = v - 1\nu = y + 1 + v"
    result = solver.solve(rulesheets.loads(rules), {"u": 9.0}, want=["v"])
    assert str(result.status) == "infeasible"
    assert "contradict" not in result.diagnoses[0].message


TWO_CASES = """
if x = w then y = x - 2.8 else y = 2.4*x
v = x + y
z = 2.8*v + x
w = -1.1*x
"""


@pytest.mark.parametrize("wanted", ["x", "y", "v", None])
def test_a_case_is_known_to_be_that_of_its_answer(wanted: str | None) -> None:
    """x = 0 is a root of the second case, but of that w = x."""
    want = None if wanted is None else [wanted]
    result = solver.solve(rulesheets.loads(TWO_CASES), {"z": 0.0}, want=want)
    assert str(result.status) == "infeasible"
    assert not result.solutions


WITH_AUXILIARY = """
if x = 2 then y = 3 else y = x + 1
call f(x; w)
if x = 2 then x = u else x = u + 1
z = u*y
function f(x; w)
rules
  k = sqrt(x - 3)
  w = x
"""


@pytest.mark.parametrize("want", [None, ["x"]])
def test_a_local_without_value_leaves_the_answers_of_all_cases(want: list[str] | None) -> None:
    """sqrt(x - 3) has no value at any of the three, and nothing is computed from it."""
    result = solver.solve(rulesheets.loads(WITH_AUXILIARY), {"z": 6.0}, want=want)
    expected = [-(7.0**0.5), 2.0, 7.0**0.5]
    assert sorted(s["x"] for s in result.solutions) == pytest.approx(expected, rel=1e-14)


@pytest.mark.parametrize(
    ("rules", "expected"),
    [
        ("if x <> 0 then x = a else x = 2*a - 1\nx >= 3", [4.0]),  # 7 is not 0
        ("abs(x) = a\nif x > y then x = -a else x = a + 1\ny = 0*a", []),  # -4 > 0 is false
    ],
)
def test_no_number_is_moved_out_of_its_case(rules: str, expected: list[float]) -> None:
    result = solver.solve(rulesheets.loads(rules), {"a": 4.0})
    assert [answer["x"] for answer in result.solutions] == expected


def test_an_answer_on_a_boundary_is_kept_through_further_cases() -> None:
    """-3x + 15.2 = 24.8 gives -3.2000000000000006 in floats; then y is assumed to be below 7.6."""
    text = """
    if x < -3.2 then 3*x - 4*a = -42.5 else 2*a - 3*x = 24.8
    if y < a then 2*y = 10.4 - a else y = a + 1
    """
    result = solver.solve(rulesheets.loads(text), {"a": 7.6})
    assert result.complete
    found = sorted((s["x"], s["y"]) for s in result.solutions)
    expected = [(x, y) for x in (-12.1 / 3, -3.2) for y in (1.4, 8.6)]
    assert [value for pair in found for value in pair] == pytest.approx(
        [value for pair in expected for value in pair], rel=1e-14
    )
