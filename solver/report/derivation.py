"""Why a number is what it is: the chain of rules from the inputs to it, and nothing besides."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from itertools import chain
from sys import float_info
from typing import NamedTuple, TypeAlias

from rulesheets.diagnosis import Diagnosis
from rulesheets.evaluate import Undefined, value
from rulesheets.inputs import variable_named
from rulesheets.model import Equation, Model, Value
from rulesheets.syntax.nodes import (
    Condition,
    Expression,
    Number,
    add,
    call,
    multiply,
    names,
    substitute,
    subtract,
)
from solver.path import Evaluate, Select, Shown, SolveBlock, Step, equations_of
from solver.path.cases import activity, outcomes
from solver.path.isolate import TARGET, Isolation, isolate
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
        (turned,) = _through(isolation, (add(inside, Number(period)),), at + 1, None)[:1]
        stride = _value(turned, known) - _value(plain, known)
        if not math.isfinite(stride) or stride == 0.0:
            continue
        turns = round((answer - _value(plain, known)) / stride)
        whole: Expression = Number(abs(turns) * period)
        halves = round(period / math.pi)
        if math.isclose(period, halves * math.pi, rel_tol=1e-12):  # in radians: multiples of pi
            whole = multiply(Number(float(abs(turns) * halves)), call("pi"))
        moved = add(inside, whole) if turns >= 0 else subtract(inside, whole)
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
        if not isinstance(step, Evaluate | Select | SolveBlock):
            return ()
        equations = tuple(self.model.equations[index] for index in equations_of(step))
        if not isinstance(step, Select):
            return equations
        decided = outcomes(self.model, self.values, self.inputs)
        return (next((e for e in equations if activity(e, decided)), equations[0]),)

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
