"""Every code that is said can be looked up, and every one that can be looked up is said."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from rulesheets.diagnosis import catalogue
from solver.__main__ import main

ROOT = Path(__file__).parents[3]


def test_the_codes_said_are_those_of_the_catalogue() -> None:
    files = [file for room in ("rulesheets", "solver") for file in (ROOT / room).rglob("*")]
    rooms = [file for file in files if file.suffix in (".py", ".toml") and file.stem != "catalogue"]
    texts = [file.read_text(encoding="utf-8") for file in rooms]
    said = {code for text in texts for code in re.findall(r'"([ESW]\d{3})"', text)}
    assert said == catalogue().keys()


@pytest.mark.parametrize("word", ["S530", "s530", "[S530]"])
def test_a_code_is_explained(word: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["codes", word]) == 0
    entry = catalogue()["S530"]
    assert capsys.readouterr().out == f"S530: {entry.title}\n\n{entry.cause}\n{entry.fix}\n"


def test_all_codes_are_listed(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["codes"]) == 0
    listed = capsys.readouterr().out.splitlines()
    assert [line.split()[0] for line in listed] == list(catalogue())


def test_a_code_that_is_none_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["codes", "E999"]) == 2
    assert capsys.readouterr().err.startswith("error[E426]: no message has the code E999\n")
