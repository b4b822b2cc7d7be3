"""``backsolve export``: a sheet as one file with sliders, for a course page or a report."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace

from solver.commands.inputs import add_input_options, read_request
from solver.commands.over import read_axes
from solver.files.replacing import write_file


def add_arguments(parser: ArgumentParser) -> None:
    add_input_options(parser)
    add = parser.add_argument
    add(
        "--over",
        metavar="NAME=START:STOP:STEP",
        action="append",
        default=[],
        help="a slider for an input, or NAME=A,B,…; up to three",
    )
    add("-o", "--output", metavar="FILE.html", help="the file to write; NAME.html by default")


def run(arguments: Namespace) -> int:
    """Solve every state, write; the exit code is 0 if one of them has an answer."""
    from solver.page.export import export

    request = read_request(arguments)
    axes = read_axes(arguments.over, request.model)
    request.swept(axes)
    values = {name: axis.cut(0, len(axis)).tolist() for name, axis in axes.items()}
    exported = export(request.model, request.inputs, request.guesses, values, request.want)
    path = arguments.output or f"{request.model.name}.html"
    write_file(path, exported.page.encode())
    print(f"{path}: {exported.solved} of {exported.states} states solved")
    return 0 if exported.solved else 1
