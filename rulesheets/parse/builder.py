"""What the grammar recognises, as nodes: one method for each rule of ``rules.lark``.

The parser calls these as it reduces, so it never builds a tree of its own. Children are
nodes, tuples of nodes, and tokens (strings that know ``start_pos`` and ``end_pos``)."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple, TypeAlias

from lark import Token

from rulesheets.diagnosis import RuleSheetError, empty_range, said, wrong_range
from rulesheets.evaluate import Undefined, value
from rulesheets.parse.foreign import too_deep
from rulesheets.syntax import Source, Span, nodes
from rulesheets.syntax.nodes import Expression, Range, measured, names, units_of

Children: TypeAlias = Sequence[Any]
Expressions: TypeAlias = tuple[nodes.Expression, ...]

_RELATIONS = {"≤": "<=", "≥": ">=", "≠": "<>"}


class Side(NamedTuple):
    """One side of an equality with its place, parentheses of a tuple included."""

    expressions: Expressions
    span: Span


def _unit(text: str) -> tuple[str | None, str | None]:
    """``[mm -> in]`` as calculation and display unit."""
    unit, _, display = text[1:-1].partition("->")
    return unit.strip() or None, display.strip() or None


class Misplaced(Exception):
    """A word that lines of this kind do not have; ``place`` is an offset into the code."""

    def __init__(self, place: int) -> None:
        super().__init__(f"misplaced at {place}")
        self.place = place


class Builder:
    """Callbacks of the parser, for the line that ``begin`` has named."""

    def __init__(self) -> None:
        self.begin(Source("", ""), 0, "rule")

    def begin(self, source: Source, offset: int, kind: str) -> None:
        """Where the line at hand begins, and what kind of line it is."""
        self.source, self.offset, self.kind = source, offset, kind

    def _span(self, first: Any, last: Any = None) -> Span:
        """The place of a token or a node, or from one to another."""
        last = first if last is None else last
        start = first.span.start if hasattr(first, "span") else self.offset + first.start_pos
        end = last.span.end if hasattr(last, "span") else self.offset + last.end_pos
        return Span(self.source, start, end)

    # --- expressions ---

    def number(self, children: Children) -> nodes.Number:
        token = children[0]
        value = float(token)
        if value == float("inf") or (value == 0.0 and token.lower().partition("e")[0].strip("0.")):
            label = "too large" if value else "too small"
            note = "numbers reach from 5e-324 to 1.8e308 in size"
            wrong = said("E107", f"the number {token} is out of range", self._span(token), note, label=label)
            raise RuleSheetError(wrong)
        return nodes.Number(value, self._span(token))

    def measure(self, children: Children) -> nodes.Number:
        """``9.81[m/s^2]``"""
        token = children[0]
        digits, _, unit = token.partition("[")
        end = token.start_pos + len(digits)
        number = self.number([Token("NUMBER", digits, token.start_pos, end_pos=end)])
        return number.but(span=self._span(token), unit=unit[:-1].strip())

    def symbol(self, children: Children) -> nodes.Symbol:
        return nodes.Symbol(str(children[0])[1:], self._span(children[0]))

    def name(self, children: Children) -> nodes.Name | nodes.Call:
        token = children[0]
        if token.lower() == "pi":
            return nodes.Call("pi", (), self._span(token))
        return nodes.Name(str(token), self._span(token))

    def local(self, children: Children) -> nodes.Name:
        """``position.yB``: the figures of a sheet see the locals of its calls, its rules do not."""
        token = children[0]
        if self.kind != "mark":
            raise Misplaced(token.start_pos + min(token.find(sign) for sign in ".#" if sign in token))
        return nodes.Name(str(token), self._span(token))

    def call(self, children: Children) -> nodes.Call:
        name, arguments, closing = children
        return nodes.Call(name.lower(), arguments, self._span(name, closing))

    def group(self, children: Children) -> Any:
        opening, inner, closing = children
        return inner.but(span=self._span(opening, closing))

    def expressions(self, children: Children) -> Expressions:
        return tuple(child for child in children if child is not None)

    def sum(self, children: Children) -> nodes.Sum:
        return nodes.Sum(tuple(children), self._span(children[0], children[-1]))

    def negative(self, children: Children) -> nodes.Negative:
        minus, operand = children
        return nodes.Negative(operand, self._span(minus, operand))

    subtracted = negative

    def times(self, children: Children) -> nodes.Product:
        return nodes.Product(children[0], children[1], self._span(children[0], children[-1]))

    def over(self, children: Children) -> nodes.Quotient:
        return nodes.Quotient(children[0], children[1], self._span(children[0], children[-1]))

    def power(self, children: Children) -> nodes.Power:
        return nodes.Power(children[0], children[1], self._span(children[0], children[-1]))

    # --- conditions ---

    def comparison(self, children: Children) -> nodes.Comparison:
        left, sign, right = children
        operator = _RELATIONS.get(sign, str(sign))
        return nodes.Comparison(operator, left, right, self._span(left, right))

    grouped = group

    def conjunction(self, children: Children) -> nodes.Condition:
        return nodes.And(tuple(children), self._span(children[0], children[-1]))

    def disjunction(self, children: Children) -> nodes.Condition:
        return nodes.Or(tuple(children), self._span(children[0], children[-1]))

    def all_of(self, children: Children, kind: Any = nodes.And) -> nodes.Condition:
        """``and(a, b)``: a word, a parenthesis, terms with commas between them, a parenthesis."""
        terms, span = tuple(children[2:-1:2]), self._span(children[0], children[-1])
        made: nodes.Condition = kind(terms, span) if len(terms) > 1 else terms[0].but(span=span)
        return made

    def any_of(self, children: Children) -> nodes.Condition:
        return self.all_of(children, nodes.Or)

    def negation(self, children: Children) -> nodes.Not:
        word, term = children
        return nodes.Not(term, self._span(word, term))

    def given(self, children: Children) -> nodes.Given:
        word, name, closing = children
        return nodes.Given(str(name)[1:], self._span(word, closing))

    # --- rules ---

    def side(self, children: Children) -> Side:
        expressions = children if len(children) == 1 else children[1:-1]
        return Side(tuple(expressions), self._span(children[0], children[-1]))

    def equality(self, children: Children) -> nodes.Equality:
        left, right = children
        if len(right.expressions) > len(left.expressions) == 1:
            left, right = right, left
        return nodes.Equality(left.expressions, right.expressions, self._span(*children))

    def inequality(self, children: Children) -> nodes.Inequality:
        sides, signs = children[::2], children[1::2]
        pairs = zip(sides, signs, sides[1:], strict=False)
        return nodes.Inequality(tuple(map(self.comparison, pairs)), self._span(children[0], children[-1]))

    def call_rule(self, children: Children) -> nodes.CallRule:
        word, name, arguments, results, closing = children
        span = self._span(word, closing)
        return nodes.CallRule(name.lower(), arguments, results or (), span)

    def conditional(self, children: Children) -> nodes.IfRule:
        word, condition, then, otherwise = children
        return nodes.IfRule(condition, then, otherwise, self._span(word, otherwise or then))

    # --- the variables section ---

    def row(self, children: Children) -> nodes.VariableRow:
        name, assigned, *marks = children
        sign, expression, tolerance = assigned or ("", None, None)
        units = [mark for mark in marks if isinstance(mark, str)]
        ranges = [bound for mark in marks if not isinstance(mark, str) for bound in mark]
        if len(units) > 1:
            note = "it stands last: x < 3[in] [mm]"
            raise RuleSheetError(said("E461", "a row has one unit", self._span(name), note))
        unit, display = _unit(units[0]) if units else (None, None)
        return nodes.VariableRow(
            str(name),
            value=expression if sign == "=" else None,
            guess=expression if sign == "~" else None,
            unit=unit,
            display_unit=display,
            range=_bounded(ranges),
            span=self._span(name),
            tolerance=tolerance,
        )

    def value(self, children: Children) -> tuple[str, nodes.Expression, nodes.Tolerance | None]:
        return "=", children[0], children[1]

    def guess(self, children: Children) -> tuple[str, nodes.Expression, None]:
        return "~", children[0], None

    def tolerance(self, children: Children) -> nodes.Tolerance:
        sign, size, percent = children
        span = self._span(sign, size if percent is None else percent)
        return nodes.Tolerance(size, percent is not None, span)

    def bound(self, children: Children) -> tuple[Bound, ...]:
        sign, expression = children
        operator = _RELATIONS.get(sign, str(sign))
        span = self._span(sign, expression)
        return (Bound(operator, _limit(expression), span),)

    def interval(self, children: Children) -> tuple[Bound, ...]:
        word, low, high, closing = children
        span = self._span(word, closing)
        return Bound(">=", _limit(low), span), Bound("<=", _limit(high), span)

    # --- section heads ---

    def names(self, children: Children) -> tuple[str, ...]:
        return tuple(str(child) for child in children if child is not None)

    parameters = names

    def use(self, children: Children) -> tuple[str, ...]:
        return tuple(str(child)[1:-1] for child in children)

    def figure(self, children: Children) -> nodes.Figure:
        _, name, unit = children
        return nodes.Figure(str(name), None if unit is None else _unit(unit)[0], ())

    def mark(self, children: Children) -> nodes.Mark:
        kind, name, arguments, closing = children
        span = self._span(kind, closing)
        return nodes.Mark(str(kind).lower(), None if name is None else str(name), arguments, span=span)

    def head(self, children: Children) -> nodes.Function:
        name, arguments, results = children
        return nodes.Function(str(name), arguments, results or (), (), ())


class Bound(NamedTuple):
    """``< 5`` and the like, beside a name in the variables section; ``limit`` may name variables."""

    operator: str
    limit: float | Expression
    span: Span


def _limit(expression: Expression) -> float | Expression:
    """The value of an expression of numbers; ``3[in]`` and one that names variables as it is."""
    if measured(expression) is not None:
        return expression
    if (unit := next(units_of(expression), None)) is not None:
        reason = f"a bound is one number with its unit, and {unit} stands in an expression"
        raise RuleSheetError(wrong_range(reason, expression.span))
    if wrong := too_deep(expression):
        raise RuleSheetError(wrong)
    if any(names(expression)):
        return expression
    try:
        return value(expression, {})
    except Undefined as undefined:
        reason = f"this bound has no value: {undefined}"
    except KeyError as unknown:
        reason = f"a bound is a number: there is no function {unknown.args[0]}"
    raise RuleSheetError(wrong_range(reason, expression.span))


def _bounded(bounds: Sequence[Bound]) -> Range | None:
    """All bounds of a row together, each end once; None where there are none."""
    if not bounds:
        return None
    ends: dict[bool, tuple[float, Expression | None, bool]] = {
        True: (-math.inf, None, False),
        False: (math.inf, None, False),
    }
    told: set[bool] = set()
    for operator, limit, span in bounds:
        lower = operator[0] == ">"
        if operator == "<>":
            raise RuleSheetError(wrong_range("<> is no bound", span))
        if lower in told:
            raise RuleSheetError(wrong_range("this end of the range is already set", span))
        told.add(lower)
        number, expression = (limit, None) if isinstance(limit, float) else (ends[lower][0], limit)
        ends[lower] = number, expression, len(operator) == 1
    (low, lower_end, low_open), (high, upper_end, high_open) = ends[True], ends[False]
    span = Span(bounds[0].span.source, bounds[0].span.start, bounds[-1].span.end)
    if low > high or (low == high and (low_open or high_open)):
        raise RuleSheetError(empty_range(span))
    return Range(low, high, low_open, high_open, lower_end, upper_end, span)
