"""Commands for a person at a terminal: ``watch``, ``tutor``."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

from solver.commands.about import tutor as tutor_text

ROOT = Path(__file__).parents[2]
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
    for found in ("1728", "26 ", "19.39692621", "V ≤ 2000", "V = h*(a - 2*h)^2 = 3*(30 - 2*3)^2", "10,1000"):
        assert found in said
    assert f"{count} of {count}" in said and "backsolve open" in said
    assert list(tmp_path.iterdir()) == []


def test_the_tutor_ends_where_the_reader_leaves(tmp_path: Path) -> None:
    tutor = started("tutor", folder=tmp_path)
    said, _ = tutor.communicate("q\n", timeout=60)
    assert tutor.returncode == 0 and "2 of" not in said
