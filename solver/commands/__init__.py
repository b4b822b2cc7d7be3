"""The options, the work and the output of each command of ``backsolve``.

This module reads the command line (a sheet, a variable sheet, options) and runs it.
"""

from __future__ import annotations

import os
import sys
from argparse import ArgumentParser, ArgumentTypeError, Namespace
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from contextlib import suppress
from importlib import import_module
from math import inf
from textwrap import fill
from typing import Any, NamedTuple, NoReturn

from rulesheets.deadline import TimeIsUp, setting, time_limit
from rulesheets.diagnosis import (
    Diagnosis,
    RuleSheetError,
    closest,
    error_at,
    plural,
    refuse,
    render,
    suggestion,
)
from rulesheets.files import decoded, find_variable_sheet
from rulesheets.inputs import (
    guess_with_tolerance,
    parse_input,
    quantities,
    symbol_for_number,
    unknown_variable,
    with_tolerances,
)
from rulesheets.loading import load, loads
from rulesheets.model import Model, Tolerance, Value
from rulesheets.syntax import Source, Span, escaped
from rulesheets.units import with_display_unit, with_display_units
from solver.report import SCREEN, screen_of

UNSOLVED = 1
WRONG = 2
"""Exit code where the sheet or the command is wrong."""


class Command(NamedTuple):
    """``options`` are lines as ``declare`` reads them, ``keeps`` tells whether it uses the cache.

    ``patient``: ``--timeout`` limits each solve, not the command. Its module has it in the table
    ``COMMANDS``.
    """

    options: str
    run: Callable[[Namespace], int]
    keeps: bool = True
    patient: bool = False
    epilog: str = ""


def run(name: str, commands: Mapping[str, tuple[str, str]], words: list[str]) -> int:
    """Parse the words of a command and run it; words that argparse refuses end with exit code 2."""
    module, about = commands[name]
    command: Command = import_module(f"solver.{module}").COMMANDS[name]
    said = f"{about[0].upper()}{about[1:]}."
    parser = _Parser(f"backsolve {name}", description=said, epilog=command.epilog)
    declare(parser, command.options + "--no-cache  do not use the cache" * command.keeps)
    parser.set_defaults(commands=commands)
    try:
        arguments = parser.read(words)
    except SystemExit as end:
        return int(end.code or 0)
    if getattr(arguments, "no_cache", False):
        os.environ["BACKSOLVE_CACHE"] = ""
    return answered(command.run, arguments, patient=command.patient)


def answered(
    command: Callable[[Namespace], int], arguments: Namespace, patient: bool = False
) -> int:
    """Run a command, within its time unless it is ``patient``.

    Diagnoses are rendered for people on stderr, and as an object on stdout where JSON is asked for.
    """
    try:
        limit = time_limit(None if patient else getattr(arguments, "timeout", None))
        with limit, setting(SCREEN, screen_of(sys.stdout)):
            return command(arguments)
    except TimeIsUp:
        print("error[S553]: the time was up", file=sys.stderr)
        return UNSOLVED
    except RuleSheetError as wrong:
        print("\n\n".join(screen_of(sys.stderr).said(wrong.diagnoses)), file=sys.stderr)
        if getattr(arguments, "json", False):
            from solver.report.sheet import error_json  # imports numpy, which help does not need

            print(error_json(wrong.diagnoses))
        return WRONG


class _Parser(ArgumentParser):
    """The arguments of one command. Mistakes are printed and raise SystemExit."""

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
    sheet = word.endswith(".tk") or os.path.exists(word)
    notes = (f"did you mean backsolve solve {word}?",) if sheet else suggestion(word, commands)
    said = f"backsolve: there is no command {word}"
    for note in (said, *notes, f"the commands are {', '.join(commands)}"):
        line = escaped(note if note is said else f"  {note}")
        width = screen_of(sys.stderr).width or len(line)
        print(fill(line, width, subsequent_indent="    "), file=sys.stderr)
    return WRONG


class Option(NamedTuple):
    """One option as the user wrote it: ``text`` follows ``--name``."""

    name: str
    text: str

    def place(self, part: str, *, first: bool = False) -> Span:
        """The place of a part of the text, the last of several."""
        within = self.text.find(part) if first else self.text.rfind(part)
        start = len(self.name) + 3 + max(within, 0)
        source = Source("command line", f"--{self.name} {self.text}")
        return Span(source, start, start + max(len(part), 1))

    def wrong(self, code: str, message: str, note: str, part: str = "") -> Diagnosis:
        """A mistake in the option, or in a part of its text."""
        return error_at(code, message, self.place(part or self.text), note)

    def repeated(self, name: str) -> Diagnosis:
        place, note = self.place(name, first=True), "keep one of the options"
        return error_at("E421", f"{name} is given twice", place, note, label="again")


class Request(NamedTuple):
    """The question of a solve: a model, inputs (None clears one), guesses, wanted names.

    ``options`` are the names of inputs given by options, not by a variable sheet; ``files`` are all
    files that were read.
    """

    model: Model
    inputs: Mapping[str, Value | None]
    guesses: Mapping[str, float]
    want: tuple[str, ...] | None
    options: frozenset[str] = frozenset()
    files: tuple[str, ...] = ()

    def swept(self, names: Iterable[str]) -> None:
        """Raise RuleSheetError (E421) if ``--set`` gives a variable that ``--over`` sweeps."""
        refuse([Option("over", name).repeated(name) for name in names if name in self.options])

    def expect_output(self, path: str | None) -> None:
        """Raise RuleSheetError (E418) if a file to write is one that was read."""
        if path is not None:
            from solver.files import expect_no_input

            expect_no_input(path, self.files)


def load_sheet(arguments: Namespace) -> Model:
    """The model of the sheet, ``-`` for standard input. Raises RuleSheetError with all mistakes."""
    allowed, within = arguments.allow_python, arguments.within
    if arguments.sheet != "-":
        model = load(arguments.sheet, within=within, allow_python=allowed)
    else:
        text = decoded("standard input", sys.stdin.buffer.read())
        model = loads(text, "standard input", base="", within=within, allow_python=allowed)
    for note in model.notes:
        print(render(note), file=sys.stderr)
    return model


def tell_of_units(model: Model) -> None:
    """A line about warnings of units, for commands that print no messages of a solve."""
    if warnings := model.unit_warnings:
        count = plural(len(warnings), "warning")
        print(f"{count} of units (backsolve check): {warnings[0].message}", file=sys.stderr)


def number_of(
    what: str, kind: type[float], least: float, most: float = inf
) -> Callable[[str], float]:
    """A reader of such a number on the command line, for argparse."""

    def read(text: str) -> float:
        with suppress(ValueError):
            if least <= (number := kind(text)) <= most:
                return number
        raise ArgumentTypeError(f"{text} is no number of {what}")

    return read


KINDS: dict[str, dict[str, Any]] = {
    "--timeout": {"type": number_of("seconds", float, 1e-6)},
    "--monte-carlo": {"type": number_of("samples from 2 to 10,000,000", int, 2, 10_000_000)},
    "--jobs": {"type": number_of("processes", int, 1)},
    "--dpi": {"type": float},
    "--seed": {"type": int, "default": 0},
    "--port": {"type": int, "default": 0},
    "--host": {"default": "127.0.0.1"},
    "--distribution": {"default": "uniform"},
}
"""The types and defaults of options that take something else than a text."""

SHEET = """\
sheet SHEET      a rule sheet, the name of a shipped one, or - for stdin
--allow-python   run the Python files that the sheet names (use python)
--within FOLDER  read only files in this folder, links resolved
"""
GIVEN = f"""\
{SHEET}
variables [VARIABLES.csv]  a variable sheet to fill in
--set NAME=VALUE[unit]*    give an input
--clear NAME*              clear an input to solve for it
--timeout SECONDS          stop after this time
--guess NAME=VALUE*        a first guess
"""
WANTED = "--want NAME,…*  solve for these only\n"
UNITS = """\
--unit NAME=UNIT*  show a variable in this unit
--units {si,us}    show every variable in units of this system
"""


def declare(parser: ArgumentParser, options: str) -> None:
    """Add options, a line each: what is written, two spaces, and what it does.

    An argument without a dash begins with its name. ``*``: it can be given several times; in
    brackets: it can be left out; ``|``: one of these lines at most.
    """
    either = parser.add_mutually_exclusive_group() if "| " in options else parser
    for line in filter(None, options.splitlines()):
        words, _, said = line.removeprefix("| ").partition("  ")
        names = words.split()
        takes = "" if names[-1].startswith("-") else names.pop()
        how: dict[str, Any] = {"metavar": takes}
        if not takes:
            how = {"action": "store_true"}
        elif takes.startswith("{"):
            how = {"choices": takes[1:-1].split(",")}
        elif takes.startswith("["):
            how = {"metavar": takes[1:-1], "nargs": "?", "const": ""}
        elif takes.endswith("*"):
            how = {"metavar": takes[:-1], "action": "append", "default": []}
        how |= {"help": said.strip(), **KINDS.get(names[-1], {})}
        (either if line.startswith("| ") else parser).add_argument(*names, **how)


def read_request(arguments: Namespace) -> Request:
    """Load the sheets and apply the options.

    Raises RuleSheetError with all mistakes, unknown names included.
    """
    model = load_sheet(arguments)
    inputs: dict[str, Value | None] = {}
    guesses: dict[str, float] = {}
    tolerances: dict[str, Tolerance] = {}
    files = model.files
    complaints: list[Diagnosis] = []
    if arguments.variables:
        beside = "." if arguments.sheet == "-" else arguments.sheet
        try:
            filled_in = find_variable_sheet(arguments.variables, beside)
        except RuleSheetError as wrong:
            list(_options(arguments, model, complaints))  # an option without a value explains it
            raise RuleSheetError(*complaints, *wrong.diagnoses) from None
        files = (*files, filled_in)
        from rulesheets.variables import read_variable_sheet

        inputs, guesses, tolerances = read_variable_sheet(filled_in, model)
    options: dict[str, Value | None] = {}
    units: dict[str, str] = {}
    want: list[str] = []
    for option, name, text in _options(arguments, model, complaints):
        try:
            if option.name == "want":
                want.append(name)
            elif option.name == "clear":
                options[name] = inputs[name] = None
            elif option.name == "unit":
                with_display_unit(model.variables[name], text, option.place(text))
                units[name] = text
            elif option.name == "set":
                options[name], tolerance = _input(option, name, text, model)
                inputs[name] = options[name]
                tolerances |= {} if tolerance is None else {name: tolerance}
            else:
                guesses[name] = _guess(option, name, text, model, inputs)
        except RuleSheetError as wrong:
            complaints.extend(wrong.diagnoses)
    refuse(complaints)
    model = with_tolerances(model, tolerances) if tolerances else model
    model = with_display_units(model, getattr(arguments, "units", None), units)
    given = frozenset(name for name, value in options.items() if value is not None)
    return Request(model, inputs, guesses, tuple(want) or None, given, files)


def _options(
    arguments: Namespace, model: Model, complaints: list[Diagnosis]
) -> Iterator[tuple[Option, str, str]]:
    """Every name that an option gives, in the order in which options take effect, with its text.

    ``NAME,…`` has no text. Each name comes once and is a variable of the model.
    """
    seen: dict[str, set[str]] = {kind: set() for kind in ("set", "guess", "unit", "want")}
    seen["clear"] = seen["set"]
    for kind in ("set", "clear", "guess", "unit", "want"):
        for text in getattr(arguments, kind, ()):
            option = Option(kind, text)
            name, equals, value = (part.strip() for part in text.partition("="))
            pairs = [(name, value)]
            if kind in ("clear", "want"):
                pairs = [(part.strip(), "") for part in text.split(",") if part.strip()]
            elif not (name and equals):
                note = f"write --{kind} NAME=VALUE, such as --{kind} {name or 'NAME'}=3"
                complaints.append(option.wrong("E420", f"--{kind} needs a name and a value", note))
                continue
            for one, told in pairs:
                if one not in model.variables:
                    complaints.append(unknown_variable(one, model, option.place(one)))
                elif one not in seen[kind]:
                    seen[kind].add(one)
                    yield option, one, told
                elif kind != "want":
                    complaints.append(option.repeated(one))


def _input(option: Option, name: str, text: str, model: Model) -> tuple[Value, Tolerance | None]:
    """The input that an option gives. Raises RuleSheetError, also for two variables in one."""
    try:
        value, tolerance = parse_input(text, option.place(text), model.variables[name])
    except RuleSheetError:
        first, *others = option.text.split(",")
        if not others or not all("=" in other for other in others):
            raise
        apart = " ".join(f"--{option.name} {part.strip()}" for part in (first, *others))
        message = f"--{option.name} gives one value, and can be repeated"
        raise RuleSheetError(option.wrong("E420", message, f"write {apart}")) from None
    if isinstance(value, str) and option.name == "set" and name in quantities(model):
        variable, place = model.variables[name], option.place(text)
        raise RuleSheetError(symbol_for_number(value, variable, model, place))
    return value, tolerance


def _guess(
    option: Option, name: str, text: str, model: Model, inputs: Mapping[str, Value | None]
) -> float:
    value, tolerance = _input(option, name, text, model)
    if tolerance is not None:
        raise RuleSheetError(guess_with_tolerance(option.place(text)))
    if inputs.get(name, model.variables[name].value) is not None:
        message, note = f"{name} is an input: a guess for it says nothing", f"add --clear {name}"
        raise RuleSheetError(option.wrong("E423", message, f"{note} to solve for it", name))
    if isinstance(value, str):
        message = f"a guess is a number, and {text} is a symbol"
        note = f"write --set {name}={text} to give it as an input"
        raise RuleSheetError(option.wrong("E423", message, note, text))
    return value
