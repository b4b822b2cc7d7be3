"""Where reading a line stopped; forms of other languages, misspelt heads, and lines too deep to read."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Iterator
from typing import Any

from lark import Token

from rulesheets.diagnosis import PROPERTIES, WRITE_IN_PYTHON, Diagnosis, closest, said
from rulesheets.parse.layout import LONGEST, NESTING, Line
from rulesheets.syntax import Source, Span
from rulesheets.syntax.nodes import Condition, Expression, IfRule, Product, Quotient, RuleBody, children

_CHAIN = (Product, Quotient)

OPERATORS = frozenset("+-*/^=<>,;~") | {"<=", ">=", "<>", "≤", "≥", "≠"}
LINKS = frozenset({"_AND", "_OR", "NOT"})
_OPERANDS = frozenset({"NAME", "NUMBER", "SYMBOL", "LPAR", "GIVEN"})
_ENDS = frozenset({"NAME", "NUMBER", "SYMBOL", "RPAR"})


class Word(Token):
    """A word with its kind (``type``) and its place in the code."""

    start_pos: int
    end_pos: int

    @property
    def relates(self) -> bool:
        """Whether it is ``=`` or a sign of order."""
        return self.type == "RELATION" or self == "="


_NONE = Word("", "", 0, end_pos=0)
"""What stands before the first word of a line and after the last: empty, and of no kind."""


class Stop:
    """Where reading a line stopped: at the word ``index`` of its ``words`` (their number at the end).

    ``before``, ``word`` and ``after`` are the words around that place, empty where there is none;
    ``lacks_operand``: something should stand between the first two, ``adjacent``: not even a blank does.
    """

    def __init__(self, source: Source, line: Line, words: tuple[Word, ...], index: int) -> None:
        self.source, self.line, self.words, self.index = source, line, words, index
        before, word, after = (_NONE, *words, _NONE, _NONE)[index : index + 3]
        self.before, self.word, self.after = before, word, after
        self.begins_operand, self.follows_operand = word.type in _OPERANDS, before.type in _ENDS
        self.lacks_operand = not before or before in OPERATORS or before == "(" or before.type in LINKS
        self.adjacent = bool(word and before) and word.start_pos == before.end_pos
        self.here = self.span(word)

    def line_ends_before(self, index: int) -> bool:
        """Whether a line of text ends between a word and the one before it."""
        if not 0 < index < len(self.words):
            return False
        return "\n" in self.line.code[self.words[index - 1].end_pos : self.words[index].start_pos]

    def count(self, kind: str) -> int:
        """How many words of a kind stand before the stop."""
        return sum(word.type == kind for word in self.words[: self.index])

    @property
    def condition(self) -> tuple[Word, ...] | None:
        """The words after an ``if`` that waits for its ``then``, up to the stop; None outside."""
        for index in range(min(self.index, len(self.words)) - 1, -1, -1):
            if self.words[index].type == "_THEN":
                return None
            if self.words[index].type == "IF":
                return self.words[index + 1 : self.index]
        return None

    # --- places ---

    def span(self, first: Word, last: Word | None = None) -> Span:
        """The place of a word, or of all from one to another; the end of the line for none."""
        if not first:
            return Span(self.source, self.line.end, self.line.end + 1)
        last = last or first
        return Span(self.source, self.line.start + first.start_pos, self.line.start + last.end_pos)

    @property
    def whole(self) -> Span:
        return self.span(self.words[0], self.words[-1])

    def text(self, first: Word, last: Word) -> str:
        return " ".join(self.line.code[first.start_pos : last.end_pos].split())


# --- forms of other languages ----------------------------------------------------

_NAME = r"(?P<name>[^\W\d]\w*)"
_INDEX = r"(?:\d+|[ijkn])(?:\s*[-+]\s*\d+)?"
_CALL = r"(?P<name>(?!(?i:if|and|or|not|call|function)\b)[^\W\d]\w*)\s*\("
_NOT_BUILT_IN = "functions of substances are not built in"
_ANGLES = "leave it out: a variable has its own unit; sind, cosd and tand take degrees"
_COMMENT = 'a comment begins with " and reaches to the end of its line'
_TOLERANCE = "a tolerance stands after the value of an input, in the variables section"

_FOREIGN: list[tuple[str, str, str | None, str]] = [
    (r"^\s*\$(?i:unitsystem)\b.*", "E129", "$UnitSystem chooses nothing here", _ANGLES),
    (r"^\s*\$(?P<name>\w+).*", "E129", "${name} is a directive of EES", "leave it out"),
    (
        r"^\s*(?i:duplicate)\s+\w+\s*=.*",
        "E190",
        "DUPLICATE is not there yet",
        "write the rules out one by one",
    ),
    (
        rf"{_NAME}\[\s*{_INDEX}\s*\.\.\s*{_INDEX}\s*\]",
        *("E190", "arrays are not there yet", "write the elements out, each under a name such as {name}_1"),
    ),
    (
        rf"{_NAME}\[\s*(?P<index>{_INDEX})(?:\s*,\s*{_INDEX})*\s*\]",
        *("E190", "arrays are not there yet", "give each element a name of its own, such as {name}_{index}"),
    ),
    (rf"(?i:{'|'.join(PROPERTIES)})\s*\([^()]*[=;]", "E190", _NOT_BUILT_IN, WRITE_IN_PYTHON),
    (
        rf"{_CALL}[^()=]*=",
        *("E129", "arguments have no names here", "write {name}(a, b), in the order of its arguments"),
    ),
    (
        r"(?i:call)\s+\w+\s*\([^():]*:",
        *("E118", "a semicolon stands between arguments and results", "write call f(a, b; x, y)"),
    ),
    (rf"{_NAME}\$", "E129", "no name ends in $", "write {name}; its value is a symbol, such as 'water"),
    (rf"{_NAME}#", "E129", "no name ends in #", "write {name}, and give its number as an input"),
    (r"(?<![=~])(?<![=~]\s)\{[^}\n]*\}?", "E129", "braces enclose no comment", _COMMENT),
    (r":=|==+", "E115", "`=` is the only sign of equality", "write `=`"),
    (r"!=|/=|=/=|~=", "E108", None, "write <>"),
    (r"=<", "E108", None, "write <="),
    (r"=>", "E108", None, "write >="),
    (r"\*\*", "E108", None, "write ^ for a power"),
    (r"&&?", "E108", None, "write and"),
    (r"\|\|", "E108", None, "write or"),
    (r"\|", "E108", None, "write abs(x) for an absolute value; between conditions stands the word or"),
    (r"!", "E108", None, "write not"),
    (r"±|\+/-|\+-(?=\s*[\d.]+%?\s*$)", "E120", _TOLERANCE, "write = 3 ± 0.01 there"),
    (r"\{", "E190", "lists are not there yet", "give one value, and solve once for each"),
    (r"%", "E108", None, "write the number as a fraction, 0.05 for 5 %"),
    (r"#|//", "E108", None, 'a comment begins with "'),
    (r"'", "E108", "an apostrophe begins a symbol", "write 'open, with no apostrophe at the end"),
    (r"\.", "E108", None, "names are made of letters, digits and _"),
    (r"\[", "E122", "a unit is never closed", "write it as in [rad/s], on one line"),
]


def foreign_form(stop: Stop) -> Diagnosis | None:
    """A diagnosis if a form of another language stands where reading stops."""
    if not stop.word:
        return None
    for pattern, code, message, cure in _FOREIGN:
        for found in re.finditer(pattern, stop.line.code):
            if found.start() <= stop.word.start_pos and found.end() >= stop.word.end_pos:
                start, parts = stop.line.start + found.start(), found.groupdict()
                wording = message or f"`{found.group()}` has no meaning in a rule sheet"
                span = Span(stop.source, start, start + len(found.group().rstrip()))
                return said(code, wording.format(**parts), span, cure.format(**parts))
    return None


def unreadable(stop: Stop) -> Diagnosis:
    """The diagnosis where nothing more can be said."""
    word = stop.word
    if not word:
        return said("E101", "this line ends too early", stop.here)
    if word.type == "UNKNOWN":
        return said("E108", f"`{word}` has no meaning in a rule sheet", stop.here, "remove it")
    label = f"not after `{stop.before}`" if stop.before else "not"
    return said("E101", f"`{word}` cannot stand here", stop.here, "remove it", label=label)


_SIGNS = {
    **dict.fromkeys("−–—‐‑‒―", "-"),
    **dict.fromkeys("×·⋅∙•∗✕", "*"),
    **dict.fromkeys("÷∕⁄", "/"),
    **dict.fromkeys("“”„‟«»″", '"'),
    **dict.fromkeys("‘’‚‛′´", "'"),
    **dict.fromkeys("≈≃≅", "~"),
    **dict.fromkeys("≡≔", "="),
    **dict.fromkeys("∧", "and"),
    **dict.fromkeys("∨", "or"),
    "¬": "not",
    "√": "sqrt(…)",
    "π": "pi",
    "°": "sind, cosd, … for angles in degrees",
    "½": "0.5",
    "¼": "0.25",
    "¾": "0.75",
    "∞": "no bound at all, which is the same",
    **{character: f"^{digit}" for digit, character in enumerate("⁰¹²³⁴⁵⁶⁷⁸⁹")},
}
_ALLOWED = frozenset("≤≥≠±")
_STRANGE = re.compile(r"[^\t\n\v\f\r -~]")
_QUOTED = re.compile(r'\[[^\[\]\n]*\]|"[^"\n]*"')


def strange_characters(source: Source, line: Line) -> Iterator[Diagnosis]:
    """One diagnosis for each kind of character that has no meaning in the code of a line.

    Units in brackets and quoted file names may hold any.
    """
    if not _STRANGE.search(line.code):
        return
    code = _QUOTED.sub(lambda found: " " * len(found.group()), line.code)
    told = set()
    for place, character in enumerate(code, line.start):
        if not _STRANGE.match(character) or character in _ALLOWED or _is_letter(character):
            continue
        cure = _replacement(character)
        if cure not in told:
            told.add(cure)
            name = unicodedata.name(character, "").lower() or f"U+{ord(character):04X}"
            shown = f"{character} ({name})" if character.isprintable() else name
            note = f"write {cure}" if cure else "remove it, or put it into a comment"
            message = f"{shown} has no meaning in a rule sheet"
            yield said("E108", message, Span(source, place, place + 1), note)


def _is_letter(character: str) -> bool:
    """Whether it may stand in a name: a letter with no other spelling (π is taken for pi)."""
    return (
        character not in _SIGNS
        and f"a{character}".isidentifier()
        and not unicodedata.combining(character)
        and unicodedata.normalize("NFKC", character) == character
    )


def _replacement(character: str) -> str:
    if character in _SIGNS:
        return _SIGNS[character]
    category = unicodedata.category(character)
    if category.startswith("Z"):
        return "a plain blank"
    if category == "Cf":
        return "nothing: it is invisible"
    plain = unicodedata.normalize("NFKC", character)
    return plain if plain != character and plain.isprintable() else ""


SECTIONS = ("variables", "rules", "units", "function", "parameters", "use", "figure")

_SHAPES = {
    "use": 'write use "position.tk"',
    "head": "write function f(a, b; x, y): arguments, a semicolon, results",
    "parameters": "write parameters AB, AO",
    "figure": "write figure velocity [m/s]: a name, and the unit of its scale if there is one",
}
PLANNED = {
    "list": ("list functions are", "write the formula, or a chain of if … then … else if …"),
    "procedure": ("procedure functions are", "write its formulas as the rules of a function"),
}
"""Constructs that the language plans, and what to write until then."""


def explain_head(stop: Stop, kind: str) -> Diagnosis:
    """What is wrong with a ``use``, ``function``, ``parameters`` or ``figure`` line."""
    note = _SHAPES[kind]
    if kind == "use" and (stop.line.comment is not None or '"' in stop.line.code):
        start = max(stop.source.text.rfind('"', stop.line.start, stop.line.end + 2), stop.line.start)
        place = Span(stop.source, start, start + 1)
        return said("E123", "a file name is never closed", place, note, label="opened here")
    if kind == "parameters" and stop.begins_operand and stop.follows_operand:
        note = f"write a comma: {stop.before}, {stop.word}"
    word = stop.words[0].lower() if stop.words else kind
    place = stop.here if stop.word else stop.whole
    return said("E118", f"this `{word}` line cannot be read", place, note)


def unknown_section(word: str, span: Span) -> Diagnosis:
    """A lone word that is no section head."""
    near = closest(word, SECTIONS)
    if word.lower() == "end":
        note = "leave it out: a function ends where the next section begins"
        return said("E116", f"`{word}` ends nothing here", span, note)
    if near is None:
        message = f"`{word}` alone is neither a rule nor the head of a section"
        note = "a rule is an equation, such as V = I*R"
        return said("E116", message, span, note, "sections are variables, rules, units, function and figure")
    if near == word.lower():
        return said("E116", f"a section head is one word alone: {near}", span, f"write {near}")
    return said("E116", f"unknown section `{word}`", span, f"did you mean {near}?")


def section_with_colon(stop: Stop) -> Diagnosis | None:
    """``rules:`` and the like."""
    if stop.word == ":" and stop.index == 1 and not stop.after:
        return unknown_section(stop.words[0], stop.whole)
    return None


DEEPEST = 200
"""Levels of a rule's tree: later stages walk trees by recursion, which must end in good time."""
FACTORS = 300
"""Factors of a product, each of which is a level for what recurses; they count as one above."""


def wrong_shape(source: Source, line: Line) -> Diagnosis | None:
    """What parentheses and length say against a line; None where it may be read."""
    if line.end - line.start > LONGEST:
        message = f"this line is too long to be a rule: {line.end - line.start:,} characters"
        note = f"a rule has at most {LONGEST:,} characters; give parts of it names of their own"
        return said("E125", message, Span(source, line.start, line.start + 1), note, label="begins here")
    if line.too_deep is not None:
        return _nested(Span(source, line.too_deep, line.too_deep + 1), f"more than {NESTING} are open here")
    if line.stray:
        place = Span(source, line.stray[0], line.stray[0] + 1)
        note = "remove it, or open a parenthesis before it"
        return said("E103", None, place, note, label="nothing is open here")
    if line.unclosed:
        place = Span(source, line.unclosed[-1], line.unclosed[-1] + 1)
        note = f"add {')' * len(line.unclosed)} where it ends"
        return said("E102", None, place, note, label="opened here")
    return None


def too_deep(tree: RuleBody | Condition | Expression) -> Diagnosis | None:
    """Whether a tree has more than DEEPEST levels, or a product more than FACTORS, by a loop."""
    if tree.span is None or tree.span.end - tree.span.start <= DEEPEST:
        return None  # a tree has no more levels than its text has characters
    stack: list[tuple[Any, int, int]] = [(tree, 1, 0)]  # the sign of equality is no factor
    while stack:
        node, level, factors = stack.pop()
        here = tree.span if node.span is None else node.span
        if level > DEEPEST:
            return _nested(here.part(0, 1), f"{DEEPEST} levels deep")
        if factors > FACTORS:
            message = f"this expression nests more than {FACTORS} levels deep"
            label = "every factor of a long product is a level"
            return said("E217", message, here.part(0, 1), "split it over several rules", label=label)
        if isinstance(node, IfRule):
            arms = filter(None, (node.condition, node.then, node.otherwise))
            stack += ((arm, level + 1, 0) for arm in arms)
            continue
        for part in reversed(children(node)):
            chained = isinstance(node, _CHAIN) and part is node.left and isinstance(part, _CHAIN)
            stack.append((part, level if chained else level + 1, factors + 1))
    return None


def _nested(span: Span, label: str) -> Diagnosis:
    note = "give the inner parts names of their own, in rules of their own"
    return said("E124", "this is nested too deeply", span, note, label=label)
