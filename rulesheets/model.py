"""A model: variables and guarded equations, ready to be solved for any of them."""

from __future__ import annotations

from collections.abc import Callable, Container, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property, wraps
from importlib import import_module
from math import inf
from typing import NamedTuple, TypeVar

from rulesheets.diagnosis import Diagnosis, plural
from rulesheets.library import Library, Unit, library
from rulesheets.syntax import Span, nodes
from rulesheets.syntax.nodes import Row as Row
from rulesheets.syntax.nodes import Value as Value
from rulesheets.syntax.nodes import Values as Values

T = TypeVar("T")
Owner = TypeVar("Owner", bound="Model | Equation")


class Tolerance(NamedTuple):
    """How far an input may be from its value, either way; in ``percent`` of the value or not."""

    size: float
    percent: bool = False

    def around(self, value: float) -> float:
        """The tolerance of this value, in its own unit."""
        return abs(value) * self.size / 100.0 if self.percent else self.size


@dataclass(frozen=True, slots=True)
class Variable:
    """A variable of a model, in calculation units.

    Locals of a call have dotted names (``position.yB``, second call ``position#2.yB``). ``posted``:
    the variable has a row, because the variables section or a rule of the sheet itself names it.
    The status of a solve is judged by these. ``passed``: only calls use it, one as its result and
    another as its argument: where it becomes infinite (the slope of a vertical line), it stays
    blank. ``units`` tell what its units mean; a ``difference`` of temperatures is converted without
    their zero.
    """

    name: str
    value: Value | None = None
    guess: float | None = None
    unit: str | None = None
    display_unit: str | None = None
    low: float = -inf
    high: float = inf
    low_open: bool = False
    high_open: bool = False
    comment: str = ""
    posted: bool = False
    passed: bool = False
    span: Span | None = field(default=None, compare=False, repr=False)
    tolerance: Tolerance | None = None
    units: Library = field(default=library(), compare=False, repr=False)
    difference: bool = False

    @property
    def shown_unit(self) -> str:
        """The unit in which it is shown, empty for none."""
        return self.display_unit or self.unit or ""

    @property
    def measure(self) -> Unit | None:
        """Its unit with its definition."""
        return self.units.unit(self.unit) if self.unit else None

    @property
    def ranged(self) -> bool:
        """Whether the sheet gives it a range, with one end or two."""
        return self.low > -inf or self.high < inf

    def admits(self, number: float) -> bool:
        """Whether a number lies in the range of the variable."""
        above = number > self.low if self.low_open else number >= self.low
        below = number < self.high if self.high_open else number <= self.high
        return above and below

    def nearest(self, number: float) -> float:
        """The number, or the end of the range that it lies beyond, if the range has that end."""
        if number < self.low and not self.low_open:
            return self.low
        return self.high if number > self.high and not self.high_open else number

    def distance(self, number: float) -> float:
        """How far a number lies beyond an end of the range."""
        return max(self.low - number, number - self.high, 0.0)


class Premise(NamedTuple):
    """A condition of the model (by index), with the outcome that makes an equation active."""

    condition: int
    holds: bool


@dataclass(unsafe_hash=True)
class Equation:
    """``left = right`` if every premise of ``guard`` is satisfied.

    ``rule`` is the place of the whole rule as the user wrote it (with its ``if``); ``scope`` is the
    prefix of the call that it belongs to (``""`` on the sheet itself).
    """

    index: int
    left: nodes.Expression
    right: nodes.Expression
    guard: tuple[Premise, ...]
    rule: Span
    scope: str = ""

    @property
    def sides(self) -> tuple[nodes.Expression, nodes.Expression]:
        return self.left, self.right

    @property
    def definitions(self) -> Iterator[tuple[str, nodes.Expression]]:
        """A side that is a single name, with the other, which does not read it: ``y = sin(x)``."""
        for side, other in (self.sides, self.sides[::-1]):
            if isinstance(side, nodes.Name) and side.name not in nodes.names(other):
                yield side.name, other

    @property
    def form(self) -> nodes.Expression:
        """``left - right``, which vanishes where the equation holds."""
        return nodes.subtract(self.left, self.right)

    def but(self, left: nodes.Expression, right: nodes.Expression) -> Equation:
        """The same with other sides."""
        return replace(self, left=left, right=right)

    def __getstate__(self) -> dict[str, object]:
        """Pickled with its names, without results of solves."""
        return {name: self.__dict__[name] for name in self.__match_args__} | {"names": self.names}

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Variables of the two sides in order of first appearance, guards not included."""
        return tuple(dict.fromkeys(nodes.names(*self.sides)))


class Requirement(NamedTuple):
    """A comparison that answers must satisfy if every premise of ``guard`` is satisfied.

    It determines nothing. ``rule`` is the place of the rule, or of the range, that states it.
    """

    comparison: nodes.Comparison
    guard: tuple[Premise, ...]
    rule: Span
    scope: str = ""

    @property
    def names(self) -> tuple[str, ...]:
        """Variables of the comparison in order of first appearance, guards not included."""
        return tuple(dict.fromkeys(nodes.names(self.comparison)))


@dataclass(frozen=True)
class Model:
    """Variables (in the order of the sheet, then locals in order of appearance) and equations.

    ``conditions[k]`` is the condition that ``Premise(k, …)`` refers to; an ``else`` arm shares its
    condition with the ``then`` arm. All names are full names. ``figures`` define what can be drawn
    of an answer, ``files`` are the paths that the model was read from, ``python`` those of the
    Python files that it needs, ``notes`` are remarks that are not mistakes. ``limits``: rules that
    are 0/0 at an answer are taken by their limits. ``units`` are the sheet's definitions.
    """

    name: str
    variables: Mapping[str, Variable]
    equations: tuple[Equation, ...]
    conditions: tuple[nodes.Condition, ...]
    figures: tuple[nodes.Figure, ...] = ()
    requirements: tuple[Requirement, ...] = ()
    limits: bool = False
    notes: tuple[Diagnosis, ...] = field(default=(), compare=False, repr=False)
    files: tuple[str, ...] = field(default=(), compare=False, repr=False)
    python: tuple[str, ...] = field(default=(), compare=False, repr=False)
    units: Library = field(default=library(), compare=False, repr=False)

    def outcomes(self, guard: Iterable[Premise]) -> list[tuple[nodes.Condition, bool]]:
        """The conditions of a guard, each with its required outcome."""
        return [(self.conditions[premise.condition], premise.holds) for premise in guard]

    def __repr__(self) -> str:
        size = plural(len(self.variables), "variable"), plural(len(self.equations), "equation")
        return f"<Model {self.name}: {', '.join(size)}>"

    def _repr_html_(self) -> str:
        # by name: what shows a model stands above it
        html: str = import_module("rulesheets.algebra").model_html(self)
        return html

    def _repr_latex_(self) -> str:
        latex: str = import_module("rulesheets.algebra").listing(self, latex=True)
        return latex

    @cached_property
    def unit_warnings(self) -> tuple[Diagnosis, ...]:
        """The certain mismatches of units in its rules (``check_units``)."""
        check = import_module("rulesheets.units.check")
        found: tuple[Diagnosis, ...] = check.check_units(self, sure=True)
        return found

    def __getstate__(self) -> dict[str, object]:
        """Pickled without results of solves, such as compiled code."""
        kept = (*self.__match_args__, "unit_warnings")
        return {name: self.__dict__[name] for name in kept if name in self.__dict__}


def once(make: Callable[[Owner], T]) -> Callable[[Owner], T]:
    """A function of a model or equation, computed once and stored on it by its name."""

    @wraps(make)
    def found(owner: Owner) -> T:
        if make.__name__ not in owner.__dict__:
            owner.__dict__[make.__name__] = make(owner)
        kept: T = owner.__dict__[make.__name__]
        return kept

    return found


def reached(
    roots: Iterable[T], following: Callable[[T], Iterable[T]], known: Container[T] = ()
) -> set[T]:
    """All that the roots lead to, these included, except what is known."""
    found, waiting = set[T](), list(roots)
    while waiting:
        one = waiting.pop()
        if one not in found and one not in known:
            found.add(one)
            waiting.extend(following(one))
    return found


def expect(kind: type, given: object, source: str = "rulesheets.load") -> None:
    """Raises TypeError for an argument of another type, with the call that gives one."""
    if not isinstance(given, kind):
        needed, found = f"a {kind.__name__} is needed, which {source} gives", type(given).__name__
        raise TypeError(f"{needed}, and this is of the type {found}")
