"""``use``: the functions of a sheet and of every file that it leads to."""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import dataclass, field, replace

from rulesheets.checks import messages
from rulesheets.diagnosis import Diagnosis, RuleSheetError, error, labels
from rulesheets.functions.registered import run_python
from rulesheets.parse import parse
from rulesheets.reading import ENDING, confined, is_sheet, near_files, read_source
from rulesheets.syntax.nodes import Function, RuleSheet, UnitRow, Use
from rulesheets.syntax.program import Program, rules_of
from rulesheets.syntax.source import Source, Span


@dataclass(frozen=True)
class File:
    """A parsed file: ``key`` tells it from others, ``folder`` is what its ``use`` paths are relative to."""

    key: str
    shown: str
    folder: str
    sheet: RuleSheet


def gather(
    source: Source, folder: str, path: str | None = None, within: str | None = None, python: bool = False
) -> Program:
    """Parse a sheet and, each once, the files that it uses directly or through others.

    ``path`` is the file of the sheet itself, None for a text that is in no file; ``within`` the folder
    that used files must lie in; ``python``: files of Python may be run. Raises RuleSheetError for what
    cannot be read or parsed, circles and doubly defined functions.
    """
    key = os.path.realpath(path) if path else source.name
    first = File(key, source.name, folder, parsed(source, path))
    gathering = _Gathering(within, python)
    gathering.follow(first)
    if gathering.complaints:
        raise RuleSheetError(*gathering.complaints)
    return Program(
        first.sheet, gathering.functions, tuple(gathering.texts), tuple(gathering.units), tuple(gathering.ran)
    )


@dataclass
class _Gathering:
    within: str | None
    python: bool
    functions: dict[str, Function] = field(default_factory=dict)
    complaints: list[Diagnosis] = field(default_factory=list)
    texts: list[Source] = field(default_factory=list)
    units: list[UnitRow] = field(default_factory=list)
    seen: set[str] = field(default_factory=set)
    ran: list[str] = field(default_factory=list)

    def follow(self, first: File) -> None:
        """Depth-first over the uses, with a stack, so that no chain of files is too long."""
        trail = [first]
        pending = [self.enter(first)]
        while trail:
            step = next(pending[-1], None)
            if step is None:
                trail.pop()
                pending.pop()
                continue
            file = self.open(*step, trail)
            if file is not None:
                trail.append(file)
                pending.append(self.enter(file))

    def enter(self, file: File) -> Iterator[tuple[str, Span | None]]:
        self.seen.add(file.key)
        self.units += (row for row in file.sheet.units if isinstance(row, UnitRow))
        for function in file.sheet.functions:
            earlier = self.functions.setdefault(function.name.lower(), function)
            if earlier is not function:
                self.complaints.append(messages.duplicate_function(function, earlier))
        for use in file.sheet.uses:
            if use.python:
                for path in use.paths:
                    self.run(path, place_of(path, use), file)
        uses = (use for use in file.sheet.uses if not use.python)
        return ((path, place_of(path, use)) for use in uses for path in use.paths)

    def run(self, path: str, place: Span | None, file: File) -> None:
        """Run a file of Python that registers functions, if that is allowed."""
        shown = os.path.normpath(os.path.join(file.folder, path))
        if not self.python:
            self.complaints.append(_not_allowed(path, place))
        elif not confined(shown, self.within):
            self.complaints.append(outside(path, place))
        elif not os.path.exists(shown):
            self.complaints.append(_missing(path, shown, place))
        elif shown not in self.ran:
            self.ran.append(shown)
            try:
                run_python(shown)
            except RuleSheetError as wrong:
                used = labels((place, "used here"))
                self.complaints.extend(replace(one, labels=used) for one in wrong.diagnoses)

    def open(self, path: str, place: Span | None, trail: list[File]) -> File | None:
        """The file that a ``use`` names; None where it was read before or cannot be used."""
        shown = os.path.normpath(os.path.join(trail[-1].folder, path))
        key = os.path.realpath(shown)
        if not confined(shown, self.within):
            self.complaints.append(outside(path, place))
            return None
        circle = [file.key for file in trail]
        if key in circle:
            shown_trail = [file.shown for file in trail[circle.index(key) :]]
            self.complaints.append(_circle(shown_trail, place))
            return None
        if key in self.seen:
            return None
        if not os.path.exists(shown):
            self.complaints.append(_missing(path, shown, place))
            return None
        source = _read(shown, place)
        self.texts.append(source)
        file = File(key, shown, os.path.dirname(shown), parsed(source, shown))
        self.complaints.extend(_only_functions(file, path, place))
        return file


def _read(path: str, place: Span | None) -> Source:
    """The text of a used file; what keeps it from being read is told with the place of the ``use``."""
    try:
        return read_source(path)
    except RuleSheetError as wrong:
        used = labels((place, "used here"))
        raise RuleSheetError(
            *(replace(one, labels=(*one.labels, *used)) for one in wrong.diagnoses)
        ) from None


def parsed(source: Source, path: str | None) -> RuleSheet:
    """The rule sheet that a text says; ``path`` is its file.

    Raises RuleSheetError with what is wrong line by line, or (E312) for a file that is no rule sheet.
    """
    try:
        return parse(source)
    except RuleSheetError:
        if path is None or is_sheet(path):
            raise
        raise RuleSheetError(_no_sheet(source.name)) from None


def _no_sheet(name: str) -> Diagnosis:
    note = f"a sheet that ends in {ENDING} is shown where it is wrong"
    return error("E312", f"{name} is no rule sheet", notes=(note,))


def outside(path: str, place: Span | None = None) -> Diagnosis:
    return error(
        "E311",
        f"{path} lies outside the folder that sheets are confined to",
        *labels((place, "")),
        notes=("links count as the files that they lead to",),
    )


def place_of(path: str, use: Use) -> Span | None:
    """Where a ``use`` names the path, quotes included."""
    if use.span is None:
        return None
    start = use.span.text.find(f'"{path}"')
    if start < 0:
        return use.span
    start += use.span.start
    return Span(use.span.source, start, start + len(path) + 2)


def _missing(path: str, shown: str, place: Span | None) -> Diagnosis:
    notes = near_files(shown) or ("paths are relative to the file that names them",)
    return error(
        "E306",
        f"there is no file {path} to use",
        *labels((place, f"looked for {shown}")),
        notes=notes,
    )


def _not_allowed(path: str, place: Span | None) -> Diagnosis:
    return error(
        "E313",
        f"the sheet needs the Python file {path}, which is not allowed to run",
        *labels((place, "named here")),
        notes=(
            "a Python file can do anything that you can: read it, and if you trust it, give --allow-python "
            "(allow_python=True in Python)",
        ),
    )


def _circle(shown: list[str], place: Span | None) -> Diagnosis:
    ring = " → ".join(os.path.basename(name) for name in (*shown, shown[0]))
    message = "a file uses itself" if len(shown) == 1 else "files use each other in a circle"
    return error(
        "E307",
        message,
        *labels((place, "closes the circle")),
        notes=(f"the way round: {ring}; move what both need into a file of its own",),
    )


def _only_functions(file: File, path: str, place: Span | None) -> Iterator[Diagnosis]:
    rule = next(rules_of(file.sheet), None)
    figure = next(iter(file.sheet.figures), None)
    if rule is not None:
        found, where, label = "rules", rule.span, "a rule outside any function"
    elif figure is not None:
        found, where, label = "figures", figure.span, "a figure"
    elif file.sheet.variables is not None:
        found, where, label = "a variables section", None, ""
    else:
        return
    yield error(
        "E308",
        f"{path} cannot be used: it has {found} of its own",
        *labels((place, "used here"), (where if is_sheet(file.key) else None, label)),
        notes=("a used file may hold functions and units only; move them into a file of their own",),
    )
