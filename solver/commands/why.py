"""``backsolve why``: the chain of rules from the inputs to one number."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace

from rulesheets.diagnosis import render
from rulesheets.inputs import variable_named
from solver.commands.inputs import add_display_options, add_input_options, read_request
from solver.derivation import Derivation, why
from solver.report.why import why_latex, why_markdown, why_text
from solver.solving import solve


def add_arguments(parser: ArgumentParser) -> None:
    add_input_options(parser, want=False)
    add_display_options(parser)
    parser.add_argument("name", metavar="NAME", help="the variable to account for, a local by its full name")
    forms = parser.add_mutually_exclusive_group()
    forms.add_argument("--markdown", action="store_true", help="print Markdown")
    forms.add_argument("--latex", action="store_true", help="print LaTeX")


def run(arguments: Namespace) -> int:
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
