"""What is wrong with sections: their heads, their order, what they lack."""

from __future__ import annotations

from rulesheets.diagnosis import Diagnosis, Label, error
from rulesheets.parse.mistakes.stop import Stop
from rulesheets.source import Source, Span
from rulesheets.spelling import closest

SECTIONS = ("variables", "rules", "units", "function", "parameters", "use", "figure")

_SHAPES = {
    "use": 'write use "position.tk"',
    "head": "write function f(a, b; x, y): arguments, a semicolon, results",
    "parameters": "write parameters AB, AO",
    "figure": "write figure velocity [m/s]: a name, and the unit of its scale if there is one",
}
_PLANNED = {
    "list": ("list functions are", "write the formula, or a chain of if … then … else if …"),
    "procedure": ("procedure functions are", "write its formulas as the rules of a function"),
}


def explain_head(stop: Stop, kind: str) -> Diagnosis:
    """What is wrong with a ``use``, ``function``, ``parameters`` or ``figure`` line."""
    note = _SHAPES[kind]
    if kind == "use" and (stop.line.comment is not None or '"' in stop.line.code):
        start = max(stop.source.text.rfind('"', stop.line.start, stop.line.end + 2), stop.line.start)
        return error(
            "E123",
            "a file name is never closed",
            Label(Span(stop.source, start, start + 1), "opened here"),
            notes=(note,),
        )
    if kind == "parameters" and stop.begins_operand and stop.follows_operand:
        note = f"write a comma: {stop.before}, {stop.word}"
    word = stop.words[0].lower() if stop.words else kind
    place = stop.here if stop.word is not None else stop.whole
    return stop.error("E118", f"this `{word}` line cannot be read", place, "", note)


def unknown_section(word: str, span: Span) -> Diagnosis:
    """A lone word that is no section head."""
    near = closest(word, SECTIONS)
    plain = "a rule is an equation, such as V = I*R"
    if word.lower() == "end":
        note = "leave it out: a function ends where the next section begins"
        return error("E116", f"`{word}` ends nothing here", Label(span), notes=(note,))
    if near is None:
        return error(
            "E116",
            f"`{word}` alone is neither a rule nor the head of a section",
            Label(span),
            notes=(plain, "sections are variables, rules, units, function and figure"),
        )
    if near == word.lower():
        return error(
            "E116", f"a section head is one word alone: {near}", Label(span), notes=(f"write {near}",)
        )
    return error("E116", f"unknown section `{word}`", Label(span), notes=(f"did you mean {near}?",))


def not_there_yet(word: str, span: Span) -> Diagnosis:
    """A construct that the language plans."""
    what, note = _PLANNED[word.lower()]
    return error("E190", f"{what} not there yet", Label(span), notes=(note,))


def second_rules(span: Span) -> Diagnosis:
    return error(
        "E119",
        "this function has its rules already",
        Label(span, "a second head"),
        notes=("rules of the sheet itself stand before the first function",),
    )


def stray_parameters(span: Span) -> Diagnosis:
    return error(
        "E119",
        "parameters belong to a function",
        Label(span),
        notes=("put the line between the head of the function and its rules",),
    )


def no_rule(source: Source) -> Diagnosis:
    span = Span(source, 0, 1)
    return error(
        "E126",
        f"{source.name} has no rule",
        Label(span, "nothing to solve"),
        notes=("write a rule, such as V = I*R",),
    )


def function_without_rules(name: str, span: Span) -> Diagnosis:
    return error(
        "E126",
        f"the function {name} has no rule",
        Label(span, "its rules are missing"),
        notes=("write its rules below its head, under `rules`",),
    )
