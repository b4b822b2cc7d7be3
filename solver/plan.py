"""A model prepared for one pattern of inputs and outputs: floats in, checked floats out."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from rulesheets.deadline import TimeIsUp, time_limit
from rulesheets.diagnosis import Diagnosis
from rulesheets.input_messages import not_finite_number, outside_range
from rulesheets.inputs import override, variables_named
from rulesheets.model import Model, Value, Variable, expect_model
from solver.arguments import arguments
from solver.compiled.scalar import with_resort
from solver.compiled.way import Pattern
from solver.facts import OutOfTime
from solver.path.activity import activity
from solver.path.planner import planner
from solver.ranking.ranking import Ranking
from solver.result import Status
from solver.solution.leaves import Exploration, Leaf
from solver.trace.paths import CompiledPaths
from solver.verdicts.conclusion import conclude
from solver.verdicts.explain import explain
from solver.verdicts.verdict import Verdict

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from solver.compiled.program import Program
    from solver.table import Column, Table
    from solver.trace.answer_rows import Answers, AnswerSweeper


class Unsolved(Exception):
    """There is no answer. ``status`` says why in a word, ``diagnoses`` in sentences."""

    def __init__(self, status: Status, diagnoses: tuple[Diagnosis, ...]) -> None:
        super().__init__(f"{status}: " + "; ".join(d.message for d in diagnoses))
        self.status = status
        self.diagnoses = diagnoses


class Plan:
    """What ``prepare`` returns. Numbers come in the order of ``inputs`` and go in that of ``want``.

    Rows that decide alike share one compiled way, learned from the first of them; rows that no way
    settles are solved step by step.
    """

    def __init__(
        self,
        model: Model,
        inputs: tuple[str, ...],
        want: tuple[str, ...],
        given: Mapping[str, Value],
        guesses: Mapping[str, float],
        timeout: float | None = None,
    ) -> None:
        self.model, self.inputs, self.want = model, inputs, want
        self.given, self.guesses, self.timeout = given, guesses, timeout
        self.paths = CompiledPaths(model, planner(model), Pattern(inputs, given, want, guesses))
        self.ranking = Ranking(model, (*inputs, *given), want, guesses)
        self._sweeper: AnswerSweeper | None = None
        self._bound: Program | None = None
        self._call(self._primary, self._every)

    def __repr__(self) -> str:
        return f"<Plan ({', '.join(self.inputs)}) -> ({', '.join(self.want)})>"

    if TYPE_CHECKING:

        def __call__(self, *numbers: Value, **named: Value) -> tuple[Value, ...]:
            """The wanted values of the primary answer for a number of each input, by place or by name.

            Raises Unsolved where there is none, as for an infinite number, TypeError for what is no number.
            """

        def all(self, *numbers: Value, **named: Value) -> list[tuple[Value, ...]]:
            """Those of every answer, the primary one first. Raises as a call does."""

    else:
        # Of each plan its own, so that a call goes straight into the compiled way.
        __slots__ = ("__call__", "__dict__", "__weakref__", "all")

    def _call(self, primary: Callable[..., Any], every: Callable[..., Any]) -> None:
        for name, function in (("__call__", primary), ("all", every)):
            object.__setattr__(self, name, function)

    def _bind(self) -> None:
        """Let calls begin with the first way that there is, where answers need no order."""
        paths = self.paths
        if paths.programs and not self.wide and self._bound is not paths.programs[0]:
            self._bound = paths.programs[0]
            ways = (paths.primary(), self._primary), (paths.every[0], self._every)
            self._call(*(with_resort(*pair) for pair in ways))

    @property
    def wide(self) -> bool:
        """Whether more than the wanted names is computed: all that the order of answers depends on."""
        return self.paths.pattern.want is not self.want

    def _widen(self, answer: Mapping[str, Value]) -> None:
        """Begin anew with ways that compute all that the order depends on, which ``answer`` has values of."""
        among = (*self.want, *(name for name in answer if name not in self.want))
        self.ranking = Ranking(self.model, (*self.inputs, *self.given), among, self.guesses)
        names = (*self.want, *(name for name in self.ranking.read if name not in self.want))
        pattern = replace(self.paths.pattern, want=names, pruned=self.want)
        self.paths = CompiledPaths(self.model, planner(self.model), pattern)
        self._bound = None
        self._call(self._primary, self._every)

    def _primary(self, *given: Value | None, **named: Value) -> tuple[Value, ...]:
        """What the first way does not settle, or all where there is none yet."""
        return self._listed(self._numbers(given, named))[0]

    def _every(self, *given: Value | None, **named: Value) -> list[tuple[Value, ...]]:
        return self._listed(self._numbers(given, named))

    def _listed(self, numbers: tuple[Value, ...]) -> list[tuple[Value, ...]]:
        for way, program in zip(self.paths.every, self.paths.programs, strict=True):
            if (found := way(*numbers)) is not None:
                return self._wanted(found if program.ordered else self._in_order(numbers, found))
        return self._answers(numbers)

    def _in_order(self, numbers: Sequence[Value], rows: list[tuple[Value, ...]]) -> list[tuple[Value, ...]]:
        if len(rows) < 2:
            return rows
        places = {name: place for place, name in enumerate(self.paths.pattern.want)}
        there = [places.get(name) for name in self.ranking.read]
        read = [tuple(_float(row[at]) if at is not None else math.nan for at in there) for row in rows]
        given = [_float(value) for value in self.known(numbers)]
        return [rows[place] for place in self.ranking.order_of_rows(read, given)]

    def _wanted(self, rows: Iterable[tuple[Value, ...]]) -> list[tuple[Value, ...]]:
        """The wanted values of answers, none of them twice."""
        return list(dict.fromkeys(row[: len(self.want)] for row in rows))

    def known(self, inputs: Sequence[Any]) -> list[Any]:
        """What the order of answers is told of the inputs: numbers or columns of them, and what is fixed."""
        values = {**self.given, **dict(zip(self.inputs, inputs, strict=True))}
        return [math.nan if isinstance(values[n], str) else values[n] for n in self.ranking.known]

    def _numbers(self, given: tuple[Value | None, ...], named: Mapping[str, Value]) -> tuple[Value, ...]:
        """The numbers of a call; places that a compiled way has filled up hold None."""
        while given and given[-1] is None:
            given = given[:-1]
        return arguments(self.model, self.inputs, given, named)

    def sweep(self, *columns: Column, jit: bool = False) -> Table:
        """One solve a row for arrays (n,) in the order of ``inputs``; a row without an answer is NaN.

        With ``jit`` the ways are compiled to machine code (extra ``jit``), which pays from about 1e5 rows.
        Raises ValueError for columns of different lengths, ImportError where the extra is absent.
        """
        from solver.sweep_rows import sweep_rows

        return sweep_rows(self, columns, jit)

    def sweep_all(self, *columns: Column, jit: bool = False) -> tuple[NDArray[np.int8], Answers]:
        """Every answer of each row for one or more arrays (n,) of numbers, and the status codes (n,).

        Raises ValueError and ImportError as ``sweep`` does.
        """
        from solver.sweep_rows import sweep_answers

        return sweep_answers(self, columns, jit)

    def sweeper(self, jit: bool) -> AnswerSweeper:
        """What solves rows by the ways that there are."""
        from solver.trace.answer_rows import AnswerSweeper

        if self._sweeper is None or self._sweeper.jit is not jit or self._sweeper.paths is not self.paths:
            self._sweeper = AnswerSweeper(self.paths, jit)
        return self._sweeper

    def outcome(self, numbers: tuple[Value, ...]) -> tuple[Status, list[tuple[Value, ...]]]:
        """The status of one row and, where it is solved, the wanted values of every answer in order."""
        status, rows = self.states(numbers)
        return status, self._wanted(rows)

    def states(self, numbers: tuple[Value, ...]) -> tuple[Status, list[tuple[Value, ...]]]:
        """The status of one row, and what the ways compute of every answer."""
        for way, program in zip(self.paths.every, self.paths.programs, strict=True):
            rows = way(*numbers)
            if rows is not None:
                return Status.SOLVED, rows if program.ordered else self._in_order(numbers, rows)
        verdict, found = self.judged(numbers)
        self.learn(numbers, verdict, found)
        if verdict.status is not Status.SOLVED:
            return verdict.status, []
        return verdict.status, self._rows(verdict)

    def _rows(self, verdict: Verdict) -> list[tuple[Value, ...]]:
        names = self.paths.pattern.want
        return [tuple(leaf.branch.values.get(n, math.nan) for n in names) for leaf in verdict.leaves]

    def judged(self, numbers: tuple[Value, ...]) -> tuple[Verdict, Exploration]:
        """Verdict on one row, unexplained; what it found out serves the rows that decide alike.

        A number that is nan is an input that the row lacks, and is solved for; one that is infinite is none
        at all. What floats leave vague is solved again in extended precision. Where the time is up the row
        is failed.
        """
        if any(isinstance(number, float) and math.isinf(number) for number in numbers):
            return Verdict(Status.PARTIAL, ()), Exploration((), False, ())
        if self._outside(numbers) is not None:
            return Verdict(Status.INFEASIBLE, ()), Exploration((), True, ())
        try:
            with time_limit(self.timeout):
                values, limits = self._values(numbers), self.model.limits
                said = conclude(self.model, values, self.want, self.guesses, self.want, limits=limits)
                return said.verdict, said.found
        except TimeIsUp:
            return Verdict(Status.FAILED, (), (OutOfTime(()),)), Exploration((), False, ())

    def _outside(self, numbers: tuple[Value, ...]) -> tuple[float, Variable] | None:
        """The first number that lies outside the range that the sheet declares."""
        for name, number in zip(self.inputs, numbers, strict=True):
            variable = self.model.variables[name]
            if isinstance(number, str) or not math.isfinite(number):
                continue
            if not variable.admits(float(number)):
                return float(number), variable
        return None

    def _values(self, numbers: tuple[Value, ...]) -> dict[str, Value]:
        """The inputs of a row by name, those that it lacks left out."""
        row = {n: v if isinstance(v, str) else float(v) for n, v in zip(self.inputs, numbers, strict=True)}
        return {**self.given, **{n: v for n, v in row.items() if isinstance(v, str) or math.isfinite(v)}}

    def learn(self, numbers: tuple[Value, ...], verdict: Verdict, found: Exploration) -> None:
        """A compiled way from a row that was judged step by step, where it has one.

        Of an infeasible row it is the way to its refusal, where nothing but that is known of it. A row that
        lacks an input teaches nothing: it is solved for it; nor does one whose rules were read anew for it.
        """
        if verdict.reread or not all(isinstance(number, str) or math.isfinite(number) for number in numbers):
            return
        if verdict.status is Status.SOLVED:
            self._learn(verdict.leaves, numbers)
            return
        ends = (*found.leaves, *found.dead, *found.adrift)
        if verdict.status is not Status.INFEASIBLE or len(ends) != 1 or found.dead:
            return
        branch = ends[0].branch
        known = [e for e in self.model.equations if all(name in branch.values for name in e.names)]
        active = [e.index for e in known if activity(e, branch.decided)]
        if not branch.assumed and branch.settled.issuperset(active):
            self.paths.refuse(numbers, branch.values)

    def _learn(self, leaves: Sequence[Leaf], numbers: tuple[Value, ...]) -> None:
        if not self.wide and len(leaves) > 1:
            names = (*self.want, *(name for name in leaves[0].branch.values if name not in self.want))
            ranking = Ranking(self.model, (*self.inputs, *self.given), names, self.guesses)
            if self.paths.record(numbers, leaves, ranking):
                self._bind()
                return
        if not self.wide and len(leaves) == 1:
            self.paths.learn(numbers, leaves)
        if not self.wide and (len(leaves) > 1 or self.paths.forked):
            self._widen(leaves[0].branch.values)
        if self.wide:
            self.paths.learn(numbers, leaves)
        self._bind()

    def _answers(self, numbers: tuple[Value, ...]) -> list[tuple[Value, ...]]:
        verdict, found = self.judged(numbers)
        for name, number in zip(self.inputs, numbers, strict=True):
            if isinstance(number, float) and math.isinf(number):
                raise Unsolved(verdict.status, (not_finite_number(number, self.model.variables[name]),))
        if (outside := self._outside(numbers)) is not None:
            raise Unsolved(verdict.status, (outside_range(*outside, None),))
        if verdict.status is not Status.SOLVED:
            raise Unsolved(verdict.status, explain(self.model, verdict, self._values(numbers), self.want))
        self.learn(numbers, verdict, found)
        return self._wanted(self._rows(verdict))


def _float(value: Value) -> float:
    return math.nan if isinstance(value, str) else float(value)


def prepare(
    model: Model,
    inputs: Iterable[str],
    want: Iterable[str] | None = None,
    given: Mapping[str, Value | None] | None = None,
    guesses: Mapping[str, float] | None = None,
    timeout: float | None = None,
) -> Plan:
    """Fix the pattern of a solve: ``inputs`` will be given by position, ``want`` is returned.

    The sheet's other inputs, overridden by ``given`` (None clears one), are fixed now. ``want``
    defaults to the variables of the sheet that are no inputs, without those that calls only pass on to one
    another. ``timeout`` limits the seconds of a solve step by step; a call that meets the limit raises
    Unsolved with the status ``failed``. Raises RuleSheetError for names that the model does not have,
    ValueError for an input that is named twice.
    """
    expect_model(model)
    names = variables_named(inputs, model)
    if twice := [name for name in names if names.count(name) > 1]:
        raise ValueError(f"{twice[0]} stands twice among the inputs")
    effective = override(model, given, guesses)
    fixed = {name: value for name, value in effective.values.items() if name not in names}
    wanted = variables_named(want, model) if want is not None else ()
    if want is None:
        shown = [n for n, v in model.variables.items() if v.posted and not v.passed] or list(model.variables)
        wanted = tuple(n for n in shown if n not in fixed and n not in names)
    return Plan(model, names, wanted, fixed, effective.guesses, timeout)
