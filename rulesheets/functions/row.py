"""A row of the table of functions: everything that is known about one function of the language.

A facet that is missing costs only the features that need it. Facets from a library are given by
their name there, or as a function of the library and the arguments, so that no row imports it:
``digits="erfc"`` is ``mpmath``'s, ``sympy=lambda s, x: s.sin(s.pi * x / 180)`` is built from
sympy's.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import cache, partial
from math import inf
from typing import Any, NamedTuple, TypeAlias

from rulesheets.functions.intervals import EPSILON
from rulesheets.syntax.nodes import Expression, Name, call

Branches: TypeAlias = Callable[[Expression], tuple[Expression, ...]]
Slopes: TypeAlias = Callable[..., Expression | tuple[Expression | None, ...]]
SLOPE = "D"
"""Before the place of an argument, the name of a slope by differences: no other has capitals."""
Facet: TypeAlias = str | Callable[..., Any] | None


class Inverse(NamedTuple):
    """The solutions of ``f(x) = t`` for ``x``.

    ``branches(t)`` lists every solution within one ``period`` of x (all of them if ``period`` is
    None), the principal one first. They are solutions for every ``t`` in the image, the interval
    from ``low`` to ``high`` without the ends that are marked open.
    """

    branches: Branches
    low: float = -inf
    high: float = inf
    low_open: bool = False
    high_open: bool = False
    period: float | None = None


@dataclass(frozen=True, eq=False, kw_only=True)
class Function:
    """What the language knows about a function.

    ``arguments`` is how messages call them: ``"y, x"``, ``""`` for a constant, ``"a, b, …"`` for
    any number. ``meaning`` says what it is, ``example`` is a rule that holds.

    Forms, each of the same arguments in another kind of number:

    - ``value``: floats. Raises ValueError, ZeroDivisionError or OverflowError where there is none.
    - ``array``: numpy and arrays that broadcast, nan or infinite outside the domain; a name may be
      one of scipy, such as ``special.erf``. Missing there: ``value``, number by number.
    - ``interval``: the two ends of every argument in turn to the two ends of the result, as
      :mod:`rulesheets.functions.intervals` has it. Missing: nothing is known of the range, nothing
      proven.
    - ``digits``: a context of mpmath and its numbers. Missing: floats are all there is.
    - ``ball``: ``arb`` of python-flint and balls. Missing: nothing is proven in many digits.
    - ``sympy``: sympy and its expressions. Missing: an undefined function of this name.
    - ``definition``: trees, by other functions; the form in digits, balls or sympy where that is
      missing.

    ``slopes(*arguments)`` are the partial derivatives as trees (one need not be a tuple), None for
    one without a formula, which differences stand in for. At a jump or a kink they are those of
    one side. ``inverse`` is there for functions of one argument that formulas undo.

    Traits: ``domain`` is the closed hull of where a function of one argument is defined; ``ulps``
    by how many units in the last place ``value`` may be off; ``smooth`` is False for a function
    with kinks or jumps; ``jumps``: it jumps at points that depend on its arguments, and ``steady``
    tells of balls whether it does not there; ``nonzero``: it is 0 only where floats lose it;
    ``turn``: the full turn of its argument, an angle, ``half_turn``: half of that makes no
    difference to it; ``swings``: it goes through 0 again and again as its last argument grows,
    though not periodically; ``angle``: the full turn of its result, an angle; ``alike``: its
    arguments have one unit, whatever it is, ``keeps_unit``: which its result has, too; ``source``:
    the file that registered it, None for a function of the language.
    """

    name: str
    value: Callable[..., float]
    arguments: str = "x"
    meaning: str = ""
    example: str = ""
    slopes: Slopes | None = None
    inverse: Inverse | None = None
    array: Facet = None
    interval: Callable[..., tuple[float, float]] | None = None
    digits: Facet = None
    ball: Facet = None
    sympy: Facet = None
    definition: Callable[..., Expression] | None = None
    domain: tuple[float, float] = (-inf, inf)
    ulps: float = 1.0
    smooth: bool = True
    jumps: bool = False
    steady: Callable[..., bool] | None = None
    nonzero: bool = False
    turn: float | None = None
    half_turn: bool = False
    swings: bool = False
    angle: float | None = None
    alike: bool = False
    keeps_unit: bool = False
    source: str | None = None

    @property
    def arity(self) -> tuple[int, int | None]:
        """The least and the greatest number of arguments (None: any number)."""
        if self.arguments.endswith("…"):
            return 1, None
        count = len(self.arguments.split(",")) if self.arguments else 0
        return count, count

    @property
    def usage(self) -> str:
        """The function with its arguments, as it is written."""
        return self.name if self.name == "pi" else f"{self.name}({self.arguments})"

    @property
    def direction(self) -> bool:
        """Whether it is the direction of a point (x, y), which jumps at negative x."""
        return self.angle is not None and self.arguments == "y, x"

    @property
    def in_degrees(self) -> bool:
        """Whether its argument or its result is an angle in degrees."""
        return 360.0 in (self.turn, self.angle)

    @property
    def sine_and_cosine(self) -> tuple[str, str]:
        """The sine and the cosine of angles in its own unit."""
        return ("sind", "cosd") if self.in_degrees else ("sin", "cos")

    def accepts(self, count: int) -> bool:
        """Whether the function can be called with ``count`` arguments."""
        least, most = self.arity
        return least <= count and (most is None or count <= most)

    def form(
        self, facet: str, library: Any, evaluate: Callable[[Expression, dict[str, Any]], Any]
    ) -> Callable[..., Any] | None:
        """The form of a library, or the definition evaluated by ``evaluate`` over the arguments,
        which are named by their places; None if there is neither."""

        def defined(*arguments: Any) -> Any:
            assert self.definition is not None
            places = {str(place): argument for place, argument in enumerate(arguments)}
            return evaluate(self.definition(*map(Name, places)), places)

        match getattr(self, facet):
            case None:
                return None if self.definition is None else defined
            case str() as name:
                found: Callable[..., Any] = getattr(library, name)
                return found
            case form:
                return partial(form, library)

    def partials(self, arguments: tuple[Expression, ...]) -> tuple[Expression, ...]:
        """The partial derivatives by every argument; without a formula those by differences."""
        found = (None,) * len(arguments) if self.slopes is None else self.slopes(*arguments)
        return tuple(
            call(f"{self.name}{SLOPE}{place}", *arguments) if slope is None else slope
            for place, slope in enumerate(found if isinstance(found, tuple) else (found,))
        )


class Functions(dict[str, Function]):
    """Rows by name, and those of slopes by differences, which are no functions of the language."""

    def __missing__(self, name: str) -> Function:
        of, by, place = name.rpartition(SLOPE)
        if not by:
            raise KeyError(name)
        return by_differences(self[of], int(place))


class Forms(Mapping[str, Callable[..., Any]]):
    """One facet of every row of a table, by name; ``make`` turns a row into it on first use."""

    def __init__(
        self, table: Mapping[str, Function], make: Callable[[Function], Callable[..., Any]]
    ) -> None:
        self._table, self._made = table, cache(make)

    def __getitem__(self, name: str) -> Callable[..., Any]:
        return self._made(self._table[name])

    def __iter__(self) -> Iterator[str]:
        return iter(self._table)

    def __len__(self) -> int:
        return len(self._table)


# --- what rows are written with ---


def entry(name: str, meaning: str, example: str, **facets: Any) -> Function:
    """A row; its forms in the libraries have the same name unless given otherwise or defined."""
    named = ("array",) if "definition" in facets else ("array", "digits", "ball", "sympy")
    bounded = getattr(facets.get("interval"), "domain", (-inf, inf))
    facets = dict.fromkeys(named, name) | {"domain": bounded} | facets
    return Function(name=name, meaning=meaning, example=example, **facets)


def by(name: str) -> Branches:
    return lambda t: (call(name, t),)


def both_signs(name: str) -> Branches:
    return lambda t: (call(name, t), -call(name, t))


# --- slopes by differences ------------------------------------------------------

STEP = 1e-3
"""The relative step of differences: about the fifth root of the rounding of floats."""
TOLD = 1e-3
"""The relative error beyond which a slope by differences is rejected."""
UNSURE = EPSILON**-0.5
"""The units in the last place by which a slope that is no formula may be off."""


@cache
def by_differences(row: Function, place: int) -> Function:
    """The slope of a function by the argument at a ``place``."""

    def value(*arguments: float) -> float:
        slope, wrong = slope_by_differences(row.value, place, arguments)
        scale = abs(row.value(*arguments)) / (abs(arguments[place]) or 1.0)
        if not wrong <= TOLD * max(abs(slope), scale):
            raise ValueError("finite differences give no slope there")
        return slope

    name = f"{row.name}{SLOPE}{place}"
    return Function(name=name, value=value, arguments=row.arguments, ulps=UNSURE, source=row.source)


def slope_by_differences(
    value: Callable[..., float], place: int, arguments: tuple[float, ...]
) -> tuple[float, float]:
    """The partial derivative by the argument at ``place``, and a bound of its error.

    Central differences of two steps, extrapolated (L. F. Richardson 1911), one-sided ones at the
    end of the domain; the error is what the extrapolation changes, and the rounding of ``value``.
    Raises ValueError or an ArithmeticError where the function is not defined on either side.
    """
    x = arguments[place]
    step = STEP * (abs(x) or 1.0)

    def at(shift: float) -> float:
        return value(*arguments[:place], x + shift, *arguments[place + 1 :])

    def central(h: float) -> float:
        return (at(h) - at(-h)) / (2.0 * h)

    def forward(h: float) -> float:
        return (4.0 * at(h) - at(2.0 * h) - 3.0 * at(0.0)) / (2.0 * h)

    rounding = 16.0 * EPSILON * abs(at(0.0)) / step
    for difference, h in ((central, step), (forward, step), (forward, -step)):
        try:
            coarse, fine = difference(h), difference(0.5 * h)
        except (ArithmeticError, ValueError):
            continue
        better = fine + (fine - coarse) / 3.0
        return better, abs(fine - coarse) + rounding
    raise ValueError("the function is not defined beside this point")
