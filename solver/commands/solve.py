"""``backsolve solve``: the variable sheet, filled in."""

from __future__ import annotations

import os
import sys
from argparse import ArgumentParser, Namespace
from dataclasses import replace

from rulesheets.diagnosis import render
from rulesheets.units.check import check_units
from solver.commands.derived import add_derived_options, asked, derived_json, derived_text
from solver.commands.inputs import add_display_options, add_input_options, read_request
from solver.files.replacing import write_file
from solver.report.json import result_json
from solver.report.sheet import result_csv
from solver.report.text import result_text
from solver.result import Result
from solver.solving import solve

MOST_WARNINGS = 3
"""Warnings of units after a table."""


def add_arguments(parser: ArgumentParser) -> None:
    add_input_options(parser)
    add_display_options(parser)
    parser.add_argument("--all", action="store_true", help="show every answer, side by side")
    parser.add_argument("--explain", action="store_true", help="show locals, path, and rules used")
    parser.add_argument(
        "--digits", action="store_true", help="print each number with the digits that are right"
    )
    parser.add_argument("--prove", action="store_true", help="prove every answer, and that there is no other")
    parser.add_argument("--limits", action="store_true", help="take rules that are 0/0 by their limits")
    add_derived_options(parser)
    forms = parser.add_mutually_exclusive_group()
    forms.add_argument("--json", action="store_true", help="print one JSON object")
    forms.add_argument("--csv", action="store_true", help="print the variable sheet as CSV")
    parser.add_argument("-o", "--output", metavar="FILE.csv", help="also write the variable sheet to a file")


def run(arguments: Namespace) -> int:
    """Solve, print, write; the exit code is that of the status."""
    request = read_request(arguments)
    request.expect_output(arguments.output)
    result = solve(
        request.model,
        request.inputs,
        want=request.want,
        guesses=request.guesses,
        prove=arguments.prove,
        limits=arguments.limits,
    )
    if arguments.output:
        write_file(arguments.output, result_csv(result).encode())
    _print(_with_unit_warnings(result, every=arguments.json), arguments)
    return result.status.exit_code


def _with_unit_warnings(result: Result, every: bool) -> Result:
    """The result with what is wrong with units in its rules, the first of it; its status stays."""
    warnings = check_units(result.model, sure=True)
    if not warnings:
        return result
    if not every and len(warnings) > MOST_WARNINGS:
        last = warnings[MOST_WARNINGS - 1]
        rest = f"{len(warnings) - MOST_WARNINGS} more such warnings: see backsolve check"
        warnings = (*warnings[: MOST_WARNINGS - 1], replace(last, notes=(*last.notes, rest)))
    return replace(result, diagnoses=(*result.diagnoses, *warnings))


def _print(result: Result, arguments: Namespace) -> None:
    if arguments.json:
        also = derived_json(result, arguments)
        print(result_json(result, explain=arguments.explain, digits=arguments.digits, also=also))
    elif arguments.csv:
        _print_csv(result, every=arguments.all)
        if asked(arguments) and (derived := derived_text(result, arguments, color=False)):
            print(derived, file=sys.stderr)
    else:
        shown = {"every": arguments.all, "explain": arguments.explain, "digits": arguments.digits}
        print(result_text(result, **shown, color=_color()))
        if derived := derived_text(result, arguments, color=_color()):
            print(f"\n{derived}")


def _print_csv(result: Result, *, every: bool) -> None:
    """The sheet on stdout; what is wrong on stderr, out of the way of a program that reads the sheet."""
    sys.stdout.write(result_csv(result, every=every))
    for diagnosis in result.diagnoses:
        print(render(diagnosis), file=sys.stderr)


def _color() -> bool:
    return sys.stdout.isatty() and "NO_COLOR" not in os.environ
