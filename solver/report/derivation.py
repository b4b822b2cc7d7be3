"""The derivation of a number, by rules from the inputs on: as text, Markdown and LaTeX."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import chain
from typing import NamedTuple

from rulesheets.diagnosis import Diagnosis, plural
from rulesheets.evaluate import Undefined, value
from rulesheets.format import format_condition
from rulesheets.inputs import readable, variable_named
from rulesheets.model import Equation, Model, Value, Values, expect, reached
from rulesheets.syntax import nodes
from rulesheets.syntax.nodes import Condition, Expression, Name, Number, conjunction, names
from rulesheets.units import shown
from solver.numerics.tolerances import HALF
from solver.path import (
    Evaluate,
    Isolation,
    Select,
    Shown,
    SolveBlock,
    Step,
    equations_of,
    solved_by,
)
from solver.path.cases import outcomes
from solver.path.isolate import isolate
from solver.report import SCREEN, table
from solver.report.path import Places, Plain, Tex
from solver.solution.solving import Result


def explicit_form(isolation: Isolation, values: Values) -> Expression | None:
    """The form of ``isolation`` whose value is that of the unknown in ``values``.

    If the answer differs from every preimage by whole turns, the form includes them: ``asind(y) +
    360``. None if no form has a value near the answer.
    """
    if isolation.identity:
        return isolation.start
    answer = values[isolation.unknown]
    if isinstance(answer, str):
        return None
    known = {name: found for name, found in values.items() if name != isolation.unknown}
    forms = [*isolation.forms(), *_turned(isolation, known, answer)]
    offs = [abs(_value(form, known) - answer) for form in forms]
    off, place = min(((off, k) for k, off in enumerate(offs) if off == off), default=(math.inf, 0))
    if not math.isfinite(off):
        return None
    numbers = (abs(v) for name in names(forms[place]) if not isinstance(v := known[name], str))
    # a form may lose digits that the answer has: near a double root half of them
    return forms[place] if off <= HALF * (max((abs(answer), *numbers)) or 1.0) else None


def _turned(isolation: Isolation, known: Values, answer: float) -> Iterator[Expression]:
    """The forms with as many whole turns as bring them nearest to the answer."""
    if (period := isolation.period) is None:
        return
    last = next(i for i, stage in enumerate(isolation.stages) if stage.period) + 1
    rest = isolation._replace(stages=isolation.stages[last:])
    for inside in isolation._replace(stages=isolation.stages[:last]).forms():
        starts = (inside, nodes.add(inside, Number(period)))
        ends = (rest._replace(start=start).forms()[0] for start in starts)
        plain, turned = (_value(form, known) for form in ends)
        stride = turned - plain
        if not math.isfinite(stride) or stride == 0.0:
            continue
        turns = round((answer - plain) / stride)
        whole: Expression = Number(abs(turns) * period)
        halves = round(period / math.pi)
        if math.isclose(period, halves * math.pi, rel_tol=1e-12):  # in radians: multiples of pi
            whole = nodes.multiply(Number(float(abs(turns) * halves)), nodes.call("pi"))
        moved = (nodes.add if turns >= 0 else nodes.subtract)(inside, whole)
        yield from rest._replace(start=moved).forms()


def _value(form: Expression, known: Values) -> float:
    """The value of a form, nan if it has none."""
    try:
        return value(form, known)
    except Undefined:
        return math.nan


class Guard(NamedTuple):
    """A condition that selected a rule: its outcome, and the variables that it was ``read`` at.

    ``assumed``: it depended on the rule's result; its case was assumed and confirmed.
    """

    condition: Condition
    holds: bool
    assumed: bool
    read: tuple[str, ...]


class Line(NamedTuple):
    """One equation. Its ``form`` is what was computed, None if no form reproduces the value.

    Without an ``unknown`` it is a rule that an iteration has satisfied; without an ``equation`` it
    is a result of an iteration.
    """

    unknown: str | None
    equation: Equation | None = None
    form: Expression | None = None
    guards: tuple[Guard, ...] = ()


class Link(NamedTuple):
    """A step: one line, or a block, whose ``tears`` were iterated on.

    The lines of a block are the explicit steps, the equations that close it, and its results.
    """

    unknowns: tuple[str, ...]
    lines: tuple[Line, ...]
    tears: tuple[str, ...] = ()


@dataclass(frozen=True)
class Derivation(Shown):
    """The derivation of the value of ``name`` among the ``values`` of the answer.

    ``inputs`` are the given names that it depends on, in the order of the sheet; ``assumed`` are
    those of symbols taken from the case that was solved; ``links`` are the steps in order of
    computation. If there is no value, ``diagnoses`` say why.
    """

    model: Model
    name: str
    values: Values
    inputs: tuple[str, ...] = ()
    assumed: tuple[str, ...] = ()
    links: tuple[Link, ...] = ()
    diagnoses: tuple[Diagnosis, ...] = ()

    @property
    def value(self) -> Value | None:
        return self.values.get(self.name)


def why(result: Result, name: str) -> Derivation:
    """The chain of rules from the inputs to one value of the primary answer.

    It contains only what that value needs, including the conditions that selected its rules. Raises
    RuleSheetError for a name that the model does not have.
    """
    expect(Result, result, "solver.solve")
    variable_named(name, result.model)
    if result[name] is None:
        about = tuple(diagnosis for diagnosis in result.diagnoses if name in diagnosis.variables)
        return Derivation(result.model, name, {}, diagnoses=about or result.diagnoses)
    return _Tracing(result).derivation(name)


class _Tracing:
    """Goes back from one value to everything that it depends on."""

    def __init__(self, result: Result) -> None:
        self.model, self.inputs, self.origins = result.model, result.inputs, result.origins
        self.values: Values = result.partial
        if result.solutions:
            self.values = result.solutions[0]
        self.place: dict[Step, int] = {}
        for number, step in enumerate(result.path.steps):
            self.place.setdefault(step, number)

    def derivation(self, name: str) -> Derivation:
        def read(one: str) -> Iterator[str]:
            for equation in self._solved(self.origins.get(one)):
                selecting = (condition for condition, _ in self.model.outcomes(equation.guard))
                every = chain(equation.names, *map(names, selecting))
                yield from (name for name in every if name in self.values)

        needed = reached([name], read)
        found = {self.origins[n] for n in needed if n in self.origins}
        links = tuple(map(self._link, sorted(found, key=self.place.__getitem__)))
        given = [n for n in self.model.variables if n in needed and n not in self.origins]
        inputs = tuple(n for n in given if n in self.inputs)
        assumed = tuple(n for n in given if n not in self.inputs)
        return Derivation(self.model, name, self.values, inputs, assumed, links)

    def _solved(self, step: Step | None) -> tuple[Equation, ...]:
        """The equations that a step solved: of several alternatives, the first active one."""
        if step is None:
            return ()
        decided = outcomes(self.model, self.values, self.inputs) if isinstance(step, Select) else {}
        first = (self.model.equations[index] for index in equations_of(step)[:1])
        return tuple(solved_by(self.model, step, decided) or first)

    def _link(self, step: Step) -> Link:
        if not isinstance(step, SolveBlock):
            assert isinstance(step, Evaluate | Select)
            return Link((step.unknown,), (self._line(step.unknown, self._solved(step)[0], step),))
        explicit = {inner.unknown: inner.equation for inner in step.order}
        closing = step.residuals if step.order else step.equations
        pairs = [*explicit.items(), *((None, index) for index in closing)]
        lines = [self._line(unknown, self.model.equations[index], step) for unknown, index in pairs]
        lines += (Line(name) for name in step.unknowns if name not in explicit)
        return Link(step.unknowns, tuple(lines), step.tears or step.unknowns)

    def _line(self, unknown: str | None, equation: Equation, step: Step) -> Line:
        """An equation with its guards; conditions not known before the step are assumed."""
        form, guards = None, []
        if unknown and (isolation := isolate(equation.left, equation.right, unknown)):
            form = explicit_form(isolation, {name: self.values[name] for name in equation.names})
        for premise in equation.guard:
            condition = self.model.conditions[premise.condition]
            read = tuple(n for n in dict.fromkeys(names(condition)) if n in self.values)
            found = {n: self.place[self.origins[n]] for n in read if n in self.origins}
            known = {n: self.values[n] for n in read if found.get(n, -1) < self.place[step]}
            assumed = premise.condition not in outcomes(self.model, known, self.inputs)
            guards.append(Guard(condition, premise.holds, assumed, read))
        return Line(unknown, equation, form, tuple(guards))


MARGIN = "    "


def why_text(derivation: Derivation) -> str:
    """The inputs, then the numbered steps, each with its rule and its condition."""
    return "\n\n".join(Page(derivation, Plain()).parts())


def why_markdown(derivation: Derivation) -> str:
    """The same as a numbered list; mathematics between dollars, rules as code."""
    return "\n\n".join(Page(derivation, Tex(), markdown=True).parts())


def why_latex(derivation: Derivation) -> str:
    """The inputs, then the steps, the places of their rules in comments."""
    given = map(Line, (*derivation.inputs, *derivation.assumed))
    lines = (line for link in derivation.links for line in link.lines)
    return aligned(derivation, (*given, *lines))


def aligned(derivation: Derivation, lines: Iterable[Line]) -> str:
    page, rows = Page(derivation, Tex()), []
    for line in lines:
        left, *others = page.chain(line)
        row = f"  {left} &= {' = '.join(others)}"
        if unit := page.unit(line.unknown).strip().translate(ESCAPED):
            row += rf"\ \text{{{unit}}}"
        if line.equation is not None:
            closes = "" if line.unknown else "closes the block: "
            row = f"  % {closes}{'  '.join(page.places.rule(line.equation))}\n{row}"
        said = [rf"\text{{{word} }} {condition}" for word, condition, _ in page.guards(line)]
        rows.append(row + " && " + r",\ ".join(said) if said else row)
    body = " \\\\\n".join(rows)
    return f"\\begin{{align*}}\n{body}\n\\end{{align*}}"


class Page:
    """One derivation in one notation, with Markdown syntax on request."""

    def __init__(
        self, derivation: Derivation, notation: Plain | Tex, *, markdown: bool = False
    ) -> None:
        self.derivation, self.notation, self.markdown = derivation, notation, markdown
        self.model, self.values = derivation.model, derivation.values
        self.places = Places(derivation.model)

    # --- the equations, alike in every form ---

    def head(self) -> str:
        """``vB = -41.46, from 7 inputs by 12 of 38 rules``, or that there is no value."""
        found, name = self.derivation, self.derivation.name
        if found.value is None:
            return f"{self.code(name)} has no value"
        whole = self.code(f"{name} = {readable(found.value)}{self.unit(name)}")
        if not found.links:
            return f"{whole} is {'an input' if name in found.inputs else 'what its case says'}"
        used = sum(len(link.unknowns) for link in found.links)
        inputs, rules = len(found.inputs), len(self.model.equations)
        return f"{whole}, from {plural(inputs, 'input')} by {used} of {plural(rules, 'rule')}"

    def unit(self, name: str | None) -> str:
        """`` N``, or `` N = 2.25 lbf`` if it is shown in another unit than that of the rules."""
        if name is None:
            return ""
        variable, value = self.model.variables[name], self.values[name]
        unit = f" {variable.unit}" if variable.unit else ""
        if not variable.display_unit or not isinstance(value, float):
            return unit
        return f"{unit} = {readable(shown(value, variable))} {variable.display_unit}"

    def chain(self, line: Line) -> tuple[str, ...]:
        """The equal expressions of a line: unknown, form, form with numbers, value; each once."""
        tell = self.notation.written
        if line.unknown is None:
            sides = line.equation.sides if line.equation else ()
            return tuple(map(tell, sides))
        told = [self.notation.value(self.values[line.unknown])]
        if line.form is not None:
            told = [tell(line.form), self.notation.filled(line.form, self.values), *told]
        return tell(Name(line.unknown)), *dict.fromkeys(told)

    def guards(
        self, line: Line, notation: Plain | Tex | None = None
    ) -> Iterator[tuple[str, str, str]]:
        """``because``, the conditions, and the values that they read; likewise the assumed ones."""
        for word, assumed in (("because", False), ("assuming", True)):
            group = [guard for guard in line.guards if guard.assumed is assumed]
            if group:
                whole = conjunction([(guard.condition, guard.holds) for guard in group])
                known = dict.fromkeys(name for guard in group for name in guard.read)
                read = ", ".join(f"{name} = {readable(self.values[name])}" for name in known)
                said = (notation or self.notation).written(whole)
                yield word, said, "" if read == format_condition(whole) else read

    # --- a list of steps, in text or in Markdown ---

    def parts(self) -> Iterator[str]:
        yield self.head()
        found, colon = self.derivation, ":\n" * self.markdown
        if found.inputs and found.links:
            yield f"Given{colon}\n{self._table(found.inputs)}"
        if found.assumed:
            yield f"Case by case{colon}\n{self._table(found.assumed)}"
        if found.links:
            yield "\n".join(self._steps(found.links))

    def code(self, text: str) -> str:
        """A text of the sheet, unchanged."""
        return code_span(text) if self.markdown else text

    def _plain(self, text: str) -> str:
        """Text of a sheet, literal in Markdown: no emphasis, no links, no HTML."""
        return _SPECIAL.sub(r"\\\1", text) if self.markdown else text

    def formula(self, line: Line) -> str:
        """The chain and its unit, in Markdown between dollars."""
        formula, unit = " = ".join(self.chain(line)), self.unit(line.unknown)
        return f"${formula}${self._plain(unit)}" if self.markdown else formula + unit

    def known(self, name: str) -> str:
        """``AO = 3 mm``, in Markdown between dollars, else as in a sheet."""
        if self.markdown:
            return self.formula(Line(name))
        return f"{name} = {readable(self.values[name])}{self.unit(name)}"

    def _table(self, names: Iterable[str]) -> str:
        rows = [(self.known(name), self.model.variables[name].comment) for name in names]
        if not self.markdown:
            return table((), ((MARGIN + known, comment) for known, comment in rows))
        ends = (f": {self._plain(said)}" if said else "" for _, said in rows)
        return "\n".join(f"- {known}{end}" for (known, _), end in zip(rows, ends, strict=True))

    def _steps(self, links: Sequence[Link]) -> Iterator[str]:
        for number, link in enumerate(links, 1):
            bullet = f"{number}. " if self.markdown else f"{number:>{len(str(len(links)))}}  "
            lines, dash, indent = list[str](), "", ""
            if link.tears:
                lines = self._heading(link)
                dash, indent = ("- ", "  ") if self.markdown else (MARGIN, MARGIN)
            for line in link.lines:
                first, *rest = self._described(line, len(bullet) + len(dash))
                lines += [dash + first, *(indent + more for more in rest)]
            yield bullet + lines[0]
            yield from (" " * len(bullet) + line if line else "" for line in lines[1:])

    def _described(self, line: Line, used: int) -> list[str]:
        """An equation with its rule and conditions; ``used`` columns precede it."""
        word = "such that " if not line.unknown else "" if line.equation else "which gives "
        formula, told = [word + self.formula(line)], []
        if line.equation is not None:
            place, rule = self.places.rule(line.equation)
            marked = f"{self.code(rule)} ({self._plain(place)})"
            told.append(marked if self.markdown else f"{place}  {rule}")
        for reason, condition, read in self.guards(line):
            said, gap = (f"${condition}$", " ") if self.markdown else (condition, "   ")
            told.append(f"{reason} {said}" + f"{gap}({self.code(read)})" * bool(read))
        if self.markdown:
            return [*(f"{one}  " for one in (*formula, *told)[:-1]), (*formula, *told)[-1]]
        room = SCREEN.get().width
        if room is not None and len(formula[0]) > room - used:  # each equal on a line of its own
            left, first, *others = self.chain(line)
            start = f"{word}{left}"
            formula = [f"{start} = {first}", *(f"{' ' * len(start)} = {other}" for other in others)]
            formula[-1] += self.unit(line.unknown)
        return [*formula, *(MARGIN + one for one in told)]

    def _heading(self, link: Link) -> list[str]:
        """The unknowns of a block, and those that were iterated on."""
        shown = {name: name for name in (*link.unknowns, *link.tears)}
        if self.markdown:
            shown = {name: f"${self.notation.written(Name(name))}$" for name in shown}
        found = ", ".join(shown[name] for name in link.unknowns)
        tears = ", ".join(shown[name] for name in link.tears)
        how = f"together, iterating on {tears}" if len(link.unknowns) > 1 else "by iteration"
        return [f"{found} {how}:", ""] if self.markdown else [f"{found}: {how}"]


_MARKS = {mark: f"\\{mark}" for mark in "%_#&${}"}
ESCAPED = str.maketrans({**_MARKS, "\\": r"\textbackslash{}", "^": r"\^{}", "~": r"\~{}"})
_SPECIAL = re.compile(r"([\\`*_\[\]<>|$~&])")


def code_span(text: str) -> str:
    """A code span of Markdown, between more backticks than the text contains."""
    fence = "`" * (1 + max(map(len, re.findall("`+", text)), default=0))
    pad = " " if text.startswith("`") or text.endswith("`") else ""
    return f"{fence}{pad}{text}{pad}{fence}"
