"""A text → RuleSheet: each line goes to the section that it stands in."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from typing import Any

from rulesheets.diagnosis import Diagnosis, Label, RuleSheetError, error
from rulesheets.parse import foreign, mistakes
from rulesheets.parse.builder import Head
from rulesheets.parse.grammar import read_line
from rulesheets.parse.layout import Line, logical_lines
from rulesheets.syntax import nodes
from rulesheets.syntax.nodes import UnitRow
from rulesheets.syntax.source import Source, Span

_HEAD = re.compile(
    r"""\s*(?:
        (?P<section>variables|rules|(?<![^\S\n])units)\s*\Z
      | (?P<use>use)\b\s*(?:["\w]|\Z)
      | (?P<parameters>parameters)\b\s*(?:[\w:]|\Z)
      | (?P<function>function)\b\s*(?:[\w(:]|\Z)
      | (?P<figure>figure)\b\s*(?:\s(?!in\s*\[)\w|\Z)
      | (?P<planned>list(?=\s+function\b)|procedure(?=\s+\w|\s*\Z))
    )""",
    re.IGNORECASE | re.VERBOSE,
)
_LONE = re.compile(r"\s*([^\W\d]\w*)\s*(:?)\s*\Z")
_ALMOST = frozenset({"rule", "variable", "equation", "equations", "formula", "formulas"})
"""Lone words that are taken for a misspelt head even where names stand alone."""


def head_word(code: str) -> str | None:
    """The word that makes a line the head of a section, in lower case; None for any other line."""
    found = _HEAD.match(code)
    return str(found[found.lastgroup or 0]).lower() if found else None


def misspelt_head(code: str, section: str) -> str | None:
    """A lone word, perhaps with a colon, that means nothing but a head that it is not."""
    lone = _LONE.match(code)
    if lone and (section != "variables" or lone[2] or lone[1].lower() in _ALMOST):
        return lone[1]
    return None


def nearest_section(word: str, section: str) -> str:
    """The section that most likely begins at a misspelt head, for reading on."""
    if word.lower() in ("variable", "variables"):
        return "variables"
    return "rules" if word.lower() in _ALMOST | {"rules"} and section != "function" else section


@dataclass
class FigureDraft:
    """What is known of a figure so far; ``end`` is where it ends."""

    name: str
    unit: str | None
    start: int
    end: int
    comment: str
    above: tuple[nodes.CommentLine, ...]
    marks: list[nodes.Mark | nodes.CommentLine] = field(default_factory=list)

    def node(self, source: Source) -> nodes.Figure:
        span = Span(source, self.start, self.end)
        return nodes.Figure(self.name, self.unit, tuple(self.marks), self.comment, span, self.above)


@dataclass
class FunctionDraft:
    """What is known of a function so far; ``begun`` once its rules have begun, ``end`` where it ends."""

    head: Head
    start: int
    end: int
    comment: str
    above: tuple[nodes.CommentLine, ...]
    parameters: list[str] = field(default_factory=list)
    remarks: list[str] = field(default_factory=list)
    rules: list[nodes.Rule | nodes.CommentLine] = field(default_factory=list)
    begun: bool = False

    def node(self, source: Source) -> nodes.Function:
        return nodes.Function(
            self.head.name,
            self.head.arguments,
            self.head.results,
            tuple(self.parameters),
            tuple(self.rules),
            self.comment,
            Span(source, self.start, self.end),
            self.above,
            "; ".join(self.remarks),
        )


_NAME = re.compile(r"(?:[^\W\d_]|[°%‰$€£¥℃℉])(?:[\w°%]*[^\W\d])?")


def unit_row(code: str, span: Span) -> UnitRow:
    """The row of a line. Raises RuleSheetError (E128) for one that defines no unit."""
    left, equals, right = code.partition("=")
    names = tuple(map(str.strip, left.split(",")))
    if not all(map(_NAME.fullmatch, names)) or bool(equals) is not bool(right.strip()):
        notes = ("write smoot = 1.7018 m, or widget alone for a unit of a kind of its own",)
        raise RuleSheetError(error("E128", "this line defines no unit", Label(span), notes=notes))
    return UnitRow(names, " ".join(right.split()), span=span)


_ENOUGH = 50
"""Complaints after which the rest of a sheet is not read."""

_PYTHON = re.compile(r"(\s*use\s+)(python\b)", re.IGNORECASE)
_SKIPPED = "skipped"
"""The section whose lines are not read, because its head says what is not there yet."""


def parse(source: Source) -> nodes.RuleSheet:
    """The rule sheet that a text says. Raises RuleSheetError with what is wrong, line by line."""
    reading = _Reading(source)
    for line in logical_lines(source.text):
        reading.take(line)
        if len(reading.complaints) >= _ENOUGH:
            break
    return reading.sheet()


@dataclass
class _Reading:
    """The sheet so far, and the section that the next line belongs to."""

    source: Source
    uses: list[nodes.Use] = field(default_factory=list)
    units: list[nodes.UnitRow | nodes.CommentLine] = field(default_factory=list)
    rows: list[nodes.VariableRow | nodes.CommentLine] | None = None
    rules: list[nodes.Rule | nodes.CommentLine] = field(default_factory=list)
    functions: list[FunctionDraft] = field(default_factory=list)
    figures: list[FigureDraft] = field(default_factory=list)
    comments: list[nodes.CommentLine] = field(default_factory=list)
    waiting: list[nodes.CommentLine] = field(default_factory=list)
    complaints: list[Diagnosis] = field(default_factory=list)
    section: str = ""

    def take(self, line: Line) -> None:
        """Take in the next line; what is wrong with it joins the complaints."""
        try:
            if line.blank:
                self.waiting.append(nodes.CommentLine(line.comment or "", self._span(line), line.gap))
            elif wrong := foreign.wrong_shape(self.source, line):
                self.complaints.append(wrong)
            elif word := head_word(line.code):
                self._begin(word, line)
            else:
                self._add(line)
        except RuleSheetError as error:
            self.complaints.extend(error.diagnoses)

    def _span(self, line: Line) -> Span:
        start = line.start + len(line.code) - len(line.code.lstrip())
        return Span(self.source, min(start, line.end), line.end)

    # --- what stands in a section ---

    def _add(self, line: Line) -> None:
        if self.section == _SKIPPED:
            return
        word = misspelt_head(line.code, "variables" if self.section == "units" else self.section)
        if word is not None:
            self.section = nearest_section(word, self.section)
            raise RuleSheetError(foreign.unknown_section(word, self._span(line)))
        if self.section == "variables":
            self._add_row(line)
        elif self.section == "units":
            self.units.extend(self._settled())
            row = unit_row(line.code, self._span(line))
            self.units.append(replace(row, comment=line.comment or "", gap=line.gap))
        elif self.section == "figure":
            self._add_mark(line)
        else:
            self._add_rule(line)

    def _add_row(self, line: Line) -> None:
        rows = self._rows()
        rows.extend(self._settled())
        row: nodes.VariableRow = read_line(self.source, line, "row")
        rows.append(replace(row, comment=line.comment or "", gap=line.gap))

    def _add_rule(self, line: Line) -> None:
        self._place_comments()
        body = read_line(self.source, line, "rule")
        rule = nodes.Rule(body, line.comment or "", self._span(line), line.gap)
        self._current_rules().append(rule)
        if self.section == "function":
            self.functions[-1].end = line.end
            self.functions[-1].begun = True

    def _add_mark(self, line: Line) -> None:
        self._place_comments()
        mark: nodes.Mark = read_line(self.source, line, "mark")
        figure = self.figures[-1]
        figure.marks.append(replace(mark, comment=line.comment or "", gap=line.gap))
        figure.end = line.end

    def _rows(self) -> list[nodes.VariableRow | nodes.CommentLine]:
        if self.rows is None:
            self.rows = []
        return self.rows

    def _current_rules(self) -> list[nodes.Rule | nodes.CommentLine]:
        return self.functions[-1].rules if self.section == "function" else self.rules

    # --- comment lines ---

    def _settled(self) -> list[nodes.CommentLine]:
        waiting, self.waiting = self.waiting, []
        return waiting

    def _place_comments(self) -> None:
        """Put comment lines that wait where they stand: into the section at hand."""
        if not self._begun():
            self.comments.extend(self._settled())
        elif self.section == "variables":
            self._rows().extend(self._settled())
        elif self.section == "units":
            self.units.extend(self._settled())
        elif self.section == "figure":
            self.figures[-1].marks.extend(self._settled())
        else:
            self._current_rules().extend(self._settled())

    def _above(self, line: Line) -> tuple[nodes.CommentLine, ...]:
        """Take out the waiting comment lines that stand right above a section head."""
        count = 0
        if not line.gap:
            gaps = [index for index, comment in enumerate(self.waiting) if comment.gap]
            count = len(self.waiting) - (gaps[-1] if gaps else 0)
        cut = len(self.waiting) - count
        above = tuple(self.waiting[cut:])
        del self.waiting[cut:]
        return above

    def _begun(self) -> bool:
        """Whether anything but comments has come yet."""
        return bool(self.section or self.rules or self.uses)

    # --- section heads ---

    def _begin(self, word: str, line: Line) -> None:
        match word:
            case "parameters":
                self._parameters(line)
            case "list" | "procedure":
                self._place_comments()
                self.section = _SKIPPED
                raise RuleSheetError(foreign.not_there_yet(word, self._span(line)))
            case "rules" if self.section == "function" and not self.functions[-1].begun:
                self._place_comments()
                self.functions[-1].begun = True
                self._remark(line)
            case _:
                above = self._above(line)
                self._place_comments()
                self._open(word, line, above)

    def _open(self, word: str, line: Line, above: tuple[nodes.CommentLine, ...]) -> None:
        if word == "function":
            self._function(line, above)
        elif word == "figure":
            self._figure(line, above)
        elif word == "use":
            self.comments.extend(above)
            self.section = "rules" if self.section in ("function", "figure") else self.section
            python = _PYTHON.match(line.code)
            if python:  # the paths that follow are written as those of sheets
                line = line._replace(code=python[1] + " " * len(python[2]) + line.code[python.end() :])
            paths = read_line(self.source, line, "use")
            self.uses.append(nodes.Use(paths, line.comment or "", self._span(line), bool(python)))
        elif word == "rules" and self.section == "function":
            raise RuleSheetError(foreign.second_rules(self._span(line)))
        else:
            (self.waiting if self._begun() else self.comments).extend(above)
            self.section = word
            if word == "variables":
                self._rows()
            self._remark(line)

    def _remark(self, line: Line) -> None:
        """A comment beside a section head becomes the first line of the section."""
        if line.comment:
            self.waiting.append(nodes.CommentLine(line.comment, self._span(line)))

    def _function(self, line: Line, above: tuple[nodes.CommentLine, ...]) -> None:
        span = self._span(line)
        self.section = "function"
        self.functions.append(
            FunctionDraft(Head("", (), ()), span.start, span.end, line.comment or "", above)
        )
        self.functions[-1].head = read_line(self.source, line, "head")

    def _figure(self, line: Line, above: tuple[nodes.CommentLine, ...]) -> None:
        span = self._span(line)
        self.section = "figure"
        self.figures.append(FigureDraft("", None, span.start, span.end, line.comment or "", above))
        self.figures[-1].name, self.figures[-1].unit = read_line(self.source, line, "figure")

    def _parameters(self, line: Line) -> None:
        if self.section == _SKIPPED:
            return
        if self.section != "function" or self.functions[-1].begun:
            raise RuleSheetError(foreign.stray_parameters(self._span(line)))
        self._place_comments()
        function = self.functions[-1]
        function.parameters.extend(read_line(self.source, line, "parameters"))
        function.end = line.end
        if line.comment:
            function.remarks.append(line.comment)

    # --- the whole ---

    def sheet(self) -> nodes.RuleSheet:
        self._place_comments()
        if not self.complaints:
            self.complaints.extend(self._emptiness())
        if self.complaints:
            raise RuleSheetError(*self.complaints)
        return nodes.RuleSheet(
            uses=tuple(self.uses),
            variables=None if self.rows is None else tuple(self.rows),
            rules=tuple(self.rules),
            functions=tuple(function.node(self.source) for function in self.functions),
            comments=tuple(self.comments),
            span=Span(self.source, 0, len(self.source.text)),
            figures=tuple(figure.node(self.source) for figure in self.figures),
            units=tuple(self.units),
        )

    def _emptiness(self) -> Iterable[Diagnosis]:
        if not (self.functions or self.units) and not _any_rule(self.rules):
            yield foreign.no_rule(self.source)
        for function in self.functions:
            if not _any_rule(function.rules):
                span = Span(self.source, function.start, function.start + 8)
                yield foreign.function_without_rules(function.head.name, span)
        for figure in self.figures:
            if not any(isinstance(line, nodes.Mark) for line in figure.marks):
                yield mistakes.empty_figure(figure.name, Span(self.source, figure.start, figure.start + 6))


def _any_rule(lines: Iterable[Any]) -> bool:
    return any(isinstance(line, nodes.Rule) for line in lines)
