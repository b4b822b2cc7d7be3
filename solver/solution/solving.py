"""One solve: inputs in, a judged and explained result out."""

from __future__ import annotations

import gc
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from importlib.util import find_spec
from typing import TYPE_CHECKING

from rulesheets.deadline import TimeIsUp, grace, in_one_chunk, limited, time_limit
from rulesheets.diagnosis import Diagnosis, RuleSheetError, error, plural
from rulesheets.inputs import override, variables_named
from rulesheets.model import Model, Tolerance, Value, Values
from solver.accuracy.forward_error import ForwardErrors
from solver.facts import Attempt, Gap, OutOfTime, Proof, Status, UnknownName, Unmet
from solver.leaves import (
    Asked,
    CutOff,
    Exploration,
    Leaf,
    conditions_without_value,
    infinite,
    leaf_errors,
)
from solver.path import Path, Shown, SolveBlock, Step, equations_of
from solver.path.planner import planner, with_checks
from solver.ranking.ranking import unlikely
from solver.solution.verdict import Verdict, explore_required, is_complete, judge

if TYPE_CHECKING:
    from solver.derivatives import Near, Sensitivities, ToleranceBands


SHOWN = 6
"""Values of an answer in its ``repr``."""


@dataclass(frozen=True)
class Solution(Values):
    """One answer: values by full name, inputs included. Names without a value are absent.

    ``worst_residual`` is the largest scaled residual |F| / Σ|∂F/∂v·v| over the rules ``checked``.
    ``accuracy`` holds the error bars and the conditions of the blocks, ``error`` the error bars
    alone: estimates of the absolute error of every number, 0 for inputs. ``unlikely`` are the names
    whose values are of unlikely size: a billion times larger or smaller than the rules and the
    inputs suggest.
    """

    by_name: Values
    worst_residual: float = field(default=0.0, repr=False)
    checked: int = 0
    measure: Callable[[], ForwardErrors] | None = field(default=None, repr=False, compare=False)
    proof: Proof | None = field(default=None, repr=False, compare=False)
    unlikely: tuple[str, ...] = ()

    @cached_property
    def accuracy(self) -> ForwardErrors:
        return self.measure() if self.measure else ForwardErrors({})

    @property
    def radius(self) -> Mapping[str, float]:
        """A proved upper bound of the error of every number, if a proof was requested."""
        return {} if self.proof is None else self.proof.radius

    @property
    def error(self) -> Mapping[str, float]:
        """An estimate of the absolute error of every number, 0 for inputs."""
        return self.accuracy.error

    def __getstate__(self) -> dict[str, object]:
        """Pickled with its error bars, which are computed on demand."""
        own: dict[str, object] = {name: self.__dict__[name] for name in self.__match_args__}
        return {**own, "measure": None, "accuracy": self.accuracy}

    def __getitem__(self, name: str) -> Value:
        if name not in self.by_name:
            raise UnknownName(name, self.by_name)
        return self.by_name[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self.by_name)

    def __len__(self) -> int:
        return len(self.by_name)


@dataclass(frozen=True)
class Result(Shown):
    """``solutions`` are distinct, the primary one first; ``complete`` if they are known to be all.

    ``inputs`` are the values that were given (after overrides and clearing), ``guesses`` likewise.
    ``wanted`` are the names that decide the status, ``undetermined`` those that stay unknown. If
    the status is not ``solved``, ``partial`` holds what the inputs determine. ``origins`` are the
    steps of the path that the values of the primary answer (or of ``partial``) came from;
    ``attempts`` the methods that were tried on each of its simultaneous blocks, in order; ``open``
    what may have other answers. ``near`` solves the same for other inputs, near to given
    values.
    """

    model: Model
    status: Status
    solutions: tuple[Solution, ...]
    complete: bool
    inputs: Values
    guesses: Mapping[str, float]
    wanted: tuple[str, ...]
    undetermined: tuple[str, ...]
    explain: Callable[[], tuple[Diagnosis, ...]] = field(repr=False, compare=False)
    path: Path
    partial: Values = field(default_factory=dict)
    origins: Mapping[str, Step] = field(default_factory=dict, repr=False)
    attempts: Mapping[SolveBlock, tuple[Attempt, ...]] = field(default_factory=dict, repr=False)
    open: tuple[Gap, ...] = field(default=(), repr=False)
    near: Near | None = field(default=None, repr=False, compare=False)

    @cached_property
    def diagnoses(self) -> tuple[Diagnosis, ...]:
        """The messages about the result, for which remedies are tried: made when they are asked
        for, or within the limit in time where there is one."""
        return tuple(dict.fromkeys((*self.explain(), *(g for g in self.gaps if g.code == CUT))))

    @cached_property
    def gaps(self) -> tuple[Diagnosis, ...]:
        """Why ``solutions`` may not be all."""
        if not self.open:
            return ()
        from solver.solution.explain import gap_note  # most lists are complete

        first = sorted(self.open, key=lambda gap: not gap.cut)
        return tuple(gap_note(self.model, gap) for gap in first)

    def __getstate__(self) -> dict[str, object]:
        own: dict[str, object] = {name: self.__dict__[name] for name in self.__match_args__}
        return {**own, "explain": partial(tuple, self.diagnoses)}

    def __getitem__(self, name: str) -> Value | None:
        """Value of the primary answer (or of the determined part); None if it has none.

        Raises KeyError for a name that the model does not have.
        """
        if name not in self.model.variables:
            raise UnknownName(name, self.model.variables)
        return self._answer(0).get(name)

    def __iter__(self) -> Iterator[str]:
        """The names with a value in the primary answer (or in the determined part)."""
        return iter(self._answer(0))

    def keys(self) -> Iterable[str]:
        """The same names: ``dict(result)`` has their values."""
        return self._answer(0).keys()

    def __repr__(self) -> str:
        known = self._answer(0)
        found = {
            name: known[name] for name in self.wanted if name in known and name not in self.inputs
        }
        told = [
            f"{n} = '{v}" if isinstance(v, str) else f"{n} = {v:.10g}" for n, v in found.items()
        ]
        values = ", ".join([*told[:SHOWN], "…"] if len(told) > SHOWN else told)
        answers = plural(len(self.solutions), "answer")
        return f"<Result {self.status}, {answers}{values and f': {values}'}>"

    def sensitivity(
        self,
        outputs: Iterable[str] | None = None,
        inputs: Iterable[str] | None = None,
        answer: int = 0,
    ) -> Sensitivities:
        """Derivatives of ``outputs`` (None: the wanted ones) by ``inputs`` (None: all that are
        numbers).

        They are exact, at the answer with that number, each input moved alone; the table has
        ``None`` for a missing one, and ``diagnoses`` that say why. Raises RuleSheetError for names
        that the model does not have, and for an input that was not given as a number; IndexError
        for a number without an answer.
        """
        from solver.derivatives import chosen_inputs, chosen_outputs, sensitivities

        values = self._answer(answer)
        shown = chosen_outputs(self.model, outputs, self.wanted, self.inputs, values)
        by = chosen_inputs(self.model, inputs, self.inputs)
        used = [e for step in self.path.steps for e in equations_of(step)]
        return sensitivities(
            self.model, values, self.inputs, shown, by, prefer=used, near=self.near
        )

    def tolerance_bands(
        self,
        tolerances: Mapping[str, float | Tolerance] | None = None,
        outputs: Iterable[str] | None = None,
        answer: int = 0,
    ) -> ToleranceBands:
        """The tolerances of ``outputs`` that follow from those of the inputs, to first order.

        ``tolerances`` override those of the sheet, in the units of the inputs. Raises
        RuleSheetError for names that the model does not have.
        """
        from solver.derivatives import ToleranceBands, tolerances_of

        sizes = tolerances_of(self.model, self.inputs, tolerances)
        found = self.sensitivity(outputs, sizes, answer)
        return ToleranceBands(sizes, found, self._answer(answer))

    def _answer(self, number: int) -> Values:
        """An answer by its number; without answers, the determined values."""
        if not self.solutions:
            return self.partial
        if not 0 <= number < len(self.solutions):
            last = len(self.solutions) - 1
            raise IndexError(f"there is no answer {number}: answers are 0 to {last}")
        return self.solutions[number]


def can_prove() -> bool:
    """Whether the extra is installed."""
    return find_spec("flint") is not None


def require_proof() -> None:
    """Raises RuleSheetError if the extra is not installed."""
    if not can_prove():
        notes = ("pip install 'backsolve[proof]'",)
        raise RuleSheetError(error("E449", "proof needs python-flint", notes=notes))


CUT = "S593"
"""The code of a note on a list of answers that was cut off."""
COLLECTION = 100_000, 50, 100
"""Thresholds of the garbage collector: large sheets are objects that stay, not worth going over
often."""
GRACE = 2.0
"""Seconds to explain a verdict whose remedies took too long."""


@in_one_chunk
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

    ``inputs`` override those of the sheet; None clears one. ``want`` names the variables that are
    asked for: nothing else can fail, except requirements that direct steps lead to. ``guesses`` say
    which of several answers comes first (and start the iteration where there is one). Values are in
    calculation units.

    ``prove``: every answer is proved to exist and to be the only one within ``solution.radius``, as
    far as ``solution.proof`` says; this needs python-flint.

    ``limits``: rules that are 0/0 at an answer are taken by their limits, forward and backward; so
    they are where the sheet has ``limits = yes``. ``timeout``: a limit in seconds. When it is met,
    the answers found until then are listed (``complete`` is False), or the status is ``failed`` and
    ``partial`` holds what was determined; a diagnosis says so.

    Raises RuleSheetError for names that the model does not have, numbers that are not finite, and
    values outside the range that the sheet declares; ValueError for a limit that is not positive.
    """
    effective = override(model, inputs, guesses)
    given, hints = effective.values, effective.guesses
    wanted = None if want is None else variables_named(want, model)
    judged = posted(model) if wanted is None else wanted
    asked = Asked(model, given, with_checks(model, given, wanted), hints, judged)
    if prove:
        require_proof()
    usual = gc.get_threshold()
    gc.set_threshold(*(COLLECTION if usual[0] else usual))  # not at all if it is switched off
    try:
        with time_limit(timeout):
            found = explore_required(asked, always=prove)
            verdict, found, by = conclude(asked, found, prove=prove, limits=limits or model.limits)
            result = _result(asked, by, verdict, found, prove)
            if limited():
                _ = result.diagnoses
            return result
    except TimeIsUp as up:
        nothing = CutOff(Exploration((), False, ()), given)
        return _cut_off(asked, up if isinstance(up, CutOff) else nothing)
    finally:
        gc.set_threshold(*usual)


def conclude(
    asked: Asked, found: Exploration, *, prove: bool = False, limits: bool
) -> tuple[Verdict, Exploration, Model]:
    """The verdict on what was ``found``, or on what was found after rules were read again, the
    exploration that it is about, and the model as it was read for it."""
    verdict = judge(asked, found)
    if verdict.status not in (Status.SOLVED, Status.PARTIAL):
        from solver.solution.reread import without_copies

        if (agreeing := without_copies(asked, found, prove)) is not None:
            found, verdict = agreeing, judge(asked, agreeing)._replace(reread=True)
    settled = verdict.status in (Status.SOLVED, Status.INCONSISTENT) and not limits
    if settled and not any(outcome.holes for outcome in found.outcomes.values()):
        return verdict, found, asked.model
    from solver.solution.reread import joined, judged_again, undefined_beside

    if settled:
        whole = joined(asked, found)
        holes = undefined_beside(whole, found, verdict.leaves[0].branch.values)
        return verdict._replace(facts=(*verdict.facts, *holes)), found, asked.model
    return judged_again(asked, found, verdict, prove, limits)


def _cut_off(asked: Asked, reached: CutOff) -> Result:
    """The results when the time is up: the answers found until then, else the values determined."""
    verdict = judge(asked, reached.found)
    fact = OutOfTime(tuple(name for name in reached.known if name not in asked.inputs))
    if verdict.status is Status.SOLVED:
        verdict = verdict._replace(facts=(fact,))
    else:
        verdict = Verdict(Status.FAILED, (), (fact,))
    found = replace(reached.found, gaps=())
    result = _result(asked, asked.model, verdict, found, False)
    return result if result.solutions else replace(result, partial=reached.known)


def posted(model: Model) -> tuple[str, ...]:
    """The names that decide the status of a solve without ``want``."""
    names = tuple(name for name, variable in model.variables.items() if variable.posted)
    return names or tuple(model.variables)


def _result(asked: Asked, by: Model, verdict: Verdict, found: Exploration, prove: bool) -> Result:
    """The result; ``by`` is the model as it was read at these values."""
    model, inputs, _, guesses, judged = asked
    status, leaves = verdict.status, verdict.leaves
    primary = leaves[0] if leaves else None
    beyond = {
        name for name in judged if primary is not None and infinite(model, primary.branch, name)
    }
    refused = any(isinstance(fact, Unmet) for fact in verdict.facts)
    alone = status is Status.INFEASIBLE and len(leaves) == 1 and not refused
    determined = leaves[0].branch.values if alone else inputs  # even though the whole is not solved
    known, asked_for = determined, {*judged} - beyond
    solutions: list[Solution] = []
    if primary is not None and status in (Status.SOLVED, Status.PARTIAL, Status.SINGULAR):
        known = primary.branch.values
        likely = unlikely(by, [leaf.branch.values for leaf in leaves], inputs, guesses)
        for leaf, names in zip(leaves, likely, strict=True):
            values = {n: 0.0 if v == 0.0 else v for n, v in leaf.branch.values.items()}
            measure, proof = partial(leaf_errors, by, leaf), None
            if prove:
                from solver.solution.proof import prove as proved

                with suppress(TimeIsUp):
                    proof = proved(by, leaf, inputs)
            solutions.append(Solution(values, leaf.worst, leaf.checked, measure, proof, names))
    complete = is_complete(verdict, found)
    return Result(
        model=model,
        status=status,
        solutions=tuple(solutions),
        complete=complete,
        inputs=inputs,
        guesses=guesses,
        wanted=tuple(name for name in judged if name not in beyond),
        undetermined=tuple(n for n in model.variables if n in asked_for and n not in known),
        explain=partial(_explained, asked, verdict),
        path=_path(model, primary, inputs),
        partial=determined,
        origins={} if primary is None else primary.branch.origins,
        attempts={} if primary is None else primary.branch.attempts,
        open=() if complete or status is not Status.SOLVED else found.gaps,
        near=partial(_near, asked),
    )


def _near(asked: Asked, inputs: Values, guesses: Mapping[str, float]) -> Values | None:
    """The answer nearest to the guesses, None if there is none."""
    asked = asked._replace(inputs=inputs, guesses=guesses)
    verdict = judge(asked, explore_required(asked))
    return verdict.leaves[0].branch.values if verdict.status is Status.SOLVED else None


@in_one_chunk
def _explained(asked: Asked, verdict: Verdict) -> tuple[Diagnosis, ...]:
    """The messages about a result; none for an undisturbed answer."""
    branches = [leaf.branch for leaf in verdict.leaves]
    noted = verdict.facts or any(branch.facts for branch in branches)
    noted = noted or any(
        True for leaf in verdict.leaves[:1] for _ in conditions_without_value(asked, leaf)
    )
    if verdict.status is Status.SOLVED and branches and not noted and not branches[0].inactive:
        return ()
    from solver.solution.explain import explain

    try:
        return explain(asked, verdict)
    except TimeIsUp:  # while remedies were tried
        with grace(GRACE):
            return explain(asked, verdict, hasty=True)


def _path(model: Model, primary: Leaf | None, inputs: Values) -> Path:
    if primary is None:
        with suppress(TimeIsUp):
            return planner(model).path(frozenset(inputs), {})
        return Path((), tuple(name for name in model.variables if name not in inputs))
    branch = primary.branch
    steps = dict.fromkeys((*branch.steps, *branch.attempts))  # and a block without answer
    missing = tuple(name for name in model.variables if name not in branch.values)
    return Path(tuple(steps), missing)
