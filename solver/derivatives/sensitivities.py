"""Sensitivities of an answer: the derivative of every output by every input, and why one does not exist."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from importlib import import_module

from rulesheets.diagnosis import Diagnosis, RuleSheetError, error
from rulesheets.inputs import variables_named
from rulesheets.model import Model, Value
from solver.derivatives.kinks import active_comparisons
from solver.derivatives.missing_slopes import Reason, diagnosis
from solver.derivatives.one_sided import Near, one_sided
from solver.derivatives.total_derivatives import Total, totals

_APPROACHABLE = ("rough", "edges", "free")
"""Reasons that hold at a point, and perhaps not beside it."""

CANCELLED = 1e-50
"""Relative size of a derivative that is taken for 0."""

SAME = 1e-12
"""Relative difference of the derivatives on both sides of an edge that is no kink."""


@dataclass(frozen=True)
class Sensitivities(Mapping[tuple[str, str], "float | None"]):
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

    def _repr_html_(self) -> str:
        # by name: the report stands above what it shows
        html: str = import_module("solver.report.html").sensitivities_html(self)
        return html

    def _repr_latex_(self) -> str:
        latex: str = import_module("solver.report.html").sensitivities_latex(self)
        return latex

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
            slope: float | Reason = Reason("blank")
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
            self.reasons[output, given] = replace(reason, kind="kink", sides=(after, before))

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
    if output in total.by and output not in total.loose:
        return _cleared(float(total.by[output].get(given, 0.0)), total, output, given)
    rule = next((e for e, read in total.rough.items() if read & {output, *total.loose}), None)
    return Reason("free") if rule is None else Reason("rough", rule)


def _cleared(slope: float, total: Total, output: str, given: str) -> float:
    """The slope; 0 where it is no more than what is left of terms that cancel at the digits computed with."""
    above, below = (abs(float(total.sharp.values[name])) or 1.0 for name in (output, given))
    return slope if abs(slope) * below > CANCELLED * above else 0.0
