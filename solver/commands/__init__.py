"""What each command of ``backsolve`` asks for, does and prints; here its words are read, and it is run.

Neither sympy nor matplotlib is imported before a command asks for it.
"""

from __future__ import annotations

import os
import sys
from argparse import ArgumentParser, HelpFormatter, Namespace
from collections.abc import Callable, Collection
from functools import partial
from importlib import import_module
from typing import NamedTuple, NoReturn

from rulesheets.deadline import TimeIsUp, time_limit
from rulesheets.diagnosis import RuleSheetError, closest, render, suggestion
from rulesheets.syntax import escaped
from solver.report import screen_of, shown_on

UNSOLVED = 1
WRONG = 2
"""Exit code where the sheet or the command is wrong."""


class Command(NamedTuple):
    """What adds the options of a command, what runs it, and whether it looks up or keeps anything."""

    add_arguments: Callable[[ArgumentParser], None]
    run: Callable[[Namespace], int]
    keeps: bool = True


def run(name: str, module: str, about: str, words: list[str]) -> int:
    """Parse the words of the command of a module and run it; what argparse refuses ends with exit code 2.

    Diagnoses are rendered for people on stderr, and as an object on stdout where JSON is asked for.
    """
    command: Command = import_module(f"solver.{module}").COMMANDS[name]
    form = partial(HelpFormatter, width=(screen_of(sys.stdout).width or 80) - 2)  # else it brings shutil
    parser = _Parser(f"backsolve {name}", description=f"{about[0].upper()}{about[1:]}.", formatter_class=form)
    command.add_arguments(parser)
    if command.keeps:
        parser.add_argument("--no-cache", action="store_true", help="neither look up nor keep anything")
    try:
        arguments = parser.read(words)
    except SystemExit as end:
        return int(end.code or 0)
    if getattr(arguments, "no_cache", False):
        os.environ["BACKSOLVE_CACHE"] = ""
    try:
        with time_limit(getattr(arguments, "timeout", None)), shown_on(sys.stdout):
            return command.run(arguments)
    except TimeIsUp:
        print("error[S553]: the time was up", file=sys.stderr)
        return UNSOLVED
    except RuleSheetError as wrong:
        color = sys.stderr.isatty() and "NO_COLOR" not in os.environ
        width = screen_of(sys.stderr).width
        said = (render(diagnosis, color=color, width=width) for diagnosis in wrong.diagnoses)
        print("\n\n".join(said), file=sys.stderr)
        if getattr(arguments, "json", False):
            from solver.report.sheet import error_json  # with it comes numpy, which help does without

            print(error_json(wrong.diagnoses))
        return WRONG


class _Parser(ArgumentParser):
    """The arguments of one command. Mistakes raise SystemExit when they are told."""

    def read(self, words: list[str]) -> Namespace:
        options = {option for action in self._actions for option in action.option_strings}
        for word in words[: words.index("--")] if "--" in words else words:
            name = word.partition("=")[0]
            if name.startswith("--") and name not in options:  # no abbreviations
                near = closest(name.lstrip("-"), sorted(option.lstrip("-") for option in options))
                notes = (f"did you mean --{near}?",) if near and f"--{near}" in options else ()
                self.error(f"there is no option {name}", *notes)
        return self.parse_intermixed_args(words)

    def error(self, message: str, *notes: str) -> NoReturn:
        for line in (f"{self.prog}: {message}", *(f"  {note}" for note in notes)):
            print(escaped(line), file=sys.stderr)
        print(f"  `{self.prog} --help` lists the options", file=sys.stderr)
        raise SystemExit(WRONG)


def unknown_command(word: str, commands: Collection[str]) -> int:
    print(f"backsolve: there is no command {escaped(word)}", file=sys.stderr)
    for note in suggestion(word, commands):
        print(f"  {note}", file=sys.stderr)
    print(f"  the commands are {', '.join(commands)}", file=sys.stderr)
    return WRONG
