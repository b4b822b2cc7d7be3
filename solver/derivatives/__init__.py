"""Sensitivities of an answer, slopes that do not exist, and what tolerances of the inputs make of it."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from rulesheets.diagnosis import Diagnosis, Label, RuleSheetError, Severity, error
from rulesheets.format import format_expression
from rulesheets.input_messages import no_tolerance
from rulesheets.inputs import variable_named, variables_named
from rulesheets.model import Model, Tolerance, Value
from solver.derivatives.total_derivatives import Near, Total, active_comparisons, one_sided, totals
from solver.path import Shown
from solver.path.cases import Pair


class Reason(NamedTuple):
    """Why one is missing: tied, rough (a rule), kink, edges (pairs), free or unsolved.

    ``sides`` are the derivatives on both sides of a kink.
    """

    kind: str
    rule: int = -1
    pairs: tuple[Pair, ...] = ()
    sides: tuple[float, float] = (0.0, 0.0)


def diagnosis(model: Model, reason: Reason, group: Sequence[tuple[str, str]]) -> Diagnosis:
    """One reason for a group of (output, input) pairs, as a note."""
    outputs = tuple(dict.fromkeys(output for output, _ in group))
    givens = tuple(dict.fromkeys(given for _, given in group))
    what = f"the derivative of {_listed(outputs)} by {_listed(givens)}"
    labels = () if reason.rule < 0 else (Label(model.equations[reason.rule].rule),)
    match reason.kind:
        case "tied":
            text = f"{what} does not exist: moved alone, {_either(givens)} would break this rule"
            note = "clear an input that the others determine"
        case "rough":
            text = f"{what} can't be told here: this rule has no slope at these values"
            note = "it has a corner or a vertical tangent there; move an input a little and ask again"
        case "kink":
            after, before = reason.sides
            where = f"the rules change at {_comparisons(reason.pairs)}" if reason.pairs else "it has a corner"
            text = f"{what} does not exist: {where}"
            note = f"it is {after:.10g} upwards and {before:.10g} downwards"
        case "unsolved":
            text = f"{what} does not exist: {_listed(outputs)} has no number here"
            note = "take it out of the list, or solve for it"
        case "edges":
            text = f"{what} can't be told here: the rules change at {_comparisons(reason.pairs)}"
            note = "move an input a little and ask again"
        case _:
            text = f"{what} does not exist: the answer is singular there"
            note = "it can move while every input stays: a double root, a fold or a dead centre"
    return Diagnosis("S592", Severity.NOTE, text, labels, (note,), outputs)


def _listed(names: Sequence[str]) -> str:
    shown = names if len(names) <= 6 else (*names[:6], f"{len(names) - 6} more")
    return " and ".join(filter(None, (", ".join(shown[:-1]), shown[-1])))


def _either(names: Sequence[str]) -> str:
    return names[0] if len(names) == 1 else "each of them"


def _comparisons(pairs: Iterable[Pair]) -> str:
    return _listed([f"{format_expression(left)} = {format_expression(right)}" for left, right in pairs])


_APPROACHABLE = ("rough", "edges", "free")
"""Reasons that hold at a point, and perhaps not beside it."""

CANCELLED = 1e-50
"""Relative size of a derivative that is taken for 0."""

SAME = 1e-12
"""Relative difference of the derivatives on both sides of an edge that is no kink."""


@dataclass(frozen=True)
class Sensitivities(Mapping[tuple[str, str], "float | None"], Shown):
    """``table["vB", "thetaAO"]`` is d(vB)/d(thetaAO) in calculation units, None where there is none.

    Every derivative is that of the one answer that it was asked of, all other inputs held. ``diagnoses``
    say why a derivative does not exist.
    """

    model: Model
    outputs: tuple[str, ...]
    inputs: tuple[str, ...]
    slopes: Mapping[tuple[str, str], float]
    diagnoses: tuple[Diagnosis, ...] = ()

    def __getitem__(self, pair: tuple[str, str]) -> float | None:
        output, given = pair
        if output not in self.outputs or given not in self.inputs:
            raise KeyError(pair)
        return self.slopes.get(pair)

    def __iter__(self) -> Iterator[tuple[str, str]]:
        return ((output, given) for output in self.outputs for given in self.inputs)

    def __len__(self) -> int:
        return len(self.outputs) * len(self.inputs)

    def unit(self, output: str, given: str) -> str:
        """``rad/s/deg``, ``1/deg``, blank where neither has a unit."""
        above, below = (self.model.variables[name].unit for name in (output, given))
        if below is None:
            return above or ""
        below = f"({below})" if any(mark in below for mark in "*/ ") else below
        return f"{above or '1'}/{below}"


def sensitivities(
    model: Model,
    values: Mapping[str, Value],
    inputs: Mapping[str, Value],
    outputs: Sequence[str],
    by: Sequence[str],
    prefer: Iterable[int] = (),
    near: Near | None = None,
) -> Sensitivities:
    """Derivatives of ``outputs`` at an answer (``values``) for ``inputs``, by those of them in ``by``.

    Where the rules have no slope there, ``near`` finds answers beside it, whose derivatives may have a limit.
    """
    return _Study(model, values, inputs, outputs, by, tuple(prefer), near).run()


def chosen_outputs(
    model: Model,
    names: Iterable[str] | None,
    wanted: Iterable[str],
    inputs: Collection[str],
    values: Mapping[str, Value],
) -> tuple[str, ...]:
    """The outputs named; else the wanted ones that have a number. Raises RuleSheetError (E407)."""
    if names is not None:
        return tuple(dict.fromkeys(variables_named(names, model)))
    return tuple(n for n in wanted if n not in inputs and isinstance(values.get(n), float))


def chosen_inputs(model: Model, names: Iterable[str] | None, inputs: Mapping[str, Value]) -> tuple[str, ...]:
    """The inputs named; else all that are numbers. Raises RuleSheetError (E407, E425)."""
    if names is None:
        return tuple(name for name in model.variables if isinstance(inputs.get(name), float))
    found = tuple(dict.fromkeys(variables_named(names, model)))
    wrong = [name for name in found if not isinstance(inputs.get(name), float)]
    if wrong:
        raise RuleSheetError(*map(no_number_input, wrong))
    return found


def no_number_input(name: str) -> Diagnosis:
    text = f"{name} is not an input with a number, so nothing can be derived by it"
    return error("E425", text, notes=(f"give it a number: --set {name}=…",))


class _Study:
    """Derivatives at one answer; where its rules change, the limits of those beside it."""

    def __init__(
        self,
        model: Model,
        values: Mapping[str, Value],
        inputs: Mapping[str, Value],
        outputs: Sequence[str],
        by: Sequence[str],
        prefer: tuple[int, ...],
        near: Near | None,
    ) -> None:
        self.model, self.values, self.inputs = model, values, inputs
        self.outputs, self.by, self.prefer, self.near = outputs, by, prefer, near
        self.slopes: dict[tuple[str, str], float] = {}
        self.reasons: dict[tuple[str, str], Reason] = {}

    def run(self) -> Sensitivities:
        pairs = active_comparisons(self.model, self.values)
        total = totals(self.model, self.values, self.inputs, self.by, self.prefer)
        for given in self.by:
            if all(total.of(pair, given) == 0 for pair in pairs):
                self._take(given, total)
            else:
                reason = Reason("edges", pairs=pairs)
                self.reasons.update(((output, given), reason) for output in self.outputs)
        for given in self.by:
            self._approach(given)
        diagnoses = tuple(self._diagnoses())
        return Sensitivities(self.model, tuple(self.outputs), tuple(self.by), self.slopes, diagnoses)

    def _take(self, given: str, total: Total) -> None:
        for output in self.outputs:
            slope: float | Reason = Reason("unsolved")
            if isinstance(self.values.get(output), float):
                slope = _one(total, output, given)
            if isinstance(slope, Reason):
                self.reasons[output, given] = slope
            else:
                self.slopes[output, given] = slope

    def _approach(self, given: str) -> None:
        """Limits of the derivatives from both sides, where the rules at the point itself tell nothing."""
        lost = [o for o in self.outputs if (r := self.reasons.get((o, given))) and r.kind in _APPROACHABLE]
        if not lost or self.near is None:
            return
        after, before = (
            one_sided(self.model, self.values, self.inputs, lost, given, way, self.near) for way in (1, -1)
        )
        for output in after.keys() & before.keys():
            reason = self.reasons.pop((output, given))
            self._settle(output, given, after[output], before[output], reason)

    def _settle(self, output: str, given: str, after: float, before: float, reason: Reason) -> None:
        """The derivative where both sides agree; else the corner, at the rule or the guards that make it."""
        if abs(after - before) <= SAME * max(abs(after), abs(before)):
            self.slopes[output, given] = after
        else:
            self.reasons[output, given] = reason._replace(kind="kink", sides=(after, before))

    # --- why there is none ---

    def _diagnoses(self) -> Iterator[Diagnosis]:
        groups: dict[Reason, list[tuple[str, str]]] = {}
        for pair, reason in self.reasons.items():
            groups.setdefault(reason, []).append(pair)
        for reason, group in groups.items():
            yield diagnosis(self.model, reason, group)


def _one(total: Total, output: str, given: str) -> float | Reason:
    """The derivative, or why there is none."""
    if output == given:
        return 1.0
    if given in total.tied:
        return Reason("tied", total.tied[given])
    corner = total.cornered.get(given, {}).get(output)
    if corner is not None:
        return Reason("rough", corner)
    if output in total.by and output not in total.underdetermined:
        return _cleared(float(total.by[output].get(given, 0.0)), total, output, given)
    rule = next((e for e, read in total.rough.items() if read & {output, *total.underdetermined}), None)
    return Reason("free") if rule is None else Reason("rough", rule)


def _cleared(slope: float, total: Total, output: str, given: str) -> float:
    """The slope; 0 where it is no more than what is left of terms that cancel at the digits computed with."""
    above, below = (abs(float(total.sharp.values[name])) or 1.0 for name in (output, given))
    return slope if abs(slope) * below > CANCELLED * above else 0.0


class Contribution(NamedTuple):
    """What one input adds to an output: ``amount`` = |∂output/∂input| · tolerance, in the output's unit.

    ``share`` is its part of the root-sum-square, amount² / Σ amount², between 0 and 1.
    """

    input: str
    amount: float
    share: float


class Band(NamedTuple):
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
