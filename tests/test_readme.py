"""What README and docs show is what happens: their commands, sheets and Python are run.

In a page, a block ``tk NAME`` is a file that the commands after it can read (or, where the
repository has a file of that name, a copy of it); a ``console`` block is commands with their
output, a line ``…`` standing for any lines; a ``python`` block is run, as a doctest where it has
prompts.
"""

from __future__ import annotations

import doctest
import re
import shlex
from collections.abc import Iterator
from pathlib import Path
from unittest.mock import patch

import pytest

from rulesheets.functions import TABLE
from solver.__main__ import main

ROOT = Path(__file__).parent.parent
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]

BLOCK = re.compile(r"^```(\w+)(?: (\S+))?\n(.*?)^```$", re.MULTILINE | re.DOTALL)
LINK = re.compile(r"\]\(([^)#:\s]+)(?:#[^)]*)?\)")
RESIDUAL = re.compile(r"worst residual \S+")
LAST = re.compile(r"(\d\.\d{12})\d+")
"""A number in all its digits; the last ones depend on the system's mathematical functions."""


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_a_page_says_what_happens(
    page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    for extra in ("flint", "matplotlib", "pyarrow"):
        pytest.importorskip(extra)
    monkeypatch.chdir(tmp_path)
    names: dict[str, object] = {}
    with patch.dict(TABLE):  # functions that a page registers go with it
        for language, name, text in blocks(page):
            if language == "tk" and name:
                provide(name, text)
            elif language == "console":
                for command, expected in commands(text):
                    assert_alike(output(command, capsys), expected)
            elif language == "python":
                run_python(text, names, page.name)


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_the_links_of_a_page_lead_somewhere(page: Path) -> None:
    for target in LINK.findall(page.read_text(encoding="utf-8")):
        assert (page.parent / target).exists(), target


def test_the_readme_has_a_sheet_its_answer_and_two_commands() -> None:
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    assert len(re.findall(r"^python3 -m venv .*$", text, re.MULTILINE)) == 2
    assert {language for language, _, _ in blocks(ROOT / "README.md")} >= {
        "tk",
        "console",
        "python",
    }


def blocks(page: Path) -> Iterator[tuple[str, str, str]]:
    """Language, name and text of every fenced block."""
    for match in BLOCK.finditer(page.read_text(encoding="utf-8")):
        yield match[1], match[2] or "", match[3]


def provide(name: str, text: str) -> None:
    """A copy of a file of the repository must be one, or of its beginning; any other file is
    written."""
    original = ROOT / name
    if original.is_file():
        assert original.read_text(encoding="utf-8").startswith(text)
    else:
        Path(name).write_text(text, encoding="utf-8")


def commands(text: str) -> Iterator[tuple[str, str]]:
    """Each command line with the output under it."""
    for part in re.split(r"^\$ ", text, flags=re.MULTILINE)[1:]:
        command, _, expected = part.partition("\n")
        yield command, expected.strip("\n")


def output(command: str, capsys: pytest.CaptureFixture[str]) -> str:
    """What ``backsolve …`` prints, then its complaints; files of the repository by relative
    names."""
    program, *words = shlex.split(command)
    assert program == "backsolve", command
    main(words)
    printed = "".join(capsys.readouterr()).replace(f"{ROOT}/", "")
    return printed.strip("\n")


def assert_alike(found: str, expected: str) -> None:
    """Line by line; ``…`` stands for any lines. The size of rounding errors and last digits do not
    count."""
    found, expected = (
        LAST.sub(r"\1", RESIDUAL.sub("worst residual #", text)) for text in (found, expected)
    )
    if "…" not in expected.split("\n"):
        assert found == expected
    else:
        lines = expected.split("\n")
        pattern = "".join("(?:.*\n)*" if line == "…" else re.escape(line) + "\n" for line in lines)
        assert re.fullmatch(pattern, found + "\n"), found


def run_python(text: str, names: dict[str, object], page: str) -> None:
    if ">>> " not in text:
        exec(compile(text, page, "exec"), names)
        return
    test = doctest.DocTestParser().get_doctest(text, names, page, page, 0)
    runner = doctest.DocTestRunner(optionflags=doctest.ELLIPSIS)
    runner.run(test, clear_globs=False)
    names.update(test.globs)
    assert runner.failures == 0
