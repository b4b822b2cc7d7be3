"""What a solve returns, and samples drawn within tolerances."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rulesheets.model import Value
from solver.facts import Status, UnknownName
from solver.path import Shown

if TYPE_CHECKING:
    from rulesheets.diagnosis import Diagnosis
    from rulesheets.model import Model, Tolerance
    from solver.accuracy.forward_error import ForwardErrors
    from solver.derivatives import Sensitivities, ToleranceBands
    from solver.derivatives.total_derivatives import Near
    from solver.facts import Attempt, Proof
    from solver.files.tables import Table
    from solver.path import Path, SolveBlock, Step


SHOWN = 6
"""Values of an answer that its ``repr`` tells."""


@dataclass(frozen=True)
class Solution(Mapping[str, Value]):
    """One answer: values by full name, inputs included. Names without a value are absent.

    ``worst_residual`` is the largest scaled residual |F| / Σ|∂F/∂v·v| over the rules ``checked``.
    ``accuracy`` holds the error bars and the conditions of the blocks, ``error`` the error bars alone:
    estimates of the absolute error of every number, 0 for inputs. ``unlikely`` are the names whose values are
    of unlikely size: a billion times larger or smaller than the rules and the inputs suggest.
    """

    by_name: Mapping[str, Value]
    residual: float | Callable[[], float] = field(default=0.0, repr=False)
    checked: int = 0
    measure: Callable[[], ForwardErrors] | None = field(default=None, repr=False, compare=False)
    proof: Proof | None = field(default=None, repr=False, compare=False)
    unlikely: tuple[str, ...] = ()

    @cached_property
    def worst_residual(self) -> float:
        return self.residual() if callable(self.residual) else self.residual

    @cached_property
    def accuracy(self) -> ForwardErrors:
        from solver.accuracy.forward_error import ForwardErrors

        return self.measure() if self.measure else ForwardErrors({})

    @property
    def radius(self) -> Mapping[str, float]:
        """How far every number may be from the exact one at most: proved, where a proof was asked for."""
        return {} if self.proof is None else self.proof.radius

    @property
    def error(self) -> Mapping[str, float]:
        """An estimate of the absolute error of every number, 0 for inputs."""
        return self.accuracy.error

    def __getstate__(self) -> dict[str, object]:
        """Pickled with its residual and its error bars, which are measured when they are asked for."""
        own: dict[str, object] = {name: self.__dict__[name] for name in self.__match_args__}
        return {**own, "residual": self.worst_residual, "measure": None, "accuracy": self.accuracy}

    def __getitem__(self, name: str) -> Value:
        if name not in self.by_name:
            raise UnknownName(name, self.by_name)
        return self.by_name[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self.by_name)

    def __len__(self) -> int:
        return len(self.by_name)


@dataclass(frozen=True)
class Result(Shown):
    """``solutions`` are distinct, the primary one first; ``complete`` where they are known to be all.

    ``inputs`` are the values that were given (after overrides and clearing), ``guesses`` likewise.
    ``wanted`` are the names by which the status was judged, ``undetermined`` those that stay unknown.
    Where the status is not ``solved``, ``partial`` holds what the inputs do determine. ``origins`` are
    the steps of the path that the values of the primary answer (or of ``partial``) came from;
    ``attempts`` the methods that were tried on each of its simultaneous blocks, in order. ``gaps`` say why
    ``solutions`` may not be all. ``near`` solves the same for other inputs, near to given values.
    """

    model: Model
    status: Status
    solutions: tuple[Solution, ...]
    complete: bool
    inputs: Mapping[str, Value]
    guesses: Mapping[str, float]
    wanted: tuple[str, ...]
    undetermined: tuple[str, ...]
    diagnoses: tuple[Diagnosis, ...]
    path: Path
    partial: Mapping[str, Value] = field(default_factory=dict)
    origins: Mapping[str, Step] = field(default_factory=dict, repr=False)
    attempts: Mapping[SolveBlock, tuple[Attempt, ...]] = field(default_factory=dict, repr=False)
    gaps: tuple[Diagnosis, ...] = field(default=(), repr=False)
    near: Near | None = field(default=None, repr=False, compare=False)

    def __getitem__(self, name: str) -> Value | None:
        """Value of the primary answer (or what is determined of it); None where it has none.

        Raises KeyError for a name that the model does not have.
        """
        if name not in self.model.variables:
            raise UnknownName(name, self.model.variables)
        return self._answer(0).get(name)

    def __repr__(self) -> str:
        from rulesheets.diagnosis import plural

        known = self._answer(0)
        found = {name: known[name] for name in self.wanted if name in known and name not in self.inputs}
        told = [f"{n} = '{v}" if isinstance(v, str) else f"{n} = {v:.10g}" for n, v in found.items()]
        values = ", ".join([*told[:SHOWN], "…"] if len(told) > SHOWN else told)
        return f"<Result {self.status}, {plural(len(self.solutions), 'answer')}{values and f': {values}'}>"

    def sensitivity(
        self, outputs: Iterable[str] | None = None, inputs: Iterable[str] | None = None, answer: int = 0
    ) -> Sensitivities:
        """Derivatives of ``outputs`` (None: the wanted ones) by ``inputs`` (None: all that are numbers).

        They are exact, those of the answer with that number, each input moved alone; ``None`` in the table
        where there is none, and ``diagnoses`` that say why. Raises RuleSheetError for names that the model
        does not have, and for an input that was not given as a number; IndexError for an answer too many.
        """
        from solver.derivatives import chosen_inputs, chosen_outputs, sensitivities
        from solver.path import equations_of

        values = self._answer(answer)
        shown = chosen_outputs(self.model, outputs, self.wanted, self.inputs, values)
        by = chosen_inputs(self.model, inputs, self.inputs)
        used = [e for step in self.path.steps for e in equations_of(step)]
        return sensitivities(self.model, values, self.inputs, shown, by, prefer=used, near=self.near)

    def tolerance_bands(
        self,
        tolerances: Mapping[str, float | Tolerance] | None = None,
        outputs: Iterable[str] | None = None,
        answer: int = 0,
    ) -> ToleranceBands:
        """How far ``outputs`` may be off by the tolerances of the inputs, to first order.

        ``tolerances`` override those of the sheet, in the units of the inputs. Raises RuleSheetError for
        names that the model does not have.
        """
        from solver.derivatives import ToleranceBands, tolerances_of

        sizes = tolerances_of(self.model, self.inputs, tolerances)
        found = self.sensitivity(outputs, sizes, answer)
        return ToleranceBands(sizes, found, self._answer(answer))

    def _answer(self, number: int) -> Mapping[str, Value]:
        """An answer by its number; where there is none, what is determined."""
        if not self.solutions:
            return self.partial
        if not 0 <= number < len(self.solutions):
            raise IndexError(f"there is no answer {number}: answers are 0 to {len(self.solutions) - 1}")
        return self.solutions[number]


SPREADS = {"uniform": 3**-0.5, "normal": 1 / 3}
"""The standard deviation of an input in units of its tolerance.

``uniform``: anywhere within the tolerance alike. ``normal``: the tolerance is three standard deviations.
"""


class Samples(NamedTuple):
    """``table`` has one row a sample: the inputs drawn, and the outputs, NaN where it is not solved.

    ``spread`` is the standard deviation of an input in units of its tolerance.
    """

    table: Table
    tolerances: Mapping[str, float]
    outputs: tuple[str, ...]
    distribution: str
    seed: int

    @property
    def spread(self) -> float:
        """The standard deviation of an input, in units of its tolerance."""
        return SPREADS[self.distribution]

    def solved(self, name: str) -> NDArray[np.float64]:
        """The values of an output, of the samples that are solved."""
        column: NDArray[np.float64] = np.asarray(self.table[name], dtype=np.float64)
        return np.compress(np.isfinite(column), column)

    def statistics(self, name: str) -> tuple[float, float, float, float] | None:
        """Mean, standard deviation, least and greatest value of an output; None of fewer than two samples."""
        column = self.solved(name)
        if len(column) < 2:
            return None
        return float(column.mean()), float(column.std(ddof=1)), float(column.min()), float(column.max())

    @property
    def counts(self) -> dict[Status, int]:
        """How many samples came out with each status."""
        codes, numbers = np.unique(self.table.status, return_counts=True)
        return {self.table.STATUSES[code]: int(n) for code, n in zip(codes, numbers, strict=True)}
