"""How conditions come out, and whether a guarded equation takes part then."""

from __future__ import annotations

from collections.abc import Collection, Mapping

from rulesheets.evaluate import Undefined, holds
from rulesheets.model import Equation, Model, Requirement, Value


def outcomes(model: Model, values: Mapping[str, Value], inputs: Collection[str]) -> dict[int, bool]:
    """The conditions that these values settle; one that has no value there is false."""
    found = {}
    for index, condition in enumerate(model.conditions):
        try:
            found[index] = holds(condition, values, inputs)
        except KeyError:
            continue
        except Undefined:
            found[index] = False
    return found


def activity(equation: Equation | Requirement, decided: Mapping[int, bool]) -> bool | None:
    """True: active (of a requirement: asked); False: its guard is false; None: not known yet."""
    verdict: bool | None = True
    for premise in equation.guard:
        outcome = decided.get(premise.condition)
        if outcome is None:
            verdict = None
        elif outcome is not premise.holds:
            return False
    return verdict
