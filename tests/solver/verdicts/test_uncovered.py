"""Rules whose conditions leave a case out: answers in the other cases stand, and the gap is
told."""

import pytest

import rulesheets
import solver

FALLING = """
vt = sqrt(4*g*(rhop - rho)*Dp/(3*CD*rho))
Re = Dp*vt*rho/mu
if Re < 0.1 then CD = 24/Re
if Re >= 0.1 and Re < 1000 then CD = 24/Re*(1 + 0.14*Re^0.7)
if Re >= 1000 and Re < 350000 then CD = 0.44
"""
"""After M. B. Cutlip and others, Comput. Appl. Eng. Educ. 6 (1998) 169: 0.015782 m/s."""

KNOWN = {"g": 9.80665, "rhop": 1800.0, "rho": 994.6, "mu": 8.931e-4, "Dp": 0.208e-3}


def test_an_answer_stands_beside_a_case_without_a_rule() -> None:
    result = solver.solve(rulesheets.loads(FALLING), KNOWN)
    assert result.status is solver.Status.SOLVED
    assert not result.complete
    assert result["vt"] == pytest.approx(0.015782, abs=1e-6)
    (note,) = result.diagnoses
    assert note.code == "S597"
    assert note.message.endswith("where Re >= 350000")


@pytest.mark.parametrize(("peak", "status"), [(1.0, "singular"), (1.25, "solved")])
@pytest.mark.parametrize("form", ["(Q - 1)^2 + 1", "sqrt((Q - 1)^4 + 1)", "1/(1 - (Q - 1)^2)"])
def test_a_double_root_hides_no_case_that_leaves_an_unknown_free(
    peak: float, status: str, form: str
) -> None:
    rules = f"if Q > 0.5 then peak = {form} else peak = 1\nQ = a/b"
    result = solver.solve(rulesheets.loads(rules), {"peak": peak, "b": 2.0})
    assert str(result.status) == status
    notes = [d.message for d in result.diagnoses if d.code == "S597"]
    assert notes == ["no rule determines Q and a where Q <= 0.5"][: status == "singular"]


def test_a_range_closes_a_case() -> None:
    ranged = rulesheets.loads("variables\nRe in [0, 3e5]\nrules" + FALLING)
    result = solver.solve(ranged, KNOWN)
    assert result.status is solver.Status.SOLVED
    assert result["vt"] == pytest.approx(0.015782, abs=1e-6)
    assert result.diagnoses == ()


def test_nothing_is_solved_where_no_case_has_an_answer() -> None:
    result = solver.solve(rulesheets.loads("if x > 0 then y = 2*x\nif x > 0 then y = -x"))
    assert result.status is not solver.Status.SOLVED


def test_a_continuum_in_one_case_is_not_hidden_by_the_edge_of_another() -> None:
    """Any income up to 11,000 is taxed by a tenth."""
    rules = "if x <= 11000 then y = 0.1*x\nelse y = 1100 + 0.12*(x - 11000)\nz*x = y\nz = 0.1"
    assert solver.solve(rulesheets.loads(rules)).status is not solver.Status.SOLVED


def test_an_answer_apart_from_a_continuum_is_listed() -> None:
    """Above 2 any x gives z = -1; below, only 1.6."""
    rules = "if x > 2 then y = 2*x - 1 else y = 2.2\nz = y - 2*x"
    result = solver.solve(rulesheets.loads(rules), {"z": -1.0})
    assert [s["x"] for s in result.solutions] == [1.6]
    assert not result.complete
    assert "x > 2" in result.diagnoses[0].message


@pytest.mark.parametrize("want", [None, ["w"]])
def test_a_case_that_other_rules_refute_is_not_left_out(want: list[str] | None) -> None:
    """a = 0.4, so that w >= 1 would contradict a = 3, whatever w is."""
    model = rulesheets.loads("if w < 1 then w = 2*a - 1 else a = 3\nb = a + 2")
    result = solver.solve(model, {"b": 2.4}, want=want)
    assert result.complete
    assert not result.diagnoses
    assert result["w"] == pytest.approx(-0.2, rel=1e-14)
    assert str(solver.solve(model, {"b": 4.0}, want=want).status) == "infeasible"
    assert str(solver.solve(model, {"b": 5.0}, want=want).status) == "partial"


@pytest.mark.parametrize("condition", ["x > c", "x >= c", "not (x < c)", "not (x <= c)"])
@pytest.mark.parametrize("cap", [5.0, -2.0, 0.1])
def test_the_end_of_a_continuum_is_no_answer(condition: str, cap: float) -> None:
    """Which of the two cases the end belongs to makes no difference: any x from there on will
    do."""
    model = rulesheets.loads(f"if {condition} then y = c else y = x\nw = 2*x")
    result = solver.solve(model, {"y": cap, "c": cap})
    assert result.status is solver.Status.PARTIAL
    assert set(result.undetermined) == {"x", "w"}
    assert solver.solve(model, {"y": cap - 1.0, "c": cap})["x"] == cap - 1.0


def test_the_end_of_a_continuum_hides_no_other_answer() -> None:
    """From 2 on any x will do; so does -2, apart from these."""
    model = rulesheets.loads("if x > 2 then y = 4 else y = x^2")
    result = solver.solve(model, {"y": 4.0})
    assert [answer["x"] for answer in result.solutions] == [-2.0]
    assert "x > 2" in result.diagnoses[0].message
