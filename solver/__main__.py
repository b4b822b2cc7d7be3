"""The ``backsolve`` command: picks the command, reports mistakes, never shows a traceback.

Only the requested command is imported, and help imports nothing.
"""

from __future__ import annotations

import gc
import os
import sys
from collections.abc import Sequence
from importlib import import_module

INTERRUPTED = 130
BROKEN_PIPE = 141
WRONG = 2

COMMANDS = {
    "solve": ("commands.solve", "solve a sheet and print its variable sheet"),
    "sweep": ("commands.sweep", "solve a sheet for many values of an input"),
    "draw": ("commands.draw", "draw the figures of a sheet to scale"),
    "chart": ("commands.chart", "measure methods on a sheet: speed against accuracy"),
    "path": ("commands.solve", "show the order in which the rules are solved"),
    "why": ("commands.solve", "show the chain of rules behind one number"),
    "check": ("commands.solve", "report the mistakes in a sheet"),
    "format": ("commands.solve", "print a sheet in its canonical form"),
    "open": ("page.serving", "open a sheet as a page in the browser"),
    "export": ("page.serving", "write a sheet as one file with sliders"),
    "watch": ("commands.solve", "solve a sheet whenever it is saved"),
    "tutor": ("commands.about", "learn the first steps in five minutes"),
    "lsp": ("page.serving", "run the language server for an editor"),
    "completion": ("commands.about", "print a completion script for a shell"),
    "models": ("commands.about", "list the sheets that come with Backsolve"),
    "codes": ("commands.about", "explain the code of a message"),
    "cache": ("commands.about", "show or clear the cache"),
}
"""Each by its name, with its module in the solver, and what it does."""

USAGE = """\
usage: backsolve COMMAND …

Write rules in any order; Backsolve solves them forward or backward.

commands:
{commands}

`backsolve COMMAND --help` lists options, `backsolve --version` the version.
A sheet is a file, a folder with a model.tk, or a name from `backsolve models`."""


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command: exit code 0 if solved, 1 if not, 2 for a wrong sheet or command."""
    words = list(sys.argv[1:] if argv is None else argv)
    if argv is None:
        gc.disable()  # until the command is imported, which stays
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # small matrices: threads would only wait
    _prepare_streams()
    try:
        code = _dispatch(words)
        sys.stdout.flush()
        return code
    except BrokenPipeError:
        _silence_stdout()
        return BROKEN_PIPE
    except OSError as failure:
        _silence_stdout()
        reason = failure.strerror or failure
        print(f"error: the output cannot be written: {reason}", file=sys.stderr)
        return WRONG
    except KeyboardInterrupt:
        print("interrupted", file=sys.stderr)
        return INTERRUPTED
    except (MemoryError, RecursionError):
        print("error: this sheet is too large for the memory of this machine", file=sys.stderr)
        return WRONG
    finally:
        if argv is None:
            # the process ends: to look for garbage then takes a fifth of a short command
            gc.freeze()


def _dispatch(words: list[str]) -> int:
    if not words or words[0] in ("-h", "--help", "help"):
        print(usage())
        return 0 if words else WRONG
    if words[0] == "--version":
        from importlib.metadata import version  # takes longer to import than help does

        print(f"backsolve {version('backsolve')}")
        return 0
    from solver.commands import run, unknown_command  # help does not need this import

    if words[0] not in COMMANDS:
        return unknown_command(words[0], COMMANDS)
    import_module(f"solver.{COMMANDS[words[0]][0]}")
    if not gc.isenabled():
        gc.freeze()
        gc.enable()
    return run(words[0], COMMANDS, words[1:])


def usage() -> str:
    width = max(map(len, COMMANDS))
    lines = (f"  {name:<{width}}  {summary}" for name, (_, summary) in COMMANDS.items())
    return USAGE.format(commands="\n".join(lines))


def _prepare_streams() -> None:
    """Replace streams that the caller has closed, so that no file opened later takes their place.

    A terminal that cannot show a character shows a substitute.
    """
    for name in ("stdin", "stdout", "stderr"):
        if getattr(sys, name) is None:
            setattr(sys, name, open(os.devnull, "r" if name == "stdin" else "w"))  # noqa: SIM115
        elif name != "stdin" and hasattr(stream := getattr(sys, name), "reconfigure"):
            stream.reconfigure(errors="replace")


def _silence_stdout() -> None:
    """Nobody reads on: discard the buffered output, so that the exit raises nothing."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


if __name__ == "__main__":
    sys.exit(main())
