"""What the language page shows is a sheet, and says what the tables of the package hold."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from rulesheets.functions import PLANNED, TABLE
from rulesheets.parse.grammar import DEEPEST
from rulesheets.parse.layout import LONGEST
from rulesheets.parse.sections import parse
from rulesheets.syntax import Source

PAGE = (Path(__file__).parent.parent.parent / "docs" / "language.md").read_text(encoding="utf-8")
SHEETS = re.findall(r"^```tk(?: (?!broken)\S+)?\n(.*?)^```$", PAGE, re.MULTILINE | re.DOTALL)


def test_the_page_has_sheets() -> None:
    assert len(SHEETS) >= 4


@pytest.mark.parametrize("text", SHEETS)
def test_every_sheet_of_the_page_is_one(text: str) -> None:
    sheet = parse(Source("page", text))
    assert sheet.rules or sheet.functions


def test_every_built_in_function_is_named() -> None:
    named = set(re.findall(r"[a-z]\w*", " ".join(re.findall(r"`([^`]*)`", PAGE))))
    helpers = {"digamma", "bessel_i1", "bessel_k1"}  # derivatives of others, not advertised
    assert set(TABLE) | PLANNED <= named | helpers


def test_the_limits_are_those_of_the_parser() -> None:
    for limit in (LONGEST, DEEPEST):
        assert f"{limit:,}" in PAGE.partition("## Limits")[2]
