"""What is found out once for rules and blocks of one shape when a path is planned."""

from __future__ import annotations

import re
from operator import attrgetter

import pytest

import rulesheets
import solver
from solver.path.graph import ModelGraph
from solver.path.isolate import isolate
from solver.path.planner import planner

RULES = [
    "0*y + x = {n}",
    "{n}*y + x = 3",
    "x*({n} + y)^2 = 2",
    "exp({n}*x) = y",
    "y/{n} = x",
    "{n}/y = x + {n}",
    "y = x + {n}*x*(1 - x/50)",
    "sin({n}*y)^2 + x^3 = y",
    "x*abs(x)/y = {n}",
]


@pytest.mark.parametrize("rule", RULES)
def test_rules_of_one_shape_share_isolations_and_what_these_cost(rule: str) -> None:
    numbers = ["2.5", "0", "1", "7", "0", "1", "3"]
    alike = [rule.format(n=n) for n in numbers]
    alike += [
        re.sub(r"\b[xy]\b", lambda name: {"x": "y2", "y": "x3"}[name[0]], rule) for rule in alike
    ]
    model = rulesheets.loads("\n".join(alike) + "\n")
    graph = ModelGraph(model)
    for equation in model.equations:
        for name in equation.names:
            found = graph.isolation(equation.index, graph.number[name])
            assert found == isolate(equation.left, equation.right, name)
            told = graph.effort(equation.index, graph.number[name])
            asked = attrgetter("cost", "branches")
            assert (told and asked(told)) == (found and asked(found))


def test_many_rules_of_one_shape_are_isolated_when_they_are_solved_only() -> None:
    rules = "\n".join(f"x{k} + y{k}^3 = {k}.5\nx{k} - y{k} = 0.{k}" for k in range(1, 100))
    model = rulesheets.loads(rules + "\n")
    made = planner(model)
    assert len(made.path(frozenset(), {}).steps) == 99
    assert len(made.graph._isolations) <= 4


ALONE = [
    "sind({x}) = {k}/4",
    "{x}^2 - 5*{k}*{x} = -2",
    "{k}^{x} = 0.5",
    "cosd({x}) = {k}",
    "sqrt({x}) = 1 - {k}",
]


@pytest.mark.parametrize("m", [0.6, 1.5])
@pytest.mark.parametrize("rule", ALONE)
def test_a_rule_is_solved_by_the_isolation_of_one_like_it_as_if_alone(rule: str, m: float) -> None:
    first, second = rule.format(x="x", k="k"), rule.format(x="y", k="m")
    ranges = "variables\n  x in [0, 1000]\n  y in [0, 700]\n\nrules\n"
    both = solver.solve(rulesheets.loads(f"{ranges}  {first}\n  {second}\n"), {"k": 0.8, "m": m})
    alone = solver.solve(rulesheets.loads(f"{ranges}  x = 0\n  {second}\n"), {"m": m})
    assert {answer["y"] for answer in both.solutions} == {answer["y"] for answer in alone.solutions}
    told = [[(d.message, d.variables) for d in found.diagnoses] for found in (both, alone)]
    assert told[0] == told[1] and alone.status == both.status
