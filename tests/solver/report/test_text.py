"""The variable sheet as a person reads it."""

from __future__ import annotations

from dataclasses import replace

import pytest

import rulesheets
import solver
from rulesheets.model import Model
from rulesheets.syntax import Span
from solver.facts import Status
from solver.path import Check, Evaluate, Path, SolveBlock
from solver.path.planner import PathTree
from solver.report import path
from solver.report.path import rule_status_table, rule_text, tree_text
from solver.report.sheet import result_text, work_line
from solver.solution.solving import Result, Solution


def test_the_sheet_of_a_solved_result(solved: Result) -> None:
    assert result_text(solved).split("\n") == [
        "St  Input       Name  Output            Unit  Comment",
        "--  ----------  ----  ----------------  ----  -------------",
        "    3           a                       mm    one leg",
        "    4           b                       mm    the other leg",
        "G   1           c     5                 mm    hypotenuse",
        "    'right      kind",
        "",
        "2 rules: 2 direct; all satisfied, worst residual 1e-16",
        "1 other answer: --all shows it",
    ]


def test_all_answers_stand_side_by_side(solved: Result) -> None:
    lines = result_text(solved, every=True).split("\n")
    assert lines[0].split() == [
        "St",
        "Input",
        "Name",
        "Output",
        "1",
        "Output",
        "2",
        "Unit",
        "Comment",
    ]
    assert lines[4].split() == ["G", "1", "c", "5", "-5", "mm", "hypotenuse"]
    assert lines[-1].endswith("worst residual 1e-16")


def test_explain_adds_locals_path_and_rules_used(solved: Result) -> None:
    text = result_text(solved, explain=True)
    assert "Used 2 of 2 rules." in text
    assert "f.angle  53.13010235" in text
    assert "1     c        2     hypotenuse.tk:1  c^2 = a^2 + b^2" in text
    assert "f.angle" not in result_text(solved)


def test_a_local_that_is_wanted_is_shown_and_nothing_without_a_value_that_is_not(
    solved: Result,
) -> None:
    answer = Solution({"a": 3.0, "b": 4.0, "f.angle": 53.0}, 0.0, 1)
    result = replace(solved, solutions=(answer,), wanted=("f.angle",), inputs={"a": 3.0, "b": 4.0})
    names = [line.split()[1:2] for line in result_text(result).split("\n")[2:5]]
    assert names == [["a"], ["b"], ["53"]]


def test_more_answers_may_exist(solved: Result) -> None:
    result = replace(solved, complete=False)
    assert result_text(result).endswith("1 other answer, maybe more: --all shows it")
    alone = replace(result, solutions=result.solutions[:1])
    assert result_text(alone).endswith("there may be other answers")


def test_an_unsolved_result_names_status_rules_and_diagnosis(unsolved: Result) -> None:
    text = result_text(unsolved)
    assert "partial: the inputs do not determine every variable" in text
    rows = [" ".join(line.split()) for line in text.splitlines()]
    assert "> hypotenuse.tk:1 c^2 = a^2 + b^2 c, b" in rows
    assert "* hypotenuse.tk:2 angle = atan2d(b, a) f.angle, b" in rows
    assert "S501" in text
    assert "give b or c" in text


def test_no_text_is_made_of_rules_that_are_only_counted(monkeypatch: pytest.MonkeyPatch) -> None:
    made: list[Span] = []

    def counted(span: Span) -> str:
        made.append(span)
        return rule_text(span)

    monkeypatch.setattr(path, "rule_text", counted)
    result = solver.solve(solver.loads("".join(f"x{k + 1} = 2*x{k}\n" for k in range(50))))
    table = rule_status_table(result).splitlines()
    assert table[-1] == "… and 38 more"
    assert [line.split()[1:5] for line in table[2:4]] == [
        ["<text>:1", "x1", "=", "2*x0"],
        ["<text>:2", "x2", "=", "2*x1"],
    ]
    assert len(made) == len(table) - 3


@pytest.mark.parametrize(
    ("steps", "checked", "expected"),
    [
        ((Evaluate(0, "c"), Check(1)), 2, "2 rules: 1 direct, 1 check"),
        ((Evaluate(0, "c"),), 1, "2 rules: 1 direct, 1 idle"),
        ((SolveBlock((0, 1), ("b", "c"), ("b",)),), 2, "2 rules: 1 block of 2"),
        ((SolveBlock((0, 1), ("b", "c"), ("b",)),), 1, "2 rules: 1 block of 2"),
    ],
)
def test_the_work_line_accounts_for_every_rule(
    solved: Result, steps: tuple[Evaluate | Check | SolveBlock, ...], checked: int, expected: str
) -> None:
    result = replace(solved, path=Path(steps), solutions=(Solution({}, 0.0, checked),))
    assert work_line(result) == f"{expected}; all satisfied, worst residual 0"


def test_a_block_shows_what_it_iterates_on(solved: Result) -> None:
    block = SolveBlock((0, 1), ("b", "c"), ("b",), (Evaluate(0, "c", 2),), (1,))
    result = replace(solved, path=Path((block,), ("a", "f.angle")))
    lines = tree_text(result.model, PathTree(result.path), result.wanted).split("\n")
    assert lines[2].split("  ")[0] == "1"
    assert "block of 2" in lines[2] and "iterating on b" in lines[2]
    assert lines[3].split()[:2] == ["c", "2"]
    assert lines[4].split()[0] == "(closes)"
    assert lines[-2:] == ["Not reached: a.", "Blocks can have any number of answers."]


def test_a_rule_that_has_no_value_is_not_counted_as_satisfied() -> None:
    rules = "(1*y + sgn(y))*y = int(pi()*y)\ny*y = y\ny/int(y*y) = y\n"
    result = solver.solve(rulesheets.loads(rules))
    assert [diagnosis.code for diagnosis in result.diagnoses] == ["S545"]
    assert "3 rules: 1 direct, 2 checks; 2 satisfied" in result_text(result)


def test_a_failed_solve_does_not_say_satisfied(unsolved: Result) -> None:
    for status in (Status.FAILED, Status.INCONSISTENT, Status.INFEASIBLE, Status.SINGULAR):
        assert "satisfied" not in result_text(replace(unsolved, status=status))


def test_an_empty_model_prints_its_header(solved: Result) -> None:
    empty = Model("empty", {}, (), ())
    result = replace(
        solved, model=empty, solutions=(Solution({}),), inputs={}, wanted=(), path=Path(())
    )
    assert result_text(result).startswith("St  Input")
