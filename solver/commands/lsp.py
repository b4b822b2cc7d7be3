"""``backsolve lsp``: the language server for editors, on standard input and output."""

from __future__ import annotations

import os
import sys
from importlib.util import find_spec
from typing import TYPE_CHECKING

from rulesheets.diagnosis import RuleSheetError
from solver.files.replacing import missing_extra

if TYPE_CHECKING:
    from argparse import ArgumentParser, Namespace


def add_arguments(parser: ArgumentParser) -> None:
    parser.add_argument("--stdio", action="store_true", help="as editors ask for it; it is always so")
    parser.add_argument("--timeout", metavar="S", type=float, default=10.0, help="seconds for a solve; 10")


def run(arguments: Namespace) -> int:
    """Serve until the editor ends it."""
    if find_spec("pygls") is None:
        raise RuleSheetError(missing_extra("the language server needs", "pygls", "lsp"))
    from solver.editor.server import server

    with os.fdopen(os.dup(sys.stdout.fileno()), "wb") as out:  # the server closes what it writes to
        server(arguments.timeout).start_io(stdout=out)
    return 0
