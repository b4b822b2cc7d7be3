"""What the tests of commands share."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

import pytest

from solver.__main__ import main

Run: TypeAlias = Callable[..., tuple[int, str, str]]
"""Exit code, standard output and standard error of a command, given by its words."""


@pytest.fixture
def run(capsys: pytest.CaptureFixture[str]) -> Run:
    """Run the command in this process."""

    def run(*words: str) -> tuple[int, str, str]:
        code = main(words)
        out, err = capsys.readouterr()
        return code, out, err

    return run
