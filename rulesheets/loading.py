"""From a file or a text, with the files that it uses, to a model."""

from __future__ import annotations

import gc
import os
from collections.abc import Iterator
from typing import NamedTuple

from rulesheets.build import build
from rulesheets.checks import head_of
from rulesheets.diagnosis import Diagnosis, RuleSheetError, error, labels, refuse, said, suggestion
from rulesheets.input_messages import expect_regular
from rulesheets.model import Model
from rulesheets.parse import parse, parse_file
from rulesheets.registered import run_python
from rulesheets.syntax import Source, Span, escaped
from rulesheets.syntax.nodes import Function, RuleSheet, UnitRow, Use
from rulesheets.syntax.program import Program, rules_of

ENDING = ".tk"
"""What the name of a rule sheet ends in."""

_LARGEST = 64 * 2**20
"""Bytes beyond which a file is not taken for a rule sheet."""


def read_source(path: str | os.PathLike[str]) -> Source:
    """The text of a UTF-8 file (a byte order mark is dropped), line ends as ``\\n``.

    Raises RuleSheetError for a file that is missing, a folder, unreadable, too large, or no text.
    """
    name = os.fspath(path)
    expect_regular(name)
    try:
        with open(name, "rb") as file:
            data = file.read(_LARGEST + 1)
    except FileNotFoundError:
        raise RuleSheetError(error("E301", f"there is no file {name}", notes=near_files(name))) from None
    except IsADirectoryError:
        notes = ("name a file in it; a folder is a sheet where it holds a model.tk",)
        raise RuleSheetError(error("E302", f"{name} is a folder, not a file", notes=notes)) from None
    except (OSError, ValueError) as failure:
        reason = getattr(failure, "strerror", None) or str(failure)
        raise RuleSheetError(error("E304", f"{name} cannot be read: {reason}")) from None
    return Source(name, decoded(name, data))


def is_sheet(path: str) -> bool:
    """Whether a file has the name of a rule sheet, links resolved: of no other is a line ever shown."""
    return os.path.realpath(path).lower().endswith(ENDING)


def confined(path: str, within: str | None) -> bool:
    """Whether a file lies in the folder ``within``, links resolved. None is the whole file system."""
    if within is None:
        return True
    folder = os.path.realpath(within)
    return os.path.realpath(path).startswith(os.path.join(folder, ""))


def near_files(path: str) -> tuple[str, ...]:
    """The note on a file that is not there: its folder is not either, or holds one that is spelt alike."""
    folder, name = os.path.split(path)
    if not os.path.isdir(folder or "."):
        return (f"there is no folder {folder} either",)
    ending = os.path.splitext(name)[1]
    return suggestion(name, sorted(other for other in os.listdir(folder or ".") if other.endswith(ending)))


def decoded(name: str, data: bytes) -> str:
    """The text of the bytes of a sheet. Raises RuleSheetError (E303, E305)."""
    if len(data) > _LARGEST:
        raise RuleSheetError(error("E305", f"{name} is too large for a rule sheet"))
    nul = data.find(b"\0")
    if nul >= 0:
        raise RuleSheetError(_not_text(name, data, nul))
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as wrong:
        raise RuleSheetError(_not_text(name, data, wrong.start)) from None
    return text.replace("\r\n", "\n").replace("\r", "\n")


def _not_text(name: str, data: bytes, place: int) -> Diagnosis:
    """Says what the file seems to be, and where the first byte stands that is no text."""
    readable = data[:place].decode("utf-8", "replace")
    source = Source(name, readable.replace("\r\n", "\n"))
    here = Span(source, len(source.text), len(source.text) + 1)
    if b"\0" in data:
        note = "a rule sheet is a UTF-8 text file"
        return said("E303", f"{name} is a binary file, not a rule sheet", None, note)
    label = f"byte 0x{data[place]:02x} is no character"
    note = "save the sheet in the encoding UTF-8"
    return said("E303", f"{name} is not UTF-8 text", here if is_sheet(name) else None, note, label=label)


class File(NamedTuple):
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
    found = _Gathering(first, within, python)
    refuse(found.complaints)
    return Program(first.sheet, found.functions, tuple(found.texts), tuple(found.units), tuple(found.ran))


class _Gathering:
    """Depth-first over the uses, with a stack, so that no chain of files is too long."""

    def __init__(self, first: File, within: str | None, python: bool) -> None:
        self.within, self.python = within, python
        self.functions: dict[str, Function] = {}
        self.complaints: list[Diagnosis] = []
        self.texts: list[Source] = []
        self.units: list[UnitRow] = []
        self.seen: set[str] = set()
        self.ran: list[str] = []
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
                message = f"the function {function.name} is defined twice"
                places = (head_of(function), "defined again"), (head_of(earlier), "first defined here")
                note = "give one of the two another name (capitals do not count in function names)"
                self.complaints.append(error("E206", message, *labels(*places), notes=(note,)))
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
            message = f"the sheet needs the Python file {path}, which is not allowed to run"
            note = (
                "a Python file can do anything that you can: read it, and if you trust it, give "
                "--allow-python (allow_python=True in Python)"
            )
            self.complaints.append(said("E313", message, place, note, label="named here"))
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
                self.complaints.extend(one._replace(labels=used) for one in wrong.diagnoses)

    def open(self, path: str, place: Span | None, trail: list[File]) -> File | None:
        """The file that a ``use`` names; None where it was read before or cannot be used."""
        shown = os.path.normpath(os.path.join(trail[-1].folder, path))
        key = os.path.realpath(shown)
        if not confined(shown, self.within):
            self.complaints.append(outside(path, place))
            return None
        circle = [file.key for file in trail]
        if key in circle:
            names = [os.path.basename(file.shown) for file in trail[circle.index(key) :]]
            message = "a file uses itself" if len(names) == 1 else "files use each other in a circle"
            ring = " → ".join((*names, names[0]))
            note = f"the way round: {ring}; move what both need into a file of its own"
            self.complaints.append(said("E307", message, place, note, label="closes the circle"))
            return None
        if key in self.seen:
            return None
        if not os.path.exists(shown):
            self.complaints.append(_missing(path, shown, place))
            return None
        try:
            source = read_source(shown)
        except RuleSheetError as wrong:
            used = labels((place, "used here"))
            told = (one._replace(labels=(*one.labels, *used)) for one in wrong.diagnoses)
            raise RuleSheetError(*told) from None
        self.texts.append(source)
        file = File(key, shown, os.path.dirname(shown), parsed(source, shown))
        self.complaints.extend(_only_functions(file, path, place))
        return file


def parsed(source: Source, path: str | None) -> RuleSheet:
    """The rule sheet that a text says; ``path`` is its file.

    Raises RuleSheetError with what is wrong line by line, or (E312) for a file that is no rule sheet.
    """
    try:
        return parse(source) if path is None else parse_file(source)
    except RuleSheetError:
        if path is None or is_sheet(path):
            raise
        note = f"a sheet that ends in {ENDING} is shown where it is wrong"
        raise RuleSheetError(said("E312", f"{source.name} is no rule sheet", None, note)) from None


def outside(path: str, place: Span | None = None) -> Diagnosis:
    message = f"{path} lies outside the folder that sheets are confined to"
    return said("E311", message, place, "links count as the files that they lead to")


def place_of(path: str, use: Use) -> Span | None:
    """Where a ``use`` names the path, quotes included."""
    start = use.span.text.find(f'"{path}"') if use.span is not None else -1
    return use.span if use.span is None or start < 0 else use.span.part(start, len(path) + 2)


def _missing(path: str, shown: str, place: Span | None) -> Diagnosis:
    notes = near_files(shown) or ("paths are relative to the file that names them",)
    return said("E306", f"there is no file {path} to use", place, *notes, label=f"looked for {shown}")


def _only_functions(file: File, path: str, place: Span | None) -> Iterator[Diagnosis]:
    if (rule := next(rules_of(file.sheet), None)) is not None:
        found, where, label = "rules", rule.span, "a rule outside any function"
    elif file.sheet.figures:
        found, where, label = "figures", file.sheet.figures[0].span, "a figure"
    elif file.sheet.variables is not None:
        found, where, label = "a variables section", None, ""
    else:
        return
    places = labels((place, "used here"), (where if is_sheet(file.key) else None, label))
    note = "a used file may hold functions and units only; move them into a file of their own"
    yield error("E308", f"{path} cannot be used: it has {found} of its own", *places, notes=(note,))


MAIN_SHEET = "model.tk"


def load(
    path: str | os.PathLike[str],
    *,
    within: str | os.PathLike[str] | None = None,
    allow_python: bool = False,
) -> Model:
    """The model of a rule sheet file.

    ``path`` is a file, a folder that holds ``model.tk``, or the bare name of a shipped model
    (``offset_slider_crank``). For sheets of strangers ``within`` names a folder: the sheet and every file
    that it uses must lie in it, links resolved. ``allow_python`` lets the files run that the sheet names by
    ``use python``. Raises RuleSheetError where anything in it is wrong.
    """
    file = find_sheet(os.fsdecode(path))
    folder = None if within is None else os.fsdecode(within)
    if not confined(file, folder):
        raise RuleSheetError(outside(file))
    parent, base = os.path.split(os.path.abspath(file))
    name = escaped(os.path.basename(parent) if base == MAIN_SHEET else os.path.splitext(base)[0])
    return _model(read_source(file), os.path.dirname(file), file, name, folder, allow_python)


def loads(
    text: str,
    name: str = "<text>",
    base: str | os.PathLike[str] | None = None,
    *,
    within: str | os.PathLike[str] | None = None,
    allow_python: bool = False,
) -> Model:
    """The model of a text. Messages call it ``name``; ``use`` paths are relative to the folder ``base``.

    ``within`` confines used files to a folder, links resolved; ``allow_python`` lets files of Python run.
    Raises RuleSheetError where anything in it is wrong, TypeError for what is no text.
    """
    if not isinstance(text, str):
        raise TypeError(f"a text is needed, and this is of the type {type(text).__name__}")
    folder = os.fspath(base) if base is not None else ""
    confines = None if within is None else os.fsdecode(within)
    return _model(Source(name, text), folder, None, name, confines, allow_python)


def _model(
    source: Source, folder: str, file: str | None, name: str, within: str | None, python: bool
) -> Model:
    """The model, made while the garbage collector rests.

    A large sheet has a million nodes, which all stay: to look for garbage among them takes longer
    than to make them.
    """
    collecting = gc.isenabled()
    gc.disable()
    try:
        program = gather(source, folder, file, within, python)
        paths = (*filter(None, [file]), *(used.name for used in program.texts))
        return build(program, name, tuple(map(os.path.abspath, paths)))
    finally:
        if collecting:
            gc.enable()


def find_sheet(path: str) -> str:
    """The file that a path or the bare name of a shipped model stands for.

    Raises RuleSheetError (E309) for a bare name that is neither.
    """
    if os.path.isfile(path):
        return path
    if os.path.isfile(os.path.join(path, MAIN_SHEET)):
        return os.path.join(path, MAIN_SHEET)
    bare = path.rstrip("/")
    if bare in shipped_models():
        return shipped_model(bare)
    if os.path.exists(path) or os.path.dirname(bare) or bare.endswith(".tk"):
        return path
    here = sorted(name for name in os.listdir() if name.endswith(".tk"))
    notes = suggestion(bare, (*shipped_models(), *here)) or (
        "a sheet is named by its path, such as crank.tk; `backsolve models` lists the shipped ones",
    )
    raise RuleSheetError(error("E309", f"there is no rule sheet and no shipped model {bare}", notes=notes))


def find_variable_sheet(path: str, sheet: str) -> str:
    """The file of a variable sheet: the path itself, or a file of that name beside the rule sheet.

    ``sheet`` is what :func:`find_sheet` takes. Raises RuleSheetError (E310) where neither is there.
    """
    folder = os.path.dirname(find_sheet(sheet))
    beside = os.path.join(folder, path)
    found = next((file for file in (path, beside) if os.path.exists(file)), None)
    if found is not None:
        return found
    there = sorted(name for name in os.listdir(folder or ".") if name.endswith(".csv"))
    notes = suggestion(path, there) or ((f"beside {sheet} there are {', '.join(there)}",) if there else ())
    message = f"there is no variable sheet {path}, neither here nor beside {sheet}"
    raise RuleSheetError(error("E310", message, notes=notes))


def shipped_models() -> tuple[str, ...]:
    """The names of the models that come with the package."""
    folder = _models_folder()
    there = sorted(os.listdir(folder)) if os.path.isdir(folder) else ()
    return tuple(name for name in there if os.path.isfile(shipped_model(name)))


def shipped_model(name: str) -> str:
    """The file of a shipped model."""
    return os.path.join(_models_folder(), name, MAIN_SHEET)


def _models_folder() -> str:
    """``rulesheets/models`` where installed, ``models`` beside the package in a checkout."""
    package = os.path.dirname(os.path.abspath(__file__))
    installed = os.path.join(package, "models")
    return installed if os.path.isdir(installed) else os.path.join(os.path.dirname(package), "models")
