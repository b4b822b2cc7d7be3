"""Commands that only read a sheet: ``check`` and ``format``."""

from __future__ import annotations

import json
import sys
from argparse import ArgumentParser, Namespace

from rulesheets.diagnosis import plural, render
from rulesheets.format import format_sheet
from rulesheets.loading import find_sheet, parsed, read_source
from rulesheets.model import Model
from rulesheets.syntax.source import escaped
from rulesheets.units.check import check_units, inferred
from solver.commands.inputs import add_sheet_options, load_sheet
from solver.commands.running import Command
from solver.files.replacing import write_file
from solver.report.sheet import diagnosis_json


def _check_arguments(parser: ArgumentParser) -> None:
    add_sheet_options(parser)
    parser.add_argument("--equations", action="store_true", help="list the equations, calls expanded")
    parser.add_argument("--latex", action="store_true", help="list the equations as LaTeX")
    parser.add_argument("--json", action="store_true", help="print what is wrong as a JSON object")


def _check(arguments: Namespace) -> int:
    """Load the sheet, which raises for all that is wrong; then say what it has."""
    model = load_sheet(arguments)
    if arguments.json:
        found = [diagnosis_json(warning) for warning in check_units(model)]
        units = inferred(model)
        more = {"inferred": units} if units else {}
        print(json.dumps({"status": "ok", "diagnoses": found, **more}, ensure_ascii=False))
    elif arguments.equations or arguments.latex:
        from rulesheets.algebra import listing

        print(listing(model, latex=arguments.latex))
    else:
        warnings = check_units(model)
        print(summary(model, len(warnings)))
        if units := inferred(model):
            print(f"inferred: {', '.join(f'{name} [{unit}]' for name, unit in units.items())}")
        for warning in warnings:
            print(f"\n{render(warning)}")
    return 0


def summary(model: Model, warnings: int = 0) -> str:
    """``offset_slider_crank: 12 variables, 16 locals, 31 rules, 3 figures; nothing wrong``."""
    locals_ = sum("." in name for name in model.variables)
    parts = [plural(len(model.variables) - locals_, "variable")]
    if locals_:
        parts.append(plural(locals_, "local"))
    parts.append(plural(len(model.equations), "rule"))
    if model.requirements:
        parts.append(plural(len(model.requirements), "requirement"))
    if model.figures:
        parts.append(plural(len(model.figures), "figure"))
    return f"{model.name}: {', '.join(parts)}; {plural(warnings, 'warning') if warnings else 'nothing wrong'}"


def _format_arguments(parser: ArgumentParser) -> None:
    parser.add_argument("sheet", metavar="SHEET", help="a rule sheet, or the name of a shipped one")
    how = parser.add_mutually_exclusive_group()
    how.add_argument("-i", "--in-place", action="store_true", help="write the file instead of printing it")
    how.add_argument("--check", action="store_true", help="only say whether the file is in canonical form")


def _format(arguments: Namespace) -> int:
    """Print or write the sheet; ``--check`` exits with 1 where it would change."""
    path = find_sheet(arguments.sheet)
    source = read_source(path)
    text = format_sheet(parsed(source, path))
    if arguments.check:
        if text == source.text:
            return 0
        print(f"{escaped(path)} is not in canonical form: backsolve format -i writes it so", file=sys.stderr)
        return 1
    if not arguments.in_place:
        sys.stdout.write(text)
    elif text != source.text:
        write_file(path, text.encode())
    return 0


COMMANDS = {
    "check": Command(_check_arguments, _check),
    "format": Command(_format_arguments, _format, keeps=False),
}
