"""Many solves of one question; this module prepares a model for one pattern of inputs and outputs:
floats go in, checked floats come out."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from functools import cached_property
from itertools import pairwise
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from rulesheets.deadline import WATCH, TimeIsUp, expect_time, interrupted, time_limit
from rulesheets.diagnosis import Diagnosis, meant, plural
from rulesheets.inputs import (
    not_finite_number,
    outside_range,
    override,
    quantities,
    symbol_name,
    variables_named,
)
from rulesheets.model import Model, Row, Value, Values, expect
from solver.facts import OutOfTime, Status, Unsolved
from solver.files.tables import CODES, Column, Table, column_of, free_name, one_length
from solver.leaves import Asked, Exploration, blocked, different
from solver.path.planner import planner, with_checks
from solver.ranking.branches import Answers, found_again, kept, together
from solver.solution.explain import explain
from solver.solution.explore import explore
from solver.solution.solving import conclude
from solver.solution.verdict import Verdict, explore_required, judge, needs_digits
from solver.trace.guards import Pattern
from solver.trace.python import float_of, with_fallback
from solver.trace.records import Records
from solver.trace.rows import AnswerSweeper, Steady, columns_of, listed


def _value(model: Model, name: str, given: Any) -> Value:
    if isinstance(given, str):
        symbol = symbol_name(given)
        if symbol is None:
            why = "a text is read as a symbol, and this is not one"
            raise TypeError(f"{given!r} is not a valid value for {name}: {why}")
        if name in quantities(model):
            raise TypeError(f"{name} is a number, and {given!r} a symbol")
        return symbol
    with suppress(TypeError, ValueError, OverflowError):
        return float_of(given)
    told = "nan to have it solved; sweep takes columns"
    raise TypeError(f"{name} takes a number or a symbol ({told}), not {type(given).__name__}")


Array: TypeAlias = NDArray[Any]


def turns_of(model: Model, names: Iterable[str]) -> Array:
    """The whole turns of angles (v,), infinite for other variables."""
    turn = planner(model).graph.turn
    return np.array([turn(name) or np.inf for name in names])


class Plan:
    """The result of ``prepare``. Numbers are given in the order of ``inputs`` and returned in that
    of ``want``.

    Rows with the same decisions share the record of the first of them; rows that no record covers
    are solved step by step.
    """

    # each plan has a call of its own, which goes directly to the record
    __slots__ = ("__call__", "__dict__", "__weakref__", "all")

    __call__: Callable[..., Row]
    """The wanted values of the primary answer for a number of each input, by place or by name.

    Raises Unsolved if there is none, also for an infinite number, TypeError for other types.
    """

    all: Callable[..., list[Row]]
    """Those of every answer, the primary one first. Raises as a call does."""

    def __init__(
        self,
        model: Model,
        inputs: tuple[str, ...],
        want: tuple[str, ...],
        given: Values,
        guesses: Mapping[str, float],
        timeout: float | None = None,
    ) -> None:
        self.model, self.inputs, self.want = model, inputs, want
        self.given, self.guesses, self.timeout = given, guesses, timeout
        self.records = Records(model, Pattern(inputs, given, want, guesses))
        self._sweeper: AnswerSweeper | None = None
        self._fixing: dict[Key, Plan] = {}
        self._bound: tuple[Callable[..., Any], ...] = ()
        self.before: Status | None = None
        """The status of the row before, as far as it was solved step by step."""
        self.__call__, self.all = self._primary, self._every

    def __repr__(self) -> str:
        return f"<Plan ({', '.join(self.inputs)}) -> ({', '.join(self.want)})>"

    def _bind(self) -> None:
        """Let calls begin with the first record."""
        if not (records := self.records).programs:
            return
        forms = (*records.first(), records.every[records.order[0]])
        if forms != self._bound:
            self._bound, (*first, every), primary = forms, forms, self._primary
            for form in reversed(first):
                primary = with_fallback(form, primary)
            self.__call__, self.all = primary, with_fallback(every, self._every)

    def _primary(self, *given: Value | None, **named: Value) -> Row:
        numbers = self._numbers(given, named)
        found, recorded = self._answers(numbers)
        if recorded:
            self.records.near(numbers)
            self._bind()
        return found[0]

    def _every(self, *given: Value | None, **named: Value) -> list[Row]:
        return self._answers(self._numbers(given, named))[0]

    def _answers(self, numbers: Row) -> tuple[list[Row], bool]:
        """The answers that the first record does not cover, or all if there is none yet, and
        whether another record has them."""
        status, found, verdict = self._outcome(numbers)
        if status is not Status.SOLVED:
            raise Unsolved(
                status, lambda: self._explained(numbers, verdict or self.judged(numbers)[0])
            )
        return found, verdict is None

    def _numbers(self, given: tuple[Value | None, ...], named: Values) -> Row:
        """The value of every input, floats and names of symbols; places that a record has filled
        hold None.

        Raises TypeError that names the input: for one that is missing, given twice or not prepared
        for, and for a value that is neither a number nor a symbol.
        """
        inputs, asked = self.inputs, ", ".join(self.inputs) or "nothing"
        while given and given[-1] is None:
            given = given[:-1]
        if len(given) > len(inputs):
            took = f"this plan takes {plural(len(inputs), 'input')} ({asked})"
            raise TypeError(f"{took}, and {len(given)} were given")
        values = dict(zip(inputs, given, strict=False))
        for name, value in named.items():
            if name not in inputs:
                notes = meant(name, inputs)
                tail = f"; {notes[0]}" if notes else ""
                raise TypeError(f"{name} is no input of this plan, which takes {asked}{tail}")
            if name in values:
                raise TypeError(f"{name} is given twice, by its place and by its name")
            values[name] = value
        if missing := [name for name in inputs if name not in values]:
            rest = f"this plan takes {asked}, in this order"
            raise TypeError(f"no value is given for {', '.join(missing)}; {rest}")
        return tuple(_value(self.model, name, values[name]) for name in inputs)

    def outcome(self, numbers: Row) -> tuple[Status, list[Row]]:
        """The status of one row and, if it is solved, the wanted values of every answer in
        order."""
        return self._outcome(numbers)[:2]

    def _outcome(self, numbers: Row) -> tuple[Status, list[Row], Verdict | None]:
        """The same with the verdict, unless a record decides."""
        found = self.records.known(numbers)
        self._bind()
        if found is None:
            return self._solved(numbers)
        self.before = Status.SOLVED
        return Status.SOLVED, found, None

    def _solved(self, numbers: Row) -> tuple[Status, list[Row], Verdict | None]:
        """The outcome of a row step by step, and the verdict unless a record refuses it.

        The solve becomes a record, if possible; an infeasible row becomes a refusal. A row that
        lacks an input, whose rules were read again, or are 0/0 somewhere for its numbers alone, is
        not recorded. After a row without an answer a brief search comes first.
        """
        if any(refused(*numbers) is not None for refused in self.records.refused):
            return Status.INFEASIBLE, [], None
        without = self.before in (Status.FAILED, Status.INFEASIBLE)
        brief = self._briefly(numbers) if without and self._refused(numbers) is None else None
        if brief is not None and brief in (self.before, Status.INFEASIBLE):
            self.before = brief
            return brief, [], None
        verdict, found = self.judged(numbers)
        self.before = verdict.status
        solved = verdict.status is Status.SOLVED
        leaves = verdict.leaves if solved else ()
        rows = [tuple(leaf.branch.values.get(n, math.nan) for n in self.want) for leaf in leaves]
        rows = [rows[place] for place in different(rows)]
        accidental = any(not o.accidental <= self._fixed for o in found.outcomes.values())
        if not (verdict.reread or accidental) and _finite(numbers):
            left = (leaf for leaf in (*found.leaves, *found.open_cases) if not leaf.solved)
            ended = (leaf for leaf in left if blocked(self.model, leaf))
            refused = (*found.contradicted, *ended, *found.outside_case)
            if solved and self.records.add(numbers, verdict.leaves, refused):
                self.records.learned += 1
                self._bind()
            elif solved:
                self.records.remember(numbers, rows)
            elif verdict.status is Status.INFEASIBLE:
                self.records.refuse(numbers, found)
        return verdict.status, rows, verdict

    @cached_property
    def _fixed(self) -> frozenset[str]:
        """The names whose values are the same in every row."""
        free = planner(self.model).path(frozenset(self.given), {}).undetermined
        return frozenset(self.model.variables) - {*free}

    def _briefly(self, numbers: Row) -> Status | None:
        """The status of a row as far as a brief search tells, None if it takes more digits; an
        infeasible row becomes a refusal."""
        asked = self._asked(numbers)
        with suppress(TimeIsUp), time_limit(self.timeout):
            found = explore(asked, brief=True)
            if needs_digits(asked, found):
                return None
            verdict = judge(asked, found)
            if verdict.status is Status.INFEASIBLE:
                verdict, found, _ = conclude(asked, found, limits=self.model.limits)
                if verdict.status is Status.INFEASIBLE and not verdict.reread and _finite(numbers):
                    self.records.refuse(numbers, found)
            return verdict.status
        return Status.FAILED

    def sweep(self, *columns: Column, jit: bool = False) -> Table:
        """One solve for each row of arrays (n,) in the order of ``inputs``; a row without an answer
        is NaN.

        The primary answer of a row continues a branch, or else comes first in the ranking. With
        ``jit`` the records are compiled to machine code (extra ``jit``), which pays off from about
        1e5 rows. Raises ValueError for columns of different lengths, ImportError without the extra.
        """
        if len(columns) != len(self.inputs):
            told = plural(len(self.inputs), "column")
            raise TypeError(f"this plan is prepared for {told}, not for {len(columns)}")
        pairs = zip(self.inputs, columns, strict=True)
        inputs = {name: column_of(column, name) for name, column in pairs}
        arrays = list(inputs.values())
        one_length(self.inputs, arrays)
        # memory for all answers may be more than that for one, and too much
        first = [self.records.programs[place].endings for place in self.records.order[:1]]
        long = all(c.dtype == float and len(c) > PIECE for c in arrays)
        several = any(len(some) > 1 for some in first)
        if long and several and (table := _in_pieces(self, inputs, jit)) is not None:
            return table
        status, answers = sweep_answers(self, arrays, jit, steady=True)
        chosen = kept(arrays, answers, self.turns, len(status))
        return one_answer(inputs, self.want, status, answers, chosen, own=True)

    @cached_property
    def turns(self) -> Array:
        return turns_of(self.model, self.want)

    def sweeper(self, jit: bool) -> AnswerSweeper:
        """Solves rows by the existing records."""
        kept = self._sweeper
        if kept is None or kept.jit is not jit or kept.records is not self.records:
            self._sweeper = kept = AnswerSweeper(self.records, jit, self.turns)
        return kept

    def fixing(self, key: Key) -> Plan:
        """The plan of rows with these symbols among their inputs, which takes their numbers."""
        pairs = zip(self.inputs, key, strict=True)
        fixed = {name: symbol for name, symbol in pairs if symbol is not None}
        if fixed and key not in self._fixing:
            names = tuple(name for name in self.inputs if name not in fixed)
            asked = names, self.want, {**self.given, **fixed}, self.guesses, self.timeout
            self._fixing[key] = Plan(self.model, *asked)
        return self._fixing[key] if fixed else self

    def mark(self) -> Any:
        """The present state of the records, for ``forget``."""
        return self.records.mark(), {key: plan.mark() for key, plan in self._fixing.items()}

    def forget(self, mark: Any) -> None:
        """Go back to a marked state."""
        known, fixing = mark
        self.records.forget(known)
        self._fixing = {key: self._fixing[key] for key in fixing}
        for key, plan in self._fixing.items():
            plan.forget(fixing[key])

    def judged(self, numbers: Row) -> tuple[Verdict, Exploration]:
        """The verdict on one row, unexplained; its solve becomes a record.

        A nan is a missing input, which is solved for; an infinite number is invalid. Where floats
        are not accurate enough the row is solved again in extended precision. When the time is up
        the row is failed.
        """
        if (refused := self._refused(numbers)) is not None:
            status, _ = refused
            return Verdict(status, ()), Exploration((), status is Status.INFEASIBLE, ())
        try:
            with time_limit(self.timeout):
                asked = self._asked(numbers)
                found = conclude(asked, explore_required(asked), limits=self.model.limits)[:2]
                if interrupted():  # a partial result is not an outcome
                    expect_time()
                return found
        except TimeIsUp:
            return Verdict(Status.FAILED, (), (OutOfTime(()),)), Exploration((), False, ())

    def _refused(self, numbers: Row) -> tuple[Status, Diagnosis] | None:
        """The status of a row with an infinite number, or one outside the declared range, and its
        message; None for other rows."""
        pairs = zip(numbers, (self.model.variables[name] for name in self.inputs), strict=True)
        given = [(float(v), variable) for v, variable in pairs if not isinstance(v, str)]
        for number, variable in given:
            if math.isinf(number):
                return Status.PARTIAL, not_finite_number(number, variable)
        for number, variable in given:
            if not math.isnan(number) and not variable.admits(number):
                return Status.INFEASIBLE, outside_range(number, variable, None)
        return None

    def _asked(self, numbers: Row) -> Asked:
        """The question of a row, without missing inputs."""
        pairs = zip(self.inputs, numbers, strict=True)
        row = {name: v if isinstance(v, str) else float(v) for name, v in pairs}
        inputs = {**self.given, **{n: v for n, v in row.items() if _finite([v])}}
        want = with_checks(self.model, inputs, self.want)
        return Asked(self.model, inputs, want, self.guesses, self.want)

    def _explained(self, numbers: Row, verdict: Verdict) -> tuple[Diagnosis, ...]:
        refused = self._refused(numbers)
        return explain(self._asked(numbers), verdict) if refused is None else refused[1:]


def _finite(numbers: Iterable[Value]) -> bool:
    return all(isinstance(one, str) or math.isfinite(one) for one in numbers)


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
    defaults to the variables of the sheet that are not inputs, without those that calls only pass
    on. ``timeout`` limits the seconds of a solve step by step; a call that reaches the limit raises
    Unsolved with the status ``failed``. Raises RuleSheetError for names that the model does not
    have, ValueError for an input that is named twice.
    """
    expect(Model, model)
    names = variables_named(inputs, model)
    if twice := [name for name in names if names.count(name) > 1]:
        raise ValueError(f"{twice[0]} stands twice among the inputs")
    effective = override(model, given, guesses)
    fixed = {name: value for name, value in effective.values.items() if name not in names}
    wanted = variables_named(want, model) if want is not None else ()
    if want is None:
        shown = [n for n, v in model.variables.items() if v.posted and not v.passed]
        unknown = (n for n in shown or model.variables if n not in fixed)
        wanted = tuple(name for name in unknown if name not in names)
    return Plan(model, names, wanted, fixed, effective.guesses, timeout)


Key: TypeAlias = tuple[str | None, ...]
"""The symbols of a row, None at the place of a number."""


def _by_symbols(columns: Sequence[Array]) -> dict[Key, Array]:
    """The rows of columns by the symbols that are in them."""
    count = len(columns[0]) if columns else 1
    if all(column.dtype != object for column in columns):
        return {(None,) * len(columns): np.arange(count)}
    kinds = ([v if isinstance(v, str) else None for v in column.tolist()] for column in columns)
    found: dict[Key, list[int]] = {}
    for row, key in enumerate(zip(*kinds, strict=True)):
        found.setdefault(key, []).append(row)
    return {key: np.array(some) for key, some in found.items()}


def sweep_answers(
    plan: Plan, columns: Sequence[Array], jit: bool, steady: bool = False
) -> tuple[NDArray[np.int8], Answers]:
    """The status codes (n,) of every row, and all its wanted values, the primary answer first.

    The columns (n,) are in the order of the plan's inputs; without any there is one row. In a
    ``steady`` sweep answers are in order as far as ``Answers.runs`` says.
    """
    groups = _by_symbols(columns)
    if len(groups) == 1 and columns:
        ((key, places),) = groups.items()
        return _alike(plan.fixing(key), _numbers(columns, key, places), len(places), jit, steady)
    count = sum(map(len, groups.values()))
    codes, parts = np.zeros(count, dtype=np.int8), list[tuple[Array, Answers]]()
    for key, places in groups.items():
        numbers, done = _numbers(columns, key, places), len(places)
        whole = bool(done == places[-1] - places[0] + 1)
        codes[places], found = _alike(plan.fixing(key), numbers, done, jit, steady and whole)
        parts.append((places, found))
    return codes, together(parts, count)


def _numbers(columns: Sequence[Array], key: Key, rows: Array) -> list[Array]:
    """The columns of numbers, of all rows as they are."""
    numbers = [column for column, symbol in zip(columns, key, strict=True) if symbol is None]
    return [(c if len(c) == len(rows) else c[rows]).astype(float, copy=False) for c in numbers]


def _alike(
    plan: Plan, columns: list[Array], count: int, jit: bool, steady: bool
) -> tuple[NDArray[np.int8], Answers]:
    """The same for ``count`` rows of numbers only."""
    if not columns:  # all rows are equal
        one, rows = plan.outcome(())
        return np.full(count, CODES[one], dtype=np.int8), listed([rows] * count)
    status = np.zeros(count, dtype=np.int8)
    plan.before = None

    def outcome(row: int) -> tuple[Status, list[Row]]:
        if (watch := WATCH.get()) is not None:
            watch(row)
        if interrupted():
            return Status.FAILED, []
        return plan.outcome(tuple(float(column[row]) for column in columns))

    def keep(rows: Array, outcome: Status) -> None:
        status[rows] = CODES[outcome]

    return status, plan.sweeper(jit).run(columns, outcome, keep, steady)


PIECE, HEAD = 2**17, 2**9
"""Rows whose answers are all in memory at a time, and the first of them."""


def _in_pieces(plan: Plan, inputs: dict[str, Array], jit: bool) -> Table | None:
    """A piece begins with the last two rows before it, whose answers are known; none has
    symbols."""
    columns, turns = list(inputs.values()), plan.turns
    steady = Steady(plan.sweeper(jit), columns)
    count = len(columns[0])
    status, counts = np.zeros(count, dtype=np.int8), list[Array]()
    values = columns_of(len(plan.want), count)
    ends = (0, HEAD, *range(HEAD + PIECE, count, PIECE), count)
    for start, end in pairwise(ends):
        rows = slice(max(start - 2, 0), end)
        here, targets = ([column[rows] for column in found] for found in (columns, values))
        before = np.array([column[: start - rows.start] for column in targets])
        counts.append(np.broadcast_to(np.int64(steady(rows.start, before, targets)), end - start))
        if not counts[-1][0]:
            status[rows], answers = sweep_answers(plan, here, jit, steady=True)
            known = found_again(answers, before, turns)
            first = kept(here, answers, turns, count, rows.start, known)
            counts[-1] = answers.counts[start - rows.start :]
            shown = answers.chosen(first, own=True) or [np.array(np.nan) for _ in values]
            if any(column.dtype == object for column in shown):
                return None
            for target, column in zip(targets, shown, strict=True):
                target[:] = column
    one = counts[0][0]
    alike = all(few.strides == (0,) and few[0] == one for few in counts)
    whole = np.broadcast_to(one, count) if alike else np.concatenate(counts)
    return _table(inputs, plan.want, status, values, whole)


def one_answer(
    inputs: Mapping[str, Array],
    want: Sequence[str],
    status: Array,
    answers: Answers,
    first: Array,
    own: bool = False,
) -> Table:
    """A row for each row of inputs, with its ``first`` (n,) answer, whose planes it may ``own``."""
    values = answers.chosen(first, own) or [np.full(len(status), np.nan) for _ in want]
    return _table(inputs, want, status, values, answers.counts)


def _table(
    inputs: Mapping[str, Array],
    want: Sequence[str],
    status: Array,
    values: Sequence[Array],
    counts: Array,
) -> Table:
    columns = {**dict(zip(want, values, strict=True)), **inputs}
    columns = {name: columns[name] for name in (*inputs, *want)}
    columns[free_name("answers", columns)] = counts
    return Table(columns, status, answers=counts)
