"""Commands whose standard streams are closed: they do their work, and say nothing."""

from __future__ import annotations

import math
import subprocess
import sys
from pathlib import Path

import pytest

SWEEP = "sweep colebrook --over v=1:3:1 --want Q"


@pytest.mark.parametrize("closed", ["<&-", ">&-", "2>&-", "<&- >&- 2>&-"])
@pytest.mark.parametrize(
    ("words", "code"), [("solve colebrook", 0), (SWEEP, 0), ("--help", 0), ("solve none", 2)]
)
def test_the_exit_code_is_the_same(closed: str, words: str, code: int) -> None:
    done = subprocess.run(
        f"'{sys.executable}' -m solver {words} {closed}", shell=True, capture_output=True
    )
    assert done.returncode == code
    assert b"Traceback" not in done.stdout + done.stderr


def test_a_file_is_written_while_nobody_listens(tmp_path: Path) -> None:
    file = tmp_path / "rows.csv"
    command = f"'{sys.executable}' -m solver {SWEEP} -o '{file}' <&- >&- 2>&-"
    assert subprocess.run(command, shell=True).returncode == 0
    rows = [row.split(",") for row in file.read_text().splitlines()]
    assert [float(q) / float(v) for v, q, *_ in rows[-3:]] == pytest.approx(
        [math.pi * 0.1**2 / 4] * 3
    )
