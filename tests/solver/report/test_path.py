"""The path before any number: order, rules with their places, tears, cases, and the number of
answers."""

from __future__ import annotations

from collections.abc import Callable

import pytest

import rulesheets
import solver
from rulesheets.model import Value
from solver.__main__ import main
from solver.path import SolveBlock
from solver.path.planner import MAX_ENDS, PathTree, path_tree
from solver.report.path import reaches, tree_text
from solver.solution.solving import posted


def ahead(
    text: str, inputs: dict[str, Value] | None = None, want: str | None = None
) -> tuple[str, PathTree]:
    model = rulesheets.loads(text)
    found = path_tree(model, inputs or {}, None if want is None else frozenset({want}))
    return tree_text(model, found, posted(model) if want is None else (want,)), found


@pytest.fixture
def run(capsys: pytest.CaptureFixture[str]) -> Callable[..., tuple[int, list[str]]]:
    def run(*words: str) -> tuple[int, list[str]]:
        code = main(["path", *words])
        return code, [" ".join(line.split()) for line in capsys.readouterr().out.splitlines()]

    return run


def test_forward_the_crank_is_all_direct(run: Callable[..., tuple[int, list[str]]]) -> None:
    code, lines = run("offset_slider_crank")
    assert code == 0
    assert "1 position.yB position.tk:4 yB = offset" in lines
    assert "9 xB position.tk:6 if (branch='open) then xB - xA = sqrt(AB^2 - (yB - yA)^2)" in lines
    assert not any("block" in line for line in lines)
    assert lines[-1] == "One answer at most."


def test_the_slider_as_driver_makes_a_block(run: Callable[..., tuple[int, list[str]]]) -> None:
    _, lines = run("offset_slider_crank", "--set", "xB=9.79", "--clear", "thetaAO")
    assert "7 block of 3 xA, thetaAO, position.yA, iterating on thetaAO" in lines
    assert lines[-1] == "Blocks can have any number of answers."


def test_nothing_is_solved_for_a_path(run: Callable[..., tuple[int, list[str]]]) -> None:
    """A slider out of reach has no answer, and the same path."""
    reach, beyond = (
        run("offset_slider_crank", "--set", f"xB={xB}", "--clear", "thetaAO") for xB in (9.79, 99)
    )
    assert reach == beyond
    assert reach[0] == 0


def test_want_prunes(run: Callable[..., tuple[int, list[str]]]) -> None:
    _, lines = run("offset_slider_crank", "--want", "xB")
    assert [line.split()[:2] for line in lines[2:-1]] == [
        ["1", "position.yB"],
        ["2", "xA"],
        ["3", "position.yA"],
        ["4", "xB"],
    ]


def test_an_arm_that_the_inputs_decide_is_no_question() -> None:
    text, found = ahead("if mode = 'a then y = x else y = 2*x", {"mode": "b", "x": 1.0})
    assert not found.cases
    assert "else y = 2*x" in text


def test_cases_are_shown_with_their_conditions() -> None:
    text, found = ahead("if x > 0 then y = x^2 else y = -x", {"y": 4.0})
    blocks = text.split("\n\n")
    assert blocks[1].startswith("Where x > 0:") and "y = x^2" in blocks[1]
    assert blocks[2].startswith("Where not (x > 0):") and "y = -x" in blocks[2]
    assert found.branches == 3
    assert text.endswith("At most 3 answers.")


@pytest.mark.parametrize(
    ("first", "second", "inputs"),
    [
        ("x < 0", "x < -2", {}),
        ("x < a", "x < b", {"a": 0.0, "b": -2.0}),
        ("x < a", "b > x", {"a": 0.0, "b": -2.0}),
        ("x < a or x > 5", "x < b and w > 1", {"a": 0.0, "b": -2.0}),
        ("x < w", "w > x and z > 1", {}),
    ],
)
def test_an_arm_out_of_reach_is_no_case(first: str, second: str, inputs: dict[str, Value]) -> None:
    rules = f"if {first} then y = 1 else if {second} then z = w*5 else y = 3\nx^2 + y*x = 4"
    text, found = ahead(rules, inputs, "x")
    assert [block.split("\n")[0] for block in text.split("\n\n")[1:3]] == [
        f"Where {first}:",
        f"Where not ({first}):",
    ]
    assert "z = w*5" not in text
    assert len(list(found.ends())) == 2
    assert found.branches == 4


def test_an_arm_that_its_inputs_let_in_is_a_case() -> None:
    rules = "if x < a then y = 1 else if x < b then y = 2 else y = 3\nx^2 + y*x = 4"
    text, found = ahead(rules, {"a": -2.0, "b": 0.0})
    assert "Where not (x < a) and x < b:" in text
    assert len(list(found.ends())) == 3


def test_a_decision_on_what_is_computed_first_has_its_cases() -> None:
    rules = "a = b^3 + 1\nif a > 0 then p + q = 3\nif a <= 0 then p + q + r = 5\np - q = 1"
    text, found = ahead(rules, {"b": 1.0})
    assert "(decides)" in text
    blocks = {block.split("\n")[0]: block for block in text.split("\n\n")}
    either = blocks["Where a > 0:"]
    assert "block of 2" in either and "iterating on" in either and "Not reached: r." in either
    assert "Not reached: p, q, r." in blocks["Where not (a > 0):"]
    assert found.branches is None


def test_steps_are_numbered_on_through_a_case_and_not_checked_again() -> None:
    text, _ = ahead("w = 2*v\nif x > 0 then y = x^2 else y = -x", {"y": 4.0, "v": 1.0})
    assert "(checks)" not in text
    case = text.split("\n\n")[1].split("\n")
    assert case[3].split()[:2] == ["3", "x"]


def test_many_cases_are_not_spelled_out() -> None:
    rules = "\n".join(f"if x{i} > 0 then y{i} = x{i} + 1 else y{i} = x{i} - 1" for i in range(8))
    text, found = ahead(rules, {f"y{i}": 1.0 for i in range(8)})
    assert sum(1 for _ in found.ends()) <= MAX_ENDS
    assert "depends on how the conditions come out" in text


def test_what_is_not_reached_is_named_and_fails() -> None:
    text, found = ahead("a + b = c", {"a": 1.0})
    assert text == "No rule gives anything.\nNot reached: b, c."
    assert not reaches(found, ("b",))
    assert reaches(found, ("a",))


def test_the_number_of_ways_multiplies() -> None:
    text, found = ahead("x^2 = a\ny^2 = x", {"a": 16.0})
    assert found.branches == 4
    assert text.endswith("At most 4 answers.")


def test_a_pruned_explanation_says_what_was_needed(capsys: pytest.CaptureFixture[str]) -> None:
    main(["solve", "offset_slider_crank", "--want", "xB", "--explain"])
    out = capsys.readouterr().out
    assert "velocity.tk" not in out and "alphaAB" not in out
    assert "Used 4 of 38 rules." in out


def test_a_block_without_an_answer_stands_in_the_path_of_the_result() -> None:
    model = rulesheets.loads("jn(2, x)*x^0.5 + exp(-x*x) = 9 + exp(-x)*x")
    result = solver.solve(model)
    (block,) = result.path.steps
    assert isinstance(block, SolveBlock) and block.unknowns == ("x",)
    assert not result.solutions and list(result.attempts) == [block]
