"""Files that are written: whole or not at all, never over an input, and nothing left behind."""

from __future__ import annotations

import errno
import os
import shutil
import signal
import stat
import subprocess
import sys
import time
from pathlib import Path

import pytest

import rulesheets
import solver
from rulesheets.diagnosis import RuleSheetError
from solver import files
from solver.__main__ import main
from solver.commands import WRONG
from solver.files import UNFINISHED, Replacement, write_file

ROOT = Path(__file__).parents[3]
Patch = pytest.MonkeyPatch

SHEET = 'use "part.tk"\nvariables\n  a = 3\n  b\nrules\n  call double(a; b)\n'
PART = "function double(a; b)\n  b = 2*a\n"


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: Patch) -> Path:
    (tmp_path / "main.tk").write_text(SHEET)
    (tmp_path / "part.tk").write_text(PART)
    (tmp_path / "in.csv").write_text("a\n1\n2\n")
    (tmp_path / "filled.csv").write_text("Name,Input\na,4\n")
    (tmp_path / "inner").mkdir()
    (tmp_path / "link.csv").symlink_to("main.tk")
    os.link(tmp_path / "part.tk", tmp_path / "hard.csv")
    monkeypatch.chdir(tmp_path)
    return tmp_path


# --- inputs ---------------------------------------------------------------------


@pytest.mark.parametrize(
    "words",
    [
        ("solve", "main.tk", "-o", "main.tk"),
        ("solve", "main.tk", "-o", "inner/../part.tk"),
        ("solve", "main.tk", "-o", "link.csv"),
        ("solve", "main.tk", "-o", "hard.csv"),
        ("solve", "main.tk", "filled.csv", "-o", "filled.csv"),
        ("sweep", "main.tk", "--rows", "in.csv", "-o", "in.csv"),
        ("sweep", "main.tk", "--over", "a=1:2:1", "-o", "link.csv"),
        ("sweep", "main.tk", "--follow", "--over", "a=1:2:1", "--want", "b", "-o", "hard.csv"),
        ("chart", "main.tk", "-o", "link.csv"),
        ("export", "main.tk", "-o", "hard.csv"),
    ],
)
def test_an_output_that_is_an_input_is_refused(
    folder: Path, words: tuple[str, ...], capsys: pytest.CaptureFixture[str]
) -> None:
    before = {path: path.read_bytes() for path in folder.iterdir() if path.is_file()}
    assert main(words) == WRONG
    assert capsys.readouterr().err.startswith("error[E418]")
    assert {path: path.read_bytes() for path in folder.iterdir() if path.is_file()} == before


def test_pictures_are_not_drawn_over_an_input(folder: Path) -> None:
    pytest.importorskip("matplotlib")
    sheet, before = folder / "main.svg", SHEET
    sheet.write_text(before)
    assert main(("sweep", "main.svg", "--over", "a=1:2:1", "--plot", "main.svg")) == WRONG
    model = "offset_slider_crank"
    shutil.copytree(ROOT / "models" / model, folder / model)
    text = (folder / model / "model.tk").read_text()
    (folder / model / "model.svg").write_text(text)
    assert main(("draw", f"{model}/model.svg", "-o", f"{model}/model.svg")) == WRONG
    assert sheet.read_text() == before
    assert (folder / model / "model.svg").read_text() == text


def test_a_table_does_not_overwrite_its_sheet(folder: Path) -> None:
    table = solver.sweep(rulesheets.load("main.tk"), {"a": [1.0, 2.0]})
    again = solver.sweep(rulesheets.load("main.tk"), {"a": [1.0, 2.0]})  # read from what was kept
    for found in (table, again):
        with pytest.raises(RuleSheetError) as caught:
            found.write("link.csv")
        assert caught.value.diagnoses[0].code == "E418"
    table.write("other.csv")
    assert (folder / "main.tk").read_text() == SHEET


# --- what is written into -------------------------------------------------------


def test_a_device_is_written_into(folder: Path) -> None:
    before = os.stat("/dev/null").st_mode
    assert main(("solve", "main.tk", "-o", "/dev/null")) == 0
    assert main(("sweep", "main.tk", "--over", "a=1:2:1", "-o", "/dev/null")) == 0
    assert os.stat("/dev/null").st_mode == before


def test_a_pipe_is_written_into(folder: Path) -> None:
    os.mkfifo("pipe")
    reader = subprocess.Popen(["cat", "pipe"], stdout=subprocess.PIPE, text=True)
    assert main(("solve", "main.tk", "-o", "pipe")) == 0
    assert "a" in reader.communicate(timeout=30)[0]
    assert stat.S_ISFIFO(os.stat("pipe").st_mode)


# --- whole or not at all --------------------------------------------------------


def test_a_file_is_replaced_and_keeps_its_mode(tmp_path: Path) -> None:
    file = tmp_path / "sheet.tk"
    file.write_text("old")
    file.chmod(0o640)
    write_file(str(file), "new é\n".encode())
    assert file.read_bytes() == "new é\n".encode()
    assert stat.S_IMODE(file.stat().st_mode) == 0o640
    assert list(tmp_path.iterdir()) == [file]


def test_a_new_file_has_the_mode_of_new_files(tmp_path: Path) -> None:
    (tmp_path / "plain").touch()
    write_file(str(tmp_path / "new"), b"")
    assert (tmp_path / "new").stat().st_mode == (tmp_path / "plain").stat().st_mode


def test_a_link_is_followed(tmp_path: Path) -> None:
    file, link = tmp_path / "real.tk", tmp_path / "link.tk"
    file.write_text("old")
    link.symlink_to(file)
    write_file(str(link), b"new")
    assert link.is_symlink()
    assert file.read_text() == "new"


def test_a_place_that_cannot_be_written_is_a_diagnosis(tmp_path: Path) -> None:
    with pytest.raises(RuleSheetError) as caught:
        write_file(str(tmp_path / "missing" / "sheet.tk"), b"text")
    assert caught.value.diagnoses[0].code == "E416"
    assert list(tmp_path.iterdir()) == []


def test_a_long_name_is_no_obstacle(tmp_path: Path) -> None:
    file = tmp_path / ("ä" * 120 + ".csv")
    write_file(str(file), b"text")
    assert [found.read_bytes() for found in tmp_path.iterdir()] == [b"text"]


@pytest.mark.parametrize(
    "failure", [OSError(errno.ENOSPC, "No space left on device"), KeyboardInterrupt()]
)
def test_what_fails_at_the_last_bytes_leaves_the_old_file(
    tmp_path: Path, monkeypatch: Patch, failure: BaseException
) -> None:
    path = tmp_path / "table"
    path.write_bytes(b"old")

    def fails(handle: int) -> None:
        raise failure

    monkeypatch.setattr(files.os, "fsync", fails)
    with pytest.raises((RuleSheetError, KeyboardInterrupt)):
        write_file(str(path), b"x" * 100)
    assert [found.read_bytes() for found in tmp_path.iterdir()] == [b"old"]


def test_bytes_are_on_the_disk_before_the_name_changes(tmp_path: Path, monkeypatch: Patch) -> None:
    done: list[str] = []
    sync, replace = os.fsync, os.replace
    monkeypatch.setattr(files.os, "fsync", lambda handle: (done.append("sync"), sync(handle)))
    monkeypatch.setattr(files.os, "replace", lambda a, b: (done.append("replace"), replace(a, b)))
    write_file(str(tmp_path / "table"), b"x")
    assert done[:2] == ["sync", "replace"]


def test_a_folder_that_is_removed_meanwhile_is_told(tmp_path: Path) -> None:
    folder = tmp_path / "folder"
    folder.mkdir()
    file = Replacement(str(folder / "table"))
    file.write(b"x" * 100)
    shutil.rmtree(folder)
    with pytest.raises(RuleSheetError, match="No such file"):
        file.keep()
    file.discard()


# --- what killed runs leave -----------------------------------------------------


def test_the_next_run_removes_what_a_killed_one_left(folder: Path) -> None:
    words = ("sweep", "main.tk", "--over", "a=1:1000:1e-5", "-o", "out.csv", "--jobs", "1")
    process = subprocess.Popen(
        [sys.executable, "-m", "solver", *words], env=os.environ | {"PYTHONPATH": str(ROOT)}
    )
    while process.poll() is None and not any(
        f.stat().st_size for f in folder.glob(f"out.csv.*{UNFINISHED}")
    ):
        time.sleep(0.05)
    living = Replacement("other.csv")  # a file of a living process stays
    process.send_signal(signal.SIGKILL)
    process.wait()
    assert len(list(folder.glob(f"*{UNFINISHED}"))) == 2
    assert main(("solve", "main.tk", "-o", "out.csv")) == 0
    assert [file.name[:9] for file in folder.glob(f"*{UNFINISHED}")] == ["other.csv"]
    living.write(b"x")
    living.keep()
    assert not list(folder.glob(f"*{UNFINISHED}"))
