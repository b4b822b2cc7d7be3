"""Inputs on the command line: a sheet, a variable sheet, and what the options override."""

from __future__ import annotations

import sys
from argparse import ArgumentParser, ArgumentTypeError, Namespace
from collections.abc import Iterable, Iterator, Mapping
from typing import NamedTuple

from rulesheets.diagnosis import Diagnosis, Label, RuleSheetError, error, refuse, render
from rulesheets.input_messages import guess_with_tolerance, symbol_for_number, unknown_variable
from rulesheets.inputs import parse_input, quantities, with_tolerances
from rulesheets.loading import decoded, find_variable_sheet, load, loads
from rulesheets.model import Model, Tolerance, Value
from rulesheets.syntax import Source, Span
from rulesheets.units import with_display_unit, with_display_units


class Option(NamedTuple):
    """One option as the user wrote it: ``text`` is what stands after ``--name``."""

    name: str
    text: str

    @property
    def source(self) -> Source:
        return Source("command line", f"--{self.name} {self.text}")

    def place(self, part: str) -> Span:
        """The place of a part of the text, the last where there are several."""
        start = len(self.name) + 3 + max(self.text.rfind(part), 0)
        return Span(self.source, start, start + max(len(part), 1))

    def wrong(self, code: str, message: str, note: str, part: str = "") -> Diagnosis:
        """What is wrong with the option, or with a part of its text."""
        return error(code, message, Label(self.place(part or self.text)), notes=(note,))

    def repeated(self, name: str) -> Diagnosis:
        start = len(self.name) + 3 + self.text.find(name)
        return error(
            "E421",
            f"{name} is given twice",
            Label(Span(self.source, start, start + len(name)), "again"),
            notes=("keep one of the options",),
        )


class Request(NamedTuple):
    """What a solve is asked: a model, inputs (None clears one), guesses, and the names wanted (None: all).

    ``options`` are the names of the inputs that options give, not a variable sheet; ``files`` are all that
    was read.
    """

    model: Model
    inputs: Mapping[str, Value | None]
    guesses: Mapping[str, float]
    want: tuple[str, ...] | None
    options: frozenset[str] = frozenset()
    files: tuple[str, ...] = ()

    def swept(self, names: Iterable[str]) -> None:
        """Raise RuleSheetError (E421) if ``--over`` sweeps what ``--set`` gives; it overrides all else."""
        twice = [name for name in names if name in self.options]
        if twice:
            raise RuleSheetError(*(Option("over", name).repeated(name) for name in twice))

    def expect_output(self, path: str | None) -> None:
        """Raise RuleSheetError (E418) if a file to write is one that was read."""
        if path is not None:
            from solver.files import expect_no_input  # most commands write none

            expect_no_input(path, self.files)


def add_sheet_options(parser: ArgumentParser) -> None:
    """The arguments of every command that loads a sheet."""
    parser.add_argument(
        "sheet", metavar="SHEET", help="a rule sheet, a shipped one by its name, or - for stdin"
    )
    parser.add_argument(
        "--allow-python", action="store_true", help="run the Python files that the sheet names (use python)"
    )
    parser.add_argument("--within", metavar="FOLDER", help="read sheets of this folder alone, links resolved")


def load_sheet(arguments: Namespace) -> Model:
    """The model of the sheet, of standard input for ``-``. Raises RuleSheetError for all that is wrong."""
    if arguments.sheet != "-":
        model = load(arguments.sheet, within=arguments.within, allow_python=arguments.allow_python)
    else:
        text = decoded("standard input", sys.stdin.buffer.read())
        allowed, within = arguments.allow_python, arguments.within
        model = loads(text, "standard input", base="", within=within, allow_python=allowed)
    for note in model.notes:
        print(render(note), file=sys.stderr)
    return model


def add_input_options(parser: ArgumentParser, *, want: bool = True) -> None:
    """The arguments that every command on a filled-in sheet takes, ``--want`` where it is asked for."""
    add_sheet_options(parser)
    parser.add_argument("variables", metavar="VARIABLES.csv", nargs="?", help="a variable sheet to fill in")
    add = parser.add_argument
    add("--set", metavar="NAME=VALUE[unit]", action="append", default=[], help="give an input")
    add("--clear", metavar="NAME", action="append", default=[], help="take an input back: solve for it")
    add("--timeout", metavar="SECONDS", type=_seconds, help="stop then, with what is known so far")
    add("--guess", metavar="NAME=VALUE", action="append", default=[], help="a first guess")
    if want:
        add("--want", metavar="NAME,…", action="append", default=[], help="solve for these alone")


def add_display_options(parser: ArgumentParser) -> None:
    """Units to show values in."""
    add = parser.add_argument
    add("--unit", metavar="NAME=UNIT", action="append", default=[], help="show a variable in this unit")
    add("--units", choices=("si", "us"), help="show every variable in units of this system")


def _seconds(text: str) -> float:
    try:
        seconds = float(text)
    except ValueError:
        seconds = 0.0
    if not seconds > 0.0:
        raise ArgumentTypeError(f"{text} is no number of seconds")
    return seconds


def read_request(arguments: Namespace) -> Request:
    """Load the sheets and apply the options.

    Raises RuleSheetError with everything that is wrong, names that the model does not have included.
    """
    model = load_sheet(arguments)
    inputs: dict[str, Value | None] = {}
    guesses: dict[str, float] = {}
    tolerances: dict[str, Tolerance] = {}
    files = model.files
    if arguments.variables:
        from rulesheets.variables import read_variable_sheet  # most commands read none

        beside = "." if arguments.sheet == "-" else arguments.sheet
        filled_in = find_variable_sheet(arguments.variables, beside)
        files = (*files, filled_in)
        written = read_variable_sheet(filled_in, model)
        inputs, guesses, tolerances = dict(written.inputs), dict(written.guesses), dict(written.tolerances)
    reading = _Reading(model)
    options = reading.inputs(arguments.set, arguments.clear)
    inputs.update(options)
    tolerances.update(reading.tolerances)
    if tolerances:
        model = with_tolerances(model, tolerances)
    guesses.update(reading.guesses(arguments.guess, inputs))
    shown = reading.units(getattr(arguments, "unit", ()))
    want = reading.names("want", getattr(arguments, "want", ()))
    refuse(reading.complaints)
    model = with_display_units(model, getattr(arguments, "units", None), shown)
    given = frozenset(name for name, value in options.items() if value is not None)
    return Request(model, inputs, guesses, want or None, given, files)


class _Reading:
    """Reads options against a model and keeps every complaint."""

    def __init__(self, model: Model) -> None:
        self.model = model
        self.complaints: list[Diagnosis] = []
        self.tolerances: dict[str, Tolerance] = {}

    def inputs(self, given: Iterable[str], cleared: Iterable[str]) -> dict[str, Value | None]:
        values: dict[str, Value | None] = {}
        for option, name, text in self._assignments("set", given):
            value = self._value(option, name, text)
            self._once(option, name, values)
            if isinstance(value, str) and name in quantities(self.model):
                variable, place = self.model.variables[name], option.place(text)
                self.complaints.append(symbol_for_number(value, variable, self.model, place))
            values[name] = value
        for option, name in self._names("clear", cleared):
            self._once(option, name, values)
            values[name] = None
        return values

    def guesses(self, given: Iterable[str], inputs: Mapping[str, Value | None]) -> dict[str, float]:
        found: dict[str, float] = {}
        for option, name, text in self._assignments("guess", given):
            value = self._value(option, name, text)
            self._once(option, name, found)
            if inputs.get(name, self.model.variables[name].value) is not None:
                said, note = (
                    f"{name} is an input: a guess for it says nothing",
                    f"add --clear {name} to solve for it",
                )
                self.complaints.append(option.wrong("E423", said, note, name))
            elif isinstance(value, str):
                said, note = (
                    f"a guess is a number, and {text} is a symbol",
                    f"write --set {name}={text} to give it as an input",
                )
                self.complaints.append(option.wrong("E423", said, note, text))
            elif value is not None:
                found[name] = value
        return found

    def units(self, given: Iterable[str]) -> dict[str, str]:
        """The units to show variables in."""
        found: dict[str, str] = {}
        for option, name, unit in self._assignments("unit", given):
            self._once(option, name, found)
            try:
                with_display_unit(self.model.variables[name], unit, option.place(unit))
                found[name] = unit
            except RuleSheetError as wrong:
                self.complaints.extend(wrong.diagnoses)
        return found

    def names(self, option: str, texts: Iterable[str]) -> tuple[str, ...]:
        return tuple(dict.fromkeys(name for _, name in self._names(option, texts)))

    def _names(self, option: str, texts: Iterable[str]) -> Iterator[tuple[Option, str]]:
        """The known names of comma-separated lists."""
        for text in texts:
            for name in filter(None, map(str.strip, text.split(","))):
                if self._known(Option(option, text), name):
                    yield Option(option, text), name

    def _assignments(self, option: str, texts: Iterable[str]) -> Iterator[tuple[Option, str, str]]:
        for text in texts:
            name, equals, value = (part.strip() for part in text.partition("="))
            given = Option(option, text)
            if not equals or not name:
                note = f"write --{option} NAME=VALUE, such as --{option} NAME=3"
                self.complaints.append(given.wrong("E420", f"--{option} needs a name and a value", note))
            elif self._known(given, name):
                yield given, name, value

    def _known(self, option: Option, name: str) -> bool:
        if name in self.model.variables:
            return True
        self.complaints.append(unknown_variable(name, self.model, option.place(name)))
        return False

    def _value(self, option: Option, name: str, text: str) -> Value | None:
        try:
            value, tolerance = parse_input(text, option.place(text), self.model.variables[name])
        except RuleSheetError as wrong:
            self.complaints.extend(wrong.diagnoses)
            return None
        if tolerance is not None and option.name == "guess":
            self.complaints.append(guess_with_tolerance(option.place(text)))
        elif tolerance is not None:
            self.tolerances[name] = tolerance
        return value

    def _once(self, option: Option, name: str, before: Iterable[str]) -> None:
        if name in before:
            self.complaints.append(option.repeated(name))
