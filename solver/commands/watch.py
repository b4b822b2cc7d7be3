"""``backsolve watch``: solve a sheet again whenever it, or a file that it uses, is saved."""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Iterable
from contextlib import suppress
from contextvars import Context
from typing import TYPE_CHECKING

from rulesheets.diagnosis import RuleSheetError, render
from solver.commands import solve

if TYPE_CHECKING:
    from argparse import ArgumentParser, Namespace

LOOK = 0.2
"""Seconds between two looks at the files."""


def add_arguments(parser: ArgumentParser) -> None:
    solve.add_arguments(parser)


def run(arguments: Namespace) -> int:
    """Solve at once and after every change until interrupted."""
    from rulesheets.loading import find_sheet

    files = {find_sheet(arguments.sheet), *filter(None, [arguments.variables])}
    with suppress(KeyboardInterrupt):
        while True:
            before = _saved(files)
            if sys.stdout.isatty():
                print("\x1b[2J\x1b[H", end="")
            # a context of its own, so that the limit in time is that of one solve
            files |= Context().run(_round, arguments)
            print(time.strftime("\n%H:%M:%S; waiting for a change, Ctrl+C ends"), flush=True)
            while _saved(files) == before | _saved(files - before.keys()):
                time.sleep(LOOK)
    return 0


def _round(arguments: Namespace) -> set[str]:
    """Solve once and print; the files that the sheet was read from."""
    from rulesheets.deadline import TimeIsUp, time_limit
    from rulesheets.loading import load
    from solver.report.table import shown_on

    try:
        with time_limit(arguments.timeout), shown_on(sys.stdout):
            solve.run(arguments)
            return set(load(arguments.sheet, within=arguments.within).files)
    except TimeIsUp:
        print("error[S553]: the time was up", file=sys.stderr)
    except RuleSheetError as wrong:
        print("\n\n".join(map(render, wrong.diagnoses)), file=sys.stderr)
    return set()


def _saved(files: Iterable[str]) -> dict[str, float]:
    """When each file was written; -1 for one that is not there at the moment."""
    found = {}
    for file in files:
        found[file] = -1.0
        with suppress(OSError):
            found[file] = os.stat(file).st_mtime_ns
    return found
