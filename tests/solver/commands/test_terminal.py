"""Commands for a person at a terminal: ``watch``, ``completion``, ``tutor``."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from solver.__main__ import COMMANDS, main
from solver.commands.about import tutor as tutor_text

ROOT = Path(__file__).parents[3]
ENVIRONMENT = {**os.environ, "PYTHONPATH": str(ROOT)}


def started(*words: str, folder: Path) -> subprocess.Popen[str]:
    """As in a terminal: a shell's job in the background would hand down that Ctrl-C is ignored."""
    command = [sys.executable, "-u", "-m", "solver", *words]
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "stderr": subprocess.STDOUT}
    heard = {"preexec_fn": lambda: signal.signal(signal.SIGINT, signal.SIG_DFL)}
    return subprocess.Popen(command, cwd=folder, env=ENVIRONMENT, text=True, **pipes, **heard)  # type: ignore[call-overload,no-any-return]


def round_of(watch: subprocess.Popen[str]) -> str:
    """What is printed until it waits again."""
    assert watch.stdout is not None
    lines = []
    for line in watch.stdout:
        lines.append(line)
        if "waiting for a change" in line:
            break
    return "".join(lines)


def test_watch_solves_at_every_save_of_the_sheet_and_of_what_it_uses(tmp_path: Path) -> None:
    sheet, used = tmp_path / "sheet.tk", tmp_path / "double.tk"
    used.write_text("function double(x; y)\n  y = 2*x\n")
    sheet.write_text('use "double.tk"\nvariables\n  a = 2\n  b\nrules\n  call double(a; b)\n')
    watch = started("watch", "sheet.tk", "--no-cache", folder=tmp_path)
    try:
        assert "b     4\n" in round_of(watch)
        time.sleep(0.01)
        sheet.write_text(sheet.read_text().replace("a = 2", "a = = 5"))
        assert "error[E1" in round_of(watch)
        sheet.write_text(sheet.read_text().replace("a = = 5", "a = 50"))
        assert "b     100\n" in round_of(watch)
        used.write_text("function double(x; y)\n  y = 2*x + 1\n")
        assert "b     101\n" in round_of(watch)
        watch.send_signal(signal.SIGINT)
        assert watch.wait(20) == 0
    finally:
        watch.kill()
        watch.communicate()


def test_the_tutor_runs_what_is_typed_and_goes_on_at_enter(tmp_path: Path) -> None:
    count = len(tutor_text()["lessons"])
    typed = "ls\nbacksolve check box.tk\n" + "\n" * count
    tutor = started("tutor", folder=tmp_path)
    said, _ = tutor.communicate(typed, timeout=120)
    assert tutor.returncode == 0
    assert "every command begins with backsolve" in said and "nothing wrong" in said
    for found in (
        "1728",
        "26 ",
        "19.39692621",
        "V ≤ 2000",
        "V = h*(a - 2*h)^2 = 3*(30 - 2*3)^2",
        "10,1000",
    ):
        assert found in said
    assert f"{count} of {count}" in said and "backsolve open" in said
    assert list(tmp_path.iterdir()) == []


def test_the_tutor_ends_where_the_reader_leaves(tmp_path: Path) -> None:
    tutor = started("tutor", folder=tmp_path)
    said, _ = tutor.communicate("q\n", timeout=60)
    assert tutor.returncode == 0 and "2 of" not in said


def completed(*words: str, folder: Path) -> list[str]:
    """What bash offers for the last of the words."""
    script = subprocess.run(
        [sys.executable, "-m", "solver", "completion", "bash"],
        capture_output=True,
        text=True,
        check=True,
    ).stdout
    line = " ".join(f"'{word}'" for word in words)
    ask = (
        f"COMP_WORDS=({line}); COMP_CWORD={len(words) - 1}; _backsolve; printf '%s\\n' "
        f'"${{COMPREPLY[@]}}"'
    )
    done = subprocess.run(
        ["bash", "-c", script + ask], capture_output=True, text=True, cwd=folder, check=True
    )
    return done.stdout.split()


def test_bash_completes_commands_options_choices_and_sheets(tmp_path: Path) -> None:
    (tmp_path / "offset.tk").write_text("x = 1\n")
    assert set(completed("backsolve", "", folder=tmp_path)) == set(COMMANDS)
    assert completed("backsolve", "solve", "--uni", folder=tmp_path) == ["--unit", "--units"]
    assert completed("backsolve", "solve", "x.tk", "--units", "", folder=tmp_path) == ["si", "us"]
    sheets = completed("backsolve", "solve", "offset", folder=tmp_path)
    assert {"offset.tk", "offset_slider_crank"} <= set(sheets)


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_the_script_of_a_shell_is_one(
    shell: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["completion", shell]) == 0
    script = capsys.readouterr().out
    assert all(command in script for command in COMMANDS) and "--no-such" not in script
    assert "guess" in script and "offset_slider_crank" in script
    if not shutil.which(shell):
        pytest.skip(f"there is no {shell} here to read it")
    (tmp_path / "script").write_text(script)
    done = subprocess.run([shell, "-n", str(tmp_path / "script")], capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (0, "")
