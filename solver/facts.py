"""The results of a solve as data: numbers of equations and names of variables, no sentences."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from enum import Enum
from typing import NamedTuple, TypeAlias

from rulesheets.diagnosis import Diagnosis, suggestion
from rulesheets.model import Value, Values
from rulesheets.syntax.nodes import Comparison


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
        """The exit code of the command: 0 for solved."""
        return 0 if self is Status.SOLVED else 1


class Unsolved(Exception):
    """There is no answer. ``status`` names the reason, ``diagnoses`` explain it, computed on
    demand."""

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

    def __reduce__(self) -> tuple[object, ...]:
        return type(self), (self.status, self.diagnoses)

    def __str__(self) -> str:
        return f"{self.status}: " + "; ".join(d.message for d in self.diagnoses)


class UnknownName(KeyError):
    """There is no such name. ``str`` is a sentence with a suggestion."""

    def __init__(self, name: object, known: Collection[str]) -> None:
        super().__init__(name)
        self.known = known  # as it is: a table asks for many names that have no value

    def __reduce__(self) -> tuple[object, ...]:
        return type(self), (self.args[0], tuple(self.known))

    def __str__(self) -> str:
        name = self.args[0]
        meant = suggestion(name, self.known) if isinstance(name, str) else ()
        return f"there is no variable {name}" + (f": {meant[0]}" if meant else "")


class NoValue(NamedTuple):
    """Solving ``equation`` for ``unknown`` needs an impossible value: ``reading`` states it (``cosd
    = 1.08``).

    ``pole``: the unknown would have to be infinite (a product with 0 that is not 0).
    """

    equation: int
    unknown: str
    reading: str
    pole: bool = False


class Indeterminacy(NamedTuple):
    """At ``values`` the rule of ``equation`` has the ``form`` 0/0, and no value.

    ``limit`` is the two-sided limit of that part, None if there is none; ``is_open``: it depends on
    an unknown without a value.
    """

    equation: int
    form: str
    limit: float | None
    is_open: bool
    values: Mapping[str, Value] = {}


class Fixed(NamedTuple):
    """``equations`` imply that ``name`` is ``value``, for every value of ``unknown``, and not
    ``given``."""

    name: str
    value: float
    given: float
    unknown: str
    equations: tuple[int, ...]


class Filled(NamedTuple):
    """``equation`` has no value at an answer, and was replaced by its ``limit``."""

    equation: int
    limit: float


class AsksNothing(NamedTuple):
    """At these values ``equation`` holds for every value of ``unknown``."""

    equation: int
    unknown: str


class OutOfRange(NamedTuple):
    """``equation`` gives ``unknown`` a value outside the range that the sheet declares for it."""

    equation: int
    unknown: str
    value: float


class Conflict(NamedTuple):
    """Rules that contradict each other: ``equation`` misses by ``miss`` (left minus right)."""

    equations: tuple[int, ...]
    miss: float | None
    values: Mapping[str, Value] = {}


class NoRoot(NamedTuple):
    """A simultaneous block without a solution: ``proven``, or only not found.

    ``best`` is the nearest miss, ``misses`` the residual of each equation there.
    """

    equations: tuple[int, ...]
    unknowns: tuple[str, ...]
    proven: bool
    best: Mapping[str, float] = {}
    misses: tuple[float, ...] = ()


class RankLoss(NamedTuple):
    """A block whose equations do not determine ``free``, which moves along ``direction`` from
    ``point``.

    ``everywhere``: linear equations that are dependent at any values (under-determined); otherwise
    a singular point (dead centre, double root). ``dependent``: equations that follow from the
    others.
    """

    equations: tuple[int, ...]
    free: tuple[str, ...]
    direction: Mapping[str, float]
    everywhere: bool
    point: Values
    dependent: tuple[int, ...] = ()


class Beside(NamedTuple):
    """A curve of ``equations`` besides isolated answers, on which ``free`` is open at
    ``values``."""

    equations: tuple[int, ...]
    free: tuple[str, ...]
    values: tuple[tuple[str, float], ...]


class Uncovered(NamedTuple):
    """A case that no rule contradicts, in which the rules leave ``free`` undetermined."""

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
    """``equation`` solved for ``unknown`` holds at no float: too large, too small, or too close."""

    equation: int
    unknown: str


class Unmet(NamedTuple):
    """Requirement number ``requirement`` does not hold at ``values``: its sides are ``miss`` apart.

    ``miss`` is None if they are not numbers.
    """

    requirement: int
    miss: float | None
    values: Mapping[str, Value] = {}


class Truncated(NamedTuple):
    """A limit was reached; there may be more answers."""

    what: str


class OutOfTime(NamedTuple):
    """The search was interrupted; ``known`` are the unknowns that had a value by then."""

    known: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Gap:
    """Why the answers may not be all: the ``unknowns``, the ``equations``, and the number of
    answers found, or listed if the list is ``cut``. ``low`` and ``high`` are the ends of the first
    unknown. ``uncounted``: a direct step has more values than it could count.

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
    """The equations that a fact refers to."""
    one: int | None = getattr(fact, "equation", None)
    several: tuple[int, ...] = getattr(fact, "equations", ())
    return several if one is None else (one,)


class Method(Enum):
    """The methods for a simultaneous block, with a description and a short name."""

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

    def __init__(self, description: str, short: str) -> None:
        self.description, self.short = description, short


class Attempt(NamedTuple):
    """``found`` is the number of new answers. ``complete``: it proved that there are no others."""

    method: Method
    found: int
    complete: bool = False


class Proof(NamedTuple):
    """``radius``: an upper bound of the error of every number of a ``proved`` answer.

    ``nearest``: every number is the float nearest to the exact one. ``obstacle`` says why there is
    no proof. ``double``: unknowns at an exact double root: in rational numbers the rules hold, and
    their Jacobian is singular. (Such an answer is not ``proved``: an arbitrarily small change of an
    input removes it.)
    """

    proved: bool
    radius: Mapping[str, float] = {}
    nearest: bool = False
    obstacle: str = ""
    double: tuple[str, ...] = ()
