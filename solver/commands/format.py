"""``backsolve format``: a sheet in its canonical form."""

from __future__ import annotations

import sys
from argparse import ArgumentParser, Namespace

from rulesheets.format import format_sheet
from rulesheets.loading import find_sheet, parsed, read_source
from rulesheets.syntax.source import escaped
from solver.files.replacing import write_file


def add_arguments(parser: ArgumentParser) -> None:
    parser.add_argument("sheet", metavar="SHEET", help="a rule sheet, or the name of a shipped one")
    how = parser.add_mutually_exclusive_group()
    how.add_argument("-i", "--in-place", action="store_true", help="write the file instead of printing it")
    how.add_argument("--check", action="store_true", help="only say whether the file is in canonical form")


def run(arguments: Namespace) -> int:
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
