"""``backsolve check``: is the sheet well formed, and which equations does it state?"""

from __future__ import annotations

import json
from argparse import ArgumentParser, Namespace

from rulesheets.diagnosis import plural, render
from rulesheets.model import Model
from rulesheets.units.check import check_units, inferred
from solver.commands.inputs import add_sheet_options, load_sheet
from solver.report.sheet import diagnosis_json


def add_arguments(parser: ArgumentParser) -> None:
    add_sheet_options(parser)
    parser.add_argument("--equations", action="store_true", help="list the equations, calls expanded")
    parser.add_argument("--latex", action="store_true", help="list the equations as LaTeX")
    parser.add_argument("--json", action="store_true", help="print what is wrong as a JSON object")


def run(arguments: Namespace) -> int:
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
