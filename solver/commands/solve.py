"""Commands on one sheet: ``solve``, ``watch``, ``check``, ``format``, ``path`` and ``why``."""

from __future__ import annotations

import json
import os
import sys
import time
from argparse import Namespace
from collections.abc import Iterable
from contextlib import suppress
from contextvars import Context
from typing import Any

from rulesheets.diagnosis import RuleSheetError, plural, render
from rulesheets.files import find_sheet, parsed, read_source
from rulesheets.inputs import override, variable_named
from rulesheets.loading import keep, load, recall, stamp
from rulesheets.model import Model
from rulesheets.syntax import escaped
from solver.commands import (
    GIVEN,
    SHEET,
    UNITS,
    WANTED,
    Command,
    Option,
    Request,
    answered,
    load_sheet,
    read_request,
)
from solver.path.planner import planner
from solver.ranking.signs import signs_of
from solver.report.sheet import (
    MOST_WARNINGS,
    diagnosis_json,
    result_csv,
    result_json,
    result_text,
    with_warnings,
)
from solver.solution.solving import Result, posted, solve

SOLVE = f"""\
{GIVEN}{WANTED}{UNITS}
--all                    show every answer, side by side
--explain                show locals, path, and rules used
--digits                 print only the digits that are correct
--prove                  prove every answer, and that there are no others
--limits                 replace rules that are 0/0 by their limits
--sensitivity [NAME,…]   derivatives of outputs by inputs, for the names given or for all
--tolerances             tolerances of the outputs (default if inputs have some)
--monte-carlo N          compare the tolerances with N random samples
--seed K                 the seed of the samples (0)
--distribution {{uniform,normal}}  uniform within the tolerances, or normal with 3 sigma in them
| --json                 print one JSON object
| --csv                  print the variable sheet as CSV
-o --output FILE.csv     also write the variable sheet to a file
"""
CHECK = f"""\
{SHEET}
--equations  list the equations with calls expanded
--latex      list the equations as LaTeX
--json       print the messages as a JSON object
"""
FORMAT = """\
sheet SHEET      a rule sheet, or the name of a shipped one
| -i --in-place  write the file instead of printing it
| --check        only report whether the file is in canonical form
"""
WHY = f"""\
{GIVEN}{UNITS}
name NAME     the variable to explain; a local by its full name
| --markdown  print Markdown
| --latex     print LaTeX
"""

_CODE = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))


def remembered(asked: Request, **options: bool) -> Result:
    """Solve with the cached results for the same names, which do not depend on numbers.

    A new path is kept with what belongs to it.
    """
    model, inputs, want, guesses = asked.model, asked.inputs, asked.want, asked.guesses
    cleared = sorted((name, value is None) for name, value in inputs.items())
    question = repr((stamp(_CODE), cleared, want))
    recall(model, question)
    known = len(planner(model).paths)
    result = solve(model, inputs, want, guesses, **options)
    if len(planner(model).paths) > known:
        keep(model, question, planner, signs_of)
    return result


def _solve(arguments: Namespace) -> int:
    """Solve, write, print; the exit code is that of the status."""
    request = read_request(arguments)
    if arguments.output:
        request.expect_output(arguments.output)
    result = remembered(request, prove=arguments.prove, limits=arguments.limits)
    if arguments.output:
        from solver.files import write_file

        write_file(arguments.output, result_csv(result).encode())
    result = with_warnings(result, sys.maxsize if arguments.json else MOST_WARNINGS)
    if arguments.csv:  # messages go to stderr, for programs that read the sheet
        sys.stdout.write(result_csv(result, every=arguments.all))
        for diagnosis in result.diagnoses:
            print(render(diagnosis), file=sys.stderr)
    elif not arguments.json:
        shown = {"every": arguments.all, "explain": arguments.explain, "digits": arguments.digits}
        print(result_text(result, **shown))
    derived = _derived(result, arguments)
    if arguments.json:
        also = derived.json() if derived else {}
        print(result_json(result, explain=arguments.explain, digits=arguments.digits, also=also))
    elif derived and arguments.csv:
        print(derived.text(), file=sys.stderr)
    elif derived:
        print(f"\n{derived.text()}")
    return result.status.exit_code


def _derived(result: Result, arguments: Namespace) -> Any:
    """The derived results that the options ask for; None if they ask for none.

    Tolerances also if an input of an answer has one. Of the names of ``--sensitivity`` inputs
    select columns, others rows. Raises RuleSheetError for unknown names.
    """
    text, samples = arguments.sensitivity, None
    stated = any(result.model.variables[name].tolerance for name in result.inputs)
    asked = arguments.tolerances or arguments.monte_carlo
    banded = asked or (stated and result.solutions and (text is not None or not arguments.csv))
    if text is None and not banded:
        return None
    from solver.report.html import Derived  # imports plans, which a plain solve does not need

    sensitivities = None
    if text is not None:
        names = list(filter(None, map(str.strip, text.split(","))))
        for name in names:
            variable_named(name, result.model, Option("sensitivity", text).place(name))
        inputs = [name for name in names if name in result.inputs]
        outputs = [name for name in names if name not in result.inputs]
        sensitivities = result.sensitivity(outputs or None, inputs or None)
    bands = result.tolerance_bands() if banded else None
    if arguments.monte_carlo and bands is not None and bands.tolerances and result.solutions:
        from solver.sweeps.sweep import monte_carlo

        samples = monte_carlo(result, arguments.monte_carlo, arguments.seed, arguments.distribution)
    return Derived(sensitivities, bands, samples)


LOOK = 0.2
"""Seconds between two looks at the files."""


def _watch(arguments: Namespace) -> int:
    """Solve now and after every change until interrupted."""
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
    """Solve once and print; return the files that the sheet was read from."""
    answered(_solve, arguments)
    with suppress(RuleSheetError):
        within, allowed = arguments.within, arguments.allow_python
        return set(load(arguments.sheet, within=within, allow_python=allowed).files)
    return set()


def _saved(files: Iterable[str]) -> dict[str, float]:
    """The time of the last change of each file; -1 for a missing one."""
    found = {}
    for file in files:
        found[file] = -1.0
        with suppress(OSError):
            found[file] = os.stat(file).st_mtime_ns
    return found


def _check(arguments: Namespace) -> int:
    """Load the sheet, which raises for all mistakes; then print a summary."""
    from rulesheets.units.check import check_units, inferred  # a solve starts without them

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
    own = sum("." not in name for name in model.variables)
    kinds = {"requirement": len(model.requirements), "figure": len(model.figures)}
    counts = {"local": len(model.variables) - own, "rule": len(model.equations), **kinds}
    more = [plural(count, noun) for noun, count in counts.items() if count or noun == "rule"]
    wrong = plural(warnings, "warning") if warnings else "nothing wrong"
    return f"{model.name}: {', '.join([plural(own, 'variable'), *more])}; {wrong}"


def _format(arguments: Namespace) -> int:
    """Print or write the sheet; ``--check`` exits with 1 if it would change."""
    from rulesheets.format import format_sheet
    from solver.files import write_file

    path = find_sheet(arguments.sheet)
    source = read_source(path)
    text = format_sheet(parsed(source, path))
    if arguments.check:
        if text == source.text:
            return 0
        told = "is not in canonical form: backsolve format -i writes it so"
        print(f"{escaped(path)} {told}", file=sys.stderr)
        return 1
    if not arguments.in_place:
        sys.stdout.write(text)
    elif text != source.text:
        write_file(path, text.encode())
    return 0


def _path(arguments: Namespace) -> int:
    """Print the path; the exit code is 0 if it reaches every wanted variable in some case."""
    from solver.path.planner import path_tree
    from solver.report.path import reaches, tree_text

    request = read_request(arguments)
    model, given = request.model, override(request.model, request.inputs, request.guesses).values
    wanted = request.want or posted(model)
    want = None if request.want is None else frozenset(request.want)
    ahead = path_tree(model, given, want)
    print(tree_text(model, ahead, wanted))
    return 0 if reaches(ahead, wanted) else 1


def _why(arguments: Namespace) -> int:
    """Solve, trace, print; the exit code is 0 if the variable has a value."""
    from solver.report import derivation as told  # a plain solve does without

    request = read_request(arguments)
    variable_named(arguments.name, request.model)
    result = solve(request.model, request.inputs, guesses=request.guesses)
    derivation = told.why(result, arguments.name)
    known = derivation.value is not None
    write = told.why_markdown if arguments.markdown else told.why_text
    print((told.why_latex if arguments.latex and known else write)(derivation))
    for diagnosis in () if known else derivation.diagnoses:
        print(f"\n{render(diagnosis)}")
    return 0 if known else 1


COMMANDS = {
    "solve": Command(SOLVE, _solve),
    "watch": Command(SOLVE, _watch),
    "check": Command(CHECK, _check),
    "format": Command(FORMAT, _format, keeps=False),
    "path": Command(GIVEN + WANTED, _path),
    "why": Command(WHY, _why),
}
