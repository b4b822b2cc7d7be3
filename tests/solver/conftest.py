"""What the tests of commands share."""

from __future__ import annotations

from collections.abc import Callable
from time import process_time
from typing import TypeAlias

import pytest

from rulesheets import deadline
from solver.__main__ import main

Run: TypeAlias = Callable[..., tuple[int, str, str]]
"""Exit code, standard output and standard error of a command, given by its words."""


@pytest.fixture
def processor_clock(monkeypatch: pytest.MonkeyPatch) -> None:
    """Limits in time are seconds of the processor: what else the machine does is none of a
    solve's."""
    monkeypatch.setattr(deadline, "monotonic", process_time)


@pytest.fixture
def run(capsys: pytest.CaptureFixture[str]) -> Run:
    """Run the command in this process."""

    def run(*words: str) -> tuple[int, str, str]:
        code = main(words)
        out, err = capsys.readouterr()
        return code, out, err

    return run
