"""A solution path as a value: the steps in order, before any number is known."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from importlib import import_module
from math import inf, prod
from typing import Any, NamedTuple, TypeAlias

from rulesheets.functions import TABLE
from rulesheets.model import Equation, Model, Requirement, Values
from rulesheets.syntax.nodes import Expression, Name, Number, call, is_number, substitute


class Shown:
    """Displayed by the report, a higher room imported by name: by ``print`` as the command shows
    it, in a notebook as HTML and LaTeX."""

    __slots__ = ()

    def __str__(self) -> str:
        report: Any = import_module("solver.report.html")
        return str(report.text(self))

    def _repr_html_(self) -> str:
        report: Any = import_module("solver.report.html")
        return str(report.html(self))

    def _repr_latex_(self) -> str | None:
        report: Any = import_module("solver.report.html")
        return report.latex(self) or None


class Evaluate(NamedTuple):
    """Solve one equation for one unknown by isolation; ``branches`` is how many preimages it can
    have."""

    equation: int
    unknown: str
    branches: int = 1


class Select(NamedTuple):
    """Solve for ``unknown`` by whichever of the guarded ``equations`` is active."""

    equations: tuple[int, ...]
    unknown: str
    branches: int = 1


class SolveBlock(NamedTuple):
    """Solve ``equations`` simultaneously for as many ``unknowns``.

    ``tears`` are iterated on; ``order`` lists the explicit steps that follow from them and
    ``residuals`` the equations that close the block. ``others`` are tearings to try if this one
    does not determine the number of answers.
    """

    equations: tuple[int, ...]
    unknowns: tuple[str, ...]
    tears: tuple[str, ...]
    order: tuple[Evaluate, ...] = ()
    residuals: tuple[int, ...] = ()
    others: tuple[SolveBlock, ...] = ()


class Decide(NamedTuple):
    """Evaluate conditions whose variables are known; the rest of the path depends on them."""

    conditions: tuple[int, ...]


class Assume(NamedTuple):
    """Solve case by case on a condition of an unknown; an answer is kept if it fits its case."""

    condition: int

    @property
    def conditions(self) -> tuple[int, ...]:
        return (self.condition,)


class Check(NamedTuple):
    """Evaluate an equation all of whose variables are known: a redundant rule."""

    equation: int


Step: TypeAlias = Evaluate | Select | SolveBlock | Decide | Assume | Check


def equations_of(step: Step) -> tuple[int, ...]:
    match step:
        case Evaluate(equation=equation) | Check(equation=equation):
            return (equation,)
        case Select(equations=equations) | SolveBlock(equations=equations):
            return equations
        case _:
            return ()


def given_by(step: Step) -> tuple[str, ...]:
    match step:
        case Evaluate(unknown=unknown) | Select(unknown=unknown):
            return (unknown,)
        case SolveBlock(unknowns=unknowns):
            return unknowns
        case _:
            return ()


def activity(equation: Equation | Requirement, decided: Mapping[int, bool]) -> bool | None:
    """True: active (a requirement: checked); False: its guard is false; None: not known yet."""
    verdict: bool | None = True
    for premise in equation.guard:
        outcome = decided.get(premise.condition)
        if outcome is None:
            verdict = None
        elif outcome is not premise.holds:
            return False
    return verdict


def known_rules(model: Model, decided: Mapping[int, bool], values: Values) -> Iterator[Equation]:
    """The rules that are active at these outcomes, and all of whose variables are known."""
    blank = model.variables.keys() - values.keys()
    for equation in model.equations:
        if activity(equation, decided) and (not blank or blank.isdisjoint(equation.names)):
            yield equation


def solved_by(model: Model, step: Step, decided: Mapping[int, bool]) -> list[Equation]:
    """The rules that a step solves: of several to select from, the first active one."""
    rules = [model.equations[index] for index in equations_of(step)] if given_by(step) else []
    return (
        [rule for rule in rules if activity(rule, decided)][:1]
        if isinstance(step, Select)
        else rules
    )


@dataclass(frozen=True, slots=True)
class Path(Shown):
    """Steps in order; a path that ends in ``Decide`` or ``Assume`` continues once the outcome is
    known.

    ``undetermined`` are the unknowns that no step reaches.
    """

    steps: tuple[Step, ...]
    undetermined: tuple[str, ...] = ()

    @property
    def branches(self) -> int:
        """The number of answers that the direct steps can fork into."""
        return prod(step.branches for step in self.steps if isinstance(step, Evaluate | Select))


# --- one rule solved for an unknown, and a block by formula ---

TARGET = Name("#")
"""Stands for the target of a stage in its forms."""


class Stage(NamedTuple):
    """Undo one operation: the preimages of the target ``#`` are the ``forms``, principal first.

    The target must lie between ``low`` and ``high`` (the image of ``operation``), and ``divisor``,
    if there is one, must not vanish (for a root that is the exponent). ``period`` is that of the
    operation in its argument.
    """

    operation: str
    forms: tuple[Expression, ...]
    low: float = -inf
    high: float = inf
    low_open: bool = False
    high_open: bool = False
    divisor: Expression | None = None
    period: float | None = None

    @property
    def divides(self) -> bool:
        """Whether it divides by something that may vanish."""
        return self.divisor is not None and (
            is_number(self.divisor, 0.0) or not isinstance(self.divisor, Number)
        )


class Quadratic(NamedTuple):
    """``c + b*x + a*x^2 = 0`` with coefficients free of the unknown, for an unknown that occurs
    twice."""

    c: Expression
    b: Expression
    a: Expression


class Isolation(NamedTuple):
    """``unknown`` from ``start`` through ``stages`` (or by ``quadratic``).

    ``cost``: 0 one preimage, always defined; 1 one preimage, but a divisor may vanish or the target
    may leave the image; n ≥ 2 n preimages. ``verify``: preimages may be extraneous and must be
    checked in the equation. ``common``: the equation was solved for a part that holds the unknown
    several times, so it may still depend on the unknown where the formula is 0/0.
    """

    unknown: str
    start: Expression
    stages: tuple[Stage, ...]
    cost: int
    branches: int = 1
    verify: bool = False
    quadratic: Quadratic | None = None
    common: bool = False

    @property
    def identity(self) -> bool:
        """Whether the unknown simply takes the value of the other side."""
        return not self.stages and self.quadratic is None

    @property
    def period(self) -> float | None:
        return next((stage.period for stage in self.stages if stage.period), None)

    @property
    def proven(self) -> bool:
        """Whether there are no other preimages: for a registered function this is its author's
        claim."""
        rows = (TABLE.get(stage.operation) for stage in self.stages)
        return all(row is None or row.source is None for row in rows)

    def renamed(self, names: Mapping[str, str]) -> Isolation:
        """The isolation for a rule that differs only in these names."""
        other = {name: Name(told) for name, told in names.items()}
        stages = (
            stage._replace(
                forms=tuple([substitute(form, other) for form in stage.forms]),
                divisor=None if stage.divisor is None else substitute(stage.divisor, other),
            )
            for stage in self.stages
        )
        quadratic = self.quadratic and Quadratic(
            *[substitute(part, other) for part in self.quadratic]
        )
        start, unknown = substitute(self.start, other), names[self.unknown]
        return self._replace(
            unknown=unknown, start=start, stages=tuple(stages), quadratic=quadratic
        )

    def forms(self) -> tuple[Expression, ...]:
        """Explicit forms of the unknown, principal first; the quadratic by its formula."""
        if self.quadratic is not None:
            a, b, c = self.quadratic.a, self.quadratic.b, self.quadratic.c
            root = call("sqrt", b**2.0 - 4.0 * (a * c))
            return (-b + root) / (2.0 * a), (-b + -root) / (2.0 * a)
        forms: tuple[Expression, ...] = (self.start,)
        for stage in self.stages:
            forms = tuple(
                substitute(form, {TARGET.name: target}) for target in forms for form in stage.forms
            )
        return forms


class Let(NamedTuple):
    """``name := expression``. A ``divisor`` must not vanish, and a root (any other with a ``size``,
    the sum of its terms' sizes) must not be negative."""

    name: str
    expression: Expression
    divisor: bool = False
    size: Expression | None = None


class Coefficient(NamedTuple):
    """A known number; ``size`` is the sum of its terms' sizes, a scale for its rounding."""

    expression: Expression
    size: Expression


class Parabola(NamedTuple):
    """``name`` is a root of ``a x² + b x + c``: two values, one, or none."""

    name: str
    a: Coefficient
    b: Coefficient
    c: Coefficient


class Circle(NamedTuple):
    """Intersections of a line ``a x + b y = k`` and ``x² + y² = square``: two values, or none."""

    x: str
    y: str
    a: Coefficient
    b: Coefficient
    k: Coefficient
    square: Coefficient


Formula = Let | Parabola | Circle


ClosedForm: TypeAlias = tuple[Formula, ...]
"""Formulas in order; they end with every unknown."""
