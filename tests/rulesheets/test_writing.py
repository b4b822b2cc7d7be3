"""Files written as a whole."""

from __future__ import annotations

import stat
from pathlib import Path

import pytest

from rulesheets.diagnosis import RuleSheetError
from rulesheets.writing import replace_file


def test_a_file_is_replaced_and_keeps_its_mode(tmp_path: Path) -> None:
    file = tmp_path / "sheet.tk"
    file.write_text("old")
    file.chmod(0o640)
    replace_file(str(file), "new é\n")
    assert file.read_bytes() == "new é\n".encode()
    assert stat.S_IMODE(file.stat().st_mode) == 0o640
    assert list(tmp_path.iterdir()) == [file]


def test_a_link_is_followed(tmp_path: Path) -> None:
    file, link = tmp_path / "real.tk", tmp_path / "link.tk"
    file.write_text("old")
    link.symlink_to(file)
    replace_file(str(link), "new")
    assert link.is_symlink()
    assert file.read_text() == "new"


def test_a_place_that_cannot_be_written_is_a_diagnosis(tmp_path: Path) -> None:
    with pytest.raises(RuleSheetError) as caught:
        replace_file(str(tmp_path / "missing" / "sheet.tk"), "text")
    assert caught.value.diagnoses[0].code == "E416"
    assert list(tmp_path.iterdir()) == []
