"""``backsolve codes``: what the code of a message means, and what to do about it."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace

from rulesheets.diagnosis import RuleSheetError, catalogue, error, suggestion
from solver.report.table import columns


def add_arguments(parser: ArgumentParser) -> None:
    parser.add_argument(
        "code", nargs="?", metavar="CODE", help="such as E105 or S530; without it, all of them are listed"
    )


def run(arguments: Namespace) -> int:
    """One code with its cause and its cure, or a line for each."""
    if arguments.code is None:
        print(columns((code, entry.title) for code, entry in catalogue().items()))
        return 0
    code = arguments.code.strip("[]").upper()
    if code not in catalogue():
        notes = (*suggestion(code, catalogue()), "`backsolve codes` lists them")
        raise RuleSheetError(error("E426", f"no message has the code {arguments.code}", notes=notes))
    entry = catalogue()[code]
    print(f"{code}: {entry.title}\n\n{entry.cause}\n{entry.fix}")
    return 0
