"""Tolerances of inputs carried to the outputs, to first order."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from rulesheets.diagnosis import Diagnosis, RuleSheetError
from rulesheets.input_messages import no_tolerance
from rulesheets.inputs import variable_named
from rulesheets.model import Model, Tolerance, Value
from solver.derivatives.sensitivities import Sensitivities


@dataclass(frozen=True, slots=True)
class Contribution:
    """What one input adds to an output: ``amount`` = |∂output/∂input| · tolerance, in the output's unit.

    ``share`` is its part of the root-sum-square, amount² / Σ amount², between 0 and 1.
    """

    input: str
    amount: float
    share: float


@dataclass(frozen=True, slots=True)
class Band:
    """How far an output may be from its value to first order, the largest contribution first.

    ``worst``: Σ amount, every input at the end of its tolerance that hurts most. ``rss``: √(Σ amount²),
    the same multiple of the standard deviation for the output that the tolerances are for independent inputs.
    """

    name: str
    value: float
    worst: float
    rss: float
    contributions: tuple[Contribution, ...]


@dataclass(frozen=True)
class ToleranceBands(Mapping[str, "Band | None"]):
    """The band of every output; None where a derivative is missing (``diagnoses`` say why).

    ``tolerances`` are those of the inputs, in their own units.
    """

    tolerances: Mapping[str, float]
    sensitivities: Sensitivities
    answer: Mapping[str, Value]

    @property
    def diagnoses(self) -> tuple[Diagnosis, ...]:
        return self.sensitivities.diagnoses

    def __getitem__(self, name: str) -> Band | None:
        if name not in self.sensitivities.outputs:
            raise KeyError(name)
        slopes = [self.sensitivities[name, given] for given in self.tolerances]
        value = self.answer.get(name)
        if not isinstance(value, float) or any(slope is None for slope in slopes):
            return None
        return _band(name, value, self.tolerances, [slope or 0.0 for slope in slopes])

    def __iter__(self) -> Iterator[str]:
        return iter(self.sensitivities.outputs)

    def __len__(self) -> int:
        return len(self.sensitivities.outputs)


def _band(name: str, value: float, tolerances: Mapping[str, float], slopes: Sequence[float]) -> Band:
    amounts = {given: abs(s) * t for (given, t), s in zip(tolerances.items(), slopes, strict=True)}
    rss = math.hypot(*amounts.values())
    ranked = sorted(amounts.items(), key=lambda item: -item[1])
    return Band(
        name,
        value,
        math.fsum(amounts.values()),
        rss,
        tuple(Contribution(given, a, (a / rss) ** 2 if rss else 0.0) for given, a in ranked),
    )


def tolerances_of(
    model: Model, inputs: Mapping[str, Value], given: Mapping[str, float | Tolerance] | None = None
) -> dict[str, float]:
    """The tolerances of the inputs that are numbers, in their own units: those of the sheet, overridden.

    Raises RuleSheetError for names that the model does not have (E407) and for a tolerance that is negative
    or not finite (E405).
    """
    stated: dict[str, Tolerance | None] = {n: v.tolerance for n, v in model.variables.items()}
    for name, tolerance in (given or {}).items():
        size = tolerance if isinstance(tolerance, Tolerance) else Tolerance(float(tolerance))
        if not 0.0 <= size.size < math.inf:
            raise RuleSheetError(no_tolerance(False, None))
        stated[variable_named(name, model).name] = size
    numbers = {n: v for n in model.variables if isinstance(v := inputs.get(n), float)}
    sizes = {n: t.around(v) for n, v in numbers.items() if (t := stated[n]) is not None}
    return {name: size for name, size in sizes.items() if size}
