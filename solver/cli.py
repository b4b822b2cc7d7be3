"""The ``backsolve`` command: picks the command, reports what is wrong, never shows a traceback.

Only the command that is asked for is imported, and its own heavy imports wait until it runs:
help and mistakes in the command cost nothing.
"""

from __future__ import annotations

import gc
import os
import sys
from argparse import ArgumentParser, Namespace
from collections.abc import Collection, Sequence
from importlib import import_module
from typing import NoReturn

from rulesheets.deadline import TimeIsUp, time_limit
from rulesheets.diagnosis import RuleSheetError, closest, render, suggestion
from rulesheets.syntax.source import escaped
from solver.report.table import screen_of, shown_on

COMMANDS = {
    "solve": "solve a sheet and print its variable sheet",
    "sweep": "solve a sheet for many values of an input",
    "draw": "draw the figures of a sheet to scale",
    "chart": "measure methods on a sheet: speed against accuracy",
    "path": "show the order in which the rules are solved",
    "why": "show the chain of rules behind one number",
    "check": "read a sheet and say what is wrong with it",
    "format": "print a sheet in its canonical form",
    "open": "open a sheet as a page in the browser",
    "export": "write a sheet as one file with sliders",
    "watch": "solve a sheet whenever it is saved",
    "tutor": "learn the first steps, in five minutes",
    "lsp": "serve an editor: the language server",
    "completion": "print what a shell completes commands by",
    "models": "list the sheets that come with Backsolve",
    "codes": "say what the code of a message means",
    "cache": "show what is kept between runs, or clear it",
}

UNKEPT = frozenset({"format", "models", "codes", "cache", "lsp", "tutor", "completion"})
"""Commands that neither find nor keep anything."""

UNSOLVED = 1
WRONG = 2
"""Exit code where the sheet or the command is wrong."""
INTERRUPTED = 130
BROKEN_PIPE = 141

COLLECTION = 100_000, 50, 100
"""Thresholds of the garbage collector: large sheets are objects that stay, not worth going over often."""

USAGE = """\
usage: backsolve COMMAND …

Write what you know as rules in any order; Backsolve solves them forward or backward.

commands:
{commands}

`backsolve COMMAND --help` tells the options of a command, `backsolve --version` the version.
A sheet is a file, a folder with a model.tk, or the name of a sheet that `backsolve models` lists."""


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command; the exit code is 0 for solved, 1 for not solved, 2 for a wrong sheet or command."""
    words = list(sys.argv[1:] if argv is None else argv)
    _open_streams()
    _print_anything()
    try:
        code = _dispatch(words)
        sys.stdout.flush()
        return code
    except BrokenPipeError:
        _silence_stdout()
        return BROKEN_PIPE
    except OSError as failure:
        _silence_stdout()
        print(f"error: the output cannot be written: {failure.strerror or failure}", file=sys.stderr)
        return WRONG
    except KeyboardInterrupt:
        print("interrupted", file=sys.stderr)
        return INTERRUPTED
    except (MemoryError, RecursionError):
        print("error: this sheet is too large for the memory of this machine", file=sys.stderr)
        return WRONG


def _dispatch(words: list[str]) -> int:
    if not words or words[0] in ("-h", "--help", "help"):
        print(usage())
        return 0 if words else WRONG
    if words[0] == "--version":
        print(_version())
        return 0
    if words[0] not in COMMANDS:
        return _unknown_command(words[0])
    return _run(words[0], words[1:])


def _run(command: str, words: list[str]) -> int:
    """Parse the words of a command and run it; what argparse refuses ends with exit code 2."""
    gc.set_threshold(*COLLECTION)
    module = import_module(f"solver.commands.{command}")
    parser = _Parser(command)
    module.add_arguments(parser)
    if command not in UNKEPT:
        parser.add_argument("--no-cache", action="store_true", help="neither look up nor keep anything")
    try:
        arguments = parser.read(words)
    except SystemExit as end:
        return int(end.code or 0)
    if getattr(arguments, "no_cache", False):
        os.environ["BACKSOLVE_CACHE"] = ""
    try:
        with time_limit(getattr(arguments, "timeout", None)), shown_on(sys.stdout):
            code: int = module.run(arguments)
        return code
    except TimeIsUp:
        print("error[S553]: the time was up", file=sys.stderr)
        return UNSOLVED
    except RuleSheetError as wrong:
        return _report(wrong, arguments)


class _Parser(ArgumentParser):
    """The arguments of one command. Mistakes raise SystemExit when they are told."""

    def __init__(self, command: str) -> None:
        about = f"{COMMANDS[command][0].upper()}{COMMANDS[command][1:]}."
        super().__init__(prog=f"backsolve {command}", description=about, allow_abbrev=False)
        self._command = command

    def read(self, words: list[str]) -> Namespace:
        options = {option for action in self._actions for option in action.option_strings}
        for word in words[: words.index("--")] if "--" in words else words:
            if word.startswith("--") and word.partition("=")[0] not in options:
                raise SystemExit(_unknown_option(self._command, word.partition("=")[0], options))
        return self.parse_intermixed_args(words)

    def error(self, message: str) -> NoReturn:
        raise SystemExit(_misused(self._command, message))


def _unknown_option(command: str, word: str, options: Collection[str]) -> int:
    near = closest(word.lstrip("-"), sorted(option.lstrip("-") for option in options))
    notes = (f"did you mean --{near}?",) if near and f"--{near}" in options else ()
    return _misused(command, f"there is no option {word}", *notes)


def _misused(command: str, message: str, *notes: str) -> int:
    """Say what is wrong with the words of a command, and where its options are told."""
    for line in (f"backsolve {command}: {message}", *(f"  {note}" for note in notes)):
        print(escaped(line), file=sys.stderr)
    print(f"  `backsolve {command} --help` lists the options", file=sys.stderr)
    return WRONG


def _report(wrong: RuleSheetError, arguments: Namespace) -> int:
    """Diagnoses rendered for people on stderr, and as an object on stdout where JSON is asked for."""
    color = sys.stderr.isatty() and "NO_COLOR" not in os.environ
    width = screen_of(sys.stderr).width
    said = (render(diagnosis, color=color, width=width) for diagnosis in wrong.diagnoses)
    print("\n\n".join(said), file=sys.stderr)
    if getattr(arguments, "json", False):
        from solver.report.sheet import error_json  # with it comes numpy, which help does without

        print(error_json(wrong.diagnoses))
    return WRONG


def usage() -> str:
    width = max(map(len, COMMANDS))
    lines = (f"  {name:<{width}}  {summary}" for name, summary in COMMANDS.items())
    return USAGE.format(commands="\n".join(lines))


def _unknown_command(word: str) -> int:
    print(f"backsolve: there is no command {escaped(word)}", file=sys.stderr)
    for note in suggestion(word, COMMANDS):
        print(f"  {note}", file=sys.stderr)
    print(f"  the commands are {', '.join(COMMANDS)}", file=sys.stderr)
    return WRONG


def _version() -> str:
    from importlib.metadata import version  # takes longer to import than help does

    return f"backsolve {version('backsolve')}"


def _open_streams() -> None:
    """Streams that the caller has closed lead nowhere; no file that is opened later takes their place."""
    for name in ("stdin", "stdout", "stderr"):
        if getattr(sys, name) is None:
            setattr(sys, name, open(os.devnull, "r" if name == "stdin" else "w"))  # noqa: SIM115


def _print_anything() -> None:
    """A terminal that cannot show a character shows a mark for it."""
    for stream in (sys.stdout, sys.stderr):
        reconfigure = getattr(stream, "reconfigure", None)
        if reconfigure is not None:
            reconfigure(errors="replace")


def _silence_stdout() -> None:
    """Nobody reads on: what is still buffered goes nowhere, so that the exit raises nothing."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
