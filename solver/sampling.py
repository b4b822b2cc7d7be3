"""Tolerances by Monte Carlo: the whole sheet solved for inputs drawn at random within their tolerances."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rulesheets.inputs import variables_named
from rulesheets.model import Tolerance
from solver.derivatives.sensitivities import tolerances_of
from solver.plan import prepare
from solver.result import Result, Status, Table

DISTRIBUTIONS: Mapping[str, tuple[float, Callable[[np.random.Generator, int], NDArray[np.float64]]]] = {
    "uniform": (3**-0.5, lambda draw, n: draw.uniform(-1.0, 1.0, n)),
    "normal": (1 / 3, lambda draw, n: draw.normal(0.0, 1 / 3, n)),
}
"""Deviations of an input in units of its tolerance: their standard deviation, and how they are drawn.

``uniform``: anywhere within the tolerance alike. ``normal``: the tolerance is three standard deviations.
"""


@dataclass(frozen=True)
class Samples:
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
        return DISTRIBUTIONS[self.distribution][0]

    def solved(self, name: str) -> NDArray[np.float64]:
        """The values of an output, of the samples that are solved."""
        column: NDArray[np.float64] = np.asarray(self.table[name], dtype=np.float64)
        return np.compress(np.isfinite(column), column)

    @property
    def counts(self) -> dict[Status, int]:
        """How many samples came out with each status."""
        codes, numbers = np.unique(self.table.status, return_counts=True)
        return {self.table.STATUSES[code]: int(n) for code, n in zip(codes, numbers, strict=True)}


def monte_carlo(
    result: Result,
    samples: int = 1000,
    seed: int = 0,
    distribution: str = "uniform",
    tolerances: Mapping[str, float | Tolerance] | None = None,
    outputs: Iterable[str] | None = None,
) -> Samples:
    """Solve for ``samples`` draws of the inputs that have a tolerance, near the primary answer of ``result``.

    Inputs are drawn independently of one another; the same ``seed`` gives the same draws. Of several
    answers of a sample the nearest to the primary one counts. ``tolerances`` override those of the sheet,
    in the units of the inputs.

    Raises ValueError for an unknown distribution, for less than two samples, and where nothing is solved to
    start from; RuleSheetError for unknown names.
    """
    if distribution not in DISTRIBUTIONS:
        raise ValueError(f"the distributions are {', '.join(DISTRIBUTIONS)}, not {distribution}")
    if samples < 2:
        raise ValueError("at least two samples are needed")
    if not result.solutions:
        raise ValueError("there is no answer to sample around")
    model, answer = result.model, result.solutions[0]
    sizes = tolerances_of(model, result.inputs, tolerances)
    named = None if outputs is None else variables_named(outputs, model)
    wanted = tuple(
        n for n in (named or result.wanted) if n not in result.inputs and isinstance(answer.get(n), float)
    )
    draw = np.random.default_rng(seed)
    deviate = DISTRIBUTIONS[distribution][1]
    columns = {n: float(result.inputs[n]) + size * deviate(draw, samples) for n, size in sizes.items()}
    given = {name: result.inputs.get(name) for name in model.variables}
    guesses = {name: answer[name] for name in model.variables if _unknown_number(name, result)}
    plan = prepare(model, list(sizes), wanted, given, guesses)  # type: ignore[arg-type]
    return Samples(plan.sweep(*columns.values()), sizes, wanted, distribution, seed)


def _unknown_number(name: str, result: Result) -> bool:
    return name not in result.inputs and isinstance(result.solutions[0].get(name), float)
