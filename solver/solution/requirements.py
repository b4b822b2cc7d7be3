"""Requirements: comparisons that an answer has to satisfy, and that determine nothing."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping

from rulesheets.evaluate import Undefined, value
from rulesheets.evaluate.conditions import meets
from rulesheets.model import Model, Requirement, Value
from solver.facts import Unmet
from solver.path.cases import activity


def unmet(model: Model, values: Mapping[str, Value], decided: Mapping[int, bool]) -> Iterator[Unmet]:
    """The requirements that these values break; those that read what has no value are not asked."""
    for index, requirement in enumerate(model.requirements):
        asked = activity(requirement, decided) and all(name in values for name in requirement.names)
        if asked and not _met(requirement, values):
            yield Unmet(index, shortfall(requirement, values), values)


def shortfall(requirement: Requirement, values: Mapping[str, Value]) -> float | None:
    """How far the smaller side is from where it has to be; None where a side is no number."""
    sides = requirement.comparison.left, requirement.comparison.right
    try:
        left, right = (value(side, values) for side in sides)
    except (Undefined, TypeError):
        return None
    apart = abs(left - right)
    return apart if math.isfinite(apart) else None


def _met(requirement: Requirement, values: Mapping[str, Value]) -> bool:
    try:
        return meets(requirement.comparison, values)
    except Undefined:
        return False
