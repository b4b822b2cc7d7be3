"""The equations of a program: its rules under full names, its calls expanded.

A call of a rule function stands for the rules of that function with their names bound:

* an argument or a result whose actual is a plain variable *is* that variable;
* any other actual gets a dotted variable and an equation (``f.a = AO/2``);
* a parameter is the variable of that name in the calling scope;
* every other name is local: ``f.name``, in the second call of f ``f#2.name``,
  in a call inside a call ``f.g.name``.

Equations come rule by rule in source order, those of a call right after the rule that
calls.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

from rulesheets.diagnosis import refusal
from rulesheets.model import Equation, Premise, Requirement
from rulesheets.syntax import Source, Span, nodes
from rulesheets.syntax.nodes import children, names, rebuilt
from rulesheets.syntax.program import Program, components, names_of, rules_of

MAX_EQUATIONS = 200_000
_NOWHERE = Span(Source("<tree>", ""), 0, 0)


class FullNames(NamedTuple):
    """The names of one body of rules and their full names.

    ``bound`` maps arguments, results and parameters to full names; other names are local and get
    ``prefix``. ``counts`` numbers the calls of each function.
    """

    prefix: str
    bound: Mapping[str, str]
    counts: dict[str, int]

    def full_name(self, name: str) -> str:
        return self.bound.get(name) or self.prefix + name


class Context(NamedTuple):
    """The context of an expression: its scope, its premises, and the rule that messages refer
    to."""

    scope: FullNames
    guard: tuple[Premise, ...]
    rule: Span


class Expansion:
    """The equations of a program that passed its checks.

    ``names`` are all variables that occur, in order of appearance, conditions included.
    """

    def __init__(self, program: Program) -> None:
        self.functions = program.functions
        self.equations: list[Equation] = []
        self.conditions: list[nodes.Condition] = []
        self.requirements: list[Requirement] = []
        self.names: dict[str, None] = {}
        self._called: list[tuple[nodes.Function, FullNames, tuple[Premise, ...]]] = []
        self._body(program.sheet, FullNames("", {}, {}), ())
        for row in program.rows:  # the ends of ranges that name variables
            limits = row.range
            if limits is None or limits.span is None:
                continue
            low, high = ">" if limits.low_open else ">=", "<" if limits.high_open else "<="
            for operator, end in ((low, limits.lower), (high, limits.upper)):
                if end is not None and any(names(end)):
                    comparison = nodes.Comparison(operator, nodes.Name(row.name), end, limits.span)
                    self.requirements.append(Requirement(comparison, (), limits.span))

    def _body(
        self, owner: nodes.RuleSheet | nodes.Function, scope: FullNames, guard: tuple[Premise, ...]
    ) -> None:
        """The rules of a sheet or a function, each followed by those of its calls."""
        for rule in rules_of(owner):
            place = rule.span or rule.body.span or _NOWHERE
            self._expand(rule.body, Context(scope, guard, place))
            if len(self.equations) + len(self.requirements) > MAX_EQUATIONS:
                reason = f"the model has more than {MAX_EQUATIONS:,} equations"
                note = "nest fewer calls"
                raise refusal("E216", reason, place, note, label="one of them")
            called, self._called = self._called, []
            for call in called:
                self._body(*call)

    def _expand(self, body: nodes.RuleBody, context: Context) -> None:
        """Expand one rule; a stack holds the remaining arms, so ``else if`` chains do not
        recurse."""
        stack = [(body, context)]
        while stack:
            body, context = stack.pop()
            scope, guard, rule = context
            read = names_of(body)  # in the order of the text, whatever the order of the calls
            self.names.update(dict.fromkeys(map(scope.full_name, read) if scope.prefix else read))
            for part in components(body, self.functions):
                match part:
                    case nodes.Equality(like=like) if like is not None and not scope.prefix:
                        self.equations.append(Equation(len(self.equations), part, guard, rule))
                    case nodes.Equality((left, *_), (right, *_)):
                        self._equate(self._bind(left, context), self._bind(right, context), context)
                    case nodes.CallRule(called, arguments, results, span):
                        function = self.functions.get(called.lower())
                        if function is not None:
                            self._call(function, arguments, results, context)
                        else:
                            result, value = results[0], nodes.Call(called.lower(), arguments, span)
                            self._equate(
                                self._bind(result, context), self._bind(value, context), context
                            )
                    case nodes.Inequality(comparisons):
                        bound = (
                            _exact(self._bind(comparison, context), rule)
                            for comparison in comparisons
                        )
                        self.requirements += (
                            Requirement(one, guard, rule, scope.prefix) for one in bound
                        )
                    case nodes.IfRule(condition, then, otherwise):
                        index = len(self.conditions)
                        self.conditions.append(_exact(self._bind(condition, context), rule))
                        for arm, holds in ((otherwise, False), (then, True)):
                            if arm is not None:
                                stack.append(
                                    (arm, Context(scope, (*guard, Premise(index, holds)), rule))
                                )

    def _call(
        self,
        function: nodes.Function,
        arguments: tuple[nodes.Expression, ...],
        results: tuple[nodes.Expression, ...] | None,
        context: Context,
    ) -> str:
        """Bind a call and record its body; return the full name of its first result.

        With ``results`` None (a call in an expression) the results are locals of the call.
        """
        caller, name = context.scope, function.name
        number = caller.counts[name] = caller.counts.get(name, 0) + 1
        prefix = f"{caller.prefix}{name}." if number == 1 else f"{caller.prefix}{name}#{number}."
        bound = {parameter: caller.full_name(parameter) for parameter in function.parameters}
        pairs = [*zip(function.arguments, arguments, strict=True)]
        if results is not None:
            pairs += zip(function.results, results, strict=True)
        for formal, actual in pairs:
            value = self._bind(actual, context)
            if isinstance(value, nodes.Name):
                bound[formal] = value.name
            else:
                bound[formal] = full = prefix + formal
                self.names.setdefault(full)
                self._equate(nodes.Name(full, actual.span), value, context)
        scope = FullNames(prefix, bound, {})
        self._called.append((function, scope, context.guard))
        return scope.full_name(function.results[0]) if function.results else ""

    def _equate(self, left: nodes.Expression, right: nodes.Expression, context: Context) -> None:
        scope, guard, rule = context
        left, right = (_exact(side, rule) for side in (left, right))
        body = nodes.Equality((left,), (right,))
        self.equations.append(Equation(len(self.equations), body, guard, rule, scope.prefix))

    def _bind(self, node: Any, context: Context) -> Any:
        """A node with full names, and with calls of rule functions replaced by their results."""
        if not self.functions:
            return node
        if isinstance(node, nodes.Name | nodes.Given):
            full = context.scope.full_name(node.name)
            return node if full == node.name else type(node)(full, node.span)
        if isinstance(node, nodes.Call) and node.function in self.functions:
            result = self._call(self.functions[node.function], node.arguments, None, context)
            self.names.setdefault(result)
            return nodes.Name(result, node.span)
        parts = children(node)
        bound = []
        for part in parts:  # a loop, for one frame a level: trees may be hundreds of levels deep
            bound.append(self._bind(part, context))
        if all(new is old for new, old in zip(bound, parts, strict=True)):
            return node
        return rebuilt(node, tuple(bound))


def _exact(part: Any, rule: Span) -> Any:
    """A part of a rule with exact values of its constants put in; ``text`` tells whether it may
    have any."""
    text = (rule.text or "sin pi").lower()
    if "pi" not in text or not any(function in text for function in ("sin", "cos", "tan")):
        return part
    from rulesheets.evaluate.exact import with_round_values  # few rules have any

    return with_round_values(part)
