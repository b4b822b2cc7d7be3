"""The first answer of a record next to some numbers, told without the others."""

from __future__ import annotations

import math
import random
from typing import Any

import pytest

import solver
from benchmarks.redistribution import linkage_question
from solver.ranking.ranking import FLOATS, Ranking
from solver.trace import records
from tests.everyday.corpus import sheets

ANGLES = "variables\nx in [0, 60]\nk = 5\nrules\nsin(x) + x/k = 1.2\ny = x^2\n"
"""Many answers of one iterated unknown, of which the sizes tell the first."""


@pytest.fixture(autouse=True)
def soon(monkeypatch: pytest.MonkeyPatch) -> None:
    """The first call pays for the first box already."""
    monkeypatch.setattr(records, "SOON", 1)


def far_and_near(number: float, share: float, seed: int) -> list[float]:
    draw = random.Random(seed)
    return [number * (1 + share * draw.uniform(-1, 1)) for _ in range(20)]


@pytest.mark.parametrize("share", [1e-3, 0.05, 0.6])
def test_a_call_returns_the_first_of_all_answers(share: float) -> None:
    model: Any = solver.loads(ANGLES)
    plan: Any = solver.prepare(model, ["k"], ["x", "y"])
    plan(5.0)
    for number in far_and_near(5.0, share, 1):
        assert plan(number) == pytest.approx(plan.all(number)[0], rel=1e-14)
        expected: Any = solver.solve(model, {"k": number}).solutions[0]
        assert plan(number)[0] == pytest.approx(expected["x"], rel=1e-12)


def test_others_are_not_followed_next_to_the_sample() -> None:
    plan: Any = solver.prepare(solver.loads(ANGLES), ["k"], ["x"])
    plan(5.0)
    plan(5.001)
    near = plan.records._nearby[plan.records.useful]
    told = near.box.uses
    assert plan(5.002) == plan.all(5.002)[0]
    assert near.box.uses == told + 1


def test_numbers_far_away_come_to_a_box_of_their_own() -> None:
    plan: Any = solver.prepare(solver.loads(ANGLES), ["k"], ["x"])
    plan(5.0)
    plan(5.001)
    near = plan.records._nearby[plan.records.useful]
    for _ in range(80):
        plan(6.0)
    low, high = near.box.ends
    assert low <= 6.0 <= high


def test_a_given_zero_is_one_for_the_rule_over_a_box_too(monkeypatch: pytest.MonkeyPatch) -> None:
    asked, keys_on = set[tuple[bool, ...]](), Ranking.keys_on

    def noted(self: Ranking, on: Any, answers: Any, given: Any, zero: tuple[bool, ...]) -> Any:
        if on is not FLOATS:
            asked.add(zero)
        return keys_on(self, on, answers, given, zero)

    monkeypatch.setattr(Ranking, "keys_on", noted)
    sheet = ANGLES.replace("k = 5", "k = 5\noff = 0").replace("= 1.2", "= 1.2 - off*x")
    plan: Any = solver.prepare(solver.loads(sheet), ["k", "off"], ["x"])
    plan(5.0, 0.0)
    asked.clear()
    plan(5.001, 0.0)
    assert asked == {(False, True)}


def test_what_is_no_number_is_told_as_ever() -> None:
    plan: Any = solver.prepare(solver.loads(ANGLES), ["k"], ["x"])
    plan(5.0)
    plan(5.001)
    with pytest.raises(TypeError):
        plan("5")
    with pytest.raises(solver.Unsolved):
        plan(math.inf)


EVERY = [question for sheet in sheets() for question in sheet.questions()]
SWAPPED = [question for question in EVERY if question.label != "forward"]


@pytest.mark.parametrize("question", SWAPPED[::50], ids=lambda question: question.id)
def test_a_plan_says_what_a_solve_says_near_its_sample_and_far_from_it(question: Any) -> None:
    model, draw = question.sheet.model, random.Random(question.id)
    given = {name: number for name, number in question.changes.items() if isinstance(number, float)}
    rest = {name: value for name, value in question.changes.items() if name not in given}
    plan: Any = solver.prepare(model, [*given], None, rest)
    for share in (0.0, 1e-3, 1e-3, 1e-2, 0.3, 0.3, 1e-3):
        numbers = {name: x * (1 + share * draw.uniform(-1, 1)) for name, x in given.items()}
        solved: Any = solver.solve(model, {**rest, **numbers})
        if not solved.solutions:
            with pytest.raises(solver.Unsolved):
                plan(*numbers.values())
            continue
        first = solved.solutions[0]
        for name, found in zip(plan.want, plan(*numbers.values()), strict=True):
            assert found == pytest.approx(first[name], rel=1e-9, abs=1e-9), (name, numbers)


def test_answers_that_sizes_alone_tell_apart_are_compared_at_every_call() -> None:
    asked: Any = linkage_question("four_link_chain", "posted", 308)
    plan: Any = solver.prepare(asked.model, [*asked.given], asked.want, asked.fixed)
    plan(*asked.given.values())
    draw = random.Random(0)
    for _ in range(8):
        near = [number * (1 + 2e-4 * draw.uniform(-1, 1)) for number in asked.given.values()]
        assert plan(*near) == plan.all(*near)[0]
    near = plan.records._nearby[plan.records.useful]
    assert near.call is not None and near.box.uses
