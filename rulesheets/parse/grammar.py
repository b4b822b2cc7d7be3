"""A logical line → a node, by lark and ``rules.lark``: the only module that imports lark.

The parser calls :class:`Builder` as it reduces, so it never builds a tree of its own.
"""

from __future__ import annotations

import os
import threading
from collections.abc import Callable, Iterable
from functools import cache
from itertools import starmap
from typing import Any, NamedTuple, cast

from lark import Lark, Token, Transformer, v_args
from lark.exceptions import UnexpectedCharacters, UnexpectedToken
from lark.lexer import PatternRE, TerminalDef

from rulesheets import store
from rulesheets.checks import wrong_mark
from rulesheets.diagnosis import Diagnosis, RuleSheetError, error_at, refusal, refuse, wrong_range
from rulesheets.parse.layout import STRANGE, Form, Line, form_of, leaves_of
from rulesheets.parse.mistakes import explain_line, strange_characters
from rulesheets.syntax import Source, Span, nodes
from rulesheets.syntax.nodes import (
    Call,
    Comparison,
    Condition,
    Equality,
    Expression,
    IfRule,
    Inequality,
    Name,
    Product,
    Quotient,
    RuleBody,
    walk,
)

KINDS = ["rule", "use", "head", "parameters", "figure", "mark"]
"""Kinds of lines beside rows: start rules of the grammar."""

LONG = 20_000
"""Characters of a text from which on its rules are compared with one another."""
MOST_FORMS = 10_000
"""Forms of rules that are remembered at a time."""

_GRAMMAR = os.path.join(os.path.dirname(__file__), os.pardir, "rules.lark")
_RELATIONS = {"≤": "<=", "≥": ">=", "≠": "<>"}


# --- nodes ----------------------------------------------------------------------


class Side(NamedTuple):
    """One side of an equality with its place, parentheses of a tuple included."""

    expressions: tuple[Expression, ...]
    span: Span


def _unit(text: str) -> tuple[str | None, str | None]:
    """``[mm -> in]`` as calculation and display unit."""
    unit, _, display = text[1:-1].partition("->")
    return unit.strip() or None, display.strip() or None


class Unparsed(Exception):
    """A line cannot be read; ``place`` is where, as an offset into the line's code."""

    def __init__(self, place: int) -> None:
        super().__init__(f"not parsed beyond {place}")
        self.place = place


def _of_two(kind: Callable[..., Any]) -> Callable[..., Any]:
    return lambda self, left, right: kind(left, right, self._span(left, right))


def _of_many(kind: Callable[..., Any]) -> Callable[..., Any]:
    return lambda self, *terms: kind(terms, self._span(terms[0], terms[-1]))


def _listed(kind: Callable[..., Any]) -> Callable[..., Any]:
    """``and(a, b)``: a word, a parenthesis, terms with commas between them, a parenthesis."""

    def made(self: Builder, *words: Any) -> Any:
        terms, span = words[2:-1:2], self._span(words[0], words[-1])
        return kind(terms, span) if len(terms) > 1 else terms[0].but(span=span)

    return made


@v_args(inline=True)
class Builder(Transformer[Any, Any]):
    """Builds nodes: one method for each rule of ``rules.lark``.

    The methods get nodes, tuples of nodes, and tokens, for the line of this ``kind`` that begins
    at the ``offset`` of the ``source``.
    """

    source: Source
    offset: int
    kind: str

    def _span(self, first: Any, last: Any = None) -> Span:
        """The span of a token or a node, or from one to another."""
        last = first if last is None else last
        start = first.span.start if hasattr(first, "span") else self.offset + first.start_pos
        end = last.span.end if hasattr(last, "span") else self.offset + last.end_pos
        return Span(self.source, start, end)

    # --- expressions ---

    def number(self, token: Token) -> nodes.Number:
        value = float(token)
        if value == float("inf") or (value == 0.0 and token.lower().partition("e")[0].strip("0.")):
            label = "too large" if value else "too small"
            note = "numbers range from 5e-324 to 1.8e308 in size"
            message = f"the number {token} is out of range"
            raise refusal("E107", message, self._span(token), note, label=label)
        return nodes.Number(value, self._span(token))

    def measure(self, token: Token) -> nodes.Number:
        """``9.81[m/s^2]``"""
        digits, _, unit = token.partition("[")
        end = (token.start_pos or 0) + len(digits)
        number = self.number(Token("NUMBER", digits, token.start_pos, end_pos=end))
        return number.but(span=self._span(token), unit=unit[:-1].strip())

    def symbol(self, token: Token) -> nodes.Symbol:
        return nodes.Symbol(str(token)[1:], self._span(token))

    def name(self, token: Token) -> nodes.Name | nodes.Call:
        if token.lower() == "pi" and token not in self.source.variables_like_pi:
            return nodes.Call("pi", (), self._span(token))
        return nodes.Name(str(token), self._span(token))

    def local(self, token: Any) -> nodes.Name:
        """``position.yB``: the figures of a sheet see the locals of its calls, its rules do not."""
        if self.kind != "mark":
            sign = min(token.find(sign) for sign in ".#" if sign in token)
            raise Unparsed(token.start_pos + sign)
        return nodes.Name(str(token), self._span(token))

    def call(self, name: Token, arguments: tuple[Expression, ...], closing: Token) -> nodes.Call:
        return nodes.Call(name.lower(), arguments, self._span(name, closing))

    def group(self, opening: Token, inner: Any, closing: Token) -> Any:
        return inner.but(span=self._span(opening, closing))

    def expressions(self, *found: Expression | None) -> tuple[Expression, ...]:
        return tuple(one for one in found if one is not None)

    def negative(self, minus: Token, operand: Expression) -> nodes.Negative:
        return nodes.Negative(operand, self._span(minus, operand))

    subtracted = negative
    sum = _of_many(nodes.Sum)
    times, over, power = map(_of_two, (nodes.Product, nodes.Quotient, nodes.Power))

    # --- conditions ---

    def comparison(self, left: Expression, sign: Token, right: Expression) -> nodes.Comparison:
        operator, span = _RELATIONS.get(sign, str(sign)), self._span(left, right)
        return nodes.Comparison(operator, left, right, span)

    def negation(self, word: Token, term: nodes.Condition) -> nodes.Not:
        return nodes.Not(term, self._span(word, term))

    def given(self, word: Token, name: Token, closing: Token) -> nodes.Given:
        return nodes.Given(str(name)[1:], self._span(word, closing))

    grouped = group
    conjunction, disjunction = map(_of_many, (nodes.And, nodes.Or))
    all_of, any_of = map(_listed, (nodes.And, nodes.Or))

    # --- rules ---

    def side(self, *parts: Any) -> Side:
        return Side(parts if len(parts) == 1 else parts[1:-1], self._span(parts[0], parts[-1]))

    def equality(self, left: Side, right: Side) -> nodes.Equality:
        span = self._span(left, right)
        if len(right.expressions) > len(left.expressions) == 1:
            left, right = right, left
        return nodes.Equality(left.expressions, right.expressions, span)

    def inequality(self, *parts: Any) -> nodes.Inequality:
        triples = zip(parts[::2], parts[1::2], parts[2::2], strict=False)
        span = self._span(parts[0], parts[-1])
        return nodes.Inequality(tuple(starmap(self.comparison, triples)), span)

    def call_rule(
        self, word: Token, name: Token, arguments: Any, results: Any, closing: Token
    ) -> nodes.CallRule:
        return nodes.CallRule(name.lower(), arguments, results or (), self._span(word, closing))

    def conditional(self, word: Token, condition: Any, then: Any, otherwise: Any) -> nodes.IfRule:
        return nodes.IfRule(condition, then, otherwise, self._span(word, otherwise or then))

    # --- the variables section ---

    def row(self, name: Token, assigned: Any, *marks: Any) -> nodes.VariableRow:
        sign, expression, tolerance = assigned or ("", None, None)
        units = [mark for mark in marks if isinstance(mark, str)]
        ranges = [bound for mark in marks if not isinstance(mark, str) for bound in mark]
        if len(units) > 1:
            note = "it stands last: x < 3[in] [mm]"
            raise refusal("E461", "a row has one unit", self._span(name), note)
        unit, display = _unit(units[0]) if units else (None, None)
        return nodes.VariableRow(
            str(name),
            value=expression if sign == "=" else None,
            guess=expression if sign == "~" else None,
            unit=unit,
            display_unit=display,
            range=_bounded(str(name), ranges),
            span=self._span(name),
            tolerance=tolerance,
        )

    def value(self, expression: Expression, tolerance: nodes.Tolerance | None) -> tuple[Any, ...]:
        return "=", expression, tolerance

    def guess(self, expression: Expression) -> tuple[Any, ...]:
        return "~", expression, None

    def tolerance(self, sign: Token, size: Expression, percent: Token | None) -> nodes.Tolerance:
        span = self._span(sign, size if percent is None else percent)
        return nodes.Tolerance(size, percent is not None, span)

    def bound(self, sign: Token, expression: Expression) -> tuple[Comparison, ...]:
        return (self.comparison(Name("", self._span(sign)), sign, expression),)

    def interval(
        self, word: Token, low: Expression, high: Expression, closing: Token
    ) -> tuple[Comparison, ...]:
        span = self._span(word, closing)
        return Comparison(">=", Name(""), low, span), Comparison("<=", Name(""), high, span)

    # --- section heads ---

    def names(self, *found: Token | None) -> tuple[str, ...]:
        return tuple(str(one) for one in found if one is not None)

    parameters = names

    def use(self, *paths: Token) -> tuple[str, ...]:
        return tuple(str(path)[1:-1] for path in paths)

    def figure(self, _: Token, name: Token, unit: Token | None) -> nodes.Figure:
        return nodes.Figure(str(name), None if unit is None else _unit(unit)[0], ())

    def mark(self, kind: Token, name: Token | None, arguments: Any, closing: Token) -> nodes.Mark:
        span = self._span(kind, closing)
        return nodes.Mark(kind.lower(), None if name is None else str(name), arguments, span=span)

    def head(self, name: Token, arguments: Any, results: Any) -> nodes.Function:
        return nodes.Function(str(name), arguments, results or (), (), ())


def _bounded(name: str, bounds: Iterable[Comparison]) -> tuple[Comparison, ...]:
    """All bounds of a row together, each end once."""
    ends: dict[str, Comparison] = {}
    for bound in bounds:
        if bound.operator == "<>":
            raise RuleSheetError(wrong_range("<> is not a bound", bound.span))
        if ends.setdefault(bound.operator[0], bound) is not bound:
            raise RuleSheetError(wrong_range("this end of the range is already set", bound.span))
    return tuple(ends[sign].but(left=Name(name)) for sign in "><" if sign in ends)


# --- lines ----------------------------------------------------------------------


class Grammar(threading.local):
    """Lark with the grammar of a line, one for each thread, as the builder holds the current line.

    Rows have a parser of their own: the lexer of the others does not know the sign of a tolerance.
    """

    def __init__(self) -> None:
        self._builder = Builder()
        self.forms: dict[tuple[str, bytes], Form | None] = {}
        self._lark = self._parser("lines", KINDS)
        self._of_rows = self._parser("rows", ["row"], _before_a_unit)

    def _parser(
        self, name: str, start: list[str], edit: Callable[[TerminalDef], object] | None = None
    ) -> Lark:
        """A parser whose tables lark keeps on disk, if there is a folder for that."""
        return Lark.open(
            _GRAMMAR,
            parser="lalr",
            start=start,
            transformer=self._builder,
            maybe_placeholders=True,
            edit_terminals=edit,
            cache=store.place(f"grammar-{name}") or False,
        )

    def read(self, source: Source, line: Line, kind: str) -> Any:
        """The node of a line of this kind (a start rule of the grammar).

        Raises Unparsed if the grammar rejects it, RuleSheetError if only the builder does (a number
        out of range).
        """
        builder = self._builder
        builder.source, builder.offset, builder.kind = source, line.start, kind
        try:
            parser = self._of_rows if kind == "row" else self._lark
            return parser.parse(line.code, start=kind)
        except UnexpectedToken as stop:
            ended = stop.token.type == "$END"
            raise Unparsed(len(line.code) if ended else int(stop.token.start_pos or 0)) from None
        except UnexpectedCharacters as stop:
            raise Unparsed(int(stop.pos_in_stream or 0)) from None


def _before_a_unit(terminal: TerminalDef) -> None:
    """In a row, a number has a unit of its own only where that of the row follows."""
    if terminal.name == "MEASURE":
        terminal.pattern = PatternRE(
            rf"{terminal.pattern.value}(?=[^\n]*\[[^\[\],\n]*\])", terminal.pattern.flags
        )


grammar = cache(Grammar)
"""The grammar, compiled on first use."""


def read_rule(source: Source, line: Line, place: Span) -> RuleBody:
    """The node of a rule in this place; raises as ``read_line`` does."""
    leaves = None
    if len(source.text) > LONG and not source.variables_like_pi:
        leaves = leaves_of(line.code)
    if leaves is None:
        return cast(RuleBody, read_line(source, line, "rule"))
    # from the third of a form on, the tree of the second with other leaves
    known = grammar().forms
    if (form := known.get(leaves.key)) is not None:
        return form(leaves.names, leaves.numbers, place)
    node = read_line(source, line, "rule")
    if len(known) >= MOST_FORMS:
        known.clear()
    known[leaves.key] = form_of(node, leaves) if leaves.key in known else None
    return cast(RuleBody, node)


def read_line(source: Source, line: Line, kind: str) -> Any:
    """The node of a line of this kind, a start rule of the grammar.

    Raises RuleSheetError with what is wrong. The shape of the line has been found right before.
    """
    if STRANGE.search(line.code):
        refuse(strange_characters(source, line))
    try:
        node = grammar().read(source, line, kind)
    except Unparsed as stopped:
        raise RuleSheetError(explain_line(source, line, stopped.place, kind)) from None
    # a tree has no more levels than its text has characters
    trees = _trees(node, kind) if line.end - line.start > DEEPEST else ()
    wrong = next(filter(None, map(too_deep, trees)), None)
    if wrong is None and kind == "mark":
        wrong = wrong_mark(node)
    elif wrong is None and isinstance(node, Equality | Inequality):
        wrong = without_variable(node)
    if wrong is not None:
        raise RuleSheetError(wrong)
    return node


def _trees(node: Any, kind: str) -> Iterable[Any]:
    """Nodes of a line that may be deep."""
    match kind:
        case "rule":
            return (node,)
        case "mark":
            return tuple(node.arguments)
        case "row":
            ends = (bound.right for bound in node.range)
            size = node.tolerance and node.tolerance.size
            return filter(None, (node.value, node.guess, size, *ends))
        case _:
            return ()


# --- what no grammar says ---

DEEPEST = 200
"""Levels of a rule's tree: later stages walk trees by recursion, which must end in good time."""
FACTORS = 300
"""Factors of a product, each of which is a level of recursion; they count as one above."""


def too_deep(tree: RuleBody | Condition | Expression) -> Diagnosis | None:
    """Whether a tree has more than DEEPEST levels, or a product more than FACTORS, by a loop."""
    if tree.span is None or tree.span.end - tree.span.start <= DEEPEST:
        return None
    chains = Product, Quotient
    stack: list[tuple[Any, int, int]] = [(tree, 1, 0)]  # the sign of equality is no factor
    while stack:
        node, level, factors = stack.pop()
        here = tree.span if node.span is None else node.span
        if level > DEEPEST:
            note = "give the inner parts names of their own, in rules of their own"
            label = f"{DEEPEST} levels deep"
            return error_at("E124", "this is nested too deeply", here.part(0, 1), note, label=label)
        if factors > FACTORS:
            message = f"this expression nests more than {FACTORS} levels deep"
            note, label = "split it over several rules", "every factor of a long product is a level"
            return error_at("E217", message, here.part(0, 1), note, label=label)
        if isinstance(node, IfRule):
            arms = filter(None, (node.condition, node.then, node.otherwise))
            stack += ((arm, level + 1, 0) for arm in arms)
            continue
        for part in reversed(node.parts):
            chained = isinstance(node, chains) and part is node.left and isinstance(part, chains)
            stack.append((part, level if chained else level + 1, factors + 1))
    return None


def without_variable(rule: Equality | Inequality) -> Diagnosis | None:
    """The mistake in a rule with numbers only; None for any other.

    A call counts as a variable: its function may have parameters.
    """
    for node in walk(*rule.parts):
        if isinstance(node, Name) or (isinstance(node, Call) and node.function != "pi"):
            return None
    message, note = "this rule has no variable", "write a name on one side: x = 3"
    return error_at("E114", message, rule.span, note, label="only numbers")
