"""A sample of the golden record: the same status, answers and values, no new claim to
completeness."""

from __future__ import annotations

import pytest

from .compare import compared
from .questions import questions
from .record import file_of

SAMPLE = {
    "models": 60,
    "corpus": 7,
    "redistributions": 8,
    "everyday": 50,
    "want": 60,
}
"""Of each source every so many-th question; hostile sheets are a report, not a gate."""

TOLD = ("complete lost", "new")
"""Differences that are to be listed and judged, and no failure."""


@pytest.mark.parametrize("source", SAMPLE)
def test_answers_are_those_of_the_record(source: str) -> None:
    if not file_of(source).exists():
        pytest.skip("no record: python -m tests.golden.freeze makes it")
    asked = list(questions(source)[:: SAMPLE[source]])
    assert asked
    assert [found for found in compared(asked, limit=60) if found[0] not in TOLD] == []
