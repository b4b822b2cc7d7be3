"""One solve: inputs in, a judged and explained result out."""

from __future__ import annotations

import gc
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING

from rulesheets.deadline import TimeIsUp, grace, time_limit
from rulesheets.inputs import override, variables_named
from rulesheets.model import Model, Value
from solver.facts import OutOfTime, Status, Unmet
from solver.leaves import Asked, CutOff, Exploration, Leaf, infinite, leaf_errors
from solver.path import Path
from solver.path.planner import planner
from solver.ranking.ranking import unlikely
from solver.result import Result, Solution
from solver.solution.conclusion import conclude, require_proof
from solver.solution.refinement import explore_required
from solver.solution.verdict import Verdict, judge

CUT = "S593"
"""The code of a note on a list of answers that was cut off."""
COLLECTION = 100_000, 50, 100
"""Thresholds of the garbage collector: large sheets are objects that stay, not worth going over often."""
GRACE = 2.0
"""Seconds to explain a verdict whose remedies took too long."""

if TYPE_CHECKING:
    from rulesheets.diagnosis import Diagnosis


def solve(
    model: Model,
    inputs: Mapping[str, Value | None] | None = None,
    want: Iterable[str] | None = None,
    guesses: Mapping[str, float] | None = None,
    prove: bool = False,
    timeout: float | None = None,
    limits: bool = False,
) -> Result:
    """Solve a model for whatever is not an input.

    ``inputs`` override those of the sheet; None clears one. ``want`` names the variables that
    are asked for: nothing else can fail, except requirements that direct steps lead to. ``guesses`` say which
    of several answers comes first (and start the iteration where there is one). Values are in calculation
    units.

    ``prove``: every answer is proved to exist and to be the only one within ``solution.radius``, as far as
    ``solution.proof`` says; this needs python-flint.

    ``limits``: rules that are 0/0 at an answer are taken by their limits, forward and backward; so they are
    where the sheet has ``limits = yes``. ``timeout``: a limit in seconds. When it is met, the answers found
    until then are listed (``complete`` is False), or the status is ``failed`` and ``partial`` holds what was
    determined; a diagnosis says so.

    Raises RuleSheetError for names that the model does not have, numbers that are not finite, and
    values outside the range that the sheet declares; ValueError for a limit that is not positive.
    """
    effective = override(model, inputs, guesses)
    given, hints = effective.values, effective.guesses
    wanted = None if want is None else variables_named(want, model)
    asked = Asked(model, given, wanted, hints, posted(model) if wanted is None else wanted)
    if prove:
        require_proof()
    try:
        with time_limit(timeout), _rare_collection():
            verdict, found, by = conclude(asked, prove=prove, limits=limits or model.limits)
            result = _result(asked, by, verdict, found.complete, prove)
            if result.status is not Status.SOLVED or result.complete:
                return result
            from solver.solution.explain import gap_note

            gaps = tuple(gap_note(model, gap) for gap in sorted(found.gaps, key=lambda gap: not gap.cut))
            cut = tuple(note for note in gaps if note.code == CUT)
            return replace(result, gaps=gaps, diagnoses=(*result.diagnoses, *cut))
    except TimeIsUp as up:
        return _cut_off(asked, up if isinstance(up, CutOff) else CutOff(Exploration((), False, ()), given))


@contextmanager
def _rare_collection() -> Iterator[None]:
    """The garbage collector looks but rarely; not at all where it has been switched off."""
    usual = gc.get_threshold()
    gc.set_threshold(*(COLLECTION if usual[0] else usual))
    try:
        yield
    finally:
        gc.set_threshold(*usual)


def _cut_off(asked: Asked, reached: CutOff) -> Result:
    """What is known when the time is up: the answers found until then, else the values determined."""
    verdict = judge(asked, reached.found)
    fact = OutOfTime(tuple(name for name in reached.known if name not in asked.inputs))
    if verdict.status is Status.SOLVED:
        verdict = verdict._replace(facts=(fact,))
    else:
        verdict = Verdict(Status.FAILED, (), (fact,))
    result = _result(asked, asked.model, verdict, False, False)
    return result if result.solutions else replace(result, partial=reached.known)


def posted(model: Model) -> tuple[str, ...]:
    """The names that a solve without ``want`` is judged by."""
    names = tuple(name for name, variable in model.variables.items() if variable.posted)
    return names or tuple(model.variables)


def _result(asked: Asked, by: Model, verdict: Verdict, complete: bool, prove: bool) -> Result:
    """The result of a verdict that was come to ``by`` the rules as they are read at these values."""
    model, inputs, _, guesses, judged = asked
    status, leaves = verdict.status, verdict.leaves
    primary = leaves[0] if leaves else None
    beyond = {name for name in judged if primary is not None and infinite(model, primary.branch, name)}
    refused = any(isinstance(fact, Unmet) for fact in verdict.facts)
    alone = status is Status.INFEASIBLE and len(leaves) == 1 and not refused
    determined = leaves[0].branch.values if alone else inputs  # even though the whole is not solved
    known, asked_for = determined, {*judged} - beyond
    solutions: list[Solution] = []
    if primary is not None and status in (Status.SOLVED, Status.PARTIAL, Status.SINGULAR):
        known = primary.branch.values
        likely = unlikely(by, [leaf.branch.values for leaf in leaves], inputs, guesses)
        for leaf, names in zip(leaves, likely, strict=True):
            values, measure, proof = leaf.branch.values, partial(leaf_errors, by, leaf), None
            if prove:
                from solver.solution.proof import prove as proved

                with suppress(TimeIsUp):
                    proof = proved(by, leaf, inputs)
            solutions.append(Solution(values, leaf.worst, leaf.checked, measure, proof, names))
    return Result(
        model=model,
        status=status,
        solutions=tuple(solutions),
        complete=status is Status.INFEASIBLE or (complete and not verdict.facts and status is Status.SOLVED),
        inputs=inputs,
        guesses=guesses,
        wanted=tuple(name for name in judged if name not in beyond),
        undetermined=tuple(n for n in model.variables if n in asked_for and n not in known),
        diagnoses=_explained(asked, verdict),
        path=_path(model, primary, inputs),
        partial=determined,
        origins={} if primary is None else primary.branch.origins,
        attempts={} if primary is None else primary.branch.attempts,
        near=partial(_near, asked),
    )


def _near(
    asked: Asked, inputs: Mapping[str, Value], guesses: Mapping[str, float]
) -> Mapping[str, Value] | None:
    """The answer nearest to the guesses, None where there is none."""
    asked = asked._replace(inputs=inputs, guesses=guesses)
    verdict = judge(asked, explore_required(asked))
    return verdict.leaves[0].branch.values if verdict.status is Status.SOLVED else None


def _explained(asked: Asked, verdict: Verdict) -> tuple[Diagnosis, ...]:
    """What there is to say; of an answer that nothing stood in the way of, nothing."""
    branches = [leaf.branch for leaf in verdict.leaves]
    noted = verdict.facts or any(branch.facts for branch in branches)
    if verdict.status is Status.SOLVED and branches and not noted and not branches[0].void:
        return ()
    from solver.solution.explain import explain

    try:
        return explain(asked, verdict)
    except TimeIsUp:  # while remedies were tried
        with grace(GRACE):
            return explain(asked, verdict, hasty=True)


def _path(model: Model, primary: Leaf | None, inputs: Mapping[str, Value]) -> Path:
    if primary is None:
        with suppress(TimeIsUp):
            return planner(model).path(frozenset(inputs), {})
        return Path((), tuple(name for name in model.variables if name not in inputs))
    missing = tuple(name for name in model.variables if name not in primary.branch.values)
    return Path(tuple(primary.branch.steps), missing)
