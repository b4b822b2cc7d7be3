"""What a solve found out, in numbers of equations and names of variables; no sentences yet."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from enum import Enum
from typing import NamedTuple, TypeAlias

from rulesheets.diagnosis import Diagnosis, suggestion
from rulesheets.model import Value
from rulesheets.syntax.nodes import Comparison

FALSE = 1e-6
"""A relative error beyond which what is called an answer is a false one (or a thousand tolerances)."""


class Status(Enum):
    """The outcome of a solve; ``str(status)`` is the word of the contract."""

    SOLVED = "solved"
    PARTIAL = "partial"
    INCONSISTENT = "inconsistent"
    INFEASIBLE = "infeasible"
    SINGULAR = "singular"
    FAILED = "failed"

    def __str__(self) -> str:
        return self.value

    @property
    def exit_code(self) -> int:
        """That of the command: 0 where it is solved."""
        return 0 if self is Status.SOLVED else 1


class Unsolved(Exception):
    """There is no answer. ``status`` says why in a word, ``diagnoses`` in sentences, found when asked for."""

    def __init__(
        self, status: Status, diagnoses: tuple[Diagnosis, ...] | Callable[[], tuple[Diagnosis, ...]]
    ) -> None:
        super().__init__(status)
        self.status, self._diagnoses = status, diagnoses

    @property
    def diagnoses(self) -> tuple[Diagnosis, ...]:
        if callable(self._diagnoses):
            self._diagnoses = self._diagnoses()
        return self._diagnoses

    def __str__(self) -> str:
        return f"{self.status}: " + "; ".join(d.message for d in self.diagnoses)


class UnknownName(KeyError):
    """A name that is not there. ``str`` is a sentence with the name that may be meant."""

    def __init__(self, name: object, known: Collection[str]) -> None:
        super().__init__(name)
        self.known = known  # as it is: a table asks for many names that have no value

    def __str__(self) -> str:
        name = self.args[0]
        meant = suggestion(name, self.known) if isinstance(name, str) else ()
        return f"there is no variable {name}" + (f": {meant[0]}" if meant else "")


class NoValue(NamedTuple):
    """Solving ``equation`` for ``unknown`` needs what can't be: ``reading`` says it (``cosd = 1.08``).

    ``pole``: the unknown would have to be infinite (a product with 0 that is not 0).
    """

    equation: int
    unknown: str
    reading: str
    pole: bool = False


class Indeterminacy(NamedTuple):
    """At ``values`` the rule of ``equation`` is of the ``form`` 0/0, and has no value.

    ``limit`` is the two-sided limit of its part that is, None where there is none; ``is_open``: it depends on
    what has no value.
    """

    equation: int
    form: str
    limit: float | None
    is_open: bool
    values: Mapping[str, Value] = {}


class Fixed(NamedTuple):
    """By ``equations`` the given ``name`` would be ``value``, whatever ``unknown`` is, and not ``given``."""

    name: str
    value: float
    given: float
    unknown: str
    equations: tuple[int, ...]


class Filled(NamedTuple):
    """``equation`` has no value at an answer, and was taken by its ``limit``."""

    equation: int
    limit: float


class AsksNothing(NamedTuple):
    """At these values ``equation`` holds whatever ``unknown`` is."""

    equation: int
    unknown: str


class OutOfRange(NamedTuple):
    """``equation`` gives ``unknown`` a value outside the range that the sheet declares for it."""

    equation: int
    unknown: str
    value: float


class Conflict(NamedTuple):
    """Rules that can't hold together: ``equation`` misses by ``miss`` (left minus right)."""

    equations: tuple[int, ...]
    miss: float | None
    values: Mapping[str, Value] = {}


class NoRoot(NamedTuple):
    """A simultaneous block without a solution: ``proven``, or only not found.

    ``best`` is the nearest miss, ``misses`` what each equation is off there.
    """

    equations: tuple[int, ...]
    unknowns: tuple[str, ...]
    proven: bool
    best: Mapping[str, float] = {}
    misses: tuple[float, ...] = ()


class RankLoss(NamedTuple):
    """A block whose equations do not determine ``free``, which moves along ``direction`` from ``point``.

    ``everywhere``: linear equations that say the same thing whatever the values (under-determined);
    otherwise a singular point (dead centre, double root).
    """

    equations: tuple[int, ...]
    free: tuple[str, ...]
    direction: Mapping[str, float]
    everywhere: bool
    point: Mapping[str, Value]


class Beside(NamedTuple):
    """Beside isolated answers ``equations`` have a curve of others, where ``values`` leave ``free`` open."""

    equations: tuple[int, ...]
    free: tuple[str, ...]
    values: tuple[tuple[str, float], ...]


class Uncovered(NamedTuple):
    """A case that nothing contradicts, and in which the rules leave ``free`` undetermined."""

    case: tuple[Comparison, ...]
    free: tuple[str, ...]


class DoubleRoot(NamedTuple):
    """An answer where two coincide: to first order ``unknowns`` can move along ``direction``."""

    equations: tuple[int, ...]
    unknowns: tuple[str, ...]
    direction: Mapping[str, float]


class Unfixed(NamedTuple):
    """At the double root of ``double`` the rules do not determine ``unknowns``."""

    unknowns: tuple[str, ...]
    double: DoubleRoot


class RestsOnRounding(NamedTuple):
    """``unknown`` may have any value: ``equation`` divides by the last places of given numbers."""

    equation: int
    unknown: str


class DeadEnd(NamedTuple):
    """What was tried ends at ``reason``; ``unknowns`` before it may have other values."""

    reason: NoValue | OutOfRange | NoRoot
    unknowns: tuple[str, ...] = ()


class BeyondFloats(NamedTuple):
    """``equation`` solved for ``unknown`` does not hold at any float: too large, too small, too near."""

    equation: int
    unknown: str


class Unmet(NamedTuple):
    """Requirement number ``requirement`` does not hold at ``values``: its sides are ``miss`` apart.

    ``miss`` is None where they are no numbers.
    """

    requirement: int
    miss: float | None
    values: Mapping[str, Value] = {}


class Truncated(NamedTuple):
    """A limit was met; there may be more answers."""

    what: str


class OutOfTime(NamedTuple):
    """The search was cut off; ``known`` are the unknowns that had a value by then."""

    known: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Gap:
    """Why the answers are not known to be all: for ``unknowns``, by ``equations``, so many are there as were
    found, or as are listed where the list is ``cut``. ``low`` and ``high`` are the ends of the first unknown.
    ``uncounted``: a direct step has more values than it could count.

    Without equations it is a limit on the answers, or the cases, of the whole.
    """

    equations: tuple[int, ...] = ()
    unknowns: tuple[str, ...] = ()
    count: int = 0
    low: float = 0.0
    high: float = 0.0
    cut: bool = False
    uncounted: bool = False


Fact: TypeAlias = (
    NoValue
    | AsksNothing
    | OutOfRange
    | Conflict
    | NoRoot
    | RankLoss
    | DoubleRoot
    | Unfixed
    | RestsOnRounding
    | DeadEnd
    | BeyondFloats
    | Unmet
    | Indeterminacy
    | Beside
    | Uncovered
    | Filled
    | Fixed
    | Truncated
    | OutOfTime
)


def about(fact: Fact) -> tuple[int, ...]:
    """The equations that a fact speaks of."""
    one: int | None = getattr(fact, "equation", None)
    several: tuple[int, ...] = getattr(fact, "equations", ())
    return several if one is None else (one,)


class Method(Enum):
    """The ways to solve a simultaneous block: what each does, and its short name."""

    LINEAR = "elimination of linear equations", "elimination"
    POLYNOMIAL = "exact count of the roots of one polynomial in {tear}", "polynomial"
    FORMULA = "elimination to a formula", "formula"
    RANGE = "search of the whole range of {tear}", "range of {tear}"
    SUBSTITUTION = "substitution, and a search of the whole range of one unknown", "substitution"
    BOXES = "subdivision of the ranges", "boxes"
    SPARSE = "damped Newton with a sparse Jacobian", "sparse Newton"
    STARTS = "damped Newton from the guess and many starts", "damped Newton"
    CURVE = "search for a curve of answers", "curve"
    TRUST_REGION = "trust regions from the guess and many starts", "trust region"
    EXTENDED = "refined in extended precision", "extended precision"

    def __init__(self, told: str, short: str) -> None:
        self.told, self.short = told, short


class Attempt(NamedTuple):
    """``found`` answers that were new. ``complete`` where it proved that there are no others.

    ``iterations`` are those of all starts together, 0 where the method counts none.
    """

    method: Method
    found: int
    complete: bool = False
    iterations: int = 0


class ProvedRoots(NamedTuple):
    """As many ``roots``, two or none, are proved to be next to what floats see as a double root of
    ``unknowns``; of two, ``apart`` says how far from each other they lie, at least."""

    unknowns: tuple[str, ...]
    roots: int
    apart: Mapping[str, float] = {}


class Proof(NamedTuple):
    """``radius``: how far every number may be from the exact one at most, of the answer that is ``proved``.

    ``nearest``: every number is the float nearest to the exact one. ``obstacle`` says what stands in the way.
    ``double``: unknowns at a double root that is exactly there: in rational numbers the rules hold, and their
    Jacobian is singular. (Such an answer is not ``proved``: no change of an input, however small, leaves it.)
    ``beside``: where floats see a double root that is not there, what is, for the numbers as they are.
    """

    proved: bool
    radius: Mapping[str, float] = {}
    nearest: bool = False
    obstacle: str = ""
    double: tuple[str, ...] = ()
    beside: ProvedRoots | None = None


class Mark(NamedTuple):
    """One method on one case.

    ``error`` is the worst relative one over the wanted variables, nan where there is no answer; ``status``
    is solved, false, or what was said instead. ``at`` is the value of the varied input; ``radius`` the
    worst relative error that a proof leaves possible.
    """

    method: str
    family: str
    tolerance: float | None
    status: str
    error: float
    iterations: int | None
    seconds: float
    at: float | None = None
    radius: float | None = None
