"""``backsolve open``: a sheet as a page in the browser."""

from __future__ import annotations

import os
from argparse import ArgumentParser, Namespace
from importlib.util import find_spec
from math import isfinite
from pathlib import Path

from rulesheets.diagnosis import RuleSheetError, error
from rulesheets.loading import find_sheet, shipped_models
from solver.files.replacing import missing_extra


def add_arguments(parser: ArgumentParser) -> None:
    add = parser.add_argument
    add("sheet", metavar="SHEET", nargs="?", help="a rule sheet, or the name of a shipped one")
    add("--port", type=int, default=0, help="the port to serve on; any free one by default")
    add("--host", default="127.0.0.1", help="the address to serve on; this machine alone by default")
    add("--timeout", metavar="S", type=float, default=10.0, help="seconds that a solve may take; 10")
    add("--no-browser", action="store_true", help="print the address, and open no browser")


def run(arguments: Namespace) -> int:
    """Serve until interrupted; everything in the folder of the sheet can be opened."""
    if any(find_spec(name) is None for name in ("starlette", "uvicorn", "websockets")):
        raise RuleSheetError(missing_extra("the page needs", "starlette", "page"))
    if not (isfinite(arguments.timeout) and arguments.timeout > 0):
        raise RuleSheetError(error("E420", f"--timeout {arguments.timeout:g} is no number of seconds"))
    folder, first = _place(arguments.sheet)
    from solver.page.server import serve

    serve(
        folder,
        first,
        host=arguments.host,
        port=arguments.port,
        timeout=arguments.timeout,
        browse=not arguments.no_browser,
    )
    return 0


def _place(sheet: str | None) -> tuple[Path, str]:
    """The folder whose sheets can be opened, and the key of the one that is shown at first."""
    if sheet is None:
        return Path.cwd(), ""
    if not os.path.exists(sheet) and sheet in shipped_models():
        return Path.cwd(), f"shipped:{sheet}"
    file = Path(find_sheet(sheet)).resolve()
    return file.parent, file.name
