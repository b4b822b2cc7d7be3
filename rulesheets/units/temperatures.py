"""Points of a temperature scale and differences; rules that need absolute temperatures."""

from __future__ import annotations

import re
from collections.abc import Iterator
from itertools import chain
from typing import NamedTuple

from rulesheets.diagnosis import Diagnosis, Label, Severity
from rulesheets.evaluate import Undefined, derivatives
from rulesheets.functions import TABLE
from rulesheets.model import Equation, Model
from rulesheets.syntax.nodes import Call, Condition, Expression, Name, Sum, names
from rulesheets.syntax.program import degree, walk

_DIFFERENCE = re.compile(r"(?:[dD]_?[Tt]|[dD]elta|Δ|LMTD|lmtd)")
"""The beginnings of names of differences, which decide if the rules do not."""
PLACES, TRIES = 3, 8
NOISE = 1e-9
"""Share of the slopes that may be left of their sum by rounding."""


class TemperatureRule(NamedTuple):
    """A rule with its slopes by temperatures, each by a kelvin, at some places."""

    equation: Equation
    slopes: tuple[dict[str, float], ...]

    def holds(self, differences: set[str]) -> bool:
        """Whether it still holds if all points shift together."""
        for row in self.slopes:
            moved = sum(slope for name, slope in row.items() if name not in differences)
            if abs(moved) > NOISE * sum(map(abs, row.values())):
                return False
        return True

    def points(self, differences: set[str]) -> list[str]:
        varied = {name for row in self.slopes for name, slope in row.items() if slope}
        return [name for name in self.slopes[0] if name in varied - differences]


class Weights:
    """``differences`` are the temperatures of a model that are differences of points of a scale.

    A law of nature does not depend on the zero of a scale: if all points in a rule shift by one
    kelvin and the differences stay, it still holds. ``dT = T1 - T2`` and ``Q = m*c*(T1 - T2)`` do
    so if dT is a difference; ``p*v = R*T`` does not, and needs an absolute temperature. This is
    decided by the slopes of a rule by its temperatures at a few places.
    """

    def __init__(self, model: Model) -> None:
        self.model = model
        measures = ((name, variable.measure) for name, variable in model.variables.items())
        self.units = {name: unit for name, unit in measures if unit and unit.bases == {"K": 1}}
        self.rules = [rule for rule in map(self._rule, model.equations) if rule is not None]
        marked = {n: model.variables[n].unit or "" for n in self.units}
        self.differences = {n for n, unit in marked.items() if "delta" in unit or "Δ" in unit}
        self.differences |= {n for n in marked if _DIFFERENCE.match(n.rpartition(".")[2])}
        denied: set[str] = set()  # some are called points by a rule: dTm = (T1 + T2)/2
        for rule in [rule for rule in self.rules if not rule.holds(self.differences)]:
            named = self.differences & rule.slopes[0].keys()
            denied.update(name for name in named if rule.holds(self.differences - {name}))
        self.differences -= denied
        for settle in (self._only_one, self._alone_on_a_side, self._of_differences, self._only_one):
            while sum(settle(rule) for rule in self.rules if not rule.holds(self.differences)):
                pass

    def _rule(self, equation: Equation) -> TemperatureRule | None:
        """The slopes of a rule; None if it has no temperature or no slopes."""
        here = [name for name in equation.names if name in self.units]
        rows = (TABLE.get(part.function) for part in _parts(equation) if isinstance(part, Call))
        # a file's own Python is not run
        if not here or any(row is None or row.source for row in rows):
            return None
        found: list[dict[str, float]] = []
        for attempt in range(1, TRIES + 1):
            values = {n: 1 + 0.618 * attempt * k % 1 for k, n in enumerate(equation.names, 1)}
            try:
                _, left = derivatives(equation.left, values)
                _, right = derivatives(equation.right, values)
            except (Undefined, KeyError, ValueError, OverflowError):
                continue
            apart = {n: left.get(n, 0.0) - right.get(n, 0.0) for n in here}
            row = {n: slope / float(self.units[n].factor) for n, slope in apart.items()}
            if all(slope == slope for slope in row.values()):
                found.append(row)
            if len(found) == PLACES:
                break
        return TemperatureRule(equation, tuple(found)) if len(found) > 1 else None

    # --- differences ---

    def _candidates(self, rule: TemperatureRule) -> list[str]:
        """The points of which one is a difference, if the others are points."""
        points = rule.points(self.differences)
        held = (name for name in points if rule.holds(self.differences | {name}))
        return list(held) if len(points) > 2 else []

    def _only_one(self, rule: TemperatureRule) -> bool:
        found = self._candidates(rule)
        self.differences.update(found if len(found) == 1 else ())
        return len(found) == 1

    def _alone_on_a_side(self, rule: TemperatureRule) -> bool:
        """``dT = T1 - T2`` is taken as the definition of dT, though T2 might be the difference."""
        sides = rule.equation.left, rule.equation.right
        found = [name for name in self._candidates(rule) if Name(name) in sides]
        self.differences.update(found[:1])
        return bool(found)

    def _of_differences(self, rule: TemperatureRule) -> bool:
        """``LMTD = (a - b)/ln(a/b)``: a value computed only from differences is one."""
        left, right = rule.equation.left, rule.equation.right
        for side, other in ((left, right), (right, left)):
            rest = set(names(other)) & self.units.keys()
            plain = isinstance(side, Name) and rule.points(self.differences) == [side.name]
            if plain and rest and rest <= self.differences and not isinstance(other, Sum):
                self.differences.add(side.name)  # type: ignore[union-attr]
                return True
        return False

    # --- mistakes ---

    def warnings(self, sure: bool) -> Iterator[tuple[Equation, Diagnosis]]:
        """Points of °C and °F in rules that need absolute temperatures, and scales that differ."""
        for rule in self.rules:
            points = rule.points(self.differences)
            scaled = [name for name in points if self.units[name].offset]
            if not scaled or self._open(rule.equation):
                continue
            if rule.holds(self.differences):
                offset = self.units[scaled[0]].offset
                other = next((n for n in points if self.units[n].offset != offset), None)
                if other is None:
                    continue
                one, two = (self.model.variables[name].unit for name in (scaled[0], other))
                apart = abs(float(offset - self.units[other].offset))
                where = f"{scaled[0]} is in {one}, {other} in {two}"
                message = f"{where}: their zeros are {apart:.6g} K apart"
                note = "give both in one unit, or write the number between them"
            elif self._candidates(rule) or self._may_mean(rule, sure):
                continue
            else:
                unit, measure = self.model.variables[scaled[0]].unit, self.units[scaled[0]]
                # below that of the scale, in its degrees
                zero = float(measure.offset / measure.factor)
                needed = "an absolute temperature or a difference"
                message = f"{scaled[0]} is in {unit}, and this rule needs {needed}"
                advice = f"write {scaled[0]} + {zero:.6g}, or give it in K"
                note = f"{advice}; a difference of temperatures is in K, too"
            label = Label(rule.equation.rule)
            yield rule.equation, Diagnosis("W603", Severity.WARNING, message, (label,), (note,))

    def _open(self, equation: Equation) -> bool:
        """Whether something is added to a temperature: ``T + 273.15`` may be absolute."""
        sums = [part.terms for part in _parts(equation) if isinstance(part, Sum)]
        for side, other in ((equation.left, equation.right), (equation.right, equation.left)):
            sums += [(side, other)] if isinstance(side, Name) and side.name in self.units else []
        return any({0.0, 1.0} <= {degree(term, self.units) for term in terms} for terms in sums)

    def _may_mean(self, rule: TemperatureRule, sure: bool) -> bool:
        """Whether its points may cancel by another rule, as in ``m1*c*T1 + m2*c*T2 = m*c*T``, or it
        counts an energy from the zero of the scale, as in ``h = c*T``, which it may mean to (where
        ``sure``)."""
        sides = rule.equation.left, rule.equation.right
        if max(degree(side, self.units) for side in sides) != 1.0:
            return False
        alone = (self.model.variables[side.name] for side in sides if isinstance(side, Name))
        units = [variable.measure for variable in alone]
        energy = any(unit is None or unit.bases.get("m") == 2 for unit in units)
        signs = {slope > 0.0 for slope in rule.slopes[0].values() if slope}
        return len(signs) == 2 or (sure and energy)


def _parts(equation: Equation) -> Iterator[Condition | Expression]:
    return chain(walk(equation.left), walk(equation.right))
