"""Whether a guarded equation takes part, by how conditions came out."""

from __future__ import annotations

from collections.abc import Mapping

from rulesheets.model import Equation


def activity(equation: Equation, decided: Mapping[int, bool]) -> bool | None:
    """True: active; False: its guard is false; None: not known yet."""
    verdict: bool | None = True
    for premise in equation.guard:
        outcome = decided.get(premise.condition)
        if outcome is None:
            verdict = None
        elif outcome is not premise.holds:
            return False
    return verdict
