"""What is assumed of a comparison, and what of that a number of a rule takes part in."""

from __future__ import annotations

import math

import pytest

import rulesheets
import solver
from solver.path.cases import AT_LEAST, AT_MOST, DIFFERENT, EQUAL, GREATER, LESS, cases_of


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


@pytest.mark.parametrize("edge", [10.0, 10.000000000000002, 9.999999999999998])
def test_an_answer_on_the_edge_of_a_case_is_found_once(edge: float) -> None:
    sheet = "if distance <= 10 then fare = 2*distance else fare = 20 + 1.25*(distance - 10)"
    result = solver.solve(rulesheets.loads(sheet), {"fare": 20.0 + 2 * (edge - 10)})
    assert str(result.status) == "solved"
    assert result.complete
    assert [s["distance"] for s in result.solutions] == pytest.approx([edge], rel=1e-15)


def test_sides_of_an_edge_that_agree_there_are_one_answer() -> None:
    result = solver.solve(
        rulesheets.loads("if x >= 0 then y = x\nif x <= 0 then y = -x"), {"y": 0.0}
    )
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


def test_an_arm_that_no_value_reaches_takes_no_answer_away() -> None:
    """x < 0: x² + x = 4, (-1 - √17)/2. Else, as x < -2 comes too late: x² + 3x = 4, 1."""
    arms = "if x < a then y = 1 else if x < b then z = w*5 else y = 3\nx^2 + y*x = 4"
    literal = arms.replace("< a", "< 0").replace("< b", "< -2")
    for sheet in (arms, literal):
        given = {} if sheet is literal else {"a": 0.0, "b": -2.0}
        result = solver.solve(rulesheets.loads(sheet), given)
        answers = {s["y"]: s["x"] for s in result.solutions}
        assert answers == pytest.approx({1.0: (-1 - 17**0.5) / 2, 3.0: 1.0})
        assert {name for d in result.diagnoses for name in ("z", "w") if name in d.message} == {
            "z",
            "w",
        }


def test_thresholds_that_an_arm_gives_count_too() -> None:
    """Where x >= 0, b = -2 and so y = 1, x + y = 3. Where x < 0, x = -1, b = -9 and y = 1."""
    first = "if x >= 0 then b = -2 else b = -9\nif x >= 0 then x + y = 3 else x = -1"
    second = "if x < b then z = w else y = 1"
    result = solver.solve(rulesheets.loads(f"{first}\n{second}"), {}, want=["x", "y", "b"])
    assert str(result.status) == "solved"
    assert result.complete
    assert sorted((s["x"], s["y"], s["b"]) for s in result.solutions) == [
        (-1.0, 1.0, -9.0),
        (2.0, 1.0, -2.0),
    ]


@pytest.mark.parametrize("diameter", [0.0127, 0.0713, 0.1, 0.2039, 0.2991])
@pytest.mark.parametrize("factor", [0.316, 0.3164, 0.317])
def test_an_answer_exactly_on_the_edge_of_a_jump_is_found_whatever_the_rounding(
    diameter: float, factor: float
) -> None:
    rule = f"if Re < 2300 then f = 64/Re else f = {factor}/Re^0.25"
    model = rulesheets.loads(f"Re = V*{diameter}/1.3e-6\n{rule}")
    result = solver.solve(model, {"f": factor / 2300**0.25})
    velocity = {s["Re"]: s["V"] for s in result.solutions}
    assert velocity[2300.0] == pytest.approx(2300 * 1.3e-6 / diameter, rel=1e-14)


@pytest.mark.parametrize(("load", "expected"), [(0.6, [3.0]), (0.3, []), (0.5999999999, [])])
def test_a_strict_edge_has_no_answer_next_to_it(load: float, expected: list[float]) -> None:
    result = solver.solve(rulesheets.loads("if V < 3 then q = V/10 else q = V/5"), {"q": load})
    assert [s["V"] for s in result.solutions] == expected
    assert result.complete


@pytest.mark.parametrize(
    ("Q", "D", "eps"), [(0.000154, 0.461, 1.11e-5), (0.000125, 0.0895, 0.00077)]
)
def test_a_boundary_that_given_numbers_miss_by_their_last_places_is_not_excluded(
    Q: float, D: float, eps: float
) -> None:
    """The friction is 1e-8 of the head, and with it the Reynolds number known to that share of
    it."""
    rules = """V = Q/(pi*D^2/4)
Re = V*D/nu
if Re < 2300 then f = 64/Re else f = (-1.8*log10((eps/D/3.7)^1.11 + 6.9/Re))^-2
h = f*150/D*V^2/19.62
H = 4 + h + 6.5*V^2/19.62
P = 9.81*Q*H/0.72"""
    V = Q / (math.pi * D**2 / 4)
    f = (-1.8 * math.log10((eps / D / 3.7) ** 1.11 + 6.9 / 2300)) ** -2
    P = 9.81 * Q * (4 + f * 150 / D * V**2 / 19.62 + 6.5 * V**2 / 19.62) / 0.72
    result = solver.solve(rulesheets.loads(rules), {"Q": Q, "D": D, "eps": eps, "P": P})
    listed = any(
        answer["nu"] == pytest.approx(V * D / 2300, rel=1e-6) for answer in result.solutions
    )
    assert listed or not result.complete


STEPS = "if s < 10000 then r = 0.02 else if s < 25000 then r = 0.03 else r = 0.05\npay = s*r"


@pytest.mark.parametrize("given", [{"r": 0.025}, {"r": 0.0}])
def test_a_value_that_no_case_gives_is_infeasible(given: dict[str, float]) -> None:
    assert str(solver.solve(rulesheets.loads(STEPS), given).status) == "infeasible"


def test_a_value_of_a_case_leaves_what_it_compares_open() -> None:
    assert str(solver.solve(rulesheets.loads(STEPS), {"r": 0.03}).status) == "partial"
    plan = solver.prepare(rulesheets.loads(STEPS), ["r"], ["s"])
    for r, status in ((0.025, "infeasible"), (0.03, "partial"), (0.04, "infeasible")):
        with pytest.raises(solver.Unsolved) as refused:
            plan(r)
        assert str(refused.value.status) == status


def test_both_ends_of_a_gap_between_cases_are_told() -> None:
    result = solver.solve(rulesheets.loads(STEPS), {"pay": 250.0})
    assert result.diagnoses[0].notes[-1].endswith("a solution needs pay < 200 or pay ≥ 300")


def test_the_other_end_of_a_gap_is_searched_afresh() -> None:
    """Where z is negative below s = 28, m is too, and leads to no m above."""
    rules = "s = 28 + 39/z\n10*z = min(5, m*(12 + z)) + min(2, m*(4 - z))"
    result = solver.solve(rulesheets.loads(rules), {"s": 50.0})
    assert result.diagnoses[0].notes[-1].endswith("a solution needs s < 28 or s ≥ 83.7143")


@pytest.mark.parametrize(
    ("rule", "needs"),
    [
        ("if sqrt(a) > 1 then k = 1 else k = 0", "sqrt of -4"),
        ("if 8/(a + 4) < 1 then k = 1 else k = 0", "division by 0"),
        ("if a < -4 then k = 2 else if not (ln(a) > 1) then k = 1 else k = 0", "ln of -4"),
    ],
)
def test_a_condition_without_a_value_is_told(rule: str, needs: str) -> None:
    """It counts as false, so that `else` applies, and never without a word."""
    result = solver.solve(rulesheets.loads(rule), {"a": -4.0})
    assert (str(result.status), result["k"]) == ("solved", 0.0)
    (note,) = result.diagnoses
    assert note.code == "S599"
    assert needs in note.notes[0]


def test_a_condition_that_another_term_decides_is_not_told() -> None:
    rule = "if a > 0 and sqrt(a) > 1 then k = 1 else k = 0"
    result = solver.solve(rulesheets.loads(rule), {"a": -4.0})
    assert (result["k"], result.diagnoses) == (0.0, ())
