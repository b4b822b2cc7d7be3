"""Rules that are 0/0: named as such, with their limits, and solved by them where that is asked
for."""

from __future__ import annotations

import math
from itertools import permutations

import pytest

import rulesheets
import solver

MEAN = "dTm = (dT1 - dT2)/ln(dT1/dT2)"
LOAN = "P = L*r/(1 - (1 + r)^(-n))"
NTU = "eps = (1 - exp(-NTU*(1 - Cr)))/(1 - Cr*exp(-NTU*(1 - Cr)))"
EXCHANGER = f"""dT1 = Thi - Tco
dT2 = Tho - Tci
{MEAN}
Q = U*A*dTm
Q = mh*(Thi - Tho)
Q = mc*(Tco - Tci)
"""
BALANCED = f"""Ch = mh*ch
Cc = mc*cc
Cr = min(Ch, Cc)/max(Ch, Cc)
NTU = UA/min(Ch, Cc)
{NTU}
Q = eps*min(Ch, Cc)*(Thi - Tci)
"""

FORWARD = [
    (MEAN, {"dT1": 40.0, "dT2": 40.0}, "dTm", 40.0),
    (LOAN, {"L": 12600.0, "r": 0.0, "n": 36.0}, "P", 350.0),
    (NTU, {"NTU": 1.5, "Cr": 1.0}, "eps", 0.6),
    ("y = sin(x)/x", {"x": 0.0}, "y", 1.0),
    ("y = (1 - cos(x))/x^2", {"x": 0.0}, "y", 0.5),
    ("y = (x^2 - a^2)/(x - a)", {"x": 3.0, "a": 3.0}, "y", 6.0),
    ("y = (x^k - 1)/k", {"x": 3.0, "k": 0.0}, "y", math.log(3.0)),
    ("y = x*ln(abs(x))", {"x": 0.0}, "y", 0.0),
    ("y = (1 + x)^(1/x)", {"x": 0.0}, "y", math.e),
]

BACKWARD = [
    (LOAN, {"P": 350.0, "r": 0.0, "n": 36.0}, {"L": 12600.0}),
    (LOAN, {"P": 350.0, "L": 12600.0, "n": 36.0}, {"r": 0.0}),
    (NTU, {"eps": 0.6, "Cr": 1.0}, {"NTU": 1.5}),
    (MEAN, {"dT1": 40.0, "dTm": 40.0}, {"dT2": 40.0}),
    (
        EXCHANGER,
        {"Thi": 100.0, "Tci": 20.0, "U": 3.0, "A": 1.0, "mh": 2.0, "mc": 2.0},
        {"Q": 96.0, "Tho": 52.0, "Tco": 68.0, "dTm": 32.0},
    ),
    (
        EXCHANGER,
        {"Thi": 100.0, "Tci": 20.0, "U": 3.0, "Q": 96.0, "mh": 2.0, "mc": 2.0},
        {"A": 1.0, "dTm": 32.0},
    ),
    (
        BALANCED,
        {"mh": 0.5, "ch": 4200.0, "mc": 2.0, "cc": 1050.0, "Thi": 90.0, "Tci": 20.0, "eps": 0.6},
        {"UA": 3150.0, "NTU": 1.5, "Q": 88200.0},
    ),
    (  # its flows differ by a unit of the last place in floats
        BALANCED,
        {"mh": 0.58, "ch": 4200.0, "mc": 4.06, "cc": 600.0, "Thi": 90.0, "Tci": 20.0, "Q": 97440.0},
        {"UA": 3248.0, "eps": 4 / 7},
    ),
]


@pytest.mark.parametrize(("text", "inputs", "name", "expected"), FORWARD)
def test_the_verdict_names_the_limit(
    text: str, inputs: dict[str, float], name: str, expected: float
) -> None:
    result = solver.solve(rulesheets.loads(text), inputs)
    assert str(result.status) == "singular"
    assert result[name] is None
    (diagnosis,) = result.diagnoses
    assert diagnosis.code == "S545"
    assert "undefined here" in diagnosis.message
    assert f"the limit is {expected:.10g}" in diagnosis.message
    assert diagnosis.labels[0].span.text == text.split("\n")[0]


@pytest.mark.parametrize(("text", "inputs", "name", "expected"), FORWARD)
def test_limits_fill_what_is_undefined(
    text: str, inputs: dict[str, float], name: str, expected: float
) -> None:
    for sheet, asked in ((text, True), (f"{text}\nlimits = yes", False)):
        result = solver.solve(rulesheets.loads(sheet), inputs, limits=asked)
        assert str(result.status) == "solved"
        assert result[name] == pytest.approx(expected, rel=1e-15, abs=1e-15)
        assert [diagnosis.code for diagnosis in result.diagnoses] == ["S595"]


@pytest.mark.parametrize(("text", "inputs", "expected"), BACKWARD)
def test_limits_are_found_backward(
    text: str, inputs: dict[str, float], expected: dict[str, float]
) -> None:
    result = solver.solve(rulesheets.loads(text), inputs, limits=True)
    assert str(result.status) == "solved"
    near = [
        solution
        for solution in result.solutions
        if all(
            solution[name] == pytest.approx(value, rel=1e-13, abs=1e-13)
            for name, value in expected.items()
        )
    ]
    assert len(near) == 1
    assert "S595" in {diagnosis.code for diagnosis in result.diagnoses}


@pytest.mark.parametrize(
    ("text", "inputs"),
    [
        ("y = abs(x)/x", {"x": 0.0}),
        ("y = (a - b)/(c - d)", {"a": 1.0, "b": 1.0, "c": 2.0, "d": 2.0}),
        ("y = x/x^2", {"x": 0.0}),
    ],
)
def test_without_a_two_sided_limit_none_is_taken(text: str, inputs: dict[str, float]) -> None:
    for limits in (False, True):
        result = solver.solve(rulesheets.loads(text), inputs, limits=limits)
        assert str(result.status) == "singular"
        assert "the limit is" not in result.diagnoses[0].message


def test_a_pole_is_no_zero_by_zero() -> None:
    result = solver.solve(rulesheets.loads("y = 1/(x - 1)"), {"x": 1.0}, limits=True)
    assert str(result.status) == "infeasible"


def test_a_wrong_value_beside_a_zero_by_zero_is_no_answer() -> None:
    for limits in (False, True):
        result = solver.solve(rulesheets.loads("y = sin(x)/x"), {"x": 0.0, "y": 1.5}, limits=limits)
        assert str(result.status) in ("singular", "inconsistent")


def test_the_limit_does_not_depend_on_the_order_of_rules() -> None:
    inputs = {"Thi": 100.0, "Tci": 20.0, "U": 3.0, "A": 1.0, "mh": 2.0, "mc": 2.0}
    for rules in list(permutations(EXCHANGER.splitlines()))[
        240::240
    ]:  # the first is among BACKWARD
        result = solver.solve(rulesheets.loads("\n".join(rules)), inputs, limits=True)
        assert result["Q"] == pytest.approx(96.0, rel=1e-14)


def test_a_setting_is_no_variable() -> None:
    sheet = rulesheets.loads("variables\n  limits = yes\n  x = 0\nrules\n  y = sin(x)/x")
    assert list(sheet.variables) == ["x", "y"]
    assert solver.solve(sheet)["y"] == 1.0
    assert solver.prepare(sheet, ["x"])(0.0) == (1.0,)
    assert "limits" in rulesheets.loads("limits = 2*x").variables


def test_a_broken_requirement_beside_a_zero_by_zero() -> None:
    result = solver.solve(rulesheets.loads("0 < x < 3.5\nx = abs(x)/x"), {"x": 0.0})
    assert str(result.status) == "singular"
    assert {"S535", "S545"} == {diagnosis.code for diagnosis in result.diagnoses}


def test_an_answer_that_is_a_limit_is_named_where_no_other_is_found() -> None:
    """A loan of 12,000 that 15 payments of 800 pay back bears no interest."""
    text = "A = P*i/(1 - (1 + i)^(-n))"
    model = rulesheets.loads(text)
    inputs = {"A": 800.0, "P": 12000.0, "n": 15.0}
    diagnosis = solver.solve(model, inputs).diagnoses[0]
    assert diagnosis.code == "S545"
    assert "the limit is 800" in diagnosis.message
    assert solver.solve(model, inputs, limits=True)["i"] == pytest.approx(0.0, abs=1e-12)


def test_limits_are_found_where_rules_give_the_numbers() -> None:
    """A balanced exchanger: Q = C*UA/(C + UA)*(Thi - Tci), with the same difference at both
    ends."""
    numbers = "".join(
        f"{name} = {value}\n" for name, value in [("Thi", 90), ("Tci", 20), ("mh", 2), ("mc", 2)]
    )
    model = rulesheets.loads(f"{numbers}U = 3\nA = 1\n{EXCHANGER}")
    refused = solver.solve(model).diagnoses[0]
    assert refused.code == "S545"
    assert refused.message.endswith("the limit is 28")
    result = solver.solve(model, limits=True)
    assert {name: result[name] for name in ("Q", "Tho", "Tco")} == {
        "Q": 84.0,
        "Tho": 48.0,
        "Tco": 62.0,
    }


@pytest.mark.parametrize(
    ("rule", "inputs", "hole"),
    [
        ("A = P*i/(1 - (1 + i)^-n)", {"P": 12000.0, "n": 48.0, "A": 250.0}, "i = 0"),
        ("A = P*i/(1 - (1 + i)^-n)", {"P": 36000.0, "n": 12.0, "A": 3000.0}, "i = 0"),
        ("F = A*((1 + i)^n - 1)/i", {"F": 2500.0, "n": 25.0, "A": 100.0}, "i = 0"),
    ],
)
def test_an_answer_by_a_limit_is_told_beside_others(
    rule: str, inputs: dict[str, float], hole: str
) -> None:
    """At 0 % a rate is the sum over the months, by the limit of the formula alone."""
    model = rulesheets.loads(rule)
    result = solver.solve(model, inputs)
    assert str(result.status) == "solved" and result["i"] != 0.0
    (note,) = (d for d in result.diagnoses if d.code == "S598")
    assert hole in note.message
    near = solver.solve(model, {**inputs, "n": inputs["n"] * 1.01})
    assert not any(d.code == "S598" for d in near.diagnoses)


@pytest.mark.parametrize(
    ("above", "below", "limit"),
    [
        ("sin(x)", "x", 1.0),
        ("exp(2*x) - 1", "x", 2.0),
        ("x", "exp(2*x) - 1", 0.5),
        ("tanh(0.1*x)", "0.1*x", 1.0),
        ("x^3 - 1", "x - 1", 3.0),
        ("10 - x", "ln(10/x)", 10.0),
        ("1200*x", "1 - (1 + x)^(-12)", 100.0),
    ],
)
@pytest.mark.parametrize(
    "rules",
    [
        "y = ({above})/({below})",
        "q = {above}\ny = q/({below})",
        "y = ({above})/q\nq = {below}",
        "r = {below}\nq = {above}\ny = q/r",
        "q = p\np = {above}\ny = q/({below})",
    ],
)
def test_a_limit_does_not_depend_on_how_rules_are_divided(
    above: str, below: str, limit: float, rules: str
) -> None:
    model = rulesheets.loads(
        "variables\n  x in [-0.5, 12]\nrules\n" + rules.format(above=above, below=below)
    )
    result = solver.solve(model, {"y": limit})
    assert str(result.status) == "singular"
    assert f"the limit is {limit:g}" in result.diagnoses[0].message
