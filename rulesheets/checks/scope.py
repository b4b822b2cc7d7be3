"""What a body of rules says and can see: the sheet itself, or one function, before any expansion."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property

from rulesheets.syntax.nodes import (
    Call,
    CallRule,
    Comparison,
    Condition,
    Equality,
    Expression,
    Function,
    Given,
    Name,
    RuleBody,
    Symbol,
    children,
)
from rulesheets.syntax.program import Program, bodies, components, operands, rules_of
from rulesheets.syntax.source import Span

LONG = 300
"""Characters; a shorter expression cannot nest deeper than that."""


@dataclass(frozen=True)
class Contents:
    """What the rules of a scope contain, each list in source order.

    ``calls`` are those that have their results beside them (``call f(a; x)``, ``x = f(a)``),
    ``inner_calls`` those inside an expression, built-in functions among them.
    ``names`` maps each variable to its first place. ``misplaced`` are symbols inside
    arithmetic, ``unlike`` the tuple rules whose sides differ in length, ``long`` the
    expressions whose text is long enough to be suspected of being too deep.
    """

    names: dict[str, Span | None] = field(default_factory=dict)
    equalities: list[Equality] = field(default_factory=list)
    calls: list[CallRule] = field(default_factory=list)
    inner_calls: list[Call] = field(default_factory=list)
    givens: list[Given] = field(default_factory=list)
    comparisons: list[Comparison] = field(default_factory=list)
    misplaced: list[Symbol] = field(default_factory=list)
    unlike: list[Equality] = field(default_factory=list)
    long: list[Expression | Condition] = field(default_factory=list)


@dataclass(frozen=True)
class Scope:
    """``function`` is None for the sheet itself."""

    program: Program
    function: Function | None = None

    @property
    def title(self) -> str:
        return self.function.name if self.function else "this sheet"

    @cached_property
    def declared(self) -> tuple[str, ...]:
        """Names that stand in the variables section or in the head of the function."""
        if self.function is None:
            return tuple(row.name for row in self.program.rows)
        return (*self.function.arguments, *self.function.results, *self.function.parameters)

    @cached_property
    def names(self) -> dict[str, None]:
        """All variables that the scope sees, the declared ones first."""
        return dict.fromkeys((*self.declared, *self.contents.names))

    @cached_property
    def contents(self) -> Contents:
        found = Contents()
        for rule in rules_of(self.function or self.program.sheet):
            for body in bodies(rule.body):
                if isinstance(body, Equality):
                    self._survey_equality(body, found)
                else:
                    _survey(body, found)
        return found

    def _survey_equality(self, rule: Equality, found: Contents) -> None:
        for part in components(rule, self.program.functions):
            if isinstance(part, Equality):
                found.equalities.append(part)
                if len(part.left) != len(part.right):
                    found.unlike.append(part)
            _survey(part, found)

    def callees(self) -> Iterator[tuple[Call | CallRule, Function]]:
        """Every call of a rule function that exists, with that function."""
        calls: tuple[Call | CallRule, ...] = (*self.contents.calls, *self.contents.inner_calls)
        for call in calls:
            function = self.program.functions.get(call.function.lower())
            if function is not None:
                yield call, function


def _survey(body: RuleBody, found: Contents) -> None:
    if isinstance(body, CallRule):
        found.calls.append(body)
    for operand in operands(body):
        if operand.span is not None and operand.span.end - operand.span.start > LONG:
            found.long.append(operand)
        _survey_operand(operand, found)


def _survey_operand(operand: Expression | Condition, found: Contents) -> None:
    stack = [operand]
    while stack:
        node = stack.pop()
        if isinstance(node, Name):
            found.names.setdefault(node.name, node.span)
            continue
        parts = children(node)
        _survey_node(node, parts, found)
        stack.extend(reversed(parts))


def _survey_node(
    node: Expression | Condition, parts: tuple[Expression | Condition, ...], found: Contents
) -> None:
    if isinstance(node, Comparison):
        found.comparisons.append(node)
        return
    if isinstance(node, Call):
        found.inner_calls.append(node)
    elif isinstance(node, Given):
        found.givens.append(node)
    for part in parts:
        if isinstance(part, Symbol):
            found.misplaced.append(part)
