"""Facts as diagnoses, in the user's names and places. Every sentence about an outcome is here."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from functools import partialmethod
from typing import assert_never

from rulesheets.diagnosis import MAX_NAMED, Diagnosis, Label, Severity, listed, plural, side_by_side
from rulesheets.evaluate.number import number_text, rounded
from rulesheets.format import format_condition
from rulesheets.model import Model, Value
from rulesheets.syntax.nodes import And, Name, Power, names, walk
from solver import facts
from solver.leaves import Asked, Leaf, conditions_without_value
from solver.path import activity
from solver.path.planner import planner
from solver.solution.remedy import (
    Patience,
    bounds,
    clash,
    cures,
    derivation,
    found_near,
    givings,
    stretch,
)
from solver.solution.verdict import Verdict

MAX_INPUTS = 10
MAX_UNCHANGED = 4


def explain(asked: Asked, verdict: Verdict, hasty: bool = False) -> tuple[Diagnosis, ...]:
    """One diagnosis for each reason why a solve is not plainly solved.

    ``hasty``: without remedies, because the time is up.
    """
    explanation = _Explanation(asked, verdict, Patience(0) if hasty else Patience())
    found = tuple(dict.fromkeys(explanation.diagnoses()))
    if not hasty:
        return found
    text = "the time was up before every remedy was tried"
    return (*found, Diagnosis("S553", Severity.NOTE, text))


class _Explanation:
    def __init__(self, asked: Asked, verdict: Verdict, patience: Patience) -> None:
        self.asked = asked._replace(want=None, guesses={})
        self.verdict, self.patience = verdict, patience
        self.model, self.inputs, self.judged = asked.model, asked.inputs, asked.judged
        self.leaf: Leaf | None = verdict.leaves[0] if verdict.leaves else None
        posted = {name for name, variable in self.model.variables.items() if variable.posted}
        self.no_help = set() if posted.issubset(self.judged) else {*self.judged}

    def diagnoses(self) -> Iterator[Diagnosis]:
        verdict = self.verdict
        contradicted = verdict.status is facts.Status.INCONSISTENT
        for fact in verdict.facts:
            if isinstance(fact, facts.OutOfTime) or (
                contradicted and isinstance(fact, facts.Fixed)
            ):
                yield self._said(fact)
                return
        if contradicted:
            yield self._clash()
            return
        if verdict.status is not facts.Status.SOLVED:
            yield from map(self._of, verdict.facts)
        if verdict.status in (facts.Status.INFEASIBLE, facts.Status.FAILED) and not verdict.facts:
            yield self._symbol_in(range(len(self.model.equations))) or self._no_case()
        if verdict.structural:
            yield self._undetermined()
        if self.leaf is not None:
            yield from self._remarks(self.leaf)

    def _remarks(self, leaf: Leaf) -> Iterator[Diagnosis]:
        """Notes on an accepted answer: blank variables, truncated lists."""
        said = (
            *self.verdict.facts,
            *(fact for leaf in self.verdict.leaves for fact in leaf.branch.facts),
        )
        notes = [
            fact for fact in said if isinstance(fact, facts.Filled | facts.Beside | facts.Uncovered)
        ]
        solved = self.verdict.status is facts.Status.SOLVED
        holes = [f for f in self.verdict.facts if solved and isinstance(f, facts.Indeterminacy)]
        cut_off = [fact for fact in leaf.branch.facts if isinstance(fact, facts.Truncated)]
        yield from map(self._said, (*dict.fromkeys(notes), *holes, *cut_off))
        if solved:
            for fact in leaf.branch.reasons:
                if isinstance(fact, facts.NoValue) and fact.unknown not in leaf.branch.values:
                    text = f"{fact.unknown} has no value here: its rule needs {fact.reading}"
                    yield self._note("S591", text, (fact.equation,), (fact.unknown,))
            for index, condition, undefined in conditions_without_value(self.asked, leaf):
                text = f"{format_condition(condition)} has no value here and counts as false"
                yield self._note("S599", text, (index,), (), f"it needs {undefined}")

    # --- one fact, one sentence ---

    def _of(self, fact: facts.Fact) -> Diagnosis:
        """If a rule fails because it contains a symbol, that is the reason."""
        failing = facts.about(fact) if isinstance(fact, facts.NoValue | facts.NoRoot) else ()
        return self._symbol_in(failing) or self._said(fact)

    def _symbol_in(self, equations: Iterable[int]) -> Diagnosis | None:
        """The first of these rules that computes with a symbol."""
        values = {**self.inputs, **(self.leaf.branch.values if self.leaf else {})}
        symbols = {name: value for name, value in values.items() if isinstance(value, str)}
        for equation in (self.model.equations[index] for index in equations):
            for name in symbols.keys() & set(equation.names):
                if Name(name) not in equation.sides:
                    message = (
                        f"this rule computes with {name}, which is the symbol '{symbols[name]}"
                    )
                    cure = f"give a number for {name}, or clear it to have it solved"
                    given = (cure,) if name in self.inputs else ()
                    return self._error("S534", message, (equation.index,), (name,), *given)
        return None

    def _said(self, fact: facts.Fact) -> Diagnosis:
        match fact:
            case facts.NoValue(equation, unknown) | facts.OutOfRange(equation, unknown):
                code = "S530" if isinstance(fact, facts.NoValue) else "S531"
                cures = self._bounds((equation,), (unknown,))
                return self._error(code, _refused(fact), (equation,), (unknown,), *cures)
            case facts.NoRoot(equations, unknowns, True):
                variables = [self.model.variables[name] for name in unknowns]
                bounded = any(v.ranged for v in variables)
                where = " within the ranges that the sheet gives them" if bounded else ""
                found, these = "values", "satisfy these rules together"
                if len(equations) == 1 == len(unknowns):
                    found, these = "value", "satisfies this rule"
                cures = self._bounds(equations, unknowns)
                message = f"no {found} of {listed(unknowns)} {these}{where} (proven)"
                return self._error("S532", message, equations, unknowns, *cures)
            case facts.NoRoot():
                return self._not_found(fact)
            case facts.AsksNothing(equation, unknown):
                leaf = self.leaf
                free = tuple(dict.fromkeys((unknown, *(leaf.missing if leaf else ()))))
                verb = "is" if len(free) == 1 else "are"
                message = (
                    f"{listed(free)} {verb} not determined here: this rule holds whatever "
                    f"{unknown} is"
                )
                names = self.model.equations[equation].names
                zeros = [
                    f"{name} = 0" for name in names if leaf and leaf.branch.values.get(name) == 0.0
                ]
                why = (f"because {listed(zeros)}",) if zeros else ()
                cure = ", or ".join((*self._giving(free), "change the position"))
                return self._error("S540", message, (equation,), free, *why, cure)
            case facts.RankLoss():
                return self._rank(fact)
            case facts.DoubleRoot(equations, unknowns, direction):
                what = "have a double root" if len(unknowns) > 1 else "is a double root"
                them = f"{listed(unknowns)} {what}"
                message = f"two answers coincide here: {them}, not an isolated answer"
                moves = "to first order the rules let them move along"
                return self._error("S541", message, equations, unknowns, *_along(moves, direction))
            case facts.Unfixed(unknowns, double):
                posted = [name for name in unknowns if self.model.variables[name].posted]
                them, first = listed(posted or unknowns), listed(double.unknowns, "or")
                message = f"{them} can have any value at this double root, or none"
                cure = f"give {first} first, or move away from the double root"
                return self._error("S543", message, double.equations, unknowns, cure)
            case facts.RestsOnRounding(equation, unknown):
                message = f"{unknown} rests on no more than the last places of the given numbers"
                note = f"to their last places they leave {unknown} any value"
                cure = f"give {unknown}"
                return self._error("S544", message, (equation,), (unknown,), note, cure)
            case facts.Conflict(equations, miss):
                notes = () if miss is None else (f"together they miss by {number_text(miss)}",)
                message = "these rules contradict each other"
                return self._error("S520", message, equations, (), *notes)
            case facts.DeadEnd():
                return self._dead_end(fact)
            case facts.BeyondFloats(equation, unknown):
                asked = f"the value that this rule asks of {unknown}"
                message = f"{asked} can't be held by a floating point number"
                note = (
                    "it is too large, too small, or too near another number: scale the rule, or "
                    "its units"
                )
                return self._error("S551", message, (equation,), (unknown,), note)
            case facts.Indeterminacy():
                return self._indeterminate(fact)
            case facts.Filled(equation, limit):
                message = (
                    "this rule is undefined at the answer (0/0), and taken by its limit "
                    f"{limit:.10g}"
                )
                return self._note("S595", message, (equation,))
            case facts.Beside(equations, free, values):
                kept = [f"{name} = {number_text(value)}" for name, value in values]
                rest = f" where {listed(kept)}" if kept else ""
                message = (
                    f"beside these answers there is a curve of others: {listed(free)} can "
                    f"vary{rest}"
                )
                return self._note("S596", message, equations, free)
            case facts.Uncovered(case, free):
                where = format_condition(case[0] if len(case) == 1 else And(case))
                message = f"no rule determines {listed(free)} where {where}"
                return self._note("S597", message, (), free)
            case facts.Fixed(name, value, given, unknown, equations):
                made, asked = f"{value + 0.0:.10g}", number_text(given)
                if made == asked:
                    made, asked = repr(value), repr(given)
                message = f"{name} is {made} whatever {unknown} is, and {asked} is given"
                cure = f"leave out {name} and give {unknown}: {name} is {made} then, too"
                other = f"to have {name} = {asked}, free an input that {name} depends on"
                return self._error("S521", message, equations, (name, unknown), cure, other)
            case facts.Unmet():
                return self._unmet(fact)
            case facts.OutOfTime(known):
                return self._out_of_time(known)
            case facts.Truncated(what):
                return self._note("S590", f"there are too many {what} to list them all", ())
            case _:
                assert_never(fact)

    def _indeterminate(self, fact: facts.Indeterminacy) -> Diagnosis:
        equation = self.model.equations[fact.equation]
        at = [
            f"{name} = {_text(fact.values[name])}" for name in equation.names if name in fact.values
        ]
        unknown = tuple(name for name in equation.names if name not in fact.values)
        if self.verdict.status is facts.Status.SOLVED:
            message = (
                f"this rule is undefined at {listed(at)} ({fact.form}), and its limit satisfies it"
            )
            cure = "--limits, or limits = yes in the sheet, lists this answer, too"
            return self._note("S598", message, (fact.equation,), unknown, cure)
        message = f"this rule is undefined here ({fact.form})"
        if fact.limit is not None:
            message += f"; the limit is {fact.limit:.10g}"
        cure = "to solve with the limit give --limits, or limits = yes in the sheet"
        if fact.limit is None and not fact.is_open:
            cure = (
                "there is no limit: the two sides, or several directions, lead to different values"
            )
        return self._error("S545", message, (fact.equation,), unknown, f"at {listed(at)}", cure)

    def _unmet(self, fact: facts.Unmet) -> Diagnosis:
        requirement = self.model.requirements[fact.requirement]
        said = [f"{name} = {_text(fact.values[name])}" for name in requirement.names]
        inputs_only = all(name in self.inputs for name in requirement.names)
        proven = self.verdict.status is facts.Status.INFEASIBLE
        answer = "no answer" if proven else "no answer that was found"
        who = f"{listed(said)} do" if len(said) > 1 else f"{said[0]} does"
        message = f"{who} not meet" if inputs_only else f"{answer} meets"
        short = f": it is missed by {number_text(rounded(fact.miss))}" if fact.miss else ""
        short = ": its sides are equal" if fact.miss == 0.0 else short
        notes = [] if inputs_only else [f"the answer nearest to it has {listed(said)}"]
        if notes and not proven:
            unknown = [name for name in requirement.names if name not in self.inputs]
            notes.append(f"give a guess for {listed(unknown)} to look for others")
        mine = self._bounds((), requirement.names, requirement.names)
        labels = (Label(requirement.rule),)
        message += f" this requirement{short}"
        told = message, labels, (*notes, *mine), requirement.names
        return Diagnosis("S535", Severity.ERROR, *told)

    def _out_of_time(self, known: Sequence[str]) -> Diagnosis:
        """An error without an answer, a note with some."""
        count = len(self.verdict.leaves)
        if self.verdict.status is facts.Status.SOLVED:
            message = f"the time was up: {plural(count, 'answer')} found, and there may be others"
            return self._note("S553", message, ())
        message = "the time was up before an answer was found"
        shown = f"until then {listed(known or ['nothing'])} had a value"
        cure = "give more time, or a guess or a range for one of the unknowns"
        missing = tuple(name for name in self.judged if name not in known)
        return self._error("S553", message, (), missing, cure, shown)

    def _rank(self, fact: facts.RankLoss) -> Diagnosis:
        code, message = "S542", f"at these values the rules leave {listed(fact.free)} free"
        if fact.everywhere:
            code = "S511"
            message = f"these rules do not determine {listed(fact.free)}: they are not independent"
            if len(fact.equations) == 1:
                which = self._stretch(fact)
                message = f"{listed(fact.free)} can take {which} here, and this rule still holds"
        notes = (*self._giving(fact.free), *_along("they can move along", fact.direction))
        return self._error(code, message, fact.equations, fact.free, *notes)

    def _stretch(self, fact: facts.RankLoss) -> str:
        """Which values the unknown of a single rule can take."""
        variable = self.model.variables[fact.free[0]]
        low, high = stretch(self.model.equations[fact.equations[0]], fact.point, variable.name)
        low, high = max(low, variable.low), min(high, variable.high)
        least, most = number_text(rounded(low)), number_text(rounded(high))
        match math.isfinite(low), math.isfinite(high):
            case True, True if rounded(low) < rounded(high):
                return f"any value between {least} and {most}"
            case True, False:
                return f"any value above {least}"
            case False, True:
                return f"any value below {most}"
        return "many values"

    def _not_found(self, fact: facts.NoRoot) -> Diagnosis:
        notes = [*self._found_near(fact.equations, fact.unknowns, fact.best)]
        posted = [name for name in fact.best if self.model.variables[name].posted] or [*fact.best]
        if posted and not notes:
            best = [f"{name} = {number_text(rounded(fact.best[name]))}" for name in posted]
            notes.append(f"the nearest miss was at {listed(best)}")
            missed = zip(fact.misses, fact.equations, strict=False)
            worst, equation = max(missed, key=lambda one: abs(one[0]), default=(0.0, 0))
            if worst:
                off = number_text(rounded(worst, 3))
                notes.append(f"rule {self._line(equation)} is off by {off} there")
        # what narrows the search most: a range for what it iterates on; or else no limit on the
        # work
        steps = () if self.leaf is None else self.leaf.branch.attempts
        tears = next((step.tears for step in steps if step.equations == fact.equations), ())
        tears = tears or fact.unknowns[:1]
        endless = _endless(self.model, tears)
        if endless:
            them = "it" if len(endless) == 1 else "them"
            ranges = f"give {listed(endless)} a range, {endless[0]} in [a, b]"
            notes.append(f"{ranges}: the search iterates on {them}")
        else:
            notes.append(
                f"--prove searches the ranges of {listed(tears)} without a limit on the work"
            )
        them = listed(fact.unknowns)
        message = f"no values of {them} were found that satisfy these rules together"
        return self._error("S550", message, fact.equations, fact.unknowns, *notes)

    def _dead_end(self, end: facts.DeadEnd) -> Diagnosis:
        rules, missing = facts.about(end.reason), self.leaf.missing if self.leaf else ()
        values = self.leaf.branch.values if self.leaf else {}
        point = {name: value for name, value in values.items() if isinstance(value, float)}
        notes = self._found_near(rules, self.judged, point)
        posted = [name for name in end.unknowns if self.model.variables[name].posted]
        cure = f"give a guess for {listed(posted or missing, 'or')}, or a range: name in [a, b]"
        message = f"no answer was found; at the values that were tried {_refused(end.reason)}"
        return self._error("S552", message, rules, missing, *notes, cure)

    def _found_near(
        self, equations: Sequence[int], unknowns: Sequence[str], point: Mapping[str, float]
    ) -> tuple[str, ...]:
        """At which other values of an input, of those that were changed if there are any, an answer
        was found from a point that comes near to one."""
        asked = self.asked._replace(want=unknowns, judged=unknowns)
        movable = self._movable(equations)
        changed = [name for name in movable if self._is_changed(name)] or movable[:MAX_UNCHANGED]
        found = found_near(asked, changed, point, self.patience)
        near = [f"{name} = {value:.6g}" for name, value in found]
        text = "with the other inputs as they are, an answer was found at "
        return (text + listed(near, "or"),) if near else ()

    def _no_case(self) -> Diagnosis:
        if self.verdict.status is facts.Status.FAILED:
            unknown = self.leaf.missing if self.leaf else tuple(self.judged)
            message = "no answer was found, and the search did not cover every case"
            if not unknown:
                return self._error("S552", message, (), ())
            cure = f"give a guess for {listed(unknown, 'or')}, or a range: name in [a, b]"
            return self._error("S552", message, (), unknown, cure)
        conditional = tuple(e.index for e in self.model.equations if e.guard)
        message = "no case of the conditional rules fits the inputs"
        cures = self._bounds((), self.judged)
        return self._error("S533", message, conditional[:MAX_NAMED], (), *cures)

    def _undetermined(self) -> Diagnosis:
        assert self.leaf is not None
        missing = self._free(self.leaf)
        sets, most = givings(self.asked, self.leaf.branch, {*missing}, self.no_help)
        # to give all that is missing is no help
        helpful = [names for names in sets if names != missing]
        if helpful and len(helpful[0]) == 1:
            note = f"give {listed([names[0] for names in helpful], 'or')}"
        elif helpful:
            note = "give " + ", or ".join(listed(names) for names in helpful[:MAX_NAMED])
        elif most:
            note = f"more than one input is missing; {most} would determine most"
        else:
            note = f"no other variable determines {listed(missing)}: add a rule that does"
        message = f"the inputs do not determine {listed(missing)}"
        idle = self._idle(missing)
        why = ("no condition of this rule holds, so it asks nothing",) * bool(idle)
        notes = (*self._misspelt(missing), note, *why)
        return self._error("S510", message, idle[:MAX_NAMED], missing, *notes)

    def _idle(self, missing: Collection[str]) -> Sequence[int]:
        """The conditional rules for missing names of which no case holds."""
        assert self.leaf is not None
        mine = [e for e in self.model.equations if e.guard and not {*missing}.isdisjoint(e.names)]
        outcomes = self.leaf.branch.conditions
        active = {e.rule for e in mine if activity(e, outcomes) is not False}
        return [e.index for e in mine if e.rule not in active]

    def _free(self, leaf: Leaf) -> tuple[str, ...]:
        """The missing names that stay free where every open condition holds on what is determined
        then, or none does: what only waits for its case is no missing input."""
        given, free, conditions = leaf.branch.given(self.inputs), set[str](), self.model.conditions
        for outcome in (True, False):
            case = dict.fromkeys(range(len(conditions)), outcome) | leaf.branch.conditions
            while True:
                loose = {*planner(self.model).path(given, case).undetermined}
                unknown = {k for k in case if not loose.isdisjoint(names(conditions[k]))}
                if unknown <= leaf.branch.conditions.keys():
                    break
                case = {k: v for k, v in case.items() if k not in unknown} | leaf.branch.conditions
            free |= loose
        structural = self.verdict.structural
        return tuple(name for name in structural if name in free) or structural

    def _misspelt(self, missing: Sequence[str]) -> Iterator[str]:
        """Names without a row that are others side by side, and e where a rule has it raised."""
        variables, equations = self.model.variables, self.model.equations
        short = {name for name in variables if "." not in name}
        for name in missing:
            if name not in short or variables[name].span is not None:
                continue
            if factors := side_by_side(name, short - {name}):
                yield f"{name} is one name: is {'*'.join(factors)} meant?"
            powers = (n for e in equations for n in walk(*e.sides) if isinstance(n, Power))
            if name == "e" and any(node.base == Name("e") for node in powers):
                yield "e is a variable: write exp(x) for a power of Euler's number"

    def _giving(self, names: Sequence[str]) -> tuple[str, ...]:
        """The advice to give one of these; none to give a wanted variable itself."""
        helpful = [name for name in names if name not in self.no_help]
        return (f"give {listed(helpful, 'or')}",) if helpful else ()

    def _clash(self) -> Diagnosis:
        assert self.leaf is not None
        fact = next(fact for fact in self.verdict.facts if isinstance(fact, facts.Conflict))
        rules, inputs = clash(self.asked, self.leaf, fact.equations, self.patience)
        given = [f"{name} = {_text(self.inputs[name])}" for name in inputs]
        message = f"these rules contradict {listed(given) if given else 'each other'}"
        notes = []
        if fact.miss is not None:
            line = self._line(fact.equations[-1])
            notes.append(f"rule {line} misses by {number_text(fact.miss)}")
        values = {**self.leaf.branch.values, **self.inputs}
        known = {name: value for name, value in values.items() if isinstance(value, float)}
        for name, value in cures(self.asked, inputs[:MAX_INPUTS], known, self.patience):
            told = _text(value) if isinstance(value, str) else f"{value + 0.0:.10g}"  # no -0
            notes.append(f"leave out {name}: the other inputs make it {told}")
        notes += self._fixed_by_rules(rules)
        return self._error("S520", message, rules, inputs, *notes)

    def _fixed_by_rules(self, equations: Sequence[int]) -> Iterator[str]:
        """Rules such as ``x = 3``, which no input replaces."""
        for equation in map(self.model.equations.__getitem__, equations):
            if len(equation.names) == 1 and isinstance(equation.left, Name) and not equation.guard:
                rule = " ".join(equation.rule.text.split())
                yield f"{rule} is a rule: write it under `variables` to change {equation.left.name}"

    def _bounds(
        self, equations: Sequence[int], unknowns: Sequence[str], read: Sequence[str] = ()
    ) -> tuple[str, ...]:
        """How far each input that these rules, or the names ``read``, depend on has to move."""
        movable = self._movable(equations, read)[:MAX_INPUTS]
        found = bounds(self.asked, movable, unknowns, self.patience)
        sides = [f"{b.name} {b.relation} {number_text(b.value)}" for b in found]
        text = "with the other inputs as they are, a solution needs "
        return (text + listed(sides, "or"),) if sides else ()

    def _movable(self, equations: Sequence[int], read: Sequence[str] = ()) -> list[str]:
        """The inputs that these rules, or what is ``read``, depend on, those that were changed
        first."""
        if self.leaf is None:
            numeric = [name for name, value in self.inputs.items() if isinstance(value, float)]
        else:
            _, numeric = derivation(self.asked, self.leaf, equations, read)
        return sorted(numeric, key=self._is_changed, reverse=True)

    def _is_changed(self, name: str) -> bool:
        """Whether an input has another value than the sheet gives it."""
        return self.inputs[name] != self.model.variables[name].value

    # --- making diagnoses ---

    def _line(self, equation: int) -> str:
        rule = self.model.equations[equation].rule
        return f"{rule.file}:{rule.line}"

    def _diagnosis(
        self,
        severity: Severity,
        code: str,
        message: str,
        equations: Sequence[int],
        variables: Sequence[str] = (),
        *notes: str,
    ) -> Diagnosis:
        labels = _labels(self.model, equations)
        return Diagnosis(code, severity, message, labels, notes, tuple(variables))

    _error = partialmethod(_diagnosis, Severity.ERROR)
    _note = partialmethod(_diagnosis, Severity.NOTE)


def _refused(fact: facts.NoValue | facts.OutOfRange | facts.NoRoot) -> str:
    """Why a rule or a block leads to no value."""
    match fact:
        case facts.NoValue(_, unknown, reading):
            return f"no value of {unknown} satisfies this rule: it needs {reading}"
        case facts.OutOfRange(_, unknown, value):
            would = f"{unknown} would be {number_text(value)}"
            return f"{would}, outside the range that the sheet gives it"
        case facts.NoRoot(_, unknowns):
            return f"no values of {listed(unknowns)} satisfy these rules together"


def _labels(model: Model, equations: Sequence[int]) -> tuple[Label, ...]:
    return tuple(map(Label, dict.fromkeys(model.equations[e].rule for e in equations)))


def _endless(model: Model, names: Iterable[str]) -> list[str]:
    """The variables without a finite range."""
    variables = (model.variables[name] for name in names)
    return [v.name for v in variables if not (math.isfinite(v.low) and math.isfinite(v.high))]


def _along(text: str, direction: Mapping[str, float]) -> tuple[str, ...]:
    """A note on how several variables move together."""
    parts = [
        f"{name}: {number_text(rounded(value, 3))}" for name, value in direction.items() if value
    ]
    return (f"{text} ({', '.join(parts)})",) if len(parts) > 1 else ()


def _text(value: Value) -> str:
    return f"'{value}" if isinstance(value, str) else number_text(value)


# --- why the answers are not known to be all ---


def gap_note(model: Model, gap: facts.Gap) -> Diagnosis:
    """The note on possible further answers, and how to decide whether there are any."""
    notes: tuple[str, ...] = ()
    if not gap.unknowns:
        message = "not every case of the conditions was tried"
        if gap.cut:
            message = f"there are too many answers: {gap.count} are listed"
            notes = ("give ranges to the unknowns, name in [a, b], to list the answers there",)
    elif gap.cut:
        first, low, high = gap.unknowns[0], number_text(gap.low), number_text(gap.high)
        message = f"there are too many answers for {listed(gap.unknowns)}: {gap.count} are listed"
        message += f", from {first} = {low} to {high}"
        notes = (
            f"give {first} a range, {first} in [a, b], to list the answers there",
            f"a guess, {first} ~ {high}, lists those nearest to it first",
        )
    else:
        many, some = plural(gap.count, "answer"), listed(gap.unknowns)
        message = f"{many} found for {some}: nothing shows that there are no others"
        if not gap.count:
            message = f"there may be answers with other values of {some}, or one beyond floats"
        # what would let the search prove that it has found all
        if endless := _endless(model, gap.unknowns):
            notes = (f"ranges may show it: give {listed(endless)} a range, name in [a, b]",)
    code = "S593" if gap.cut else "S594"
    labels = _labels(model, gap.equations)
    return Diagnosis(code, Severity.NOTE, message, labels, notes, gap.unknowns)
