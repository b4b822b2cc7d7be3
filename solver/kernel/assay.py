"""Is a root that floats can't tell from its surroundings a root at all?

Far out in a valley every rule may hold to rounding, its terms being so large that what they differ by drowns,
although the rules have no common root there: only a limit at infinity. One Newton step tells, computed with
many digits at the very point: near a root, a multiple one even, it is short; in a valley it leads away.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from rulesheets.evaluate import Undefined, extended
from rulesheets.functions.extended import Extended, context
from solver.kernel.question import Question
from solver.numerics.elimination import eliminate

DIGITS = 60
NUDGE = 1e-9
SHORT = 0.02
"""The longest step, relative to the unknowns, that ends at a root nearby (multiple ones are blurred)."""


def leads_away(question: Question, point: Mapping[str, float]) -> bool:
    """Whether the exact Newton step from a point at which every rule holds to rounding is a long one.

    At the turn of a fold the step is long however near its two roots are, so one from beside the point
    may be the short one.
    """
    stepped = False
    sizes = [max(abs(point[name]), s) for name, s in zip(question.unknowns, question.scale(), strict=True)]
    for shift in (0.0, NUDGE):
        nudged = [
            v + shift * (k + 1) * size for k, (v, size) in enumerate(zip(point.values(), sizes, strict=True))
        ]
        try:
            residual, columns = _linearized(question, nudged, sizes)
        except (Undefined, ValueError):
            return False  # nothing speaks against it
        if not any(residual):
            return False
        change = eliminate(list(zip(*columns, strict=True)), residual)
        if change is not None and max(map(abs, change)) <= SHORT:
            return False
        stepped = stepped or change is not None
    return stepped


def _linearized(
    question: Question, x: Sequence[float], sizes: Sequence[float]
) -> tuple[list[Extended], list[list[Extended]]]:
    """Residuals (n,) and their changes with each unknown (n, n), by columns, in units of the sizes."""
    mp, names, forms = context(DIGITS), question.unknowns, question.kernel.forms
    step = mp.mpf(10) ** (-DIGITS // 2)
    here = {**question.here, **{name: mp.mpf(v) for name, v in zip(names, x, strict=True)}}
    residual = [extended(form, here, DIGITS) for form in forms]
    columns = []
    for name, size in zip(names, sizes, strict=True):
        ahead = {**here, name: here[name] + size * step}
        moved = [extended(form, ahead, DIGITS) for form in forms]
        columns.append([(b - a) / step for a, b in zip(residual, moved, strict=True)])
    return residual, columns
