"""Sensitivities of an answer, missing derivatives, and the effect of tolerances of the inputs."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from itertools import product
from typing import NamedTuple

from rulesheets.diagnosis import Diagnosis, Label, RuleSheetError, Severity, error, listed
from rulesheets.format import format_expression
from rulesheets.inputs import no_tolerance, variable_named, variables_named
from rulesheets.model import Model, Tolerance, Value, Values
from solver.derivatives.linearization import (
    Extended,
    Total,
    active_comparisons,
    kinks,
    number,
    totals,
)
from solver.path import Shown
from solver.path.cases import Pair

MISSING = {
    "tied": (
        "{what} does not exist: moved alone, {alone} would break this rule",
        "clear an input that the others determine",
    ),
    "rough": (
        "{what} is unknown here: this rule has no slope at these values",
        "it has a corner or a vertical tangent there; move an input a little and ask again",
    ),
    "corner": (
        "{what} does not exist: it has a corner",
        "it is {after:.10g} upwards and {before:.10g} downwards",
    ),
    "kink": (
        "{what} does not exist: the rules change at {pairs}",
        "it is {after:.10g} upwards and {before:.10g} downwards",
    ),
    "unsolved": (
        "{what} does not exist: {outputs} has no number here",
        "take it out of the list, or solve for it",
    ),
    "edges": (
        "{what} is unknown here: the rules change at {pairs}",
        "move an input a little and ask again",
    ),
    "free": (
        "{what} does not exist: the answer is singular there",
        "it can move while every input stays: a double root, a fold or a dead centre",
    ),
}
"""Why a derivative is missing, and what can be done, by the kind of reason."""


class Reason(NamedTuple):
    """Why a derivative is missing: its kind, and the rule or pairs at its root.

    ``sides`` are the derivatives on both sides of a kink.
    """

    kind: str
    rule: int = -1
    pairs: tuple[Pair, ...] = ()
    sides: tuple[float, float] = (0.0, 0.0)


def diagnosis(model: Model, reason: Reason, group: Sequence[tuple[str, str]]) -> Diagnosis:
    """One reason for a group of (output, input) pairs, as a note."""
    outputs, givens = (tuple(dict.fromkeys(names)) for names in zip(*group, strict=True))
    pairs = [f"{format_expression(one)} = {format_expression(two)}" for one, two in reason.pairs]
    said = {
        "what": f"the derivative of {listed(outputs)} by {listed(givens)}",
        "alone": givens[0] if len(givens) == 1 else "each of them",
        "outputs": listed(outputs),
        "pairs": pairs and listed(pairs),
        "after": reason.sides[0],
        "before": reason.sides[1],
    }
    text, note = (told.format(**said) for told in MISSING[reason.kind])
    labels = () if reason.rule < 0 else (Label(model.equations[reason.rule].rule),)
    return Diagnosis("S592", Severity.NOTE, text, labels, (note,), outputs)


_APPROACHABLE = ("rough", "edges", "free")
"""Reasons that hold at a point, but perhaps not near it."""

NO_SLOPE = 1e-50
"""Relative size of a derivative that is taken for 0."""

SAME = 1e-12
"""Relative difference of the derivatives on both sides of an edge that is no kink."""


class Sensitivities(dict[tuple[str, str], float | None], Shown):
    """``table["vB", "thetaAO"]`` is d(vB)/d(thetaAO) in calculation units, None if there is none.

    Every derivative is that of one answer, with all other inputs held. ``diagnoses`` say why a
    derivative does not exist.
    """

    def __init__(
        self,
        model: Model,
        outputs: Sequence[str],
        inputs: Sequence[str],
        slopes: Mapping[tuple[str, str], float],
        diagnoses: tuple[Diagnosis, ...] = (),
    ) -> None:
        super().__init__((pair, slopes.get(pair)) for pair in product(outputs, inputs))
        self.model, self.diagnoses = model, diagnoses
        self.outputs, self.inputs = tuple(outputs), tuple(inputs)

    def unit(self, output: str, given: str) -> str:
        """``rad/s/deg``, ``1/deg``, blank if neither has a unit."""
        above, below = (self.model.variables[name].unit for name in (output, given))
        if below is None:
            return above or ""
        below = f"({below})" if any(mark in below for mark in "*/ ") else below
        return f"{above or '1'}/{below}"


def sensitivities(
    model: Model,
    values: Values,
    inputs: Values,
    outputs: Sequence[str],
    by: Sequence[str],
    prefer: Iterable[int] = (),
    near: Near | None = None,
) -> Sensitivities:
    """Derivatives of ``outputs`` at an answer (``values``) for ``inputs``, by those of them in
    ``by``.

    If the rules have no slope there, ``near`` finds answers nearby, whose derivatives may have a
    limit.
    """
    pairs = active_comparisons(model, values)
    total = totals(model, values, inputs, by, prefer)
    corners = [(e, pair) for e in total.sharp.rows for pair in kinks(model.equations[e], values)]
    slopes: dict[tuple[str, str], float] = {}
    reasons: dict[tuple[str, str], Reason] = {}
    for given in by:
        changing = any(total.of(pair, given) != 0 for pair in pairs)
        corner = next((e for e, pair in corners if total.of(pair, given) != 0), None)
        for output in outputs:
            found = _one(total, values, output, given, corner)
            if changing:
                found = Reason("edges", pairs=pairs)
            if isinstance(found, Reason):
                reasons[output, given] = found
            else:
                slopes[output, given] = found
        lost = [o for o in outputs if (r := reasons.get((o, given))) and r.kind in _APPROACHABLE]
        if near is None or not lost:
            continue
        # limits of the derivatives from both sides, where the rules at the point itself tell
        # nothing
        limits = [one_sided(model, values, inputs, lost, given, side, near) for side in (1, -1)]
        for output in (one for one in lost if all(one in limit for limit in limits)):
            after, before = (limit[output] for limit in limits)
            reason = reasons.pop((output, given))
            if abs(after - before) <= SAME * max(abs(after), abs(before)):
                slopes[output, given] = after
            else:  # a corner, at the rule or the guards that make it
                kind = "kink" if reason.pairs else "corner"
                reasons[output, given] = reason._replace(kind=kind, sides=(after, before))
    groups: dict[Reason, list[tuple[str, str]]] = {}
    for key, reason in reasons.items():
        groups.setdefault(reason, []).append(key)
    diagnoses = tuple(diagnosis(model, reason, group) for reason, group in groups.items())
    return Sensitivities(model, outputs, by, slopes, diagnoses)


def chosen_outputs(
    model: Model,
    names: Iterable[str] | None,
    wanted: Iterable[str],
    inputs: Collection[str],
    values: Values,
) -> tuple[str, ...]:
    """The named outputs, else the wanted ones with a number. Raises RuleSheetError (E407)."""
    if names is not None:
        return tuple(dict.fromkeys(variables_named(names, model)))
    return tuple(n for n in wanted if n not in inputs and isinstance(values.get(n), float))


def chosen_inputs(model: Model, names: Iterable[str] | None, inputs: Values) -> tuple[str, ...]:
    """The named inputs; without names all that are numbers. Raises RuleSheetError (E407, E425)."""
    if names is None:
        return tuple(name for name in model.variables if isinstance(inputs.get(name), float))
    found = tuple(dict.fromkeys(variables_named(names, model)))
    wrong = []
    for name in found:
        if not isinstance(inputs.get(name), float):
            message = f"{name} is not an input with a number, so nothing can be derived by it"
            wrong.append(error("E425", message, notes=(f"give it a number: --set {name}=…",)))
    if wrong:
        raise RuleSheetError(*wrong)
    return found


def _one(
    total: Total, values: Values, output: str, given: str, corner: int | None
) -> float | Reason:
    """The derivative, or why there is none; ``corner`` is a rule with a function that has a kink or
    a jump as the input moves."""
    if not isinstance(values.get(output), float):
        return Reason("unsolved")
    if output == given:
        return 1.0
    if given in total.tied:
        return Reason("tied", total.tied[given])
    if corner is not None:
        return Reason("rough", corner)
    if output in total.by and output not in total.sharp.lost:
        slope = float(total.by[output].get(given, 0.0))
        # 0 where it is no more than what is left of terms that cancel at the digits computed with
        above, below = (abs(float(total.sharp.values[name])) or 1.0 for name in (output, given))
        return slope if abs(slope) * below > NO_SLOPE * above else 0.0
    rule = next((e for e, read in total.rough.items() if read & {output, *total.sharp.lost}), None)
    return Reason("free") if rule is None else Reason("rough", rule)


# --- where the rules have no slope: limits of the derivatives from one side ---

Near = Callable[[Values, Mapping[str, float]], Values | None]
"""The answer for some inputs that is nearest to guesses; None where there is none."""

NODES = 8
FARTHEST = 2.0**-10
"""Distance of the farthest node, in units of the input (or 1); each next one is half as far."""

ONE_LIMIT = 1e-12
"""Change of the limit by its farthest node, relative, at which it is one."""

CONTINUOUS, NOUGHT = 1e-9, 1e-15
"""Relative distance of an output from its limit, and of a limit from 0, at which they are taken for
one."""


def one_sided(
    model: Model,
    values: Values,
    inputs: Values,
    outputs: Sequence[str],
    given: str,
    side: int,
    near: Near,
) -> dict[str, float]:
    """Limits of the derivatives by ``given`` from above (``side`` 1) or below (-1), if there are
    any.

    An output that is not continuous there has none; without answers on that side nothing has.
    """
    middle = inputs[given]
    assert isinstance(middle, float)
    guesses = {n: v for n, v in values.items() if isinstance(v, float) and n not in inputs}
    reach = FARTHEST * max(abs(middle), 1.0)
    nodes, near_by = list[Extended](), list[Total]()
    for k in range(NODES):
        at = middle + side * reach * 2.0**-k
        moved = {**inputs, given: at}
        if (answer := near(moved, guesses)) is None:
            return {}
        near_by.append(totals(model, answer, moved, (given,)))
        nodes.append(number(at) - number(middle))
    found = {}
    for output in outputs:
        if any(output in t.sharp.lost or output not in t.by or given in t.tied for t in near_by):
            continue
        levels = [total.sharp.values[output] for total in near_by]
        slope = _limit(nodes, [total.by[output].get(given, number(0.0)) for total in near_by])
        level, here = _limit(nodes, levels), values[output]
        if slope is None or level is None or not isinstance(here, float):
            continue
        if abs(level - here) <= CONTINUOUS * max(abs(here), *map(abs, levels)):
            found[output] = float(slope)
    return found


def _limit(nodes: Sequence[Extended], samples: Sequence[Extended]) -> Extended | None:
    """The value at 0 of the polynomial through the samples, by Neville's scheme; None if it depends
    on the farthest one."""
    row, rest = list(samples), samples[-1]
    for step in range(1, len(row)):
        rest = row[1]
        for i in range(len(row) - step):
            far, near = nodes[i], nodes[i + step]
            row[i] = (far * row[i + 1] - near * row[i]) / (far - near)
    size = max(map(abs, samples))
    if abs(row[0] - rest) > ONE_LIMIT * size:
        return None
    return row[0] if abs(row[0]) > NOUGHT * size else row[0] * 0


class Contribution(NamedTuple):
    """The contribution of one input to an output: ``amount`` = |∂output/∂input| · tolerance, in the
    output's unit.

    ``share`` is its part of the root-sum-square, amount² / Σ amount², between 0 and 1.
    """

    input: str
    amount: float
    share: float


class Band(NamedTuple):
    """The tolerance of an output to first order, the largest contribution first.

    ``worst``: Σ amount, every input at the worse end of its tolerance. ``rss``: √(Σ amount²), the
    same multiple of the output's standard deviation as the tolerances are for independent inputs.
    """

    name: str
    value: float
    worst: float
    rss: float
    contributions: tuple[Contribution, ...]


class ToleranceBands(dict[str, Band | None], Shown):
    """The band of every output; None if a derivative is missing (``diagnoses`` say why).

    ``tolerances`` are those of the inputs, in their own units.
    """

    def __init__(
        self, tolerances: Mapping[str, float], slopes: Sensitivities, answer: Values
    ) -> None:
        found = ((n, _band(n, answer.get(n), tolerances, slopes)) for n in slopes.outputs)
        super().__init__(found)
        self.tolerances, self.model = tolerances, slopes.model
        self.diagnoses = slopes.diagnoses


def _band(
    name: str, value: Value | None, tolerances: Mapping[str, float], slopes: Sensitivities
) -> Band | None:
    amounts: dict[str, float] = {}
    for given, tolerance in tolerances.items():
        if (slope := slopes[name, given]) is None:
            return None
        amounts[given] = abs(slope) * tolerance
    if not isinstance(value, float):
        return None
    rss = math.hypot(*amounts.values())
    ranked = sorted(amounts.items(), key=lambda item: -item[1])
    parts = (Contribution(given, one, (one / rss) ** 2 if rss else 0.0) for given, one in ranked)
    return Band(name, value, math.fsum(amounts.values()), rss, tuple(parts))


def tolerances_of(
    model: Model, inputs: Values, given: Mapping[str, float | Tolerance] | None
) -> dict[str, float]:
    """The tolerances of the inputs that are numbers, in their own units: those of the sheet,
    overridden.

    Raises RuleSheetError for names that the model does not have (E407) and for a tolerance that is
    negative or not finite (E405).
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
