"""Broken sheets and what is said about them, filed by the stage that must reject them.

``tests/diagnostics/<stage>/X.tk`` (or ``X/main.tk``, where a case has several files) stands
beside ``X.expected`` (``X/expected``): the rendered diagnoses, separated by blank lines.
"""

from __future__ import annotations

from pathlib import Path

import pytest

import rulesheets
from rulesheets.diagnosis import RuleSheetError, catalogue, render
from rulesheets.files import read_source
from rulesheets.parse.sections import parse
from rulesheets.units.check import check_units

ROOT = Path(__file__).parent / "diagnostics"


def warned(path: str) -> None:
    raise RuleSheetError(*check_units(rulesheets.load(path)))


STAGES = {
    "syntax": lambda path: parse(read_source(path)),
    "model": rulesheets.load,
    "units": warned,
}


def cases() -> list[str]:
    sheets = [*ROOT.glob("*/*.tk"), *ROOT.glob("*/*/main.tk")]
    return sorted(str(sheet.relative_to(ROOT)) for sheet in sheets)


def expected_of(sheet: Path) -> Path:
    return sheet.parent / "expected" if sheet.name == "main.tk" else sheet.with_suffix(".expected")


@pytest.mark.parametrize("case", cases())
def test_broken_sheet_is_explained(case: str, monkeypatch: pytest.MonkeyPatch) -> None:
    stage, _, sheet = case.partition("/")
    monkeypatch.chdir(ROOT / stage)
    with pytest.raises(RuleSheetError) as caught:
        STAGES[stage](sheet)
    said = "\n\n".join(map(render, caught.value.diagnoses)) + "\n"
    assert said == expected_of(ROOT / case).read_text(encoding="utf-8")


def test_every_syntax_code_has_a_golden_message() -> None:
    text = "".join(path.read_text(encoding="utf-8") for path in ROOT.glob("*/**/*expected"))
    unseen = [code for code in catalogue() if code.startswith("E1") and f"[{code}]" not in text]
    assert unseen == ["E125"]  # a line of ten megabytes, in tests/rulesheets/test_parse.py


def test_there_are_cases_for_every_stage() -> None:
    assert {case.partition("/")[0] for case in cases()} == set(STAGES)
