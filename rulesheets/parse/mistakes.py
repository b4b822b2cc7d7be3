"""What is wrong with a line that cannot be read."""

from __future__ import annotations

from rulesheets.diagnosis import Diagnosis, Label, error
from rulesheets.parse.layout import Line
from rulesheets.source import Source, Span


def before_reading(source: Source, line: Line) -> list[Diagnosis]:
    if line.unclosed:
        return [error("E102", None, Label(Span(source, line.unclosed[-1], line.unclosed[-1] + 1)))]
    if line.stray:
        return [error("E103", None, Label(Span(source, line.stray[0], line.stray[0] + 1)))]
    return []


def explain(source: Source, line: Line, kind: str, place: int) -> Diagnosis:
    start = line.start + place
    return error("E101", None, Label(Span(source, start, start + 1)))


def second_rules(span: Span) -> Diagnosis:
    return error("E119", "this function has its rules already", Label(span))


def stray_parameters(span: Span) -> Diagnosis:
    return error("E119", None, Label(span))


def no_rule(source: Source) -> Diagnosis:
    return error("E126", f"{source.name} has no rule", notes=("write a rule, such as V = I*R",))


def function_without_rules(name: str, span: Span) -> Diagnosis:
    return error("E126", f"the function {name} has no rule", Label(span))
