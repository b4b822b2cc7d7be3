"""A text → RuleSheet: each line goes to its section."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any

from rulesheets.checks import MARK_SHAPE
from rulesheets.diagnosis import Diagnosis, RuleSheetError, error_at, refusal, refuse
from rulesheets.parse.grammar import read_line, read_rule
from rulesheets.parse.layout import Line, logical_lines, wrong_shape
from rulesheets.parse.mistakes import contents, misspelt_head, unknown_section
from rulesheets.syntax import Source, Span, nodes

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
PLANNED = ("list", "procedure")
"""Heads of kinds of sections that are not supported yet."""
_LONE = re.compile(r"\s*([^\W\d]\w*)\s*(:?)\s*\Z")
_ALMOST = frozenset({"rule", "variable", "equation", "equations", "formula", "formulas"})
"""Lone words that are taken for a misspelt head even where names stand alone."""


def head_word(code: str) -> str | None:
    """The word that makes a line the head of a section, in lower case; None for any other line."""
    found = _HEAD.match(code)
    return str(found[found.lastgroup or 0]).lower() if found else None


@dataclass
class _Unfinished:
    """A function or a figure in progress: its end so far, and whether its rules have begun."""

    node: Any
    end: int
    lines: list[Any] = field(default_factory=list)
    begun: bool = False


_UNIT = re.compile(r"(?:[^\W\d_]|[°%‰$€£¥℃℉])(?:[\w°%]*[^\W\d])?")
_ENOUGH = 50
"""Complaints after which the rest of a sheet is not read."""

_PYTHON = re.compile(r"(\s*use\s+)(python\b)", re.IGNORECASE)
_SKIPPED = "skipped"
"""The section whose lines are not read, because its kind is not supported yet."""


def parse(source: Source) -> nodes.RuleSheet:
    """The rule sheet of a text. Raises RuleSheetError with the mistakes, line by line."""
    reading = _Reading(source)
    for line in logical_lines(source.text):
        reading.take(line)
        if len(reading.complaints) >= _ENOUGH:
            break
    return reading.sheet()


@dataclass
class _Reading:
    """The sheet read so far, and the section of the next line."""

    source: Source
    uses: list[nodes.Use] = field(default_factory=list)
    parts: dict[str, list[Any]] = field(default_factory=dict)
    blocks: list[_Unfinished] = field(default_factory=list)
    comments: list[nodes.CommentLine] = field(default_factory=list)
    waiting: list[nodes.CommentLine] = field(default_factory=list)
    complaints: list[Diagnosis] = field(default_factory=list)
    section: str = ""

    def take(self, line: Line) -> None:
        """Add the next line; its mistakes join the complaints."""
        try:
            if line.blank:
                place = line.place(self.source)
                self.waiting.append(nodes.CommentLine(line.comment or "", place, line.gap))
            elif wrong := wrong_shape(self.source, line):
                self.complaints.append(wrong)
            elif word := head_word(line.code):
                self._begin(word, line)
            elif self.section != _SKIPPED:
                self._add(line)
        except RuleSheetError as error:
            self.complaints.extend(error.diagnoses)

    # --- lines of a section ---

    def _add(self, line: Line) -> None:
        section, comment, span = self.section, line.comment or "", line.place(self.source)
        lone = _LONE.match(line.code)
        if lone and (
            section not in ("variables", "units") or lone[2] or lone[1].lower() in _ALMOST
        ):
            word = lone[1].lower()
            if word in ("variable", "variables"):  # the section that most likely begins here
                self.section = "variables"
            elif word in _ALMOST | {"rules"} and section != "function":
                self.section = "rules"
            raise RuleSheetError(unknown_section(lone[1], span))
        self._place_comments()
        if section == "units":
            node: Any = _unit_row(line.code, span).but(comment=comment, gap=line.gap)
        elif section in ("variables", "figure"):
            kind = "row" if section == "variables" else "mark"
            node = read_line(self.source, line, kind).but(comment=comment, gap=line.gap)
        else:
            node = nodes.Rule(read_rule(self.source, line, span), comment, span, line.gap)
        self._lines.append(node)
        if section in ("function", "figure"):
            self.blocks[-1].end, self.blocks[-1].begun = line.end, True

    @property
    def _lines(self) -> list[Any]:
        if self.section in ("function", "figure"):
            return self.blocks[-1].lines
        section = self.section if self.section in ("variables", "units") else "rules"
        return self.parts.setdefault(section, [])

    # --- comment lines ---

    def _place_comments(self) -> None:
        """Put waiting comment lines into the current section."""
        if self.waiting:
            (self._lines if self._begun() else self.comments).extend(self.waiting)
            self.waiting = []

    def _above(self, line: Line) -> tuple[nodes.CommentLine, ...]:
        """Take out the waiting comment lines directly above a section head."""
        gaps = [index for index, comment in enumerate(self.waiting) if comment.gap]
        cut = len(self.waiting) if line.gap else next(reversed(gaps), 0)
        above = tuple(self.waiting[cut:])
        del self.waiting[cut:]
        return above

    def _begun(self) -> bool:
        """Whether anything but comments has been read."""
        return bool(self.section or self.parts.get("rules") or self.uses)

    # --- section heads ---

    def _begin(self, word: str, line: Line) -> None:
        if word == "parameters":
            if self.section != _SKIPPED:
                self._parameters(line)
        elif word in PLANNED:
            planned = contents()["planned"][word]
            self._place_comments()
            self.section = _SKIPPED
            message = f"{planned['name']} not supported yet"
            raise refusal("E190", message, line.place(self.source), planned["cure"])
        elif word == "rules" and self.section == "function" and not self.blocks[-1].begun:
            self._place_comments()
            self.blocks[-1].begun = True
            self._remark(line)
        else:
            above = self._above(line)
            self._place_comments()
            self._open(word, line, above)

    def _open(self, word: str, line: Line, above: tuple[nodes.CommentLine, ...]) -> None:
        span = line.place(self.source)
        if word in ("function", "figure"):
            # it exists for the following lines, even if its head is wrong
            self.section, kind = word, "head" if word == "function" else word
            about: dict[str, Any] = {"comment": line.comment or "", "span": span, "above": above}
            empty: Any = nodes.Figure("", None, (), **about)
            if word == "function":
                empty = nodes.Function("", (), (), (), (), **about)
            self.blocks.append(_Unfinished(empty, line.end))
            self.blocks[-1].node = read_line(self.source, line, kind).but(**about)
        elif word == "use":
            self.comments.extend(above)
            self.section = "rules" if self.section in ("function", "figure") else self.section
            python = _PYTHON.match(line.code)
            if python:  # the paths that follow are written as those of sheets
                line.code = python[1] + " " * len(python[2]) + line.code[python.end() :]
            paths = read_line(self.source, line, "use")
            self.uses.append(nodes.Use(paths, line.comment or "", span, bool(python)))
        elif word == "rules" and self.section == "function":
            message = "this function has its rules already"
            note = "rules of the sheet itself stand before the first function"
            raise refusal("E119", message, span, note, label="a second head")
        else:
            (self.waiting if self._begun() else self.comments).extend(above)
            self.section = word
            self.parts.setdefault(word, [])
            self._remark(line)

    def _remark(self, line: Line) -> None:
        """A comment next to a section head becomes the first line of the section."""
        if line.comment:
            self.waiting.append(nodes.CommentLine(line.comment, line.place(self.source)))

    def _parameters(self, line: Line) -> None:
        if self.section != "function" or self.blocks[-1].begun:
            note = "put the line between the head of the function and its rules"
            message = "parameters belong to a function"
            raise refusal("E119", message, line.place(self.source), note)
        self._place_comments()
        block = self.blocks[-1]
        block.end = line.end
        parameters = (*block.node.parameters, *read_line(self.source, line, "parameters"))
        remarks = "; ".join(filter(None, (block.node.parameters_comment, line.comment)))
        block.node = block.node.but(parameters=parameters, parameters_comment=remarks)

    # --- the whole ---

    def sheet(self) -> nodes.RuleSheet:
        self._place_comments()
        complaints = self.complaints or [*self._emptiness()]
        rows = self.parts.get("variables", ()) if "rules" not in self.parts else ()
        refuse((complaints and misspelt_head(rows)) or complaints)
        blocks = []
        for block in self.blocks:
            content = "rules" if isinstance(block.node, nodes.Function) else "marks"
            span = Span(self.source, block.node.span.start, block.end)
            blocks.append(block.node.but(span=span, **{content: tuple(block.lines)}))
        variables = self.parts.get("variables")
        return nodes.RuleSheet(
            uses=tuple(self.uses),
            variables=None if variables is None else tuple(variables),
            rules=tuple(self.parts.get("rules", ())),
            functions=tuple(block for block in blocks if isinstance(block, nodes.Function)),
            comments=tuple(self.comments),
            span=Span(self.source, 0, len(self.source.text)),
            figures=tuple(block for block in blocks if isinstance(block, nodes.Figure)),
            units=tuple(self.parts.get("units", ())),
        )

    def _emptiness(self) -> Iterable[Diagnosis]:
        """The complaint about an empty sheet, function or figure."""
        functions = [block for block in self.blocks if isinstance(block.node, nodes.Function)]
        if not (functions or self.parts.get("units") or _filled(self.parts.get("rules", ()))):
            note, message = "write a rule, such as V = I*R", f"{self.source.name} has no rule"
            yield error_at("E126", message, Span(self.source, 0, 1), note, label="nothing to solve")
        for block in self.blocks:
            if _filled(block.lines):
                continue
            node, word = block.node, "figure"
            message, note, label = f"the figure {node.name} is empty", MARK_SHAPE, "nothing to draw"
            if block in functions:
                message, word = f"the function {node.name} has no rule", "function"
                note = "write its rules below its head, under `rules`"
                label = "its rules are missing"
            yield error_at("E126", message, node.span.part(0, len(word)), note, label=label)


def _unit_row(code: str, span: Span) -> nodes.UnitRow:
    """The row of a line. Raises RuleSheetError (E128) if it defines no unit."""
    left, equals, right = code.partition("=")
    names = tuple(map(str.strip, left.split(",")))
    if not all(map(_UNIT.fullmatch, names)) or bool(equals) is not bool(right.strip()):
        note = "write smoot = 1.7018 m, or widget alone for a unit of a kind of its own"
        raise refusal("E128", "this line defines no unit", span, note)
    return nodes.UnitRow(names, " ".join(right.split()), span=span)


def _filled(lines: Iterable[Any]) -> bool:
    return any(not isinstance(line, nodes.CommentLine) for line in lines)
