"""Verdicts that help: what to give, what to try next."""

from __future__ import annotations

import pytest

import rulesheets
import solver
from solver.report.text import result_text, rule_statuses


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


def test_failed_names_the_rules_and_a_range_to_give() -> None:
    text = "x*y^2 + sin(x*y)*z = 4\nx*z + cos(y*z) = 3\nx*x + y*y + z*z = sin(x*y*z)"
    result = solver.solve(rulesheets.loads(text))
    assert str(result.status) == "failed"
    (diagnosis,) = result.diagnoses
    assert len(diagnosis.labels) >= 2
    assert any("a range, " in note and " in [a, b]" in note for note in diagnosis.notes)


def test_a_contradiction_prints_a_rule_once() -> None:
    sheet = rulesheets.loads("call f(1; x)\ncall f(2; x)\nfunction f(a; x)\nrules\n  x = a*k\n  k = 3")
    result = solver.solve(sheet)
    assert str(result.status) == "inconsistent"
    shown = [status.equation.rule for status in rule_statuses(result)]
    assert len(shown) == len(set(shown))


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
def test_isolated_answers_are_shown_beside_a_curve(text: str, isolated: dict[str, float], free: str) -> None:
    result = solver.solve(rulesheets.loads(text))
    assert str(result.status) == "solved"
    assert [dict(answer) for answer in result.solutions] == [pytest.approx(isolated)]
    assert not result.complete
    (note,) = result.diagnoses
    assert (note.code, note.variables) == ("S596", (free,))
