"""What is assumed of a comparison, and what of that a number of a rule takes part in."""

from __future__ import annotations

import pytest

import rulesheets
import solver
from solver.path.cases import AT_LEAST, AT_MOST, DIFFERENT, EQUAL, GREATER, LESS, cases_of, possible


def cases(*rules: str) -> tuple[int, ...]:
    model = rulesheets.loads("\n".join(rules))
    guards = [(model.conditions[p.condition], p.holds) for e in model.equations for p in e.guard]
    first = model.conditions[0]
    while not hasattr(first, "operator"):
        first = first.terms[0] if hasattr(first, "terms") else first.term
    return cases_of((first.left, first.right), model.conditions, guards)


@pytest.mark.parametrize(
    ("rules", "expected"),
    [
        (("if x >= 0 then y = x", "if x <= 0 then y = -x"), (AT_LEAST, LESS)),
        (("if x <= 5 then y = x else y = 2*x",), (GREATER, AT_MOST)),
        (("if x > 5 then y = x else y = 2*x",), (GREATER, AT_MOST)),
        (("if x < 5 then y = x else y = 2*x",), (AT_LEAST, LESS)),
        (("if x < 5 then y = x", "if x > 5 then y = 2*x"), (GREATER, LESS, EQUAL)),
        (("if x = 5 then y = x else y = 2*x",), (DIFFERENT, EQUAL)),
        (("if x >= 5 then y = x", "if x <> 5 then y = 2*x"), (GREATER, LESS, EQUAL)),
        (("if and(x >= 0, z > 1) then y = x", "if not(x >= 0) then y = z"), (AT_LEAST, LESS)),
        (("if 5 >= x then y = x else y = 2*x",), (AT_LEAST, LESS)),
    ],
)
def test_equality_goes_with_a_side_that_loses_no_rule(
    rules: tuple[str, ...], expected: tuple[int, ...]
) -> None:
    assert cases(*rules) == expected


def test_closed_ranges_may_meet_in_a_point() -> None:
    condition = rulesheets.loads(
        "if x <= 5 then y = 1\nif x >= 5 then y = 2\nif x <= 4 then y = 3"
    ).conditions
    (at_most, at_least, less) = ((c.left, c.right) for c in condition)  # type: ignore[union-attr]
    assert possible({at_most: AT_MOST}) and possible({at_least: AT_LEAST})
    assert not possible({at_least: AT_LEAST, less: AT_MOST})
    assert not possible({at_least: GREATER, less: AT_MOST})


@pytest.mark.parametrize("edge", [10.0, 10.000000000000002, 9.999999999999998])
def test_an_answer_on_the_edge_of_a_case_is_found_once(edge: float) -> None:
    sheet = "if distance <= 10 then fare = 2*distance else fare = 20 + 1.25*(distance - 10)"
    result = solver.solve(rulesheets.loads(sheet), {"fare": 20.0 + 2 * (edge - 10)})
    assert str(result.status) == "solved"
    assert result.complete
    assert [s["distance"] for s in result.solutions] == pytest.approx([edge], rel=1e-15)


def test_sides_of_an_edge_that_agree_there_are_one_answer() -> None:
    result = solver.solve(rulesheets.loads("if x >= 0 then y = x\nif x <= 0 then y = -x"), {"y": 0.0})
    assert str(result.status) == "solved"
    assert [s["x"] for s in result.solutions] == [0.0]


@pytest.mark.parametrize(
    ("rules", "given", "expected"),
    [
        (("if x <= 0 then y = 1 - x else y = 2*x", "w = y + x"), {"w": 5.0}, [5 / 3]),
        (("if x <= 0 then y = 1 - x else y = 2*x", "w = y + x"), {"w": -5.0}, []),
        (("if x >= 0 then y = x^2 else y = -x^2",), {"y": -4.0}, [-2.0]),
        (("if x > 0 then y = exp(x) else y = -exp(-x)",), {"y": 0.5}, []),
        (("if x > z then y = x else y = z", "x + z = 2"), {"y": 1.5}, [0.5, 1.5]),
        (("if x > z then y = x else y = z", "x + z = 2"), {"y": 0.5}, []),
    ],
)
def test_a_case_that_its_own_rules_exclude_hides_no_answer(
    rules: tuple[str, ...], given: dict[str, float], expected: list[float]
) -> None:
    result = solver.solve(rulesheets.loads("\n".join(rules)), given)
    answers = sorted(s["x"] for s in result.solutions)
    assert result.complete
    assert str(result.status) == ("solved" if expected else "infeasible")
    assert answers == pytest.approx(expected)
