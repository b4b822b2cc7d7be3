"""Commands that explain a solve: the ``path`` that it takes, and ``why`` a number is what it is."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace

from rulesheets.diagnosis import render
from rulesheets.inputs import override, variable_named
from solver.commands.inputs import add_display_options, add_input_options, read_request
from solver.commands.running import Command
from solver.path.planner import planner
from solver.path.tree import path_tree
from solver.report.derivation import Derivation, why
from solver.report.path import reaches, tree_text
from solver.report.why import why_latex, why_markdown, why_text
from solver.solving import posted, solve


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


COMMANDS = {"path": Command(add_input_options, _path), "why": Command(_why_arguments, _why)}
