"""``backsolve path``: the order in which the rules are solved."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace

from solver.commands.inputs import add_input_options, read_request


def add_arguments(parser: ArgumentParser) -> None:
    add_input_options(parser)


def run(arguments: Namespace) -> int:
    """Print the path; the exit code is 0 where it reaches every wanted variable."""
    from solver.report.path import path_text, unreached
    from solver.solving import solve

    request = read_request(arguments)
    result = solve(request.model, request.inputs, want=request.want, guesses=request.guesses)
    print(path_text(result))
    return 1 if unreached(result) else 0
