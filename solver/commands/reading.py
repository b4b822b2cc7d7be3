"""Commands that read a sheet or explain a solve: ``check``, ``format``, ``path`` and ``why``."""

from __future__ import annotations

import json
import sys
from argparse import ArgumentParser, Namespace

from rulesheets.diagnosis import plural, render
from rulesheets.format import format_sheet
from rulesheets.inputs import override, variable_named
from rulesheets.loading import find_sheet, parsed, read_source
from rulesheets.model import Model
from rulesheets.syntax.source import escaped
from rulesheets.units.check import check_units, inferred
from solver.commands.inputs import (
    add_display_options,
    add_input_options,
    add_sheet_options,
    load_sheet,
    read_request,
)
from solver.commands.running import Command
from solver.files.replacing import write_file
from solver.path.planner import planner
from solver.path.tree import path_tree
from solver.report.derivation import Derivation, why
from solver.report.path import reaches, tree_text
from solver.report.sheet import diagnosis_json
from solver.report.why import why_latex, why_markdown, why_text
from solver.solving import posted, solve


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


def _path(arguments: Namespace) -> int:
    """Print the path; the exit code is 0 where it reaches every wanted variable, at least in some case."""
    request = read_request(arguments)
    model, given = request.model, override(request.model, request.inputs, request.guesses).values
    wanted = request.want or posted(model)
    ahead = path_tree(planner(model), given, None if request.want is None else frozenset(request.want))
    print(tree_text(model, ahead, wanted))
    return 0 if reaches(ahead, wanted) else 1


def _why_arguments(parser: ArgumentParser) -> None:
    add_input_options(parser, want=False)
    add_display_options(parser)
    parser.add_argument("name", metavar="NAME", help="the variable to account for, a local by its full name")
    forms = parser.add_mutually_exclusive_group()
    forms.add_argument("--markdown", action="store_true", help="print Markdown")
    forms.add_argument("--latex", action="store_true", help="print LaTeX")


def _why(arguments: Namespace) -> int:
    """Solve, trace, print; the exit code is 0 where the variable has a value."""
    request = read_request(arguments)
    variable_named(arguments.name, request.model)
    result = solve(request.model, request.inputs, guesses=request.guesses)
    derivation = why(result, arguments.name)
    print(_written(derivation, arguments))
    if derivation.value is not None:
        return 0
    _explain(derivation)
    return 1


def _written(derivation: Derivation, arguments: Namespace) -> str:
    if arguments.latex and derivation.value is not None:
        return why_latex(derivation)
    return why_markdown(derivation) if arguments.markdown else why_text(derivation)


def _explain(derivation: Derivation) -> None:
    """Why there is no value."""
    for diagnosis in derivation.diagnoses:
        print()
        print(render(diagnosis))


COMMANDS = {
    "check": Command(_check_arguments, _check),
    "format": Command(_format_arguments, _format, keeps=False),
    "path": Command(add_input_options, _path),
    "why": Command(_why_arguments, _why),
}
