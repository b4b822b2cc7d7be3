"""The first answer to ordinary questions is the one that an engineer expects, and nothing listed is
false."""

from __future__ import annotations

import math
import tomllib

import pytest

from . import judge
from .corpus import HERE, Question, Sheet, sheets

OPEN = tomllib.loads((HERE / "open_cases.toml").read_text())
"""Questions that are not answered as they should be, and why; each is expected to fail until it is
mended."""

QUICK = 3


def questions() -> list[object]:
    marked = []
    for place, sheet in enumerate(sheets()):
        for question in sheet.questions():
            marks = (
                [pytest.mark.xfail(strict=True, reason=OPEN[question.id])]
                if question.id in OPEN
                else []
            )
            if place % QUICK == 0 and question.label == "forward":
                marks.append(pytest.mark.quick)
            marked.append(pytest.param(question, id=question.id, marks=marks))
    return marked


@pytest.mark.parametrize("question", questions())
def test_first_answer(question: Question) -> None:
    found = question.judged()
    assert found.first, f"{found}: {found.result.solutions[:3]}; expected {question.expected[0]}"
    assert not found.false, found.false


@pytest.mark.quick
@pytest.mark.parametrize("sheet", sheets(), ids=lambda sheet: f"{sheet.area}/{sheet.name}")
def test_oracle(sheet: Sheet) -> None:
    """The independent computation names every variable, satisfies the sheet, and agrees with its
    source."""
    assert set(sheet.state) == set(sheet.model.variables)
    for rule in judge.rules(sheet.text):
        assert judge.holds(rule, sheet.state, 1e-9), rule
    for name, (value, error) in sheet.published.items():
        assert math.isclose(sheet.state[name], value, rel_tol=error), (
            name,
            sheet.state[name],
            value,
        )


def test_open_cases_are_questions() -> None:
    assert OPEN.keys() <= {question.id for sheet in sheets() for question in sheet.questions()}
