"""Verdicts that help: what does not depend on the freed input, what to give, what to try next."""

from __future__ import annotations

import math
import pickle
import re
from pathlib import Path

import pytest

import rulesheets
import solver
from solver.report.path import rule_status_table
from solver.report.sheet import result_text

MODELS = Path(__file__).parents[3] / "models"
GEARS = "n2 = n1*z1/z2\nn3 = n2*z3/z4\ni = n1/n3\n"
TEETH = {"z1": 20.0, "z2": 60.0, "z3": 25.0, "z4": 80.0}


SERIES = "Ceq = Ca*Va/(Va + Va*Ca/Cb)"
"""Two capacitors in series; the voltage of one cancels."""


@pytest.mark.parametrize(
    ("text", "inputs", "message"),
    [
        (GEARS, {**TEETH, "i": 10.0}, "i is 9.6 whatever n1 is, and 10 is given"),
        (
            "A = pi*d^2/4\nV = A*h\nr = V/(d^2*h)",
            {"r": 0.5, "h": 2.0},
            f"r is {math.pi / 4:.10g} whatever d is, and 0.5 is given",
        ),
        ("y = (x + 1)^2 - x^2 - 2*x", {"y": 4.0}, "y is 1 whatever x is, and 4 is given"),
        ("y = sin(x)^2 + cos(x)^2", {"y": 2.0}, "y is 1 whatever x is, and 2 is given"),
        (
            SERIES,
            {"Ca": 0.3, "Cb": 0.7, "Ceq": 0.2100000000003},
            "Ceq is 0.21 whatever Va is, and 0.2100000000003 is given",
        ),
    ],
)
def test_what_does_not_depend_on_the_freed_input_is_inconsistent(
    text: str, inputs: dict[str, float], message: str
) -> None:
    result = solver.solve(rulesheets.loads(text), inputs)
    assert str(result.status) == "inconsistent"
    (diagnosis,) = result.diagnoses
    assert (diagnosis.code, diagnosis.message) == ("S521", message)
    assert not any("e-1" in note for note in diagnosis.notes)


@pytest.mark.parametrize("ulps", [-2, -1, 0, 1, 2])
def test_what_cancels_is_free_where_the_rule_holds_but_for_rounding(ulps: int) -> None:
    equivalent = 1.0 / (1.0 / 0.3 + 1.0 / 0.7)
    given = equivalent + ulps * math.ulp(equivalent)
    result = solver.solve(rulesheets.loads(SERIES), {"Ca": 0.3, "Cb": 0.7, "Ceq": given})
    assert str(result.status) == "singular"
    assert [diagnosis.message for diagnosis in result.diagnoses] == [
        "Va is not determined here: this rule holds whatever Va is"
    ]


@pytest.mark.parametrize(
    ("text", "inputs"),
    [
        ("y = erf(x)", {"y": 1.5}),
        ("y = max(x, 3)", {"y": 2.0}),
        ("y = x^2 + 1", {"y": 0.5}),
        ("y = tanh(x)*k", {"y": 3e3, "k": 1e3}),
        ("exp(x) + y = b\ns = x + y", {"b": 0.3, "s": 1e-6}),
    ],
)
def test_what_does_depend_on_it_is_not(text: str, inputs: dict[str, float]) -> None:
    result = solver.solve(rulesheets.loads(text), inputs)
    assert "whatever" not in " ".join(diagnosis.message for diagnosis in result.diagnoses)


@pytest.mark.parametrize(
    ("text", "inputs", "want", "help_line"),
    [
        ("V = I*R\nP = V*I", {"V": 12.0}, ["P"], "give I or R"),
        ("q = a + b\nr = q*a", {"a": 1.0}, ["q"], "give b or r"),
        ("q*0 = 0\na = 3", {}, ["q"], "change the position"),
    ],
)
def test_to_give_what_is_asked_for_is_no_help(
    text: str, inputs: dict[str, float], want: list[str], help_line: str
) -> None:
    result = solver.solve(rulesheets.loads(text), inputs, want=want)
    notes = [note for diagnosis in result.diagnoses for note in diagnosis.notes]
    assert help_line in notes
    assert not any(note.startswith(f"give {want[0]}") for note in notes)


@pytest.mark.parametrize(
    ("rules", "note"),
    [
        ("y = k*T44", "is T4 meant?"),  # an input
        ("yy = k*T4", "is y meant?"),
        ("y = k*T4 + t0", None),  # every row is read
        ("y = kT4", "kT4 is one name: is k*T4 meant?"),
        ("y = k*e^(-T4)", "e is a variable: write exp(x) for a power of Euler's number"),
        ("y = k*T4 + ykT4", "ykT4 is one name: is y*k*T4 meant?"),
    ],
)
def test_a_name_that_may_be_misspelt_is_asked_about(rules: str, note: str | None) -> None:
    sheet = f"variables\n  T4 = 300\n  k = 2\n  y\nrules\n  {rules}"
    result = solver.solve(model := rulesheets.loads(sheet))
    assert result.status is solver.Status.PARTIAL
    notes = [note for one in (*model.notes, *result.diagnoses) for note in one.notes]
    assert [one for one in notes if "meant" in one or "Euler" in one] == ([note] if note else [])


def test_what_conditions_read_may_determine_all_by_itself() -> None:
    rules = (
        "8*c*b = b\nif w < 4.16 then 2*c = ln(pi + c)\nif w >= 4.16 then c = pi\n"
        "if b < -0.17 then b^3*w = b\nif b >= -0.17 then b*c^2*cosd(b) = 0.5*b"
    )
    (told,) = solver.solve(rulesheets.loads(rules)).diagnoses
    assert (told.code, told.notes) == ("S510", ("give w",))


def test_failed_names_the_rules_and_a_range_to_give() -> None:
    text = "x*y^2 + sin(x*y)*z = 4\nx*z + cos(y*z) = 3\nx*x + y*y + z*z = sin(x*y*z)"
    result = solver.solve(rulesheets.loads(text))
    assert str(result.status) == "failed"
    (diagnosis,) = result.diagnoses
    assert len(diagnosis.labels) >= 2
    assert any("a range, " in note and " in [a, b]" in note for note in diagnosis.notes)


def test_a_contradiction_prints_a_rule_once() -> None:
    sheet = rulesheets.loads(
        "call f(1; x)\ncall f(2; x)\nfunction f(a; x)\nrules\n  x = a*k\n  k = 3"
    )
    result = solver.solve(sheet)
    assert str(result.status) == "inconsistent"
    shown = [line.split()[1] for line in rule_status_table(result).splitlines()[2:]]
    assert shown and len(shown) == len(set(shown))


def test_a_block_of_deficient_rank_is_tried_again() -> None:
    text = "x + y = 5\n2*x + 2*y = 10\nx*w = 4\nw^2 + x = 5"
    result = solver.solve(rulesheets.loads(text))
    assert str(result.status) == "solved"
    assert all(answer["x"] + answer["y"] == pytest.approx(5.0) for answer in result.solutions)
    assert len(result.solutions) == 3


def test_the_words_on_other_answers_come_with_a_reason() -> None:
    result = solver.solve(
        rulesheets.loads("P = L*r/(1 - (1 + r)^(-n))"), {"P": 400.0, "L": 12600.0, "n": 36.0}
    )
    assert result.complete or "r by <text>:1" in result_text(result, every=True)
    cubic = solver.solve(rulesheets.loads("x^3 - 2*x = 5"))
    assert "other answers" not in result_text(cubic)


@pytest.mark.parametrize(
    ("text", "isolated", "free"),
    [
        ("(a - 1)*b = 0\n(a - 2)*(b - 3)*b = 0", {"a": 1.0, "b": 3.0}, "a"),
        ("a*(b - 1) = 0\na*(a - 2) = 0", {"a": 2.0, "b": 1.0}, "b"),
    ],
)
def test_isolated_answers_are_shown_beside_a_curve(
    text: str, isolated: dict[str, float], free: str
) -> None:
    result = solver.solve(rulesheets.loads(text))
    assert str(result.status) == "solved"
    assert [dict(answer) for answer in result.solutions] == [pytest.approx(isolated)]
    assert not result.complete
    (note,) = result.diagnoses
    assert (note.code, note.variables) == ("S596", (free,))


def test_a_contradiction_behind_a_long_search_still_says_what_to_leave_out() -> None:
    """The force on a nozzle is proportional to the pressure, and to the square of both diameters at
    once."""
    model = rulesheets.loads(
        "A1 = pi*D1^2/4\nA2 = pi*D2^2/4\np + rho*V1^2/2 = rho*V2^2/2\nA1*V1 = A2*V2\nQ = Cd*A2*V2\n"
        "F = p*A1 - rho*Q*(V2 - V1)"
    )
    inputs = {"p": 250000.0, "D1": 0.08, "D2": 0.03, "rho": 1000.0, "Cd": 0.95}
    force = solver.solve(model, inputs)["F"]
    (clash,) = solver.solve(model, {**inputs, "F": 1.05 * force}).diagnoses
    assert clash.code == "S520"
    assert {*clash.variables} >= {*inputs, "F"} - {"rho"}
    assert "leave out p: the other inputs make it 262500" in clash.notes


def test_a_given_number_may_determine_what_a_condition_says_but_for_its_rounding() -> None:
    """The total, given back, makes the shipping -2e-14; by the rule it is 0."""
    model = rulesheets.loads(
        "net = price*3*(1 - 15/100)\nif net > 500 then ship = 0 else ship = 12.5\ntotal = (net + "
        "ship)*1.21"
    )
    result = solver.solve(model, {"price": 249.0, "total": 768.2895})
    assert (str(result.status), result["ship"]) == ("solved", 0.0)
    assert str(solver.solve(model, {"price": 249.0, "total": 768.2896}).status) == "inconsistent"


def test_where_nothing_is_proven_a_value_at_which_there_is_an_answer_is_told() -> None:
    model = rulesheets.loads("x*y^2 + sin(x*y)*y = 4\nx + cos(y*x)*y = 3\nsind(t) = s + x^2/100\n")
    result = solver.solve(model, {"s": 10.0})
    assert str(result.status) == "failed"
    (note,) = (n for n in result.diagnoses[0].notes if "an answer was found at" in n)
    (value,) = re.findall(r"s = ([-\d.e]+)", note)
    assert str(solver.solve(model, {"s": float(value)}).status) == "solved"


def test_what_is_known_of_the_sheet_as_it_stands_tells_how_far_an_input_can_go() -> None:
    """At 30 N a load of 1e9 N is asked for, which is far beyond what any angle gives."""
    model = rulesheets.loads("variables\n F = 30\n a = 20\nrules\n N = F*sind(a) + F*cosd(a/2)\n")
    result = solver.solve(model, {"N": 1e9, "a": None})
    (note,) = result.diagnoses[0].notes
    (limit,) = re.findall(r"N ≤ ([\d.]+)", note)
    most = max(math.sin(a) + math.cos(a / 2) for a in (k / 1e4 for k in range(31416)))
    assert float(limit) == pytest.approx(30 * most, rel=1e-5)


@pytest.mark.parametrize(
    ("rules", "inputs", "needs"),
    [
        (
            "if T <= 0.5 then S = 2.5*T else if T <= 2 then S = 1.25 else S = 5/T^2\nV = 100*S",
            {"V": 130.0},
            "V ≤ 125",
        ),
        ("if a >= b then t = (a - b)/(a + 5) else t = 0", {"t": -2.0, "b": 3.0}, "t ≥ 0"),
    ],
)
def test_a_value_that_no_case_reaches_is_infeasible(
    rules: str, inputs: dict[str, float], needs: str
) -> None:
    """... though in a case that fixes it, it contradicts the rules."""
    result = solver.solve(rulesheets.loads(rules), inputs)
    assert str(result.status) == "infeasible"
    assert needs in result.diagnoses[0].notes[0]


def test_failed_names_the_rule_at_which_what_was_tried_ends() -> None:
    text = "x*y^2 + sin(x*y)*y = 4\nx + cos(y*x)*y = 3\nsind(t) = 10 + x^2"
    (diagnosis,) = solver.solve(rulesheets.loads(text)).diagnoses
    assert diagnosis.code == "S552"
    assert "no value of t satisfies this rule: it needs sind = 1" in diagnosis.message
    assert len(diagnosis.labels) == 1


@pytest.mark.parametrize(("share", "status"), [(0.999, "solved"), (1.001, "infeasible")])
def test_a_speed_that_a_linkage_never_reaches_is_proven_to_be_none(
    share: float, status: str
) -> None:
    """The slide of a quick return, swept forward, has a largest speed."""
    model = rulesheets.load(MODELS / "whitworth_quick_return" / "model.tk")
    forward = solver.prepare(model, ["phi"], ["vE"], given={"OC": 0.3})
    fastest = float(forward.sweep([float(phi) for phi in range(-180, 180)])["vE"].max())
    result = solver.solve(model, {"vE": share * fastest, "phi": None, "OC": 0.3}, want=["phi"])
    assert (str(result.status), result.complete) == (status, True)
    if status == "infeasible":
        (bound,) = re.findall(
            r"needs vE ≤ ([\d.]+)", " ".join(n for d in result.diagnoses for n in d.notes)
        )
        assert float(bound) == pytest.approx(fastest, rel=1e-4)


def test_what_may_be_left_out_of_a_contradiction_has_the_value_of_its_own_solve() -> None:
    """Without a stiffness the springs have an answer at infinity alone, which is none."""
    model = rulesheets.loads(
        "(k1 + k2)*x2 - k2*x3 = F2\n-k2*x2 + (k2 + k3)*x3 - k3*x4 = F3\n-k3*x3 + k3*x4 = F4\nR1 = "
        "-k1*x2"
    )
    given = {
        "k1": 100.0,
        "k2": 150.0,
        "k3": 200.0,
        "F2": 50.0,
        "F3": -20.0,
        "F4": 80.0,
        "R1": -115.5,
    }
    (clash,) = solver.solve(model, given).diagnoses
    told = dict(
        re.findall(r"leave out (\w+): the other inputs make it ([-\d.e]+)", "\n".join(clash.notes))
    )
    assert set(told) == {"F2", "F3", "F4", "R1"}
    for name, value in told.items():
        result = solver.solve(model, {**given, name: None})
        assert str(result.status) == "solved"
        assert float(value) == pytest.approx(result[name], rel=1e-9)


def test_a_positive_number_of_the_sheet_is_not_advised_to_become_negative() -> None:
    text = (
        "variables\n  f = 0.02\n  L = 10\n  D = 0.1\n  h\n  v >= 0\nrules\n  h = f*L/D*v^2/(2*9.81)"
    )
    (refusal,) = solver.solve(rulesheets.loads(text), {"h": -20.0}).diagnoses
    assert refusal.notes == ("with the other inputs as they are, a solution needs h ≥ 0",)


def test_the_way_to_a_solution_may_be_long_but_keeps_its_sign() -> None:
    """A lamp at height h gives at most I/h^2 below it, so that 50 lx need h ≤ 4."""
    text = "variables\n  I = 800\n  h\n  E\n  x\nrules\n  E = I*h/(h^2 + x^2)^1.5"
    (refusal,) = solver.solve(rulesheets.loads(text), {"E": 50.0, "h": 90.0}).diagnoses
    assert "h ≤ 4" in refusal.notes[0]


def test_a_contradiction_tells_which_rule_could_be_an_input() -> None:
    model = rulesheets.loads("variables\n  y\nrules\n  x = 3\n  y = 2*x")
    for inputs in ({"x": 4.0}, {"y": 8.0, "x": None}):
        (told,) = solver.solve(model, inputs).diagnoses
        assert told.code == "S520"
        assert "x = 3 is a rule: write it under `variables` to change x" in told.notes


@pytest.mark.parametrize(
    ("given", "bound"),
    [
        ({"c": 900.0}, "c < 7"),
        ({"c": 0.002}, "c > 1"),
        ({"b": 0.03, "c": 4.0}, "b > 1"),
        ({"a": 5000.0, "b": 30.0, "c": 40.0}, "a < 70"),
    ],
)
def test_a_bound_is_found_orders_of_magnitude_away(given: dict[str, float], bound: str) -> None:
    """The triangle inequality, for lengths in the wrong unit."""
    triangle = rulesheets.load("triangle")
    inputs = {"a": 3.0, "b": 4.0, **given}
    (refusal, *_) = solver.solve(triangle, inputs).diagnoses
    assert bound in refusal.notes[-1]


def test_a_wanted_input_that_the_others_determine_is_checked() -> None:
    """The slider is given, and the crank angle of the sheet was not cleared."""
    crank = rulesheets.load("offset_slider_crank")
    result = solver.solve(crank, {"xB": 9.79}, want=["thetaAO"])
    assert str(result.status) == "inconsistent"
    assert any(
        "leave out thetaAO: the other inputs make it -30.0377" in note
        for d in result.diagnoses
        for note in d.notes
    )
    with pytest.raises(solver.Unsolved) as caught:
        solver.prepare(crank, ["xB"], ["thetaAO"])(9.79)
    assert pickle.loads(pickle.dumps(caught.value)).diagnoses == caught.value.diagnoses
    with pytest.raises(KeyError) as unknown:
        result["thetaA0"]
    assert "thetaAO" in str(pickle.loads(pickle.dumps(unknown.value)))
    assert dict(result)["xB"] == 9.79
    assert solver.solve(crank, want=["thetaAO", "AO"])["thetaAO"] == -30.0
    right = solver.solve(crank)["xB"]
    assert str(solver.solve(crank, {"xB": right}, want=["thetaAO"]).status) == "solved"


def test_a_bound_serves_the_whole_sheet() -> None:
    """By the median alone 2*mb < 2*(a + c) would do; the sides need more."""
    sheet = "4*mb^2 = 2*a^2 + 2*c^2 - b^2\n16*A^2 = (a + b + c)*(b + c - a)*(a + c - b)*(a + b - c)"
    given = {"a": 7.0, "c": 9.0, "mb": 9.8}
    model = rulesheets.loads(sheet)
    (refusal, *_) = solver.solve(model, given).diagnoses
    limits = re.findall(r"(\w+) [<>≤≥] ([\d.]+)", refusal.notes[0])
    assert ("mb", "8") in limits
    for name, limit in limits:
        inward = 0.999 if name == "mb" else 1.001
        assert str(solver.solve(model, {**given, name: inward * float(limit)}).status) == "solved"
