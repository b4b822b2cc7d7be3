"""Equations solved by formula for an unknown that occurs several times, all in one part of them."""

from __future__ import annotations

import math

import pytest

import rulesheets
import solver
from solver.path.graph import _rule_angle_evidence as told_angles
from solver.path.isolate import isolate
from solver.path.planner import planner

SOLVABLE = (
    ("Pv = 0.61094*exp(17.625*T/(T + 243.04))", "T", {"T": 24.5}),
    (
        "P1*v1^n = P2*v2^n",
        "n",
        {"n": 1.3, "P1": 100.0, "v1": 1.2, "P2": 100.0 * 3.0**1.3, "v2": 0.4},
    ),
    (
        "V = A*(1 - (1 + i)^(-n))/i + r*(1 + i)^(-n)",
        "n",
        {"n": 47.0, "A": 350.0, "i": 0.006, "r": 4000.0},
    ),
    (
        "V = 1000*c/y*(1 - (1 + y)^-n) + 1000/(1 + y)^n",
        "n",
        {"n": 9.5, "c": 0.04, "y": 0.05},
    ),
    ("A = P*i*(1 + i)^n/((1 + i)^n - 1)", "n", {"n": 96.0, "P": 25_000.0, "i": 0.004}),
    ("e = (1 - exp(-N*(1 - C)))/(1 - C*exp(-N*(1 - C)))", "N", {"N": 1.6, "C": 0.7}),
    ("z - H = 3*Q*abs(Q)", "Q", {"Q": -0.8, "z": 12.0}),
    ("pH = 4.76 + log((0.1*V + n)/(0.2*V - n))", "n", {"n": 0.013, "V": 0.5}),
    ("pH = 4.76 + log((0.1*V + n)/(0.2*V - n))", "V", {"n": 0.013, "V": 0.5}),
)


@pytest.mark.parametrize(("rule", "unknown", "values"), SOLVABLE)
def test_the_value_that_was_put_in_comes_out(
    rule: str, unknown: str, values: dict[str, float]
) -> None:
    model = rulesheets.loads(rule + "\n")
    state = dict(solver.solve(model, values).solutions[0].items())
    asked = {**state, unknown: None}
    found = solver.solve(model, asked)
    assert str(found.status) == "solved"
    assert found.complete
    assert [answer[unknown] for answer in found.solutions] == [
        pytest.approx(values[unknown], rel=1e-12)
    ]
    given = {name: value for name, value in state.items() if name != unknown}
    prepared = solver.prepare(model, given, [unknown])
    assert math.isclose(prepared(**given)[0], values[unknown], rel_tol=1e-12)


@pytest.mark.parametrize(
    ("rule", "values", "status"),
    [
        ("A = P*i*(1 + i)^n/((1 + i)^n - 1)", {"P": 1000.0, "i": 0.01, "A": 5.0}, "infeasible"),
        ("A = P*i*(1 + i)^n/((1 + i)^n - 1)", {"P": 1000.0, "i": 0.0, "A": 5.0}, "singular"),
        ("e = (1 - exp(-N*(1 - C)))/(1 - C*exp(-N*(1 - C)))", {"e": 1.5, "C": 0.5}, "infeasible"),
        ("e = (1 - exp(-N*(1 - C)))/(1 - C*exp(-N*(1 - C)))", {"e": 0.5, "C": 1.0}, "singular"),
        ("a^x = 3*b^x", {"a": -2.0, "b": -4.0}, "infeasible"),
        ("a^x = b^x", {"a": 2.0, "b": 2.0}, "singular"),
        ("z - H = K*Q*abs(Q)", {"z": 10.0, "H": 13.0, "K": 0.0}, "infeasible"),
    ],
)
def test_where_there_is_no_answer(rule: str, values: dict[str, float], status: str) -> None:
    found = solver.solve(rulesheets.loads(rule + "\n"), values)
    assert str(found.status) == status
    assert not found.solutions or len(found.solutions[0]) == len(values)


def test_negative_bases_take_whole_exponents() -> None:
    model = rulesheets.loads("a^x = c*b^x\n")
    assert solver.solve(model, {"a": -2.0, "b": 1.0, "c": -8.0}).solutions[0]["x"] == 3.0
    assert solver.solve(model, {"a": -2.0, "b": 1.0, "c": 4.0}).solutions[0]["x"] == 2.0


def test_no_part_is_exchanged_that_lacks_an_occurrence_of_the_unknown(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The power at a bus of three lines: no part of it but the whole holds every occurrence of its
    angle."""

    def exchanged(*_: object) -> object:
        raise AssertionError("a part was exchanged")

    monkeypatch.setattr("rulesheets.syntax.nodes.exchange", exchanged)
    power = " + ".join(f"V{k}*(3*cos(d - d{k}) + 5*sin(d - d{k}))" for k in range(3))
    rule = rulesheets.loads(f"{power} = 0.4\n").equations[0]
    assert isolate(rule.left, rule.right, "d") is None


def test_rules_of_one_shape_tell_their_angles_by_their_own_names_and_numbers() -> None:
    rules = [f"x{k} = r*cosd(t{k}/{k}) + sind(t{k} + u{k})" for k in (1, 2, 3)]
    graph = planner(
        rulesheets.loads("\n".join([*rules, "y = r*u3", "z = r*cosd(2*v)", "w = r*cosd(3*v)"]))
    ).graph
    assert {name: graph.turn(name) for name in ("t1", "t2", "t3", "u1", "u3", "v", "r")} == {
        "t1": 360.0,
        "t2": 720.0,
        "t3": 1080.0,
        "u1": 360.0,
        "u3": None,
        "v": 360.0,
        "r": None,
    }


def test_the_trees_of_rules_are_not_made_to_find_angles(monkeypatch: pytest.MonkeyPatch) -> None:
    made: list[object] = []
    told = told_angles
    monkeypatch.setattr(
        "solver.path.graph._rule_angle_evidence", lambda *sides: made.append(sides) or told(*sides)
    )
    graph = planner(rulesheets.loads("".join(f"x{k} = r*cosd(t{k})\n" for k in range(20)))).graph
    assert graph.turn("t7") == 360.0
    assert len(made) == 1


@pytest.mark.parametrize(
    "rules",
    [
        "y = sqrt(a/(2*a + a*b^2))\nz = a^3 + b^2\n",
        "y = exp(a*b/(2*a))\nz = a^3 + exp(b)\n",
        "y = acosd(a/a) + b - b\nz = (a*b)^2\n",
    ],
)
def test_a_common_factor_is_not_taken_for_zero(rules: str) -> None:
    model = rulesheets.loads(rules)
    planted = solver.solve(model, {"a": 1.5, "b": 2.0}).solutions[0]
    found = solver.solve(model, {"y": planted["y"], "z": planted["z"]})
    assert str(found.status) != "infeasible"
    if found.status is solver.Status.SOLVED:
        assert any(answer["a"] == pytest.approx(1.5) for answer in found.solutions)
    else:
        assert not found.complete
