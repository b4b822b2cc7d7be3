"""Small everyday questions with planted answers: nothing false, whatever the form.

``benchmarks/planted.py`` makes and judges as many as one has patience for.
"""

from __future__ import annotations

import rulesheets
import solver
from benchmarks.planted import FORMS, SPECIAL, Question, examine, findings, question


def test_small_everyday_questions() -> None:
    forms = [form for form in FORMS if form not in SPECIAL]
    found = [examine(1000 + k, form, plans=k % 8 == 0)[2] for k, form in enumerate(forms)]
    assert found == [[]] * len(forms)


def test_a_question_depends_on_its_seed_alone() -> None:
    assert [question(seed).text for seed in (7, 8)] == [question(seed).text for seed in (7, 8)]
    assert question(7).text != question(8).text


def test_the_judge_sees_what_is_wrong() -> None:
    made = Question("power", (("", "x^2", "4.0"),), planted={"x": -2.0}, body=("x^2 = 4",))
    right = solver.solve(rulesheets.loads(made.text))
    assert list(findings(made, right)) == []
    one = solver.solve(rulesheets.loads("x = sqrt(4)"))
    assert {what for what, _ in findings(made, one)} == {"false"}
    none = solver.solve(rulesheets.loads("x^2 = -4"))
    assert {what for what, _ in findings(made, none)} == {"false"}
    other = solver.solve(rulesheets.loads("x = 3"))
    assert "no root: {'x': 3.0}" in [detail for _, detail in findings(made, other)]
