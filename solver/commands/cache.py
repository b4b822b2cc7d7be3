"""``backsolve cache``: what is kept between runs, and where."""

from __future__ import annotations

import sys
from argparse import ArgumentParser, Namespace

from rulesheets import store


def add_arguments(parser: ArgumentParser) -> None:
    parser.add_argument("--clear", action="store_true", help="remove every entry")


def run(arguments: Namespace) -> int:
    """Say where the entries are, how many, and their size; with ``--clear`` remove them first."""
    folder = store.folder()
    if folder is None:
        print("nothing is kept: BACKSOLVE_CACHE is empty")
        return 0
    if arguments.clear:
        return _clear(folder)
    count, size = store.usage()
    print(f"{folder}: {_entries(count)}, {_size(size)}")
    if not store.trusted(folder):
        print("it is not used: it belongs to somebody else, or others can write to it", file=sys.stderr)
    return 0


def _clear(folder: str) -> int:
    try:
        count = store.clear()
    except OSError as failure:
        print(f"error: {folder} cannot be cleared: {failure.strerror}", file=sys.stderr)
        return 2
    print(f"{folder}: {_entries(count)} removed")
    return 0


def _entries(count: int) -> str:
    return "1 entry" if count == 1 else f"{count or 'no'} entries"


def _size(size: int) -> str:
    return f"{size / 2**20:.1f} MB" if size >= 2**20 else f"{size / 2**10:.1f} kB"
