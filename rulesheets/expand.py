"""Calls expanded: every rule of every call becomes guarded equations under full names.

A call of a rule function stands for the rules of that function with their names bound:

* an argument or a result whose actual is a plain variable *is* that variable;
* any other actual gets a dotted variable and an equation (``f.a = AO/2``);
* a parameter is the variable of that name in the calling scope;
* every other name is local: ``f.name``, in the second call of f ``f#2.name``,
  in a call inside a call ``f.g.name``.

Equations come rule by rule in source order, those of a call right after the rule that
calls. Bodies of calls are worked off a stack, so that only the nesting of one rule recurses.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import NamedTuple

from rulesheets.evaluate.exactly import with_round_values
from rulesheets.model import Equation, Premise, Requirement
from rulesheets.parse.ranges import ends
from rulesheets.syntax import Source, Span
from rulesheets.syntax.nodes import (
    And,
    Call,
    CallRule,
    Comparison,
    Condition,
    Equality,
    Expression,
    Function,
    Given,
    IfRule,
    Inequality,
    Name,
    Not,
    Or,
    RuleBody,
    RuleSheet,
    children,
    rebuilt,
)
from rulesheets.syntax.program import Program, components, names_of, rules_of

_NOWHERE = Span(Source("<tree>", ""), 0, 0)

Guard = tuple[Premise, ...]


@dataclass
class Scope:
    """Names of one body of rules on their way to full names.

    ``bound`` maps arguments, results and parameters to full names; what is not in it is
    local and gets ``prefix``. ``counts`` numbers the calls of each function.
    """

    prefix: str = ""
    bound: Mapping[str, str] = field(default_factory=dict)
    counts: dict[str, int] = field(default_factory=dict)

    def full_name(self, name: str) -> str:
        return self.bound.get(name) or self.prefix + name

    def prefix_of_call(self, function: str) -> str:
        """The prefix of the next call of a function in this scope."""
        number = self.counts[function] = self.counts.get(function, 0) + 1
        return f"{self.prefix}{function}." if number == 1 else f"{self.prefix}{function}#{number}."


@dataclass
class Context:
    """Where an expression stands: its scope, its premises and the rule that complaints and places name."""

    scope: Scope
    guard: Guard
    rule: Span


class Expansion(NamedTuple):
    """``names`` are all variables that occur, in order of appearance, conditions included."""

    equations: tuple[Equation, ...]
    conditions: tuple[Condition, ...]
    requirements: tuple[Requirement, ...]
    names: tuple[str, ...]


def expand(program: Program) -> Expansion:
    """The equations of a program that passed its checks."""
    return _Expander(program).run()


class _Expander:
    def __init__(self, program: Program) -> None:
        self.program = program
        self.functions = program.functions
        self.equations: list[Equation] = []
        self.conditions: list[Condition] = []
        self.requirements: list[Requirement] = []
        self.names: dict[str, None] = {}
        self.called: list[Iterator[tuple[RuleBody, Context]]] = []

    def run(self) -> Expansion:
        """Work off the rules; calls found in a rule are pushed and come before the next rule."""
        stack = [_bodies(self.program.sheet, Scope(), ())]
        while stack:
            step = next(stack[-1], None)
            if step is None:
                stack.pop()
                continue
            self.expand_body(*step)
            stack.extend(reversed(self.called))
            self.called.clear()
        requirements = (*self.requirements, *_ranges(self.program))
        return Expansion(tuple(self.equations), tuple(self.conditions), requirements, tuple(self.names))

    def expand_body(self, body: RuleBody, context: Context) -> None:
        """One rule; a stack holds the arms to come, so that long ``else if`` chains don't recurse."""
        stack = [(body, context)]
        while stack:
            body, context = stack.pop()
            self.note_names(body, context.scope)
            match body:
                case Equality():
                    for part in components(body, self.functions):
                        self.expand_component(part, context)
                case CallRule():
                    self.expand_component(body, context)
                case Inequality(comparisons):
                    self.require(comparisons, context)
                case IfRule():
                    stack.extend(reversed(self.arms(body, context)))

    def require(self, comparisons: tuple[Comparison, ...], context: Context) -> None:
        for comparison in comparisons:
            bound = self.bind_condition(comparison, context)
            assert isinstance(bound, Comparison)
            scope = context.scope.prefix
            self.requirements.append(Requirement(bound, context.guard, context.rule, scope))

    def expand_component(self, part: Equality | CallRule, context: Context) -> None:
        if isinstance(part, Equality) and part.like is not None and not context.scope.prefix:
            self.equations.append(Equation.of(len(self.equations), part, context.guard, context.rule))
            return
        if isinstance(part, Equality):
            self.equate(self.bind(part.left[0], context), self.bind(part.right[0], context), context)
            return
        function = self.functions.get(part.function.lower())
        if function is None:
            value = Call(part.function.lower(), part.arguments, part.span)
            self.equate(self.bind(part.results[0], context), self.bind(value, context), context)
        else:
            self.expand_call(function, part.arguments, part.results, context)

    def note_names(self, body: RuleBody, scope: Scope) -> None:
        """Variables in the order of the text, whatever the order in which calls are bound."""
        for name in names_of(body):
            self.names.setdefault(scope.full_name(name))

    def arms(self, rule: IfRule, context: Context) -> list[tuple[RuleBody, Context]]:
        """The arms of an ``if``, each under the premise that opens it."""
        condition = len(self.conditions)
        self.conditions.append(self.bind_condition(rule.condition, context))
        return [
            (arm, Context(context.scope, (*context.guard, Premise(condition, holds)), context.rule))
            for arm, holds in ((rule.then, True), (rule.otherwise, False))
            if arm is not None
        ]

    def expand_call(
        self,
        function: Function,
        arguments: tuple[Expression, ...],
        results: tuple[Expression, ...] | None,
        context: Context,
    ) -> str:
        """Bind a call and put its body on the stack; the full name of its first result.

        With ``results`` None (a call in an expression) the results are locals of the call.
        """
        caller = context.scope
        prefix = caller.prefix_of_call(function.name)
        bound = {name: caller.full_name(name) for name in function.parameters}
        bound.update(self.bind_actuals(function.arguments, arguments, prefix, context))
        if results is not None:
            bound.update(self.bind_actuals(function.results, results, prefix, context))
        scope = Scope(prefix, bound)
        self.called.append(_bodies(function, scope, context.guard))
        return scope.full_name(function.results[0]) if function.results else ""

    def bind_actuals(
        self, formals: tuple[str, ...], actuals: tuple[Expression, ...], prefix: str, context: Context
    ) -> Iterator[tuple[str, str]]:
        for formal, actual in zip(formals, actuals, strict=True):
            value = self.bind(actual, context)
            if isinstance(value, Name):
                yield formal, value.name
            else:
                self.names.setdefault(prefix + formal)
                self.equate(Name(prefix + formal, actual.span), value, context)
                yield formal, prefix + formal

    def equate(self, left: Expression, right: Expression, context: Context) -> None:
        left, right = _exact(left, context.rule), _exact(right, context.rule)
        equation = Equation(
            index=len(self.equations),
            left=left,
            right=right,
            guard=context.guard,
            rule=context.rule,
            scope=context.scope.prefix,
        )
        self.equations.append(equation)

    def bind(self, node: Expression, context: Context) -> Expression:
        """The expression under full names, calls of rule functions replaced by their results."""
        if not self.functions:
            return node
        if isinstance(node, Name):
            full = context.scope.full_name(node.name)
            return node if full == node.name else Name(full, node.span)
        if isinstance(node, Call) and node.function in self.functions:
            function = self.functions[node.function]
            result = self.expand_call(function, node.arguments, None, context)
            self.names.setdefault(result)
            return Name(result, node.span)
        parts = children(node)
        bound: list[Expression] = []
        for part in parts:  # a loop, for one frame a level: trees may be hundreds of levels deep
            bound.append(self.bind(part, context))
        if all(new is old for new, old in zip(bound, parts, strict=True)):
            return node
        return rebuilt(node, tuple(bound))

    def bind_condition(self, node: Condition, context: Context) -> Condition:
        match node:
            case Comparison(operator, left, right, span):
                left, right = (_exact(self.bind(side, context), context.rule) for side in (left, right))
                return Comparison(operator, left, right, span)
            case And(terms, span):
                return And(tuple(self.bind_condition(term, context) for term in terms), span)
            case Or(terms, span):
                return Or(tuple(self.bind_condition(term, context) for term in terms), span)
            case Not(term, span):
                return Not(self.bind_condition(term, context), span)
            case Given(name, span):
                return Given(context.scope.full_name(name), span)


def _bodies(owner: RuleSheet | Function, scope: Scope, guard: Guard) -> Iterator[tuple[RuleBody, Context]]:
    """The rules of a sheet or a function with where each stands."""
    for rule in rules_of(owner):
        yield rule.body, Context(scope, guard, rule.span or rule.body.span or _NOWHERE)


def _ranges(program: Program) -> Iterator[Requirement]:
    """The ends of ranges that name variables."""
    for row in program.rows:
        if row.range is not None and row.range.span is not None:
            for comparison in ends(row.name, row.range):
                yield Requirement(comparison, (), row.range.span)


def _exact(side: Expression, rule: Span) -> Expression:
    """A side of a rule with what its constants are exactly put in: the text tells where there may be any."""
    text = (rule.text or "sin pi").lower()
    return with_round_values(side) if "pi" in text and any(f in text for f in ("sin", "cos", "tan")) else side
