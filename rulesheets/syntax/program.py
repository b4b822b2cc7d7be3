"""A sheet with all functions that it can call, from its own file and the used ones."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property

from rulesheets.syntax import Source, Span, nodes


@dataclass(eq=False)
class Program:
    """``functions`` are the rule functions of all files by their names in lower case.

    ``units`` are the units that all files define, ``texts`` the texts of the files that it uses,
    ``links`` the paths by which they are used, each with where its links lead to, ``python`` the
    paths of the Python files that have registered functions for it.
    """

    sheet: nodes.RuleSheet
    functions: dict[str, nodes.Function] = field(default_factory=dict)
    units: list[nodes.UnitRow] = field(default_factory=list)
    texts: list[Source] = field(default_factory=list)
    links: dict[str, str] = field(default_factory=dict)
    python: list[str] = field(default_factory=list)

    @cached_property
    def rows(self) -> tuple[nodes.VariableRow, ...]:
        """The rows of the variables section, without comment lines and settings."""
        rows = (row for row in self.sheet.variables or () if isinstance(row, nodes.VariableRow))
        return tuple(row for row in rows if _setting(row.name, row.value) is None)

    @cached_property
    def rules(self) -> tuple[nodes.Rule, ...]:
        """The rules of the sheet itself."""
        return tuple(rules_of(self.sheet))

    @property
    def limits(self) -> bool:
        """Whether the sheet has ``limits = yes``, in its variables section or among its rules."""
        rows = (row for row in self.sheet.variables or () if isinstance(row, nodes.VariableRow))
        rules = (rule for rule in self.sheet.rules if isinstance(rule, nodes.Rule))
        settings = [_setting(row.name, row.value) for row in rows]
        settings += map(_setting_value, rules)
        return next((setting for setting in reversed(settings) if setting is not None), False)


def _setting(name: str, value: nodes.Expression | None) -> bool | None:
    """The value of ``limits = yes`` or ``limits = no``; None for any other node."""
    if name != "limits" or not isinstance(value, nodes.Name) or value.name not in ("yes", "no"):
        return None
    return value.name == "yes"


def _setting_value(rule: nodes.Rule) -> bool | None:
    match rule.body:
        case nodes.Equality((nodes.Name(name),), (value,)):
            return _setting(name, value)
        case _:
            return None


def rules_of(owner: nodes.RuleSheet | nodes.Function) -> Iterator[nodes.Rule]:
    """The rules of a sheet or a function, without settings and the comment lines between them."""
    rules = (rule for rule in owner.rules if isinstance(rule, nodes.Rule))
    return (rule for rule in rules if _setting_value(rule) is None)


def bodies(body: nodes.RuleBody) -> Iterator[nodes.RuleBody]:
    """A rule body and every body nested in its arms, in source order."""
    stack: list[nodes.RuleBody] = [body]
    while stack:
        item = stack.pop()
        yield item
        if isinstance(item, nodes.IfRule):
            stack.extend(arm for arm in (item.otherwise, item.then) if arm is not None)


def components(
    rule: nodes.RuleBody, functions: Mapping[str, nodes.Function]
) -> tuple[nodes.RuleBody, ...]:
    """An equality as scalar equalities and calls, in order; any other rule alone.

    ``(x, y) = f(a)`` and ``x = f(a)`` are calls of f with these results. Sides of different length
    that no call explains are returned unchanged.
    """
    if not isinstance(rule, nodes.Equality) or (
        not functions and len(rule.left) == len(rule.right) == 1
    ):
        return (rule,)
    if len(rule.left) == len(rule.right):
        parts: list[nodes.RuleBody] = []
        for left, right in zip(rule.left, rule.right, strict=True):
            call = _as_call(right, (left,), rule.span, functions)
            call = call or _as_call(left, (right,), rule.span, functions)
            parts.append(call or nodes.Equality((left,), (right,), rule.span))
        return tuple(parts)
    for one, other in ((rule.right, rule.left), (rule.left, rule.right)):
        call = _as_call(one[0], other, rule.span, functions) if len(one) == 1 else None
        if call is not None:
            return (call,)
    return (rule,)


def _as_call(
    side: nodes.Expression,
    results: tuple[nodes.Expression, ...],
    span: Span | None,
    functions: Mapping[str, nodes.Function],
) -> nodes.CallRule | None:
    if not isinstance(side, nodes.Call) or side.function not in functions:
        return None
    return nodes.CallRule(side.function, side.arguments, results, side.span or span)
