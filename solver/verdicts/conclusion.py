"""One question to its verdict: explored, judged, and judged again where more can be said."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace

from rulesheets.deadline import TimeIsUp
from rulesheets.model import Model, Value
from solver.result import Status
from solver.solution.leaves import Exploration
from solver.solution.narrowing import explore_required
from solver.verdicts.verdict import Verdict, judge


@dataclass(frozen=True)
class Conclusion:
    """A verdict, what it rests on, and the model as it was read for it (limits filled, say)."""

    verdict: Verdict
    found: Exploration
    model: Model


def conclude(
    model: Model,
    given: Mapping[str, Value],
    wanted: Sequence[str] | None,
    guesses: Mapping[str, float],
    judged: Sequence[str],
    *,
    prove: bool = False,
    limits: bool = False,
) -> Conclusion:
    """The verdict on these inputs. When the time is up after the first verdict, that is the last.

    Raises TimeIsUp before there is one.
    """
    found = explore_required(model, given, wanted, guesses, judged, always=prove)
    verdict, by = judge(model, found, given, guesses), model
    if verdict.status in (Status.SINGULAR, Status.PARTIAL):
        from solver.verdicts.vanishing import look_behind

        with suppress(TimeIsUp):
            behind = look_behind(model, found, verdict, given, wanted, guesses, judged, always=prove)
            by, found, verdict = behind or (by, found, verdict)
    with suppress(TimeIsUp):
        if limits:
            from solver.solution.limits import with_limits

            by, found = with_limits(model, found, given, wanted, guesses, judged)
            verdict = replace(judge(by, found, given, guesses), reread=by is not model)
        elif verdict.status is Status.FAILED:
            from solver.verdicts.limit import at_a_limit

            verdict = at_a_limit(model, verdict, given, wanted, guesses, judged) or verdict
        if verdict.status in (Status.FAILED, Status.INFEASIBLE):
            from solver.verdicts.fixed import fixed_otherwise

            verdict = fixed_otherwise(model, verdict, given) or verdict
    return Conclusion(verdict, found, by)
