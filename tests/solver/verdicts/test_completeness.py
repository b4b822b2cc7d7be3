"""Why a list of answers may not be whole: how many are listed, where, and how to come by the
others."""

from __future__ import annotations

from math import asin, atan2, exp, pi, sqrt
from typing import Any

import mpmath
import pytest

import rulesheets
import solver
from solver import Status
from solver.report.sheet import result_text


def solved(text: str, guesses: dict[str, float] | None = None) -> Any:
    return solver.solve(rulesheets.loads(text), guesses=guesses)


def notes(result: Any) -> list[str]:
    return [diagnosis.code for diagnosis in result.diagnoses]


def test_list_that_is_cut_off_says_so_and_where() -> None:
    result = solved("variables\nx in [0, 1e5]\nrules\nsin(x) = 0.5")
    assert str(result.status) == "solved"
    assert not result.complete
    assert notes(result) == ["S593"]
    roots = sorted(solution["x"] for solution in result.solutions)
    note = result.diagnoses[0]
    assert note.variables == ("x",)
    assert f"{len(roots)} are listed, from x = {roots[0]:.6g} to" in note.message
    assert f"{roots[-1]:.6g}" in note.message
    assert any("x in [a, b]" in text for text in note.notes)


def test_endless_roots_are_not_claimed_to_be_all() -> None:
    result = solved("y = 0\ny = y0(x)")
    assert len(result.solutions) == 48
    assert not result.complete
    assert [gap.code for gap in result.gaps] == ["S593"]


def test_an_answer_beyond_floats_is_not_said_to_be_none() -> None:
    """At x = 3 the power is 1e600."""
    result = solved("(x - 3)*(x + 1) = 0\ny = 10^(200*x)")
    assert [solution["x"] for solution in result.solutions] == [-1.0]
    assert not result.complete
    assert "other values of y" in result.gaps[0].message


def test_range_lists_the_answers_there() -> None:
    """As the note says."""
    result = solved("variables\nx in [600, 640]\ny = 0\nrules\ny = y0(x)")
    with mpmath.workdps(20):
        near = [(k - mpmath.mpf(3) / 4) * mpmath.pi for k in range(190, 207)]
        exact = [float(mpmath.findroot(lambda x: mpmath.bessely(0, x), start)) for start in near]
    inside = [root for root in exact if 600 <= root <= 640]
    assert len(inside) > 10
    assert notes(result) == []
    assert sorted(s["x"] for s in result.solutions) == pytest.approx(inside, rel=1e-13)


def test_guess_lists_those_nearest_to_it() -> None:
    result = solved("y = 0\ny = y0(x)", {"x": 1000.0})
    assert abs(result["x"] - 1000.0) < 3.2
    assert not result.complete


def test_guess_lists_the_nearest_first() -> None:
    result = solved("y = 0\ny = sin(x)/x", {"x": 1000.0})
    assert result["x"] == pytest.approx(318 * pi, rel=1e-15)
    assert not result.complete


def test_root_that_floats_do_not_come_near_is_looked_for() -> None:
    """exp is 1 to all digits there, and d = 3.71 - y is 0: an answer is proven to be, by
    intervals."""
    result = solved("ln(exp(d*y)) = -2e-27\ny + d = 3.71")
    assert result.status is Status.SOLVED
    near = [solution for solution in result.solutions if solution["y"] == 3.71]
    assert [solution["d"] for solution in near] == pytest.approx([-2e-27 / 3.71], rel=1e-14)


def test_whole_list_has_no_note() -> None:
    result = solved("x^2 = 4")
    assert result.complete
    assert result.gaps == ()
    assert "S59" not in result_text(result, explain=True)


def test_search_without_a_proof_says_what_it_lacks_where_it_is_asked_to_explain() -> None:
    result = solved("x^3 + sin(x*y) = 1\ny - x*cos(x*y) = 0.3")
    assert not result.complete
    assert result.diagnoses == ()
    assert [gap.code for gap in result.gaps] == ["S594"]
    assert "S594" in result_text(result, explain=True)
    assert "S594" not in result_text(result)
    assert "give x and y a range" in result.gaps[0].notes[0]


def test_more_answers_than_a_result_holds() -> None:
    result = solved("\n".join(f"x{k}^2 = {k}" for k in range(1, 11)))
    assert len(result.solutions) == 1_000
    assert notes(result) == ["S593"]
    assert "1000 are listed" in result.diagnoses[0].message


def test_no_answer_is_left_out_below_that() -> None:
    result = solved("\n".join(f"x{k}^2 = {k}" for k in range(1, 10)))
    assert len(result.solutions) == 512
    assert result.complete


@pytest.mark.parametrize(
    "nothing", ["0/c/(b*d)", "0*c/(b*d)", "p/c/(b*d)", "p*c/(b*d)", "0/(b*c*d)"]
)
def test_an_unknown_that_drops_out_of_a_rule_is_not_found_by_it(nothing: str) -> None:
    """0 over c is 0 whatever c is: the rule that says so gives b alone, and c is found by
    another."""
    ranges = "  b in [-1, -0.3]\n  c in [-31, 22]\n  d in [-3, 0.3]\n  p = 0\n"
    rules = f"  {nothing} - b/5 = 0.08\n  b/(d*d) = -14.6\n  d/b*(3 + c) = 4.6\n"
    result = solver.solve(rulesheets.loads(f"variables\n{ranges}rules\n{rules}"))
    b = -0.4
    places = [(d, 4.6 * b / d - 3) for d in (sqrt(b / -14.6), -sqrt(b / -14.6))]
    assert result.status is Status.SOLVED
    found = sorted((s["d"], s["c"]) for s in result.solutions)
    assert found == [pytest.approx(place, rel=1e-12) for place in sorted(places)]


def test_nothing_over_an_unknown_is_never_something() -> None:
    result = solver.solve(rulesheets.loads("rules\n  0/c = 1\n"))
    assert result.status is Status.INFEASIBLE
    result = solver.solve(rulesheets.loads("rules\n  0/c = 0\n"))
    assert result.status is Status.SINGULAR
    assert "c" in result.undetermined


def test_half_a_line_has_one_direction() -> None:
    """``atan2d(0, x)`` is 180 wherever x is negative."""
    rules = "atan2d(0, x)*y = 180 + sin(y - 1)\nx*y + y^2 = -3"
    result = solver.solve(rulesheets.loads(rules))
    assert any(abs(s["x"] + 4) + abs(s["y"] - 1) < 1e-9 for s in result.solutions)
    ranged = "variables\nx in [-10, 10]\ny in [-10, 10]\nrules\n" + rules
    assert solver.solve(rulesheets.loads(ranged)).status is not solver.Status.INFEASIBLE


def test_a_turn_of_an_angle_that_a_condition_weighs_is_an_answer_of_its_own() -> None:
    """-3.21 and the 3.07 in the turn around 0 have the same sine, but not the same place beside
    -2.9."""
    rule = "if c <= -2.9 then sin(c) = 0.0683 else (0 - c) = c"
    assert not solved(rule).complete
    ranged = solver.solve(rulesheets.loads(f"variables\n  c in [-4, 4]\nrules\n  {rule}\n"))
    assert ranged.complete
    assert sorted(s["c"] for s in ranged.solutions) == [pytest.approx(asin(-0.0683) - pi), 0.0]
    assert solved("if sin(c) < 0 then cos(c) = 0.5 else cos(c) = 0.3").complete


def test_the_direction_of_a_point_on_an_axis_says_nothing_of_its_distance() -> None:
    result = solved("atan2(0, w)*a^2 = max(b*c, 1 + c) - 25\nb = -4.2\nc - a = -10.65\nw*c*b = 39")
    for solution in result.solutions:
        assert solution["w"] > 0 or atan2(0.0, solution["w"]) == pi
    c = 25 / -4.2
    assert any(
        s["c"] == pytest.approx(c) and s["w"] == pytest.approx(39 / 25) for s in result.solutions
    )


def test_a_case_whose_missing_value_is_refused_hides_no_answer() -> None:
    """With y unknown the sign of w is a case; below 0 no root gives it, though z is what has no
    value."""
    sheet = """
variables
  b
  x
  y
rules
  if y >= 1 then w = b else w = -b
  w = sqrt(z)
  x = z + 1
  y = x - 2
"""
    result = solver.solve(rulesheets.loads(sheet), {"b": 2.0})
    assert [(s["x"], s["y"]) for s in result.solutions] == [(5.0, 3.0)]
    assert result.complete


@pytest.mark.parametrize("c", [-60.0, -230.0])
def test_a_root_next_to_zero_is_not_denied(c: float) -> None:
    """ln(w) + w = c has one root, near exp(c), be that 1e-100."""
    result = solved(f"ln(w) + w = {c}")
    assert [s["w"] for s in result.solutions] == [pytest.approx(exp(c), rel=1e-12)]


@pytest.mark.parametrize("y", [60.0, 90.0, 120.0])
def test_a_value_of_which_not_all_turns_were_counted_contradicts_nothing(y: float) -> None:
    """y^4 is a whole number of turns: of all the y with that cosine only some are looked at."""
    model = rulesheets.loads("cosd(y^4) = 1\nround(y) = a")
    assert y**4 % 360.0 == 0.0
    result = solver.solve(model, {"a": y})
    assert result.status not in (solver.Status.INCONSISTENT, solver.Status.INFEASIBLE)
    assert not result.complete


@pytest.mark.parametrize("added", [0.01, 0.02, 0.3, 5.0])
def test_a_logarithm_has_no_root_at_the_pole_of_its_quotient(added: float) -> None:
    """The buffer after a base was added: with A = 10^p H the second rule is linear."""
    sheet = f"p = log(A/H)\nq = log((A + {added})/(H - {added}))"
    result = solver.solve(rulesheets.loads(sheet), {"p": 0.2, "q": 0.3})
    assert result.complete
    acid = added * (1 + 10**0.3) / (10**0.3 - 10**0.2)
    assert [s["H"] for s in result.solutions] == pytest.approx([acid], rel=1e-13)


@pytest.mark.parametrize("rule", ["asind(u)", "acosd(u)", "atand(u)", "atan2d(u, 0.3)"])
@pytest.mark.parametrize("limit", [-10.0, 20.0, 70.0])
def test_a_compared_angle_is_in_the_turn_of_its_function(rule: str, limit: float) -> None:
    """Whole turns of it are no other answers: the function has one value."""
    model = rulesheets.loads(f"b = {rule}\nif b < {limit} then y = 1.4*u else y = 2*u")
    assert solver.solve(model, {"u": 0.4}).complete
    assert solver.solve(model, {"b": 25.0}).complete
