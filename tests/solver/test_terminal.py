"""The lesson for a person at a terminal."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
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
