"""``backsolve models``: the sheets that come with Backsolve."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace

from rulesheets.loading import find_sheet, shipped_models
from solver.report.table import columns


def add_arguments(parser: ArgumentParser) -> None:
    del parser  # this command takes no arguments


def run(arguments: Namespace) -> int:
    """One line a model: its name, and the comment that its sheet opens with."""
    names = shipped_models()
    if names:
        print(columns((name, title(find_sheet(name))) for name in names))
    return 0


def title(path: str) -> str:
    """The comment on the first line of a sheet, empty where there is none."""
    with open(path, encoding="utf-8") as file:
        first = file.readline().strip()
    return first.lstrip('";').strip() if first[:1] in ('"', ";") else ""
