"""Names and calls of a program: what each name means where it stands."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from graphlib import CycleError, TopologicalSorter

from rulesheets.checks import messages
from rulesheets.diagnosis import Diagnosis, plural
from rulesheets.functions import PLANNED, TABLE
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
from rulesheets.syntax.program import Program, bodies, components, operands, rules_of, walk
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


def check_calls(scope: Scope) -> Iterator[Diagnosis]:
    calls: tuple[Call | CallRule, ...] = (*scope.contents.calls, *scope.contents.inner_calls)
    for call in calls:
        function = scope.program.functions.get(call.function.lower())
        if function is not None:
            yield from _check_rule_function(call, function, scope)
        else:
            yield from check_builtin(call, scope.program.functions, scope.names)


def _check_rule_function(call: Call | CallRule, function: Function, scope: Scope) -> Iterator[Diagnosis]:
    if len(call.arguments) != len(function.arguments):
        yield messages.argument_count(call, plural(len(function.arguments), "argument"), function)
    results = len(call.results) if isinstance(call, CallRule) else 1
    if results != len(function.results):
        yield messages.result_count(call, function, results)
    for parameter in function.parameters:
        if parameter not in scope.names:
            yield messages.unknown_parameter(call, function, parameter, scope.title, scope.names)


def check_builtin(
    call: Call | CallRule, own: Iterable[str] = (), variables: Iterable[str] = ()
) -> Iterator[Diagnosis]:
    """A call of no function of one's own; ``own`` and ``variables`` are what may be meant instead."""
    name = call.function.lower()
    if name in PLANNED:
        yield messages.planned_function(call)
    elif name not in TABLE:
        yield messages.unknown_function(call, (*own, *TABLE), variables)
    else:
        if not TABLE[name].accepts(len(call.arguments)):
            yield messages.argument_count(call, _arity(*TABLE[name].arity), None)
        if isinstance(call, CallRule) and len(call.results) != 1:
            yield messages.builtin_results(call)


def _arity(least: int, most: int | None) -> str:
    if most == least:
        return plural(least, "argument")
    return f"at least {plural(least, 'argument')}" if most is None else f"{least} to {most} arguments"


def check_recursion(scopes: Mapping[str, Scope]) -> Iterator[Diagnosis]:
    """One diagnosis for each ring of calls; ``scopes`` are those of the functions.

    The functions of a ring that was told are left out of the search for the next one.
    """
    calls: dict[str, dict[str, Call | CallRule]] = {name: {} for name in scopes}
    for name, scope in scopes.items():
        for call, function in scope.callees():
            calls[name].setdefault(function.name.lower(), call)
    order = list(scopes)
    while True:
        try:
            TopologicalSorter(calls).prepare()
            return
        except CycleError as found:
            ring = found.args[1][:0:-1]  # each is called by the one before it
        first = min(range(len(ring)), key=lambda k: order.index(ring[k]))
        ring = [*ring[first:], *ring[:first]]
        pairs = zip(ring, [*ring[1:], ring[0]], strict=True)
        yield messages.recursion(
            [_function(scopes[name]) for name in ring], [calls[name][target] for name, target in pairs]
        )
        calls = {
            name: {target: call for target, call in targets.items() if target not in ring}
            for name, targets in calls.items()
            if name not in ring
        }


def _function(scope: Scope) -> Function:
    assert scope.function is not None
    return scope.function


MAX_EQUATIONS = 200_000
MAX_DEPTH = 100
MAX_NESTING = 300
"""Levels of an expression; what works on expressions recurses, one level by one."""


@dataclass(frozen=True)
class Size:
    """Equations of a scope with those of its calls, and how deep the calls nest in it."""

    equations: int
    depth: int


def check_size(sheet: Scope, functions: Mapping[str, Scope]) -> Iterator[Diagnosis]:
    """At most one diagnosis; the calls of the functions must not go round."""
    callees = {
        name: [function.name.lower() for _, function in functions[name].callees()] for name in functions
    }
    sizes: dict[str, Size] = {}
    for name in TopologicalSorter(callees).static_order():
        sizes[name] = _size(functions[name], sizes)
    size = _size(sheet, sizes)
    place = next((call.span for call, _ in sheet.callees()), None)
    if size.depth > MAX_DEPTH:
        yield messages.too_large(place, f"calls nest {size.depth} deep; {MAX_DEPTH} is the limit")
    elif size.equations > MAX_EQUATIONS:
        yield messages.too_large(place, f"the model has more than {MAX_EQUATIONS:,} equations")


def _size(scope: Scope, sizes: Mapping[str, Size]) -> Size:
    called = [sizes[function.name.lower()] for _, function in scope.callees()]
    return Size(
        equations=len(scope.contents.equalities) + sum(size.equations for size in called),
        depth=max((size.depth + 1 for size in called), default=0),
    )


def check_nesting(scope: Scope) -> Iterator[Diagnosis]:
    """Expressions too deep to work on, such as a product of a thousand factors."""
    for operand in scope.contents.long:
        if _nesting(operand) > MAX_NESTING:
            yield messages.too_deep(operand.span, MAX_NESTING)


def _nesting(node: Expression | Condition) -> int:
    """How many levels a tree has."""
    level, depth = [node], 0
    while level:
        level = [part for item in level for part in children(item)]
        depth += 1
    return depth


FREE = frozenset(PLANNED) | {"e", "gamma", "beta", "step", "j0", "j1", "jn", "y0", "y1", "yn", "i0", "k0"}
"""Functions whose names are free for variables, because sheets about angles, places and
currents need them: a function is always followed by a parenthesis, so nothing is ambiguous."""


def is_reserved(name: str) -> bool:
    """Whether no variable may have this name, as it is that of a built-in function."""
    return name.lower() in TABLE and name.lower() not in FREE


def check_names(scope: Scope) -> Iterator[Diagnosis]:
    declared = set(scope.declared)
    own = {function.name: function for function in scope.program.functions.values()}
    for name, place in scope.contents.names.items():
        if name in declared:
            continue
        if is_reserved(name) or name in own:
            yield messages.name_of_function(name, place, own.get(name))


def check_declared(scope: Scope) -> Iterator[Diagnosis]:
    """Reserved names in the variables section or in the head of a function."""
    for name, place in _declarations(scope):
        if is_reserved(name):
            yield messages.name_of_function(name, place, None)


def _declarations(scope: Scope) -> Iterator[tuple[str, Span | None]]:
    if scope.function is None:
        yield from ((row.name, row_name(row.span, row.name)) for row in scope.program.rows)
    else:
        head = messages.head_of(scope.function)
        yield from ((name, head) for name in scope.declared)


def row_name(row: Span | None, name: str) -> Span | None:
    """The place of the name at the start of its row."""
    return Span(row.source, row.start, row.start + len(name)) if row else None


def check_rows(program: Program) -> Iterator[Diagnosis]:
    first: dict[str, Span | None] = {}
    for row in program.rows:
        place = row_name(row.span, row.name)
        if row.name in first:
            yield messages.duplicate_row(row.name, place, first[row.name])
        else:
            first[row.name] = place


def check_ranges(scope: Scope) -> Iterator[Diagnosis]:
    """Ends of ranges that name variables: these are there, and the functions are built in."""
    ranges = (row.range for row in scope.program.rows if row.range is not None)
    for end in (end for limits in ranges for end in (limits.lower, limits.upper) if end is not None):
        yield from check_constant(end)
        for node in walk(end):
            if isinstance(node, Name) and node.name not in scope.names:
                yield messages.unknown_end(node.name, node.span, scope.names)


def check_givens(scope: Scope) -> Iterator[Diagnosis]:
    for node in scope.contents.givens:
        if node.name not in scope.names:
            yield messages.unknown_given(node.name, node.span, scope.names)


def check_symbols(scope: Scope) -> Iterator[Diagnosis]:
    own = scope.program.functions
    passed = {
        id(argument)
        for call in scope.contents.inner_calls
        if call.function.lower() in own
        for argument in call.arguments
    }
    for symbol in scope.contents.misplaced:
        if id(symbol) not in passed:
            yield messages.symbol_in_arithmetic(symbol.name, symbol.span)
    for comparison in scope.contents.comparisons:
        yield from _check_order(comparison)


def _check_order(comparison: Comparison) -> Iterator[Diagnosis]:
    if comparison.operator in ("=", "<>"):
        return
    for side in (comparison.left, comparison.right):
        if isinstance(side, Symbol):
            yield messages.symbol_by_order(comparison.operator, side.name, comparison.span)
            return


def check_constant(expression: Expression) -> Iterator[Diagnosis]:
    """An input as written: numbers and built-in functions, no arithmetic with symbols."""
    for node in walk(expression):
        if isinstance(node, Call):
            yield from check_builtin(node)
        for part in children(node):
            if isinstance(part, Symbol):
                yield messages.symbol_in_arithmetic(part.name, part.span)


def check_tuples(scope: Scope) -> Iterator[Diagnosis]:
    rule: Equality
    for rule in scope.contents.unlike:
        yield messages.unlike_tuples(len(rule.left), len(rule.right), rule.span)


def check_head(function: Function) -> Iterator[Diagnosis]:
    if function.name.lower() in TABLE or function.name.lower() in PLANNED:
        yield messages.shadows_builtin(function)
    roles: dict[str, list[str]] = {}
    for role, names in (
        ("an argument", function.arguments),
        ("a result", function.results),
        ("a parameter", function.parameters),
    ):
        for name in names:
            roles.setdefault(name, []).append(role)
    for name, held in roles.items():
        if len(held) > 1:
            yield messages.repeated_in_head(function, name, _join(held))


def _join(held: list[str]) -> str:
    """``an argument and a result``, or ``twice an argument``."""
    distinct = list(dict.fromkeys(held))
    return " and ".join(distinct) if len(distinct) > 1 else f"twice {distinct[0]}"
