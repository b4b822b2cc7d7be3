"""``backsolve path``: the order in which the rules are solved, before anything is."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace

from rulesheets.inputs import override
from solver.commands.inputs import add_input_options, read_request
from solver.path.planner import planner
from solver.path.tree import path_tree
from solver.report.path import reaches, tree_text
from solver.solving import posted


def add_arguments(parser: ArgumentParser) -> None:
    add_input_options(parser)


def run(arguments: Namespace) -> int:
    """Print the path; the exit code is 0 where it reaches every wanted variable, at least in some case."""
    request = read_request(arguments)
    model, given = request.model, override(request.model, request.inputs, request.guesses).values
    wanted = request.want or posted(model)
    ahead = path_tree(planner(model), given, None if request.want is None else frozenset(request.want))
    print(tree_text(model, ahead, wanted))
    return 0 if reaches(ahead, wanted) else 1
