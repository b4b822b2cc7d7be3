"""Why a number is what it is: the chain of rules from the inputs to it; as text, Markdown and LaTeX."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import chain
from sys import float_info
from typing import Any, NamedTuple, TypeAlias

from rulesheets.diagnosis import Diagnosis, plural
from rulesheets.evaluate import Undefined, value
from rulesheets.inputs import variable_named
from rulesheets.model import Equation, Model, Value
from rulesheets.syntax import nodes
from rulesheets.syntax.nodes import Condition, Expression, Name, Number, names, substitute
from rulesheets.units import shown
from solver.path import Evaluate, Select, Shown, SolveBlock, Step, equations_of
from solver.path.cases import outcomes, solved_by
from solver.path.isolate import TARGET, Isolation, isolate
from solver.report import SCREEN, columns
from solver.report.path import Notation, Places, Plain, Tex
from solver.result import Result

CLOSE = math.sqrt(float_info.epsilon)
"""A form may lose digits that the answer has (near a double root half of them), and still is the one."""


def explicit_form(isolation: Isolation, values: Mapping[str, Value]) -> Expression | None:
    """The form of ``isolation`` whose value is that of the unknown in ``values``.

    Where the answer lies whole turns away from every preimage, the form says how many:
    ``asind(y) + 360``. None where no form has a value near the answer.
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
    return forms[place] if off <= CLOSE * (max((abs(answer), *numbers)) or 1.0) else None


def _turned(isolation: Isolation, known: Mapping[str, Value], answer: float) -> Iterator[Expression]:
    """The forms with as many whole turns as bring them nearest to the answer."""
    if isolation.period is None:
        return
    at = next(i for i, stage in enumerate(isolation.stages) if stage.period)
    period = isolation.stages[at].period or 0.0
    for inside in _through(isolation, (isolation.start,), 0, at + 1):
        (plain,) = _through(isolation, (inside,), at + 1, None)[:1]
        (turned,) = _through(isolation, (nodes.add(inside, Number(period)),), at + 1, None)[:1]
        stride = _value(turned, known) - _value(plain, known)
        if not math.isfinite(stride) or stride == 0.0:
            continue
        turns = round((answer - _value(plain, known)) / stride)
        whole: Expression = Number(abs(turns) * period)
        halves = round(period / math.pi)
        if math.isclose(period, halves * math.pi, rel_tol=1e-12):  # in radians: multiples of pi
            whole = nodes.multiply(Number(float(abs(turns) * halves)), nodes.call("pi"))
        moved = (nodes.add if turns >= 0 else nodes.subtract)(inside, whole)
        yield from _through(isolation, (moved,), at + 1, None)


def _through(
    isolation: Isolation, targets: tuple[Expression, ...], first: int, last: int | None
) -> tuple[Expression, ...]:
    for stage in isolation.stages[first:last]:
        targets = tuple(substitute(form, {TARGET.name: t}) for t in targets for form in stage.forms)
    return targets


def _value(form: Expression, known: Mapping[str, Value]) -> float:
    """The value of a form, nan where it has none."""
    try:
        return value(form, known)
    except Undefined:
        return math.nan


class Known(NamedTuple):
    """A variable with its value, in calculation units."""

    name: str
    value: Value


class Guard(NamedTuple):
    """A condition that selected a rule: how it came out, and what it was read at.

    ``assumed``: it waited on what the rule was to give, so its case was assumed, solved, and
    found to be so.
    """

    condition: Condition
    holds: bool
    assumed: bool
    read: tuple[Known, ...]


class Direct(NamedTuple):
    """One unknown from one equation. ``form`` is what was computed, None where no form reproduces the value.

    ``numbers`` are the values that the form reads.
    """

    found: Known
    equation: Equation
    form: Expression | None
    numbers: Mapping[str, Value]
    guards: tuple[Guard, ...] = ()


class Together(NamedTuple):
    """Equations solved as one: ``tears`` were iterated on, ``order`` follows, and ``closing`` holds then.

    Each equation of ``closing`` comes with what selected it.
    """

    found: tuple[Known, ...]
    tears: tuple[str, ...]
    order: tuple[Direct, ...]
    closing: tuple[tuple[Equation, tuple[Guard, ...]], ...]


Link: TypeAlias = Direct | Together


@dataclass(frozen=True)
class Derivation(Shown):
    """Where the value of ``name`` comes from.

    ``inputs`` are the given values that it rests on, in the order of the sheet; ``assumed`` are symbols
    taken from the case that was solved; ``links`` are the steps in order of computation. Where there
    is no value, ``diagnoses`` say why.
    """

    model: Model
    name: str
    value: Value | None
    inputs: tuple[Known, ...] = ()
    assumed: tuple[Known, ...] = ()
    links: tuple[Link, ...] = ()
    diagnoses: tuple[Diagnosis, ...] = ()


def why(result: Result, name: str) -> Derivation:
    """The chain of rules from the inputs to one value of the primary answer.

    Only what that value needs is in it, the conditions that selected its rules included.
    Raises RuleSheetError for a name that the model does not have.
    """
    variable_named(name, result.model)
    if result[name] is None:
        about = tuple(diagnosis for diagnosis in result.diagnoses if name in diagnosis.variables)
        return Derivation(result.model, name, None, diagnoses=about or result.diagnoses)
    return _Tracing(result).derivation(name)


class _Tracing:
    """Goes back from one value to everything that it rests on."""

    def __init__(self, result: Result) -> None:
        self.model, self.inputs, self.origins = result.model, result.inputs, result.origins
        self.values: Mapping[str, Value] = result.solutions[0] if result.solutions else result.partial
        self.place: dict[Step, int] = {}
        for number, step in enumerate(result.path.steps):
            self.place.setdefault(step, number)

    def derivation(self, name: str) -> Derivation:
        needed: set[str] = set()
        waiting = [name]
        while waiting:
            one = waiting.pop()
            if one not in needed:
                needed.add(one)
                for equation in self._solved(self.origins.get(one)):
                    selecting = (self.model.conditions[premise.condition] for premise in equation.guard)
                    read = chain(equation.names, *map(names, selecting))
                    waiting.extend(name for name in read if name in self.values)
        steps = {step for n in needed if (step := self.origins.get(n)) is not None}
        given = [n for n in self.model.variables if n in needed and n not in self.origins]
        return Derivation(
            self.model,
            name,
            self.values[name],
            inputs=self._known(n for n in given if n in self.inputs),
            assumed=self._known(n for n in given if n not in self.inputs),
            links=tuple(self._link(step) for step in sorted(steps, key=self.place.__getitem__)),
        )

    def _known(self, read: Iterable[str]) -> tuple[Known, ...]:
        return tuple(Known(name, self.values[name]) for name in read)

    def _solved(self, step: Step | None) -> tuple[Equation, ...]:
        """The equations that a step solved: of several to select from, the first active at the answer."""
        if step is None:
            return ()
        decided = outcomes(self.model, self.values, self.inputs) if isinstance(step, Select) else {}
        first = (self.model.equations[index] for index in equations_of(step)[:1])
        return tuple(solved_by(self.model, step, decided) or first)

    def _link(self, step: Step) -> Link:
        if not isinstance(step, SolveBlock):
            assert isinstance(step, Evaluate | Select)
            return self._direct(self._solved(step)[0], step.unknown, step)
        equations = self.model.equations
        order = tuple(self._direct(equations[inner.equation], inner.unknown, step) for inner in step.order)
        closing = (equations[index] for index in (step.residuals if step.order else step.equations))
        closed = tuple((equation, self._guards(equation, step)) for equation in closing)
        return Together(self._known(step.unknowns), step.tears or step.unknowns, order, closed)

    def _direct(self, equation: Equation, unknown: str, step: Step) -> Direct:
        isolation = isolate(equation.left, equation.right, unknown)
        at = {name: self.values[name] for name in equation.names}
        form = None if isolation is None else explicit_form(isolation, at)
        numbers = {} if form is None else {name: self.values[name] for name in names(form)}
        found = Known(unknown, self.values[unknown])
        return Direct(found, equation, form, numbers, self._guards(equation, step))

    def _guards(self, equation: Equation, step: Step) -> tuple[Guard, ...]:
        """The conditions; assumed are those that what was known before the step does not decide."""
        guards = []
        for premise in equation.guard:
            condition = self.model.conditions[premise.condition]
            read = self._known(n for n in dict.fromkeys(names(condition)) if n in self.values)
            origins = {one.name: self.origins.get(one.name) for one in read}
            earlier = {
                n for n, origin in origins.items() if origin is None or self.place[origin] < self.place[step]
            }
            before = {one.name: one.value for one in read if one.name in earlier}
            assumed = premise.condition not in outcomes(self.model, before, self.inputs)
            guards.append(Guard(condition, premise.holds, assumed, read))
        return tuple(guards)


MARGIN = "    "


def why_text(derivation: Derivation) -> str:
    """The inputs, then the numbered steps, each with its rule and what selected it."""
    return "\n\n".join(Page(derivation, Plain()).parts())


def why_markdown(derivation: Derivation) -> str:
    """The same as a numbered list; mathematics between dollars, rules as code."""
    return "\n\n".join(Page(derivation, Tex(), markdown=True).parts())


def why_latex(derivation: Derivation) -> str:
    """Rows of an ``align*`` environment, the places of the rules in comments."""
    page, rows = Page(derivation, Tex()), []
    given = [page.line(known) for known in (*derivation.inputs, *derivation.assumed)]
    for line in (*given, *(line for link in derivation.links for line in page.lines(link))):
        row = f"  {line.left} &= {' = '.join(line.chain)}"
        if unit := line.unit.strip().translate(ESCAPED):
            row += rf"\ \text{{{unit}}}"
        if line.equation is not None:
            place = "  ".join(page.places.rule(line.equation))
            row = f"  % {'closes the block: ' * line.closing}{place}\n{row}"
        said = [rf"\text{{{word} }} {condition}" for word, condition, _ in page.guards(line.guards)]
        rows.append(row + " && " + r",\ ".join(said) if said else row)
    body = " \\\\\n".join(rows)
    return f"\\begin{{align*}}\n{body}\n\\end{{align*}}"


class Line(NamedTuple):
    """One equation of a step: ``left`` equals each of the ``chain``, the last in the ``unit``.

    ``closing``: a rule that an iteration has made hold. What the iteration itself gave has no ``equation``.
    """

    left: str
    chain: tuple[str, ...]
    unit: str = ""
    equation: Equation | None = None
    guards: tuple[Guard, ...] = ()
    closing: bool = False

    @property
    def formula(self) -> str:
        return " = ".join((self.left, *self.chain))


class Page:
    """One derivation in one notation, with the signs of Markdown where they are asked for."""

    def __init__(self, derivation: Derivation, notation: Notation, *, markdown: bool = False) -> None:
        self.derivation, self.notation, self.markdown = derivation, notation, markdown
        self.model = derivation.model
        self.places = Places(derivation.model)

    # --- the equations, alike in every form ---

    def head(self) -> str:
        """``vB = -41.46, from 7 inputs by 12 of 38 rules``, or that there is no value."""
        found = self.derivation
        if found.value is None:
            return f"{self.code(found.name)} has no value"
        whole = self.code(f"{found.name} = {Plain().value(found.value)}{self.unit(found)}")
        if any(known.name == found.name for known in found.inputs):
            return f"{whole} is an input"
        if any(known.name == found.name for known in found.assumed):
            return f"{whole} is what its case says"
        used = sum(1 if isinstance(link, Direct) else len(link.found) for link in found.links)
        inputs, rules = plural(len(found.inputs), "input"), plural(len(self.model.equations), "rule")
        return f"{whole}, from {inputs} by {used} of {rules}"

    def unit(self, known: Known | Derivation) -> str:
        """`` N``, or `` N = 2.25 lbf`` where it is shown in another unit than that of the rules."""
        variable = self.model.variables[known.name]
        unit = f" {variable.unit}" if variable.unit else ""
        if not variable.display_unit or not isinstance(known.value, float):
            return unit
        return f"{unit} = {Plain().value(shown(known.value, variable))} {variable.display_unit}"

    def lines(self, link: Link) -> Iterator[Line]:
        """The equations of a step: of a block what follows from tears, what closes it, and what it gave."""
        for one in (link,) if isinstance(link, Direct) else link.order:
            yield self.line(one.found, one.form, one.numbers, one.equation, one.guards)
        if isinstance(link, Direct):
            return
        for equation, guards in link.closing:
            left, right = map(self.notation.expression, (equation.left, equation.right))
            yield Line(left, (right,), "", equation, guards, closing=True)
        explicit = {inner.found.name for inner in link.order}
        yield from (self.line(known) for known in link.found if known.name not in explicit)

    def line(
        self, known: Known, form: Expression | None = None, numbers: Mapping[str, Value] = {}, *rule: Any
    ) -> Line:
        """The form, the form with numbers, the value; each said once."""
        chain = [self.notation.value(known.value)]
        if form is not None:
            chain = [self.notation.expression(form), self.notation.filled(form, numbers), *chain]
        name = self.notation.expression(Name(known.name))
        return Line(name, tuple(dict.fromkeys(chain)), self.unit(known), *rule)

    def guards(
        self, guards: Sequence[Guard], notation: Notation | None = None
    ) -> Iterator[tuple[str, str, str]]:
        """``because``, the conditions, and the values that they were read at; likewise what was assumed."""
        for word, assumed in (("because", False), ("assuming", True)):
            group = [guard for guard in guards if guard.assumed is assumed]
            if group:
                outcomes = [(guard.condition, guard.holds) for guard in group]
                known = dict.fromkeys(known for guard in group for known in guard.read)
                read = ", ".join(f"{one.name} = {Plain().value(one.value)}" for one in known)
                said = (notation or self.notation).conditions(outcomes)
                yield word, said, "" if read == Plain().conditions(outcomes) else read

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
        """A text of the sheet as it stands."""
        return code_span(text) if self.markdown else text

    def _plain(self, text: str) -> str:
        """Words of a sheet as themselves in Markdown: no emphasis, no links, no HTML."""
        return _SPECIAL.sub(r"\\\1", text) if self.markdown else text

    def _formula(self, line: Line) -> str:
        return f"${line.formula}${self._plain(line.unit)}" if self.markdown else line.formula + line.unit

    def known(self, known: Known) -> str:
        """``AO = 3 mm``, in Markdown between dollars, else as in a sheet."""
        if self.markdown:
            return self._formula(self.line(known))
        return f"{known.name} = {Plain().value(known.value)}{self.unit(known)}"

    def _table(self, knowns: Iterable[Known]) -> str:
        rows = [(self.known(known), self.model.variables[known.name].comment) for known in knowns]
        if not self.markdown:
            return columns((MARGIN + known, comment) for known, comment in rows)
        return "\n".join(f"- {known}" + f": {self._plain(said)}" * bool(said) for known, said in rows)

    def _steps(self, links: Sequence[Link]) -> Iterator[str]:
        for number, link in enumerate(links, 1):
            bullet = f"{number}. " if self.markdown else f"{number:>{len(str(len(links)))}}  "
            lines, dash, indent = list[str](), "", ""
            if isinstance(link, Together):
                lines = self._heading(link)
                dash, indent = ("- ", "  ") if self.markdown else (MARGIN, MARGIN)
            for line in self.lines(link):
                first, *rest = self._told(line, len(bullet) + len(dash))
                lines += [dash + first, *(indent + more for more in rest)]
            yield bullet + lines[0]
            yield from (" " * len(bullet) + line if line else "" for line in lines[1:])

    def _told(self, line: Line, used: int) -> list[str]:
        """An equation with its rule, and what selected that; ``used`` columns stand before it."""
        word = "such that " if line.closing else "" if line.equation else "which gives "
        formula, told = [word + self._formula(line)], []
        if line.equation is not None:
            place, rule = self.places.rule(line.equation)
            told.append(f"{self.code(rule)} ({self._plain(place)})" if self.markdown else f"{place}  {rule}")
        for word_of_it, condition, read in self.guards(line.guards):
            said, gap = (f"${condition}$", " ") if self.markdown else (condition, "   ")
            told.append(f"{word_of_it} {said}" + f"{gap}({self.code(read)})" * bool(read))
        if self.markdown:
            return [*(f"{line}  " for line in (*formula, *told)[:-1]), (*formula, *told)[-1]]
        room = SCREEN.get().width
        if room is not None and len(formula[0]) > room - used:  # each equal on a line of its own
            first, *others = line.chain
            start = f"{word}{line.left}"
            formula = [f"{start} = {first}", *(f"{' ' * len(start)} = {other}" for other in others)]
            formula[-1] += line.unit
        return [*formula, *(MARGIN + line for line in told)]

    def _heading(self, link: Together) -> list[str]:
        """What a block gives, and what was iterated on."""
        found = [known.name for known in link.found]
        maths = {
            n: f"${self.notation.expression(Name(n))}$" if self.markdown else n for n in (*found, *link.tears)
        }
        how = "by iteration"
        if len(found) > 1:
            how = f"together, iterating on {', '.join(maths[name] for name in link.tears)}"
        names = ", ".join(maths[name] for name in found)
        return [f"{names} {how}:", ""] if self.markdown else [f"{names}: {how}"]


ESCAPED = str.maketrans(
    {**{mark: f"\\{mark}" for mark in "%_#&${}"}, "\\": r"\textbackslash{}", "^": r"\^{}", "~": r"\~{}"}
)
_SPECIAL = re.compile(r"([\\`*_\[\]<>|$~&])")


def code_span(text: str) -> str:
    """A code span of Markdown, between more backticks than there are in the text."""
    fence = "`" * (1 + max(map(len, re.findall("`+", text)), default=0))
    pad = " " if text.startswith("`") or text.endswith("`") else ""
    return f"{fence}{pad}{text}{pad}{fence}"
