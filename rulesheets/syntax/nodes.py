"""The syntax of a rule sheet as values.

Every node keeps its place in the text (``span``), which equality ignores. Expressions serve both as
syntax and, once names are bound, as the mathematics that the solver works on.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from functools import cached_property
from math import inf
from operator import attrgetter
from typing import Any, ClassVar, Self, TypeAlias, TypeVar, dataclass_transform

from rulesheets.syntax import Span

Value: TypeAlias = float | str
"""The value of a variable: a number, or a symbol by its bare name (``"open"``)."""
Values: TypeAlias = Mapping[str, Value]
"""Numbers and symbols by the full names of variables."""
Row: TypeAlias = tuple[Value, ...]
"""The values of some variables in order."""

_PLACES = frozenset({"span", "gap"})


@dataclass_transform(eq_default=False)
class Node:
    """A value of its fields, the annotated names of its class, which are the arguments of its
    constructor; ``span`` and ``gap`` are only its position in the text.

    ``parts`` are its expressions and conditions from left to right, without the arms of an ``if``.
    No node is changed.
    """

    parts: ClassVar[Any] = ()
    _values: ClassVar[attrgetter[Any]]
    _content: ClassVar[attrgetter[Any]]
    __match_args__: ClassVar[tuple[str, ...]] = ()

    def __init_subclass__(cls) -> None:
        """As ``dataclass`` does, which takes more than twice the time at every start. (A metaclass
        would do for slots, but make ``isinstance`` and ``match`` several times slower.)"""
        own = vars(cls).get("__annotations__", {}).items()
        if fields := tuple(field for field, kind in own if "ClassVar" not in kind):
            taken = ", ".join(f"{one}=cls.{one}" if one in vars(cls) else one for one in fields)
            kept = "; ".join(f"self.{one} = {one}" for one in fields)
            made: dict[str, Any] = {}
            exec(f"def __init__(self, {taken}): {kept}", {"cls": cls}, made)
            cls.__match_args__ = fields  # type: ignore[misc]
            cls.__init__ = made["__init__"]  # type: ignore[method-assign]
            cls._values = attrgetter(*fields)
            cls._content = attrgetter(*(one for one in fields if one not in _PLACES))

    def but(self, **changes: Any) -> Self:
        """The same with other values of some fields."""
        return type(self)(**{name: getattr(self, name) for name in self.__match_args__} | changes)

    def __eq__(self, other: object) -> bool:
        if type(other) is not type(self):
            return NotImplemented
        return bool(self._content(self) == self._content(other))

    def __hash__(self) -> int:
        return hash(self._content(self))

    def __repr__(self) -> str:
        shown = ((name, getattr(self, name)) for name in self.__match_args__ if name not in _PLACES)
        told = ", ".join(f"{name}={value!r}" for name, value in shown if value is not None)
        return f"{type(self).__name__}({told})"

    def __reduce__(self) -> tuple[type, tuple[Any, ...]]:
        return type(self), self._values(self)


# --- arithmetic -----------------------------------------------------------------


def is_number(expression: Expression, value: float) -> bool:
    return isinstance(expression, Number) and expression.value == value


def negative(operand: Expression) -> Expression:
    match operand:
        case Number(value):
            return Number(-value) if value else operand
        case Negative(inner):
            return inner
        case _:
            return Negative(operand)


def add(*terms: Operand) -> Expression:
    kept = tuple(term for term in map(_tree, terms) if not is_number(term, 0.0))
    if not kept:
        return ZERO
    return kept[0] if len(kept) == 1 else Sum(kept)


def subtract(left: Operand, right: Operand) -> Expression:
    return add(left, negative(_tree(right)))


def multiply(left: Operand, right: Operand) -> Expression:
    left, right = _tree(left), _tree(right)
    if is_number(left, 0.0) or is_number(right, 0.0):
        return ZERO
    if is_number(left, 1.0):
        return right
    return left if is_number(right, 1.0) else Product(left, right)


def divide(left: Operand, right: Operand) -> Expression:
    left, right = _tree(left), _tree(right)
    return left if is_number(right, 1.0) or is_number(left, 0.0) else Quotient(left, right)


def power(base: Expression, exponent: Operand) -> Expression:
    exponent = _tree(exponent)
    if is_number(exponent, 1.0):
        return base
    return ONE if is_number(exponent, 0.0) else Power(base, exponent)


def call(function: str, *arguments: Expression) -> Expression:
    return Call(function, arguments)


def _tree(operand: Operand) -> Expression:
    return Number(operand) if isinstance(operand, float | int) else operand


def _swapped(
    operation: Callable[[Operand, Operand], Expression],
) -> Callable[[Any, float], Expression]:
    return lambda right, left: operation(left, right)


class Operators(Node):
    """``+ - * / **`` of expressions and numbers; terms 0 and factors 1 fold away."""

    __neg__, __add__, __sub__, __mul__, __truediv__ = negative, add, subtract, multiply, divide
    __pow__ = power

    __radd__, __rsub__ = _swapped(add), _swapped(subtract)
    __rmul__, __rtruediv__ = _swapped(multiply), _swapped(divide)


# --- expressions ----------------------------------------------------------------


class Number(Operators):
    """A number as written; ``unit`` is the text in ``9.81[m/s^2]``, which no solve reads."""

    value: float
    span: Span | None = None
    unit: str | None = None


class Symbol(Operators):
    """A symbolic value such as ``'open``; ``name`` is ``open``."""

    name: str
    span: Span | None = None


class Name(Operators):
    """A variable. In a model the name is the full, dotted one."""

    name: str
    span: Span | None = None


class Negative(Operators):
    operand: Expression
    span: Span | None = None
    parts = property(lambda node: (node.operand,))


class Sum(Operators):
    """``a + b - c`` is ``Sum((a, b, Negative(c)))``: two terms or more, added left to right.

    N-ary, so that a sum of a thousand terms is not a thousand levels deep.
    """

    terms: tuple[Expression, ...]
    span: Span | None = None
    parts = property(attrgetter("terms"))


class Product(Operators):
    left: Expression
    right: Expression
    span: Span | None = None
    parts = property(attrgetter("left", "right"))


class Quotient(Operators):
    left: Expression
    right: Expression
    span: Span | None = None
    parts = property(attrgetter("left", "right"))


class Power(Operators):
    base: Expression
    exponent: Expression
    span: Span | None = None
    parts = property(attrgetter("base", "exponent"))


class Call(Operators):
    """A function in an expression; the name is in lower case. ``pi`` is ``Call("pi", ())``."""

    function: str
    arguments: tuple[Expression, ...]
    span: Span | None = None
    parts = property(attrgetter("arguments"))


Expression: TypeAlias = Number | Symbol | Name | Negative | Sum | Product | Quotient | Power | Call
Operand: TypeAlias = Expression | float
_Tree = TypeVar("_Tree", bound="Expression | Condition")

# --- conditions -----------------------------------------------------------------


class Comparison(Node):
    """``operator`` is one of ``=  <>  <  <=  >  >=``."""

    operator: str
    left: Expression
    right: Expression
    span: Span | None = None
    parts = property(attrgetter("left", "right"))


class And(Node):
    terms: tuple[Condition, ...]
    span: Span | None = None
    parts = property(attrgetter("terms"))


class Or(Node):
    terms: tuple[Condition, ...]
    span: Span | None = None
    parts = property(attrgetter("terms"))


class Not(Node):
    term: Condition
    span: Span | None = None
    parts = property(lambda node: (node.term,))


class Given(Node):
    """``given('x)``: true where x is an input."""

    name: str
    span: Span | None = None


Condition: TypeAlias = Comparison | And | Or | Not | Given
_Opposite: TypeAlias = Callable[[Condition], Condition]

# --- rules ----------------------------------------------------------------------


class Body(Node):
    """What a rule states."""

    @cached_property
    def names(self) -> tuple[str, ...]:
        """The variables in it, not in its arms, in order of first appearance."""
        return tuple(dict.fromkeys(names(*self.parts)))


class Equality(Body):
    """``(a, b) = (c, d)``; a plain ``a = b`` has one expression a side.

    ``(x, y) = f(a)`` has two on the left and the call alone on the right.
    """

    left: tuple[Expression, ...]
    right: tuple[Expression, ...]
    span: Span | None = None
    parts = property(lambda node: (*node.left, *node.right))


class CallRule(Body):
    """``call f(arguments; results)``."""

    function: str
    arguments: tuple[Expression, ...]
    results: tuple[Expression, ...]
    span: Span | None = None
    parts = property(lambda node: (*node.arguments, *node.results))


class IfRule(Body):
    """``if c then r else s``; an ``else if`` chain is an ``IfRule`` in ``otherwise``."""

    condition: Condition
    then: RuleBody
    otherwise: RuleBody | None = None
    span: Span | None = None
    parts = property(lambda node: (node.condition,))


class Inequality(Body):
    """``a < b`` as a rule; for ``0 < x < 1``, a comparison of each two neighbours."""

    comparisons: tuple[Comparison, ...]
    span: Span | None = None
    parts = property(attrgetter("comparisons"))


RuleBody: TypeAlias = Equality | Inequality | CallRule | IfRule


class Rule(Node):
    """One rule of a sheet with its trailing comment (without the comment mark).

    ``gap``, here and below: a blank line precedes it.
    """

    body: RuleBody
    comment: str = ""
    span: Span | None = None
    gap: bool = False


class CommentLine(Node):
    """A line with only a comment, kept so that a formatted sheet loses nothing."""

    text: str
    span: Span | None = None
    gap: bool = False


# --- variables and sheets -------------------------------------------------------


class Tolerance(Node):
    """``± 0.01`` or ``± 1%`` after the value of an input; ``size`` as written."""

    size: Expression
    percent: bool = False
    span: Span | None = None


class VariableRow(Node):
    """A row of the variables section.

    ``value`` is the input as written (an expression of numbers, or a symbol), ``guess`` the
    expression after ``~``; at most one of the two is given. ``range`` has the bounds as comparisons
    of the name, that from below first: ``in [a, b]``, ``> 0``; ends may have variables.
    """

    name: str
    value: Expression | None = None
    guess: Expression | None = None
    unit: str | None = None
    display_unit: str | None = None
    range: tuple[Comparison, ...] = ()
    comment: str = ""
    span: Span | None = None
    gap: bool = False
    tolerance: Tolerance | None = None


class UnitRow(Node):
    """A line of the units section: ``names = meaning``; ``""`` for a unit without another."""

    names: tuple[str, ...]
    meaning: str = ""
    comment: str = ""
    span: Span | None = None
    gap: bool = False

    @property
    def definition(self) -> str:
        """The line as a library reads it; units of a sheet take prefixes."""
        return ", ".join(f"~{name}" for name in self.names) + f" = {self.meaning}"


class Use(Node):
    """``use "a.tk", "b.tk"``: paths as written; ``python`` files register functions."""

    paths: tuple[str, ...]
    comment: str = ""
    span: Span | None = None
    python: bool = False


class Function(Node):
    """A rule function: ``function f(arguments; results)``, ``parameters``, ``rules``.

    ``above`` are the comment lines directly above its head.
    """

    name: str
    arguments: tuple[str, ...]
    results: tuple[str, ...]
    parameters: tuple[str, ...]
    rules: tuple[Rule | CommentLine, ...]
    comment: str = ""
    span: Span | None = None
    above: tuple[CommentLine, ...] = ()
    parameters_comment: str = ""


class Mark(Node):
    """A line of a figure: ``point A = (x, y)``; ``kind`` is a row of ``checks.KINDS``."""

    kind: str
    name: str | None
    arguments: tuple[Expression, ...]
    comment: str = ""
    span: Span | None = None
    gap: bool = False


class Figure(Node):
    """``figure name [unit]`` with its lines; the comment next to the head is its caption.

    ``unit`` is that of its coordinates, ``above`` are the comment lines directly above its head.
    """

    name: str
    unit: str | None
    marks: tuple[Mark | CommentLine, ...]
    comment: str = ""
    span: Span | None = None
    above: tuple[CommentLine, ...] = ()


class RuleSheet(Node):
    """A whole file. ``variables`` is None where the sheet has no such section."""

    uses: tuple[Use, ...] = ()
    variables: tuple[VariableRow | CommentLine, ...] | None = None
    rules: tuple[Rule | CommentLine, ...] = ()
    functions: tuple[Function, ...] = ()
    comments: tuple[CommentLine, ...] = ()
    span: Span | None = None
    figures: tuple[Figure, ...] = ()
    units: tuple[UnitRow | CommentLine, ...] = ()


def rebuilt(node: _Tree, parts: tuple[Any, ...], span: Span | None = None) -> _Tree:
    """The node with other direct parts, or with another span."""
    kind: Any = type(node)
    found, span = node, span or node.span
    if kind in (Product, Sum, Quotient, Power, Negative, And, Or, Not):
        found = kind(parts, span) if kind in (Sum, And, Or) else kind(*parts, span)
    elif isinstance(node, Call):
        found = kind(node.function, parts, span)
    elif isinstance(node, Comparison):
        found = kind(node.operator, *parts, span)
    return found


def conjunction(outcomes: Iterable[tuple[Condition, bool]], opposite: _Opposite = Not) -> Condition:
    """The conditions that hold, and the opposites of those that do not, joined by ``and``."""
    terms = tuple(condition if holds else opposite(condition) for condition, holds in outcomes)
    return terms[0] if len(terms) == 1 else And(terms)


def walk(*roots: Expression | Condition) -> list[Expression | Condition]:
    """Nodes and all their parts, left to right, each before its own parts."""
    found: list[Expression | Condition] = []
    stack = [*reversed(roots)]
    while stack:
        item = stack.pop()
        found.append(item)
        if parts := item.parts:
            stack.extend(parts[::-1])
    return found


def names(*roots: Expression | Condition) -> list[str]:
    """Names of the variables in nodes, left to right, with repetition."""
    return [node.name for node in walk(*roots) if type(node) is Name]


def calls(*roots: Expression | Condition) -> list[Call]:
    """The calls of functions in nodes, left to right, each before those in its arguments."""
    return [node for node in walk(*roots) if type(node) is Call]


def measured(node: Expression) -> tuple[float, str] | None:
    """``3[in]`` and ``-3[in]`` as number and unit; None for anything else."""
    match node:
        case Number(value, unit=str(unit)):
            return value, unit
        case Negative(Number(value, unit=str(unit))):
            return -value, unit
        case _:
            return None


def units_of(node: Expression | Condition) -> list[str]:
    """The units of numbers in a node that have one."""
    return [one.unit for one in walk(node) if isinstance(one, Number) and one.unit is not None]


def terms(*sides: Expression) -> Iterator[Expression]:
    """The terms of sums, here of the sides of an equation; anything else is its own term."""
    for side in sides:
        yield from side.terms if isinstance(side, Sum) else (side,)


def chain(node: Expression) -> list[tuple[str, Expression]]:
    """The factors of ``a*b/c`` with their signs, by a loop: a chain may be very long."""
    parts: list[tuple[str, Expression]] = []
    while isinstance(node, Product | Quotient):
        parts.append(("*" if isinstance(node, Product) else "/", node.right))
        node = node.left
    return [("*", node), *reversed(parts)]


def bare(node: Expression) -> bool:
    """Whether an expression is a plain number: it adopts the unit of the terms next to it."""
    return not any(
        type(part) is Name or (type(part) is Number and part.unit is not None)
        for part in walk(node)
    )


ZERO = Number(0.0)
ONE = Number(1.0)


def substitute(expression: Expression, replacements: Mapping[str, Expression]) -> Expression:
    """The expression with variables replaced."""

    def replaced(leaf: Name | Number | Symbol) -> Expression:
        return replacements.get(leaf.name, leaf) if isinstance(leaf, Name) else leaf

    return map_leaves(expression, replaced)


def exchange(expression: Expression, old: Expression, new: Expression) -> Expression:
    """The expression with ``old`` replaced by ``new`` everywhere."""
    if expression == old:
        return new
    return rebuilt(expression, tuple(exchange(part, old, new) for part in expression.parts))


def map_leaves(
    expression: Expression, change: Callable[[Name | Number | Symbol], Expression]
) -> Expression:
    """The expression with ``change`` applied to every name, number and symbol."""
    if isinstance(expression, Name | Number | Symbol):
        return change(expression)
    return rebuilt(expression, tuple(map_leaves(part, change) for part in expression.parts))


def degree(expression: Expression, unknowns: Collection[str]) -> float:
    """The degree in the unknowns of a polynomial as written, with any coefficients, or after
    multiplying by divisors that are products, which count as one more; infinite for others."""
    match expression:
        case Name(name):
            return float(name in unknowns)
        case Negative(operand):
            return degree(operand, unknowns)
        case Sum(terms):
            return max(degree(term, unknowns) for term in terms)
        case Product(left, right):
            return degree(left, unknowns) + degree(right, unknowns)
        case Quotient(left, right) if degree(right, unknowns) == 0.0:
            return degree(left, unknowns)
        case Quotient(left, right) if not any(isinstance(node, Sum) for node in walk(right)):
            return 1.0 + degree(left, unknowns) + degree(right, unknowns)
        case Power(base, Number(power)) if power.is_integer() and power > 0.0:
            return power * degree(base, unknowns)
    return 0.0 if set(unknowns).isdisjoint(names(expression)) else inf
