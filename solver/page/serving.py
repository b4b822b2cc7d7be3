"""A sheet in a browser, an editor or a notebook: ``open``, ``export``, ``lsp``, ``interact``."""

from __future__ import annotations

import os
import sys
from argparse import Namespace
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from rulesheets.files import find_sheet, read_source, shipped_models
from rulesheets.inputs import override
from rulesheets.model import Model, Value, expect
from rulesheets.syntax import escaped
from solver.commands import GIVEN, WANTED, Command, read_request, tell_of_units
from solver.commands.over import read_axes
from solver.files import require_extra, write_file

if TYPE_CHECKING:
    from solver.page.widget import Cell


def interact(
    model: Model,
    over: Mapping[str, Sequence[Value]] | None = None,
    inputs: Mapping[str, Value | None] | None = None,
    *,
    guesses: Mapping[str, float] | None = None,
    timeout: float = 10.0,
) -> Cell:
    """The page of a sheet in a cell of a notebook.

    ``over`` names inputs with the values of their sliders; ``inputs`` and ``guesses`` are the
    initial ones of :func:`solve`, ``timeout`` the time limit of a solve in seconds. The attribute
    ``inputs`` of the cell holds the current inputs. Values are in the units of the rules. Raises
    RuleSheetError: E441 without the extra ``notebook``, and for names and values that :func:`solve`
    refuses.
    """
    expect(Model, model)
    require_extra("notebook", "the widget needs", "anywidget")
    from solver.page.widget import Cell

    begin = override(model, inputs, guesses)
    given = {name: begin.values.get(name) for name in inputs or {}}
    sliders = {}
    for name, values in (over or {}).items():
        read = [override(model, {name: value}).values[name] for value in values]
        sliders[name] = read
        if name not in begin.values:
            given[name] = read[len(read) // 2]
    first = {name: begin.guesses[name] for name in guesses or {}}
    return Cell(model, sliders, given, first, timeout)


PATIENCE = 10.0
"""Seconds that a solve may take by default."""

OPEN = """\
sheet [SHEET]      a rule sheet, or the name of a shipped one
--port N           the port to serve on; any free one by default
--host ADDRESS     the address to serve on; this machine alone by default
--timeout SECONDS  seconds that a solve may take; 10
--no-browser       print the address, and open no browser
"""
EXPORT = f"""\
{GIVEN}{WANTED}
--over NAME=START:STOP:STEP*  a slider for an input, or NAME=A,B,…; up to three
-o --output FILE.html         the file to write; NAME.html by default
"""
LSP = """\
--stdio            always in effect; editors pass it
--timeout SECONDS  seconds that a solve may take; 10
"""


def _open(arguments: Namespace) -> int:
    """Serve until interrupted; all sheets in the folder of the sheet can be opened."""
    require_extra("page", "the page needs", "starlette", "uvicorn", "websockets")
    from solver.page.server import serve

    folder, first, sheet = Path.cwd(), "", arguments.sheet
    if sheet is not None and not os.path.exists(sheet) and sheet in shipped_models():
        first = f"shipped:{sheet}"
    elif sheet is not None:
        file = Path(find_sheet(sheet)).resolve()
        folder, first = file.parent, file.name
        if not file.exists() and folder.is_dir() and file.suffix == ".tk":
            print(f"{escaped(sheet)} is a new sheet: Save on the page writes it", flush=True)
        elif not file.is_file():
            read_source(str(file))
    at = {"host": arguments.host, "port": arguments.port, "browse": not arguments.no_browser}
    serve(folder, first, timeout=arguments.timeout or PATIENCE, **at)
    return 0


def _export(arguments: Namespace) -> int:
    """Solve every state, write; the exit code is 0 if one of them has an answer."""
    from solver.page.description import export

    request = read_request(arguments)
    path = arguments.output or f"{request.model.name}.html"
    request.expect_output(path)
    values = {name: axis[:].tolist() for name, axis in read_axes(arguments.over, request).items()}
    asked = request.model, request.inputs, request.guesses, values, request.want
    page, states, solved = export(*asked)
    write_file(path, page.encode())
    print(f"{path}: {solved} of {states} states solved")
    tell_of_units(request.model)
    return 0 if solved else 1


def _lsp(arguments: Namespace) -> int:
    """Serve until the editor ends it."""
    require_extra("lsp", "the language server needs", "pygls")
    from solver.editor.server import server

    with os.fdopen(os.dup(sys.stdout.fileno()), "wb") as out:  # the server closes what it writes to
        server(arguments.timeout or PATIENCE).start_io(stdout=out)
    return 0


COMMANDS = {
    "open": Command(OPEN, _open, patient=True),
    "export": Command(EXPORT, _export),
    "lsp": Command(LSP, _lsp, keeps=False, patient=True),
}
