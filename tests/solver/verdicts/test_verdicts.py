"""Small probes with a known verdict: the status, and a sentence that names rules, variables and
values."""

from __future__ import annotations

import math
import re
from pathlib import Path
from typing import Any

import mpmath
import pytest
from scipy.optimize import fsolve

import rulesheets
import solver
from rulesheets.diagnosis import RuleSheetError

CRANK = Path(__file__).parents[3] / "models" / "offset_slider_crank" / "model.tk"


def solve(*rules: str, **given: Any) -> Any:
    return solver.solve(rulesheets.loads("\n".join(rules) + "\n"), given)


def said(result: Any) -> str:
    """Everything that the diagnoses say, the rules that they point at included."""
    lines = []
    for diagnosis in result.diagnoses:
        lines += [diagnosis.message, *diagnosis.notes]
        lines += [
            label.span.source.text[label.span.start : label.span.end] for label in diagnosis.labels
        ]
    return "\n".join(lines)


@pytest.mark.parametrize("x", ["x", "(x - 1)", "(2*x)"])
def test_cubic_has_one_real_root(x: str) -> None:
    result = solve(f"3*{x}^3 - 200*{x}^2 - {x} - 1 = 0")
    with mpmath.workdps(50):
        (root,) = (r for r in mpmath.polyroots([3, -200, -1, -1], maxsteps=200) if not mpmath.im(r))
        expected = {"x": root, "(x - 1)": root + 1, "(2*x)": root / 2}[x]
    assert str(result.status) == "solved"
    assert result.complete
    assert [s["x"] for s in result.solutions] == [pytest.approx(float(expected), rel=1e-14)]


def test_cubic_with_three_real_roots() -> None:
    result = solve("x^3 - 7*x + 6 = 0")
    assert sorted(s["x"] for s in result.solutions) == pytest.approx([-3.0, 1.0, 2.0])
    assert result.complete


@pytest.mark.parametrize("second", ["2*x + 2*y = 52", "26 - y = x", "0.1*x + 0.1*y = 2.6"])
def test_redundant_pair_determines_too_little(second: str) -> None:
    result = solve("x + y = 26", second)
    assert str(result.status) == "partial"
    assert set(result.undetermined) == {"x", "y"}
    assert "x and y" in said(result)


def test_redundant_pair_of_decimals_is_not_called_a_contradiction() -> None:
    assert str(solve("x + y = 26.1", "3*x + 3*y = 78.3").status) == "partial"


@pytest.mark.parametrize(
    "rules", [("x + y = 26", "x + y = 27"), ("2*x + 2*y = 52", "x + y = 27", "z = x")]
)
def test_pair_that_contradicts_is_named(rules: tuple[str, ...]) -> None:
    result = solve(*rules)
    assert str(result.status) == "inconsistent"
    assert {line for line in said(result).splitlines() if line in rules} == set(rules[:2])


@pytest.mark.parametrize(
    ("rules", "guilty"),
    [
        (("x*y = 6", "x*y = 7"), (0, 1)),
        (("exp(x)*y = 0.3", "7*y*exp(x) = 2.2"), (0, 1)),
        (("x*y + z = 1", "x + z = 2", "x*y + x + 2*z = 4"), (0, 1, 2)),
        (("a*x*y = 6", "w*sin(x) = y", "y*x/2 = 2", "a = 2"), (0, 2, 3)),
    ],
)
def test_rules_that_contradict_each_other_in_products_are_named(
    rules: tuple[str, ...], guilty: tuple[int, ...]
) -> None:
    """Far out, where x is 1e20, floats cannot tell them from rules that say the same thing
    twice."""
    result = solve(*rules)
    assert str(result.status) == "inconsistent"
    assert {line for line in said(result).splitlines() if line in rules} == {
        rules[k] for k in guilty
    }


def test_rules_that_say_the_same_in_products_leave_unknowns_free() -> None:
    for rules in (("x*y = 0.1", "3*x*y = 0.3"), ("x*y + z = 1", "x + z = 2", "x*y + x + 2*z = 3")):
        result = solve(*rules)
        assert str(result.status) == "partial"
        assert {"x", "y"} <= set(result.undetermined)


def test_ohms_law_asks_for_one_of_three() -> None:
    result = solve("V = I*R", "P = V*I", V=12.0)
    assert str(result.status) == "partial"
    assert set(result.undetermined) == {"I", "R", "P"}
    assert "give I, or R, or P" in said(result).replace("give I, R or P", "give I, or R, or P")


def test_both_modes_of_the_crank() -> None:
    result = solver.solve(rulesheets.load(CRANK), {"xB": 9.791823496, "thetaAO": None})
    assert str(result.status) == "solved"
    angles = sorted(s["thetaAO"] for s in result.solutions)
    assert angles == pytest.approx([-30.0, 53.0879880], abs=1e-6)


def test_slider_out_of_reach() -> None:
    """The reach: hypot(xB, offset) is at most AO + AB, so xB alone has a bound."""
    result = solver.solve(rulesheets.load(CRANK), {"xB": 11.0, "thetaAO": None})
    assert str(result.status) == "infeasible"
    assert result.solutions == () and result.complete
    bound = re.search(
        r"xB ≤ ([\d.]+\d)", said(result)
    )  # the input that the caller changed comes first
    assert bound
    assert float(bound[1]) == pytest.approx(math.sqrt(11.0**2 - 2.0**2), rel=1e-5)


@pytest.mark.parametrize(
    ("rule", "given", "bound"),
    [
        ("y = ln(x)", {"x": -2.0}, "x > 0"),
        ("y = sqrt(x)", {"x": -2.0}, "x ≥ 0"),
        ("y = sqrt(x - 5)", {"x": 1.8}, "x ≥ 5"),
        ("y = sqrt(-x)", {"x": 1.8}, "x ≤ 0"),
        ("y = ln(-x)", {"x": 1.8}, "x < 0"),
        ("y = 1/x", {"x": 0.0}, "x ≠ 0"),
        ("y = 1/(x - 3)", {"x": 3.0}, "x ≠ 3"),
        ("a*y = 5", {"a": 0.0}, "a ≠ 0"),
        ("a = 3*cosd(y)", {"a": 3.24}, "a ≤ 3"),
        ("a*y = 16\ny < 2", {"a": 2.0}, "a > 8"),  # any a below 0 would do, too
    ],
)
def test_a_bound_says_whether_it_belongs_to_what_is_feasible(
    rule: str, given: dict[str, float], bound: str
) -> None:
    result = solve(rule, **given)
    assert str(result.status) == "infeasible"
    assert f"a solution needs {bound}" in said(result)


def test_rates_at_dead_centre_are_not_determined() -> None:
    """Stretched out along the x-axis: whatever the crank's rate, the slider stands."""
    given = {"offset": 0.0, "thetaAO": 0.0, "omegaAO": None, "vB": 0.0}
    result = solver.solve(rulesheets.load(CRANK), given)
    assert str(result.status) == "singular"
    assert "omegaAO" in said(result)


def test_slider_that_moves_at_dead_centre_is_infeasible() -> None:
    given = {"offset": 0.0, "thetaAO": 0.0, "omegaAO": None, "vB": 5.0}
    result = solver.solve(rulesheets.load(CRANK), given)
    assert str(result.status) == "infeasible"


@pytest.mark.parametrize(
    ("rule", "reading"),
    [
        ("sqrt(x) = -3.2", "sqrt = -3.2"),
        ("x^2 = -3.2", "sqrt of -3.2"),
        ("cosd(x) = 1.08", "cosd = 1.08"),
        ("0*x = 1", "0 times x = 1"),
        ("x/0 = 1", "division by 0 for x"),
        ("exp(x) = 0", "exp = 0"),
    ],
)
def test_infeasible_rule_tells_the_operation_and_its_value(rule: str, reading: str) -> None:
    result = solve(rule)
    assert str(result.status) == "infeasible"
    assert re.search(rf"needs {re.escape(reading)}$", said(result), re.MULTILINE)
    assert rule in said(result)


@pytest.mark.parametrize(
    "rules", [("x = x",), ("0*x = 0",), ("x^y = 1", "y = 0"), ("atan2d(x, y) = 90", "y = 0")]
)
def test_rule_that_holds_for_any_value_leaves_it_free(rules: tuple[str, ...]) -> None:
    result = solve(*rules)
    assert str(result.status) == "singular"
    assert result.undetermined == ("x",)
    assert "x is not determined" in said(result)


def test_where_a_given_rule_is_undefined_all_that_stays_unknown_is_told() -> None:
    result = solve("sin(x)/x = 2", "y = 3*w", x=0.0)
    assert str(result.status) == "singular"
    assert set(result.undetermined) == {"y", "w"}


@pytest.mark.parametrize(
    ("rule", "roots"),
    [
        ("(-2)^x = 4", [2.0]),
        ("(-2)^x = -8", [3.0]),
        ("0^x = 1", [0.0]),
        ("x^(-2) = 4", [-0.5, 0.5]),
        ("(x^2 - 1)/(x - 1) = 3", [2.0]),
        ("sqrt(x) = x - 1", [(3 + 5**0.5) / 2]),
        ("abs(x - 2) = 3", [-1.0, 5.0]),
        ("sind(2*x) = -0.5", [-75.0, -15.0, 105.0, 165.0]),
    ],
)
def test_every_answer_of_one_rule(rule: str, roots: list[float]) -> None:
    result = solve(rule)
    assert str(result.status) == "solved"
    assert sorted(s["x"] for s in result.solutions) == pytest.approx(roots)
    assert result.complete


@pytest.mark.parametrize("rule", ["mod(x, 3) = 1", "tan(x) = x/2 + 1", "sind(x^2) = 0.5"])
def test_no_list_of_infinitely_many_answers_is_called_complete(rule: str) -> None:
    assert not solve(rule).complete


@pytest.mark.parametrize("rule", ["int(x) = 3", "round(x) = 3", "max(x, 3) = 3", "abs(x) = x"])
def test_stretch_of_answers_is_neither_solved_nor_refuted(rule: str) -> None:
    assert str(solve(rule).status) in ("partial", "singular")


@pytest.mark.parametrize(
    "rules",
    [
        ("if x > 0 then x = -1 else x = 1",),
        ("if x > 0 then y = x else y = -x", "y = -4"),
        ("if x > y then z = 1 else z = 2", "x + y = 5", "x - z = 1"),
    ],
)
def test_rules_of_which_no_case_fits_are_refuted(rules: tuple[str, ...]) -> None:
    assert str(solve(*rules).status) in ("infeasible", "inconsistent")


def test_value_given_by_the_case_where_a_rule_asks_nothing() -> None:
    result = solve("if x <> 3 then y = 1", "x + y = 4")
    assert [(s["x"], s["y"]) for s in result.solutions] == [(3.0, 1.0)]


@pytest.mark.parametrize(
    ("text", "given"),
    [
        ("y = 2*x", {"x": "open"}),
        ("y^2 = 2*x + sin(z)\nz = y", {"x": "open"}),
        ("if y > 2 then z = x*2 else z = 3\ny = z + 1", {"x": "open"}),
        ("x = y\nz = x*2", {"y": "open"}),
    ],
)
def test_a_symbol_for_what_rules_compute_with_is_refused(text: str, given: dict[str, str]) -> None:
    with pytest.raises(RuleSheetError) as caught:
        solver.solve(rulesheets.loads(text), given)
    (diagnosis,) = caught.value.diagnoses
    assert diagnosis.code == "E406"
    assert f"{next(iter(given))} is a number that rules compute with" in diagnosis.message


def test_a_rule_that_computes_with_a_symbol_says_so() -> None:
    """Some case of the rules gives x a number, so that a symbol is no mistake at the door."""
    text = "if k > 2 then x = 'open else x = 1\ny = 2*x\nk = 3"
    (diagnosis,) = solver.solve(rulesheets.loads(text)).diagnoses
    assert (diagnosis.code, diagnosis.variables) == ("S534", ("x",))
    assert "x, which is the symbol 'open" in diagnosis.message


def test_a_symbol_that_is_only_compared_is_no_mistake() -> None:
    result = solver.solve(
        rulesheets.loads("if x > 2 then y = 2 else y = 3\nz = w"), {"x": "open", "w": "off"}
    )
    assert (result["y"], result["z"]) == (3.0, "off")


@pytest.mark.parametrize(
    ("sheet", "given"),
    [
        # a four-bar whose rocker is given beside the crank: no coupler of 7 reaches, however it is
        # turned
        (
            "2*cosd(30) + 7*cosd(t) = 6 + 9*cosd(r)\n2*sind(30) + 7*sind(t) = 9*sind(r)\nmu = "
            "abs(r - t)",
            {"r": 123.15},
        ),
        # Kepler's equation fixes E; the tangent of half of it has infinitely many
        (
            "tan(E/2) = sqrt((1 - e)/(1 + e))*tand(nu/2)\nM = E - e*sin(E)",
            {"e": 0.5, "nu": 75, "M": 0.4869},
        ),
        # a shock tube with a velocity beside the pressures
        (
            "p4 = p/(1 - (p - 1)*0.4/sqrt(2*k*(2*k + (k + 1)*(p - 1))))^(2*k/(k - 1))\n"
            "u = 340/k*(p - 1)*sqrt(2*k/(k + 1)/(p + (k - 1)/(k + 1)))",
            {"k": 1.4, "p4": 8, "u": 264.85},
        ),
    ],
)
def test_numbers_that_contradict_each_other_are_said_to(
    sheet: str, given: dict[str, float]
) -> None:
    """Although the rule that was solved first may have more answers than are listed."""
    result = solver.solve(rulesheets.loads(sheet), given)
    assert str(result.status) == "inconsistent"
    assert result.diagnoses[0].code == "S520"


@pytest.mark.parametrize("share", [1.0, 1.05])
def test_a_balance_that_follows_from_the_others_leaves_room_for_other_rules(share: float) -> None:
    """Two loops of pipes with a balance at every node, and one flow given beside what determines
    it."""
    sheet = """
        100 = Q1 + Q2
        Q1 = 30 + Q3 + Q4
        Q2 + Q3 = 30 + Q5
        Q4 + Q5 = 40
        8*Q1*abs(Q1) + 10*Q3*abs(Q3) = 15*Q2*abs(Q2)
        20*Q4*abs(Q4) = 10*Q3*abs(Q3) + 12*Q5*abs(Q5)
    """

    def misses(flows: Any) -> list[float]:
        q1, q3 = flows
        q2, q4 = 100 - q1, q1 - 30 - q3
        losses = [
            c * q * abs(q)
            for c, q in zip((8, 15, 10, 20, 12), (q1, q2, q3, q4, 40 - q4), strict=True)
        ]
        return [losses[0] + losses[2] - losses[1], losses[3] - losses[2] - losses[4]]

    q1, q3 = fsolve(misses, [55.0, 10.0], xtol=1e-12)
    forward = solver.solve(rulesheets.loads(sheet))
    assert [forward["Q1"], forward["Q3"]] == pytest.approx([q1, q3])
    repeated = solver.solve(rulesheets.loads(sheet), {"Q3": share * float(forward["Q3"])})
    assert str(repeated.status) == ("solved" if share == 1.0 else "inconsistent")


def test_a_local_without_a_value_spoils_no_answer():
    """At x = -2 the local k, which nothing needs, would be a root of -1."""
    found = solver.solve(
        rulesheets.loads(
            "x^2 = 4\ncall f(x; w)\nfunction f(p; q)\nrules\n  k = sqrt(p + 1)\n  q = 2*p\n"
        )
    )
    assert [(answer["x"], answer["w"]) for answer in found.solutions] == [(2.0, 4.0), (-2.0, -4.0)]
    assert str(found.status) == "solved" and found.complete


@pytest.mark.parametrize(
    "form",
    [
        "(360 - d)*(c - d)",
        "sin(c + d)*(c - d)",
        "ln(c*d)*(c - d)",
        "exp(c - d) + c",
        "(c + d)^2 + (c - d)",
    ],
)
@pytest.mark.parametrize("more", [(), ("d^5*(c*z + z/z) = 47249.9",)], ids=["alone", "third"])
def test_one_form_has_one_value(form: str, more: tuple[str, ...]) -> None:
    """Whatever its unknowns are; far out its rules only seem to touch. No third rule is to blame,
    nor what it reads."""
    given = {"z": -1.24} if more else {}
    result = solve(f"{form} = -2208.554321525421", f"{form} = -1416.4420992", *more, **given)
    (diagnosis,) = result.diagnoses
    assert result.status is solver.Status.INCONSISTENT
    assert diagnosis.message == "these rules contradict each other"
    assert len(diagnosis.labels) == 2


def test_a_partial_answer_is_listed_once() -> None:
    """Of the signs of two angles the reactive power leaves one pair, whatever the voltage is."""
    sheet = ("cosd(phi1) = pf1", "cosd(phi2) = pf2", "Q = P*(tand(phi1) - tand(phi2))", "P = V*I")
    reactive = 80.0 * (math.tan(math.acos(0.72)) - math.tan(math.acos(0.95)))
    result = solve(*sheet, pf1=0.72, pf2=0.95, P=80.0, Q=reactive)
    assert result.status is solver.Status.PARTIAL
    (solution,) = result.solutions
    angles = [math.degrees(math.acos(pf)) for pf in (0.72, 0.95)]
    assert [solution["phi1"], solution["phi2"]] == pytest.approx(angles, rel=1e-12)


def test_what_inputs_refuse_is_refuted_beside_an_angle_of_many_turns() -> None:
    """No list of the turns of w is whole, but no value of n helps in any of them."""
    sheet = "d = 23.45*sin(n)\ncosd(w) = 0.3\nN = 2/15*w"
    result = solver.solve(rulesheets.loads(sheet), {"d": 24.2})
    assert result.status is solver.Status.INFEASIBLE
    assert "d ≤ 23.45" in result.diagnoses[0].notes[0]


@pytest.mark.parametrize("rest", ["x = u^2 + 3", "x = u^2 + v^2 + 3\nu = 2*v"])
def test_the_case_that_was_followed_farthest_tells_why(rest: str) -> None:
    """y = 4 is that of x = 2, and does not contradict its rule."""
    sheet = f"if x < 10 then y = 2*x else y = 5\n{rest}"
    result = solver.solve(rulesheets.loads(sheet), {"y": 4.0})
    assert result.status is solver.Status.INFEASIBLE
    assert "y ≥ 6" in result.diagnoses[0].notes[0]


def test_a_duct_without_friction_is_refused_with_its_reason() -> None:
    """The advice looks as far as floats go, where a rule divides by 0."""
    sheet = (
        "vel = V/(pi*D^2/4)\nRe = vel*D/nu\n1/sqrt(f) = -2*log(2.51/(Re*sqrt(f)))\n"
        "hL = f*(L/D)*vel^2/(2*9.81)"
    )
    known = {"V": 0.35, "L": 150.0, "nu": 1.655e-5, "f": 0.0}
    result = solver.solve(rulesheets.loads(sheet), known)
    assert str(result.status) == "infeasible"
    assert "division by 0" in result.diagnoses[0].message


@pytest.mark.parametrize("t", [-1.0, 0.0, 19.0, 20.0, 95.0])
def test_a_table_says_that_no_condition_of_it_holds(t: float) -> None:
    table = "if t < 0 then y = t else if t < 10 then y = 1 + t else if t < 20 then y = 11"
    result = solve(table, "w = 2*y", t=t)
    assert str(result.status) == ("partial" if t >= 20.0 else "solved")
    assert ("no condition of this rule holds" in said(result)) is (t >= 20.0)
    assert (table in said(result)) is (t >= 20.0)
